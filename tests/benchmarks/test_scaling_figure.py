"""Fails where the figure or the report shows other points than were measured, or hides a lack."""

from benchmarks import measurements
from benchmarks.measurements import save
from benchmarks.records import Curve, Point, ScalingMeasurement
from benchmarks.scaling_figure import draw_committed_scaling, draw_measured
from ghostball.reports import style

ENVIRONMENT = {"cpu": "a | b", "cores": 2, "date": "2026-01-02T03:04:05+00:00"}


def point(engine, physics, balls, packing, per_event):
    return Point(
        engine=engine,
        physics=physics,
        balls=balls,
        packing=packing,
        events=100.0,
        per_event=per_event,
        least=per_event,
        greatest=per_event,
        samples=3,
    )


MEASURED = ScalingMeasurement(
    environment=ENVIRONMENT,
    rounds=3,
    fixed_packing=0.3,
    fixed_balls=256,
    by_balls=[
        point("ghostball", "gas", 2, 0.3, 2e-7),
        point("ghostball", "gas", 1000, 0.3, 9e-7),
        point("ghostball", "cloth", 2, 0.3, 3e-7),
        point("pooltool", "cloth", 2, 0.3, 1e-3),
    ],
    by_packing=[point("ghostball", "gas", 256, p, 1e-6) for p in (0.5, 0.1)],
    curves=[
        Curve(engine="ghostball", physics="gas", outcome="ran"),
        Curve(engine="pooltool", physics="gas", outcome="not-representable", detail="has | legs"),
    ],
)


def test_each_engine_and_physics_is_a_line_with_its_points():
    with style.drawing():
        left, right = draw_measured(MEASURED).axes
    lines = {line.get_label(): line for line in left.lines}
    assert list(lines) == [
        "ghostball, elastic gas",
        "ghostball, pool's physics",
        "pooltool, pool's physics",
    ]
    gas = lines["ghostball, elastic gas"]
    assert (list(gas.get_xdata()), list(gas.get_ydata())) == ([2, 1000], [2e-7, 9e-7])
    assert list(right.lines[0].get_xdata()) == [0.1, 0.5]
    assert (left.get_xscale(), left.get_yscale(), right.get_yscale()) == ("log", "log", "log")


def test_engines_differ_in_colour_and_physics_in_more_than_colour():
    with style.drawing():
        gas, cloth, other = draw_measured(MEASURED).axes[0].lines
    assert gas.get_color() == cloth.get_color() != other.get_color()
    assert gas.get_markerfacecolor() != cloth.get_markerfacecolor()
    assert gas.get_linestyle() != cloth.get_linestyle()


def test_nothing_is_drawn_of_nothing(tmp_path, monkeypatch):
    assert draw_measured(MEASURED.model_copy(update={"by_balls": (), "by_packing": ()})) is None
    monkeypatch.setattr(measurements, "STORE", tmp_path)
    assert draw_committed_scaling() is None


def test_the_figure_says_what_is_wrong_with_a_measurement():
    part = MEASURED.model_copy(update={"interrupted": True, "quick": True})
    with style.drawing():
        title = draw_measured(part).get_suptitle()
    assert "interrupted" in title
    assert "its times mean nothing" in title


def test_this_machines_measurement_wins_over_anothers(tmp_path, monkeypatch):
    monkeypatch.setattr(measurements, "STORE", tmp_path)
    monkeypatch.setattr(measurements, "describe_environment", lambda: ENVIRONMENT)
    save(MEASURED.model_copy(update={"rounds": 9}), tmp_path / "a-a" / "scaling.json", "--store")
    assert measurements.committed(ScalingMeasurement).rounds == 9
    save(MEASURED, tmp_path / "a-b-2-cores" / "scaling.json", "--store")
    assert measurements.committed(ScalingMeasurement).rounds == 3
    with style.drawing():
        assert draw_committed_scaling() is not None

"""Fails where the figure or the report shows other points than were measured, or hides a lack."""

import json

import pytest

from ghostball.engine import GhostballError
from ghostball.reports import gallery_pictures, stored, style, write_gallery, write_report
from ghostball.reports.scaling_figure import draw_measured, draw_scaling, draw_scaling_or_committed
from ghostball.validation.bench import measurements
from ghostball.validation.bench.measurements import Curve, Point, ScalingMeasurement, save
from ghostball.validation.results.store import Results

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


@pytest.fixture
def with_scaling(small_folder):
    save(MEASURED, small_folder / "scaling.json", "--out")
    return small_folder


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


def test_nothing_is_drawn_of_nothing(small_folder):
    assert draw_measured(MEASURED.model_copy(update={"by_balls": (), "by_packing": ()})) is None
    assert draw_scaling(Results.open(small_folder)) is None


def test_the_report_has_a_section_where_it_was_measured(with_scaling):
    text = write_report(with_scaling).read_text(encoding="utf-8")
    section = text[text.index("## Time per event") : text.index("## Environment")]
    assert "figures/scaling.svg" in section
    assert "| `ghostball` | elastic gas | 200 ns (2) | 900 ns (1000) |" in section
    assert "- `pooltool`, elastic gas: not representable: has \\| legs" in section
    assert "3 rounds" in section
    assert (with_scaling / "figures" / "scaling.png").exists()


@pytest.mark.usefixtures("without_run_figures")
def test_the_report_says_what_is_wrong_with_a_measurement(with_scaling):
    part = MEASURED.model_copy(update={"interrupted": True, "quick": True})
    save(part, with_scaling / "scaling.json", "--out")
    text = write_report(with_scaling).read_text(encoding="utf-8")
    assert "This measurement was interrupted. This is a trial" in text


@pytest.mark.usefixtures("without_run_figures")
def test_a_report_without_a_measurement_has_no_section(small_folder):
    assert "## Time per event" not in write_report(small_folder).read_text(encoding="utf-8")


def test_a_damaged_measurement_is_an_error_that_names_it(with_scaling):
    path = with_scaling / "scaling.json"
    path.write_text(json.dumps({"kind": "scaling"}))
    with pytest.raises(GhostballError, match=r"scaling\.json: `environment`"):
        write_report(with_scaling)


def test_the_gallery_draws_the_committed_measurement_if_there_is_one(
    results_folder, tmp_path, monkeypatch
):
    monkeypatch.setattr(measurements, "STORE", tmp_path / "store")
    monkeypatch.setattr(gallery_pictures, "GALLERY", {})  # what else it draws is not the question
    names = {path.name for path in write_gallery(results_folder, tmp_path / "without")}
    assert "scaling.png" not in names
    save(MEASURED, tmp_path / "store" / "some-machine" / "scaling.json", "--store")
    names = {path.name for path in write_gallery(results_folder, tmp_path / "with")}
    assert {"scaling.png", "scaling.svg"} <= names


def test_this_machines_measurement_wins_over_anothers(tmp_path, monkeypatch, small_folder):
    monkeypatch.setattr(measurements, "STORE", tmp_path)
    monkeypatch.setattr(stored, "describe_environment", lambda: ENVIRONMENT)
    save(MEASURED.model_copy(update={"rounds": 9}), tmp_path / "a-a" / "scaling.json", "--store")
    assert stored.committed(ScalingMeasurement).rounds == 9
    save(MEASURED, tmp_path / "a-b-2-cores" / "scaling.json", "--store")
    assert stored.committed(ScalingMeasurement).rounds == 3
    with style.drawing():
        assert draw_scaling_or_committed(Results.open(small_folder)) is not None

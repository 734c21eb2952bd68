"""Fails where a figure or the report shows other errors, times or orders than were measured."""

import numpy as np

from benchmarks import measurements
from benchmarks.measurements import save
from benchmarks.precision.figure import FLOOR, draw_against_time, draw_committed_precision
from benchmarks.precision.points import (
    LeftOut,
    PrecisionCurve,
    PrecisionMeasurement,
    PrecisionPoint,
    Reach,
)
from benchmarks.precision.tables import best_text, reach_text
from ghostball.reports import style

ENVIRONMENT = {"cpu": "a | b", "cores": 2, "date": "2026-01-02T03:04:05+00:00"}


def point(engine, seconds, error, *, step=None, scene="cut", true_course=True):
    return PrecisionPoint(
        scene=scene,
        title="A cut",
        truth="closed form",
        engine=engine,
        label=engine if step is None else f"{engine}:dt={step}",
        step=step,
        seconds=seconds,
        samples=4,
        error=error,
        error_low=0.5 * error,
        error_high=2.0 * error,
        work_name="events" if step is None else "steps",
        work=3 if step is None else round(4.0 / step),
        exact=step is None,
        true_course=true_course,
    )


def reach(*seconds):
    targets = (1e-3, 1e-6, 1e-9)
    return tuple(Reach(target=t, seconds=s) for t, s in zip(targets, seconds, strict=True))


MEASURED = PrecisionMeasurement(
    environment=ENVIRONMENT,
    rounds=4,
    points=[
        point("ghostball", 4e-6, 0.0),
        point("pymunk", 1e-2, 2e-2, step=0.01, true_course=False),
        point("pymunk", 2e-2, 1e-2, step=0.005),
        point("ghostball", 5e-6, 1e-15, scene="bounce"),
    ],
    curves=[
        PrecisionCurve(
            scene="cut",
            engine="ghostball",
            reach=reach(4e-6, 4e-6, 4e-6),
        ),
        PrecisionCurve(
            scene="cut",
            engine="pymunk",
            reach=reach(7.0, None, None),
        ),
    ],
    left_out=[LeftOut(scene="bounce", engine="pymunk", why="has | legs")],
)


def bars_of(axes):
    return {bar.get_label(): bar for bar in axes.containers}


def test_each_scene_has_a_panel_and_each_engine_a_line_with_its_range():
    with style.drawing():
        figure = draw_against_time(MEASURED)
        assert [axes.get_title(loc="left") or axes.get_title() for axes in figure.axes] == [
            "cut",
            "bounce",
        ]
        bars = bars_of(figure.axes[0])
    assert set(bars) == {"ghostball", "pymunk"}
    line, _, (ranges,) = bars["pymunk"]
    assert list(line.get_xdata()) == [1e-2, 2e-2]
    assert list(line.get_ydata()) == [2e-2, 1e-2]
    assert np.allclose(ranges.get_segments()[0][:, 1], [1e-2, 4e-2])
    assert figure.axes[0].get_xscale() == figure.axes[0].get_yscale() == "log"


def test_an_error_of_nothing_is_drawn_at_the_floor_and_said():
    with style.drawing():
        figure = draw_against_time(MEASURED)
        line, *_ = bars_of(figure.axes[0])["ghostball"]
    assert list(line.get_ydata()) == [FLOOR]
    assert figure.axes[0].get_ylim()[0] < FLOOR
    assert "0, or below 1e-17 m" in [text.get_text() for text in figure.axes[0].texts]


def test_another_course_is_an_open_marker():
    with style.drawing():
        axes = draw_against_time(MEASURED).axes[0]
    (open_ones,) = [
        line
        for line in axes.lines
        if line.get_markerfacecolor() == "white" and len(line.get_xdata())
    ]
    assert list(open_ones.get_xdata()) == [1e-2]


def test_the_legend_names_the_engines():
    with style.drawing():
        (legend,) = draw_against_time(MEASURED).legends
    assert [text.get_text() for text in legend.get_texts()] == ["ghostball", "pymunk"]


def test_the_least_error_is_of_the_worst_phase_of_the_best_step():
    assert best_text(MEASURED.points[1:3]) == "20 mm in 20 ms"


def test_a_time_is_told_where_a_run_was_so_near():
    near, far, _ = MEASURED.curves[1].reach
    assert reach_text(near) == "7 s"
    assert reach_text(far) == "not reached"


def test_the_committed_measurement_is_drawn_if_there_is_one(tmp_path, monkeypatch):
    monkeypatch.setattr(measurements, "STORE", tmp_path)
    assert draw_committed_precision() is None
    save(MEASURED.model_copy(update={"points": ()}), tmp_path / "a" / "precision.json", "--store")
    assert draw_committed_precision() is None
    save(MEASURED, tmp_path / "a" / "precision.json", "--store")
    with style.drawing():
        assert draw_committed_precision() is not None


def test_a_legend_of_many_engines_is_within_the_figure():
    labels = [f"pybullet:mode=landed,iterations={k}" for k in range(9)]
    many = MEASURED.model_copy(
        update={
            "points": [
                point(label, 1e-2, 1e-3, step=0.01, scene=scene)
                for label in labels
                for scene in ("a", "b", "c")
            ],
        }
    )
    with style.drawing():
        figure = draw_against_time(many)
        figure.draw_without_rendering()
        (legend,) = figure.legends
        box = legend.get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.width

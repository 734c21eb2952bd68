"""Fails where a figure or the report shows other errors, times or orders than were measured."""

import numpy as np

from benchmarks.precision.figure import draw_against_time
from benchmarks.precision.points import (
    LeftOut,
    PrecisionCurve,
    PrecisionMeasurement,
    PrecisionPoint,
    Reach,
)
from benchmarks.precision.tables import best_text
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


def test_the_least_error_is_of_the_worst_phase_of_the_best_step():
    assert best_text(MEASURED.points[1:3]) == "20 mm in 20 ms"

"""The figure and the table show the measured errors, times and orders."""

import numpy as np
import pytest

from ghostball.reports import style
from ghostball.reports.precision import draw_against_time, least_error
from ghostball.validation.precision.points import PrecisionMeasurement, PrecisionPoint, seconds_to


def point(engine, seconds, error, *, step=None, scene="cut", same_events=True):
    return PrecisionPoint(
        scene=scene,
        title="A cut",
        truth="closed form",
        engine=engine,
        label=engine if step is None else f"{engine}:dt={step}",
        step=step,
        call_seconds=seconds,
        seconds=0.25 * seconds,
        samples=4,
        error=error,
        error_low=0.5 * error,
        error_high=2.0 * error,
        same_events=same_events,
    )


MEASURED = PrecisionMeasurement(
    points=[
        point("ghostball", 4e-6, 0.0),
        point("pymunk", 1e-2, 2e-2, step=0.01, same_events=False),
        point("pymunk", 2e-2, 1e-2, step=0.005),
        point("ghostball", 5e-6, 1e-15, scene="bounce"),
    ]
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


def test_a_second_mark_is_at_the_time_inside_the_engine():
    with style.drawing():
        figure = draw_against_time(MEASURED)
        marks = [
            line
            for line in figure.axes[0].lines
            if line.get_marker() == "|" and len(line.get_xdata())
        ]
        (legend,) = figure.legends
    assert [float(mark.get_xdata()[0]) for mark in marks] == [1e-6, 2.5e-3, 5e-3]
    assert "run time inside the engine" in [text.get_text() for text in legend.get_texts()]


def test_the_least_error_is_of_the_worst_phase_of_the_best_step():
    assert least_error(MEASURED.points[1:3]) == "20 mm in 20 ms"


def test_a_step_that_is_good_by_luck_does_not_count():
    lucky, coarse, fine = (point("toy", s, e, step=s) for s, e in ((4, 0.0), (2, 1e-2), (1, 1e-4)))
    assert seconds_to(1e-3, [lucky, coarse, fine]) == 1.0
    assert seconds_to(1e-3, [lucky, fine]) == 1.0
    assert seconds_to(1e-3, [lucky]) == 4.0
    assert seconds_to(1e-3, [lucky], lost=[1e-3]) is None
    assert seconds_to(1e-9, [fine]) is None
    assert seconds_to(1.0, [lucky, coarse, fine]) == pytest.approx(1.0)

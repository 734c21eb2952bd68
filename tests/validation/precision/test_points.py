"""The recommended time step follows the rule."""

import pytest

from ghostball.reports import style
from ghostball.reports.precision import draw_against_steps, knee_text
from ghostball.validation.precision.points import (
    PrecisionMeasurement,
    PrecisionPoint,
    knee_of,
    order_of,
)
from ghostball.validation.results.measurement import MeasurementError


def ladder(errors: dict[float, float]) -> list[PrecisionPoint]:
    """Return the points of an engine from its errors [m] by time step [s]."""
    return [
        PrecisionPoint(
            scene="cut",
            title="A cut",
            truth="closed form",
            engine="pymunk",
            label=f"pymunk:dt={step}",
            step=step,
            call_seconds=1e-4 / step,
            seconds=5e-5 / step,
            samples=4,
            error=error,
            error_low=error,
            error_high=error,
        )
        for step, error in errors.items()
    ]


def test_the_recommended_step_is_the_longest_that_no_shorter_step_improves():
    # The error is of first order down to 1e-5 m; below, the step doesn't determine it.
    mine = ladder({1e-2: 1e-2, 1e-3: 1e-3, 1e-4: 1e-4, 1e-5: 1.1e-5, 1e-6: 1e-5})
    assert knee_of(mine).step == 1e-5
    assert knee_text(mine) == "10 µs"


def test_the_recommended_step_is_below_all_if_each_step_reduces_the_error():
    mine = ladder({1e-2: 1e-2, 1e-3: 1e-3, 1e-4: 1e-4})
    assert knee_text(mine) == "< 100 µs"


def test_the_recommended_step_is_the_longest_if_no_step_reduces_the_error():
    assert knee_text(ladder({1e-2: 1e-3, 1e-3: 0.9e-3, 1e-4: 1e-3})) == "10 ms"
    assert knee_text(ladder({1e-2: 0.0, 1e-3: 0.0})) == "10 ms"


def test_a_step_with_other_events_is_no_answer():
    mine = ladder({1e-2: 1e-9, 1e-3: 1e-3, 1e-4: 1e-3})
    mine[0] = mine[0].model_copy(update={"same_events": False})
    assert knee_of(mine).step == 1e-3
    none = [one.model_copy(update={"same_events": False}) for one in mine]
    assert knee_of(none) is None
    assert knee_text(none) == "\u2013"


def test_a_step_is_not_recommended_if_a_shorter_one_has_wrong_collisions():
    mine = ladder({1e-2: 1e-3, 1e-3: 1e-3, 1e-4: 1e-3})
    mine[1] = mine[1].model_copy(update={"same_events": False})
    assert knee_of(mine).step == 1e-4


def test_no_step_is_recommended_if_the_error_stays_large():
    assert knee_of(ladder({1e-2: 0.2, 1e-3: 0.15, 1e-4: 0.16})) is None
    assert knee_text(ladder({1e-2: 0.2, 1e-3: 0.02})) == "< 1 ms"  # shorter steps reduce it


def test_the_order_is_the_slope_of_the_errors():
    assert order_of(ladder({1e-2: 4e-2, 1e-3: 4e-4, 1e-4: 4e-6})) == pytest.approx(2.0)
    assert order_of(ladder({1e-2: 1e-9, 1e-3: 1e-9})) == pytest.approx(0.0)
    assert order_of(ladder({1e-2: 0.0, 1e-3: 1e-9})) is None
    wrong = [
        one.model_copy(update={"same_events": False}) for one in ladder({1e-2: 1.0, 1e-3: 1.0})
    ]
    assert order_of([*wrong, *ladder({1e-4: 1e-3, 1e-5: 1e-4})]) == pytest.approx(1.0)


def test_the_picture_rings_the_recommended_step():
    mine = ladder({1e-2: 1e-2, 1e-3: 1e-3, 1e-4: 1e-3})
    exact = [one.model_copy(update={"engine": "ghostball", "step": None}) for one in mine[:1]]
    with style.drawing():
        figure = draw_against_steps(PrecisionMeasurement(points=(*exact, *mine)))
        (axes,) = figure.axes
        (ring,) = [line for line in axes.lines if line.get_fillstyle() == "none"]
        assert list(ring.get_xdata()) == pytest.approx([1e3])
        assert list(axes.containers[0][0].get_xdata()) == pytest.approx([1e2, 1e3, 1e4])
        assert len(axes.containers) == 1
        with pytest.raises(MeasurementError, match="compares time steps"):
            draw_against_steps(PrecisionMeasurement(points=exact))

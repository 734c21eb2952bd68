"""Fails where the step that is called worth it is another one than the rule says."""

import pytest

from ghostball.reports import style
from ghostball.reports.precision import draw_against_steps, knee_text
from ghostball.validation.precision.points import (
    PrecisionMeasurement,
    PrecisionPoint,
    knee_of,
)
from ghostball.validation.results.measurement import MeasurementError


def ladder(errors: dict[float, float]) -> list[PrecisionPoint]:
    """Return an engine's points, of steps [s] and the errors that they come to [m]."""
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


def test_it_is_where_the_floor_begins():
    # First order down to 1e-5 m, where something else than the step decides.
    mine = ladder({1e-2: 1e-2, 1e-3: 1e-3, 1e-4: 1e-4, 1e-5: 1.1e-5, 1e-6: 1e-5})
    assert knee_of(mine).step == 1e-5
    assert knee_text(mine) == "10 µs"


def test_where_each_step_pays_it_is_the_finest_and_says_so():
    mine = ladder({1e-2: 1e-2, 1e-3: 1e-3, 1e-4: 1e-4})
    assert knee_text(mine) == "< 100 µs"


def test_where_no_step_pays_it_is_the_coarsest():
    assert knee_text(ladder({1e-2: 1e-3, 1e-3: 0.9e-3, 1e-4: 1e-3})) == "10 ms"
    assert knee_text(ladder({1e-2: 0.0, 1e-3: 0.0})) == "10 ms"


def test_a_step_with_other_events_is_no_answer():
    mine = ladder({1e-2: 1e-9, 1e-3: 1e-3, 1e-4: 1e-3})
    mine[0] = mine[0].model_copy(update={"same_events": False})
    assert knee_of(mine).step == 1e-3
    none = [one.model_copy(update={"same_events": False}) for one in mine]
    assert knee_of(none) is None
    assert knee_text(none) == "\u2013"


def test_the_picture_rings_and_names_it():
    mine = ladder({1e-2: 1e-2, 1e-3: 1e-3, 1e-4: 1e-3})
    exact = [one.model_copy(update={"engine": "ghostball", "step": None}) for one in mine[:1]]
    with style.drawing():
        figure = draw_against_steps(PrecisionMeasurement(points=(*exact, *mine)))
        (axes,) = figure.axes
        assert "pymunk: 1 ms" in {text.get_text() for text in axes.texts}
        assert list(axes.containers[0][0].get_xdata()) == pytest.approx([1e2, 1e3, 1e4])
        assert len(axes.containers) == 1
        with pytest.raises(MeasurementError, match="compares time steps"):
            draw_against_steps(PrecisionMeasurement(points=exact))

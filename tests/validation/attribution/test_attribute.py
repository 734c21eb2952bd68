"""Differences divided: of engines whose model, step and rounding errors are planted."""

import numpy as np
import pytest
from toy_engines import ToyEngine, ToySettings, cut, other_shot, roll

from engine import UnsupportedSceneError
from reference_adapters import make_engine
from validation import find_scene
from validation.attribution import Plan, attribute


def toy(**settings):
    return ToyEngine(ToySettings(**settings))


def test_model_and_step_are_told_apart():
    found = attribute(roll(), toy(model=3e-3, slope=0.4, order=1.0))
    assert found.outcome == "attributed"
    assert found.truth == "certified"
    assert found.difference == pytest.approx(5e-3, rel=1e-9)  # 3 mm along x, 4 along y
    assert found.model.size == pytest.approx(3e-3, rel=1e-6)
    assert found.discretisation.size == pytest.approx(4e-3, rel=1e-6)
    assert found.model.share == pytest.approx(9 / 25, rel=1e-6)
    assert found.model.share + found.discretisation.share == pytest.approx(1.0)
    assert found.order == pytest.approx(1.0, abs=0.011)
    assert found.rounding < 1e-14
    assert found.instant is None


def test_a_second_order_engine_is_one():
    found = attribute(roll(), toy(slope=40.0, order=2.0))
    assert found.order_used == pytest.approx(2.0)
    assert found.discretisation.size == pytest.approx(4e-3, rel=1e-3)
    assert found.model.size < 1e-6


def test_an_engine_without_errors_has_none_whatever_its_step():
    found = attribute(roll(), toy())
    assert found.flat
    assert found.order is None
    assert found.difference < 1e-14
    assert found.model.size < 1e-13


def test_a_model_error_that_no_step_changes_is_the_whole():
    found = attribute(roll(), toy(model=0.05))
    assert found.flat
    assert found.model.size == pytest.approx(0.05)
    assert found.discretisation.size < 1e-12
    assert found.model.share == pytest.approx(1.0)


def test_a_sawtooth_in_the_phase_of_the_steps_is_within_the_uncertainty():
    found = attribute(roll(), toy(model=3e-3, sawtooth=0.5, dt=0.013))
    assert found.outcome == "attributed"
    assert abs(found.model.size - 3e-3) <= found.model.uncertainty < 1.5e-3
    assert max(found.phases) > 1


def test_a_ladder_that_goes_nowhere_gives_no_number():
    found = attribute(roll(), toy(wobble=1e-3))
    assert found.outcome == "not converged"
    assert "limit" in found.reason
    assert found.model is None
    assert found.discretisation is None
    assert found.difference == pytest.approx(1e-3)


def test_an_engine_without_a_step_has_its_whole_difference_as_model():
    found = attribute(roll(), other_shot(speed=0.01))
    assert found.outcome == "no step"
    assert found.model.size == found.difference
    assert found.discretisation is None


def test_the_order_of_real_engines():
    # Semi-implicit Euler: a roll ends v dt / 2 short.
    found = attribute(find_scene("stop"), make_engine("paper-discrete"))
    assert found.order == pytest.approx(1.0, abs=0.02)
    assert found.discretisation.size == pytest.approx(0.8 * 0.02 / 2.0, rel=0.05)
    assert any("semi-implicit" in text for text in found.approximations)
    landed = attribute(find_scene("half-ball-cut"), make_engine("pymunk:mode=landed"))
    assert landed.flat
    assert landed.difference < 1e-8


def test_runs_that_part_are_compared_before_they_do():
    found = attribute(find_scene("break-7"), make_engine("paper-discrete"))
    assert found.instant is not None
    assert 0.0 < found.instant < 0.6256  # the cue ball is on its way
    assert "collisions" in found.until


def test_what_is_but_rounding_is_not_divided():
    """Breaks where bars of femtometres are drawn of a shot that parts at its first collision."""
    found = attribute(find_scene("break-7"), make_engine("pymunk"))
    assert found.outcome == "not compared"
    assert found.difference < 1e-13
    assert (found.model, found.discretisation, found.backward) == (None, None, None)
    assert "before the first event" in found.reason


def test_nothing_is_compared_past_what_can_be_predicted():
    found = attribute(find_scene("galperin-1"), make_engine("pymunk:mode=landed"))
    assert found.instant is not None
    assert "ulp" in found.until
    assert found.rounding < 1e-4


def test_a_run_that_stops_early_is_not_compared():
    found = attribute(roll(), make_engine("pymunk:max_time=0.5"))
    assert found.outcome == "not compared"
    assert "`max_time`" in found.reason


def test_a_scene_that_the_engine_lacks_is_refused():
    with pytest.raises(UnsupportedSceneError):
        attribute(find_scene("sliding-stun"), make_engine("paper-discrete"))


def test_the_same_twice():
    once, again = (attribute(cut(), toy(slope=0.4), plan=Plan((2, 2, 1, 1))) for _ in range(2))
    assert once == again
    assert np.isfinite(once.model.size)

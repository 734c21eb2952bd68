"""Time reversal: our engine comes back as predicted, and one that doesn't is seen."""

from __future__ import annotations

import pytest

from ghostball.model import GhostballError
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.families.reversal import TOLERANCE, ReversalTrial, Step, judge
from ghostball.validation.stress.gas import gas

SCENE = gas(2, 0.1, 3.0)


@pytest.mark.slow
@pytest.mark.compiled
def test_our_engine_is_lost_where_the_tangent_map_says():
    verdict = ReversalTrial("back", gas(3, 0.2, 14.0), 900, 5).run(make_engine("ghostball"))
    assert verdict.faults == ()
    assert verdict.values["predicted"] / 1.5 <= verdict.values["lost_after"]
    assert verdict.values["lost_after"] <= 1.5 * verdict.values["predicted"]


@pytest.mark.parametrize("ours", [True, False])
def test_one_that_does_not_come_back_is_seen(ours):
    lost = [Step(1, 0.1, 1e-16, 1e-16), Step(2, 0.2, 1e-15, 2.0 * TOLERANCE)]
    assert "isn't back after 2" in judge(SCENE, lost, ours).faults[0]


def test_one_that_comes_back_worse_than_rounding_is_seen():
    poor = [Step(1, 0.1, 1e-16, 1e-16), Step(2, 0.2, 1e-15, 1e-12)]
    assert "times what rounding makes of it" in judge(SCENE, poor, True).faults[0]
    assert judge(SCENE, poor, False).faults == ()


SURE = Step(1, 0.1, 1e-16, 1e-16)


def hopeless(k: int, distance: float = 1e-16) -> Step:
    return Step(k, 0.1 * k, 1.0, distance)


def test_a_step_that_is_sure_and_lost_is_seen_behind_one_that_is_neither():
    unsure = Step(2, 0.2, TOLERANCE, 2.0 * TOLERANCE)
    late = Step(3, 0.3, 1e-15, 3.0 * TOLERANCE)
    assert judge(SCENE, [SURE, unsure], False).faults == ()
    assert "isn't back after 3" in judge(SCENE, [SURE, unsure, late], False).faults[0]


def test_a_prediction_that_says_nothing_is_seen():
    assert not judge(SCENE, [SURE, hopeless(2)], True).faults  # one draw may be that small
    vague = [SURE, hopeless(2), hopeless(3)]
    assert "after 3 collisions" in judge(SCENE, vague, True).faults[0]
    assert "the prediction is wrong" in judge(SCENE, vague, True).faults[0]
    # Also behind one that was lost; but not where one that is lost comes between them.
    astray = hopeless(2, 1.0)
    assert judge(SCENE, [SURE, astray, hopeless(3), hopeless(4)], True).faults
    assert not judge(SCENE, [SURE, hopeless(2), hopeless(3, 1.0), hopeless(4)], True).faults


@pytest.mark.parametrize("ours", [True, False])
@pytest.mark.parametrize("steps", [[], [hopeless(1)]])
def test_where_nothing_is_asked_that_is_an_error_of_the_trial(ours, steps):
    with pytest.raises(GhostballError, match="no collision after which rounding leads back"):
        judge(SCENE, steps, ours)


def test_a_scene_without_collisions_is_an_error_of_the_trial():
    with pytest.raises(GhostballError, match="no collision"):
        ReversalTrial("none", gas(2, 0.1, 1e-9), 12, 5).run(make_engine("ghostball"))


def test_lost_beyond_the_prediction_is_no_fault():
    far = [Step(1, 0.1, 1e-16, 1e-16), Step(9, 0.9, TOLERANCE, 1.0)]
    assert judge(SCENE, far, True).faults == judge(SCENE, far, False).faults == ()

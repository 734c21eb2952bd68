"""Time reversal: our engine comes back as predicted, and one that doesn't is seen."""

from __future__ import annotations

import pytest

from reference_adapters.registry import make_engine
from validation.stress.families.reversal import (
    FAMILY,
    TOLERANCE,
    ReversalTrial,
    Step,
    _line,
    _unlike,
    judge,
)
from validation.stress.gas import gas

SCENE = gas(2, 0.1, 3.0)


@pytest.mark.parametrize("suite", ["quick", "full"])
def test_names_are_unique(suite):
    names = [trial.name for trial in FAMILY.trials(suite)]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("scene", [SCENE, _unlike(gas(3, 0.2, 2.0)), _line(20)])
def test_our_engine_comes_back(scene):
    verdict = ReversalTrial("back", scene, 12, 5).run(make_engine("ghostball"))
    assert verdict.faults == ()
    assert len(verdict.values["steps"]) >= 5


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


def test_a_prediction_that_says_nothing_is_seen():
    once = [Step(1, 0.1, 1.0, 1e-16)]
    assert not judge(SCENE, once, True).faults  # one draw may be that small
    vague = [*once, Step(2, 0.2, 1.0, 1e-16)]
    assert "the prediction is wrong" in judge(SCENE, vague, True).faults[0]


def test_lost_beyond_the_prediction_is_no_fault():
    far = [Step(1, 0.1, 1e-16, 1e-16), Step(9, 0.9, TOLERANCE, 1.0)]
    assert judge(SCENE, far, True).faults == judge(SCENE, far, False).faults == ()

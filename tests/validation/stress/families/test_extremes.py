"""Extremes: the shots are proved, and a wrong answer is seen; what is beyond is refused."""

from __future__ import annotations

import pytest

from ghostball.reference_adapters.certified import certify
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.stress.families.extremes import FAMILY
from ghostball.validation.stress.proved import ProvedTrial

TRIALS = {trial.name: trial for trial in FAMILY.trials("quick")}


def test_what_is_proved_has_a_collision_wherever_a_ball_can_get_to_one():
    """A sweep of empty scenes would ask nothing."""
    for name in ("speed-elastic-1e-09", "radius-ratio-rolling-1e+06", "friction-rolling-10"):
        trial = TRIALS[name]
        assert isinstance(trial, ProvedTrial)
        proof = certify(trial.scene)
        assert proof.proved
        assert proof.events


def test_steps_are_not_asked_to_continue_for_years():
    with pytest.raises(Exception, match="more than the 2 s"):
        TRIALS["speed-elastic-1e-09"].run(make_engine("paper-continuous"))

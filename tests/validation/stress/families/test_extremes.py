"""Extremes: the shots are proved, and a wrong answer is seen; what is beyond is refused."""

from __future__ import annotations

import pytest

from ghostball.model import Ball, Scene, SceneError
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


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"velocity": (1e51, 0.0)}, r"velocity.* must be at most 1e\+50, got 1e\+51"),
        ({"radius": 1e-51}, r"radius.* must be at least 1e-50, got 1e-51"),
        ({"position": (1e14, 0.0)}, r"position` must be known to better than the radius"),
    ],
)
def test_what_is_beyond_is_refused_with_the_field_and_the_rule(fields, message):
    with pytest.raises(SceneError, match=message):
        Scene(name="x", t_max=1.0, balls=[Ball(**({"id": "a", "position": (0.0, 0.0)} | fields))])

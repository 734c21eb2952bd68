"""Scaled shots: they are the same to the bit, and an ulp is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import Physics, simulate
from ghostball.validation.stress.families.extremes import ICE, bank
from ghostball.validation.stress.scaling import differences, scaled


@pytest.mark.parametrize("physics", [ICE, Physics(preset="pool", ball_friction=0.05)])
def test_a_scaled_shot_is_the_same_to_the_bit_and_an_ulp_is_seen(physics: Physics):
    scene = bank("scaled", physics, t_max=0.4)
    one = simulate(scene, record="trajectory")
    other = simulate(scaled(scene, -11, 30, 5), record="trajectory")
    assert differences(one, other, -11, 30) == []
    state = other.final_state
    off = state._replace(velocities=np.nextafter(state.velocities, np.inf))
    assert differences(one, replace(other, final_state=off), -11, 30)
    assert other.events is not None
    assert differences(one, replace(other, events=other.events[:-1]), -11, 30)


def test_a_law_that_has_a_scale_is_not_scaled():
    with pytest.raises(Exception, match="can't be scaled"):
        scaled(bank("pool", Physics(preset="pool")), 1, 0, 0)

"""Scaled shots: they are the same to the bit, and an ulp is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scaled_shots import differences, scaled

from ghostball.engine import simulate
from ghostball.model import Physics
from ghostball.validation.stress.families.extremes import ICE, KINDS, bank, cut

SIZES = (
    (0, 30, 0), (19, -13, 20), (-11, 30, -20), (0, -13, 0), (-11, 0, 0), (19, 0, 0),
    (-30, -40, 0), (40, 7, -40), (100, 50, 60), (-100, -60, 30),
)  # fmt: skip
"""Powers of two that lengths, times and masses are multiplied by: 1e-9 to 1e4 times as fast, tables
of 0.2 mm to 2e5 m, 1e-6 to 1e6 of the mass; then far beyond."""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shape", [cut, bank])
def test_a_shot_is_the_same_at_any_size(kind, shape):
    scene = shape("scaled", Physics(**KINDS[kind]), t_max=0.4)
    one = simulate(scene, record="events")
    for length, time, mass in SIZES:
        other = simulate(scaled(scene, length, time, mass), record="events")
        assert differences(one, other, length, time) == [], (length, time, mass)


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

"""Tests of a restitution that falls with speed: its bounds, and its use in every law."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.impacts.laws.falling_restitution import restitution_at
from ghostball.model import Scene, Table

LAWS = ("restitution", "frictional", "han2005", "mathavan2010", "stronge2000")


@given(st.floats(0.0, 1e6), st.floats(0.0, 1.0), st.floats(0.0, 1e3))
def test_restitution_stays_between_0_and_that_of_slow_impacts(speed, slow, loss):
    assert 0.0 <= restitution_at(speed, slow, loss) <= slow


@given(st.floats(0.0, 1e6), st.floats(0.0, 1.0))
def test_without_loss_restitution_is_constant_to_the_bit(speed, slow):
    assert restitution_at(speed, slow, 0.0) == slow


def one_bounce(law: str, **physics: float) -> Scene:
    """Return a ball that rolls, unslowed, into a cushion at exactly 1.44 m/s."""
    return scene_of(
        ball((0.8, 0.5), (1.44, 0.2)),
        table=Table(length=1.0, width=1.0),
        motion="sliding",
        rolling_friction=0.0,
        cushion=law,
        t_max=0.5,
        **physics,
    )


@pytest.mark.parametrize("law", LAWS)
def test_an_impact_has_the_restitution_at_its_speed(law):
    # The root of 1.44 is 1.2, so every law must act as with the restitution 0.9 / (1 + 0.15 * 1.2).
    fixed = simulate(one_bounce(law, cushion_restitution=0.9 / (1.0 + 0.15 * math.sqrt(1.44))))
    falls = one_bounce(law, cushion_restitution=0.9, cushion_restitution_loss=0.15)
    assert np.array_equal(simulate(falls).rest_positions, fixed.rest_positions)
    assert fixed.rest_positions[0, 0] < 0.8  # the ball has bounced


def test_a_mirror_has_none():
    with pytest.raises(ValueError, match=r"cushion_restitution_loss.*has no effect"):
        scene_of(ball((0.5, 0.5)), cushion_restitution_loss=0.1)

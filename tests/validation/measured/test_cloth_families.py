"""Families of cloth: how it slows balls that roll."""

from __future__ import annotations

from functools import partial

import pytest

from ghostball.model import Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.cloth_families import deceleration, pool_rolling
from ghostball.validation.measured.play import OperatorError

OURS = make_engine("ghostball")
PLAY = partial(OURS.simulate, record="trajectory")


def test_our_engine_follows_what_cloth_does_at_each_speed():
    family = pool_rolling(OURS, PLAY)
    assert family.most < 1.0
    assert family.settings["rolling_friction_quadratic"] > 0.0


def test_a_deceleration_is_that_of_the_cloth():
    physics = Physics(motion="sliding", rolling_friction=0.01, rolling_friction_quadratic=0.02)
    expected = 0.01 * 9.81 + 0.02 * 0.8**2
    assert deceleration(PLAY, physics, 0.8) == pytest.approx(expected, rel=1e-3)


def test_a_ball_that_does_not_roll_is_said():
    def still(scene):
        return PLAY(scene.model_copy(update={"t_max": 0.5}))

    with pytest.raises(OperatorError, match="doesn't roll"):
        deceleration(still, Physics(motion="sliding"), 0.8)

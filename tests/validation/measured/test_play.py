"""What operators have in common: how the cloth slows a ball, and the balls of each game."""

from __future__ import annotations

import pytest

from ghostball.model import Physics
from ghostball.validation.measured.play import (
    rolling_deceleration,
)


def test_a_ball_that_rolls_is_slowed_by_both_parts_of_the_cloth():
    physics = Physics(rolling_friction=0.01, rolling_friction_quadratic=0.02)
    assert rolling_deceleration(physics, 2.0) == pytest.approx(0.0981 + 0.08)

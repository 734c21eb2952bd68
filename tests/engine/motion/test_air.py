"""Tests of the deceleration by air, and by rolling friction that grows with the speed."""

import math
from types import SimpleNamespace

import pytest

from ghostball.engine.motion.air import (
    in_air,
    rolling_deceleration,
    slowed_by_air,
    slowed_while_rolling,
)

AIR = SimpleNamespace(powers=object())  # balls; only the difference from None matters
NO_AIR = SimpleNamespace(powers=None)


def laws(air_drag=0.0, roll_quadratic=0.0, slides=True):
    return SimpleNamespace(air_drag=air_drag, roll_quadratic=roll_quadratic, slides=slides)


def test_only_deceleration_that_grows_with_the_speed_counts_as_air():
    assert not in_air(NO_AIR, laws(0.1, 0.1))
    assert not in_air(AIR, laws())
    assert in_air(AIR, laws(0.1))
    assert in_air(AIR, laws(0.0, 0.1))


def test_drag_is_against_the_velocity_and_grows_with_its_square():
    assert slowed_by_air(AIR, laws(0.5), 3.0, 4.0, 1.0, 2.0) == (1.0 - 7.5, 2.0 - 10.0)
    assert slowed_by_air(AIR, laws(), 3.0, 4.0, 1.0, 2.0) == (1.0, 2.0)
    assert slowed_by_air(NO_AIR, laws(0.5), 3.0, 4.0, 1.0, 2.0) == (1.0, 2.0)


@pytest.mark.parametrize(("slides", "felt"), [(True, 5.0 / 7.0), (False, 1.0)])
def test_a_ball_that_rolls_feels_five_sevenths_of_the_air_where_the_cloth_turns_it(slides, felt):
    ax, ay = slowed_while_rolling(AIR, laws(0.35, 0.1, slides), 3.0, 4.0, 0.0, 0.0)
    assert math.hypot(ax, ay) == pytest.approx((0.35 * felt + 0.1) * 25.0, rel=1e-15)
    assert ax * 4.0 == pytest.approx(ay * 3.0, rel=1e-15)
    assert ax < 0.0


def test_rolling_friction_has_a_part_that_grows():
    assert rolling_deceleration(AIR, laws(0.0, 0.1), 0.05, 3.0, 4.0) == pytest.approx(2.55)
    assert rolling_deceleration(NO_AIR, laws(0.0, 0.1), 0.05, 3.0, 4.0) == 0.05

"""The paper's formulas agree with values that were computed in another way."""

from __future__ import annotations

import math

import pytest

from ghostball.model import Ball, Scene, Table
from ghostball.reference_adapters.paper.model import PaperBalls

DECELERATION = 0.02 * 9.81


def balls_of(*balls: Ball, stop: str = "reversal", **scene) -> PaperBalls:
    return PaperBalls(Scene(name="test", balls=balls, **scene), stop)


def one_ball(speed: float, **more) -> PaperBalls:
    ball = Ball(id="cue", position=(0.5, 0.5), velocity=(0.6 * speed, 0.8 * speed))
    return balls_of(ball, **more)


def test_a_step_is_semi_implicit_euler():
    """Explicit Euler (old v) or the exact a t^2 / 2 would put the ball elsewhere."""
    balls = one_ball(1.0)
    balls.advance(0.1)
    speed = 1.0 - DECELERATION * 0.1
    assert balls.vx[0] == pytest.approx(0.6 * speed, rel=1e-15)
    assert balls.x[0] == pytest.approx(0.5 + 0.06 * speed, rel=1e-15)
    assert balls.y[0] == pytest.approx(0.5 + 0.08 * speed, rel=1e-15)


def test_a_ball_that_friction_would_turn_round_stops():
    balls = one_ball(0.5 * DECELERATION * 0.02)
    place = balls.x[0]
    balls.advance(0.02)
    assert not balls.moving
    assert balls.x[0] == place


def test_as_printed_a_slow_ball_trembles_and_creeps_for_ever():
    """Without a rule for rest, no run would end."""
    flip = DECELERATION * 0.02
    balls = one_ball(0.3 * flip, stop="never")
    speeds = []
    for _ in range(1000):
        balls.advance(0.02)
        speeds.append(balls.vx[0] / 0.6)
    assert speeds == pytest.approx([-0.7 * flip, 0.3 * flip] * 500)
    assert balls.x[0] - 0.5 == pytest.approx(0.6 * (-0.2 * flip) * 1000 * 0.02)


def test_the_formula_tests_nothing_so_separating_balls_are_turned_round():
    """As printed, the formula can "cause collisions that shouldn't have happened"."""
    a = Ball(id="a", position=(0, 0), velocity=(-1, 0))
    balls = balls_of(a, Ball(id="b", position=(0.06, 0)))
    assert not balls.approaching(0, 1)
    balls.collide(0, 1)
    assert balls.vx == [0.0, -1.0]
    assert balls.approaching(0, 1)


def test_cushion_overlaps_and_times():
    balls = one_ball(1.0, table=Table(length=2, width=1, cushions=("right", "top")))
    r = balls.radii[0]
    assert dict(balls.cushion_overlaps(0)) == pytest.approx({1: r - 1.5, 3: r - 0.5})
    assert balls.time_to_cushion(0) == pytest.approx((0.5 - r) / 0.8)
    assert [balls.leaving(0, cushion) for cushion in range(4)] == [False, True, False, True]
    balls.flip(0, 1)
    balls.flip(0, 3)
    assert balls.time_to_cushion(0) == math.inf

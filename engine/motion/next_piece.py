"""Predict the next piece of a ball's motion: slide, roll or rest, and its own next event.

This module uses closed forms. It calls `motion.drag` for motion in air, and `motion.flight` for
flight. `motion.position` computes the position of the ball on its piece.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Laws
from ghostball.engine.core.tolerances import SLIP_ROUNDING, TIME_ROUNDING
from ghostball.engine.motion.air import in_air
from ghostball.engine.motion.drag import roll_piece, slide_piece, trim_piece
from ghostball.engine.motion.flight import bounce_on, fly
from ghostball.engine.motion.frame import ALL, NONE, cushion_ahead
from ghostball.engine.motion.geometry import speed_of
from ghostball.engine.motion.obstacles import time_to_obstacle
from ghostball.engine.motion.position import (
    advance,
    impacts_after,
    straighten,
    turn_about_vertical,
)

_NO_MOTION = -1.0  # in place of a duration


@kernel
def mark(balls: Balls, i: int) -> None:
    """Mark ball i, because the current event changes its motion."""
    if not balls.changed[i]:
        balls.changed[i] = True
        balls.touched[0] += 1
        balls.touched[balls.touched[0]] = i


@kernel
def come_to_rest(balls: Balls, laws: Laws, i: int, t: float) -> None:
    """Move ball i to where it stops rolling, at the time t [s], and stop it exactly.

    The ball may keep its spin about the vertical.
    """
    _end_piece(balls, laws, i, t, 0.0, 0.0)
    balls.state[i].vx, balls.state[i].vy = 0.0, 0.0  # air leaves a rounding


@kernel
def start_rolling(balls: Balls, laws: Laws, i: int, t: float) -> None:
    """Move ball i to where its slip ends, at the time t [s]; it rolls from there.

    The cloth has then taken 2/7 of the slip from the velocity, whatever the friction.
    """
    ux, uy = slip(balls, i)
    _end_piece(balls, laws, i, t, balls.state[i].vx - ux / 3.5, balls.state[i].vy - uy / 3.5)


@kernel
def _end_piece(balls: Balls, laws: Laws, i: int, t: float, vx: float, vy: float) -> None:
    """Move ball i to the end of its piece, at the time t [s]; then its phase is ROLLING.

    The phase is ROLLING also if the ball rests.

    Without air, its velocity there is (vx, vy) [m/s]. The mean of the velocities at both ends then
    gives the displacement; unlike the full polynomial, this form cancels no digits.
    """
    ball = balls.state[i]
    if in_air(balls, laws):
        advance(balls, i, t)
        ball.phase = st.ROLLING
        return
    s = t - ball.epoch
    ball.x += 0.5 * s * (ball.vx + vx)
    ball.y += 0.5 * s * (ball.vy + vy)
    ball.vx, ball.vy = vx, vy
    ball.phase = st.ROLLING
    turn_about_vertical(balls, i, s)
    ball.fastest = 0.0
    ball.impacts = impacts_after(balls, i, s, t)
    ball.epoch = t


@kernel
def leave(balls: Balls, i: int) -> None:
    """Remove ball i from the run at its position; its velocity and spin become 0."""
    ball = balls.state[i]
    ball.vx, ball.vy = 0.0, 0.0
    ball.wx, ball.wy, ball.wz = 0.0, 0.0, 0.0
    ball.phase = st.GONE


@kernel
def slip(balls: Balls, i: int) -> tuple[float, float]:
    """Return the slip of ball i [m/s], the velocity of its lowest point, at its epoch."""
    if balls.state[i].phase != st.SLIDING:
        return 0.0, 0.0
    radius = balls.state[i].radius
    return (
        balls.state[i].vx - radius * balls.state[i].wy,
        balls.state[i].vy + radius * balls.state[i].wx,
    )


@kernel
def keep_spin(balls: Balls, i: int) -> None:
    """Prepare ball i for an impulse: keep its angular velocity while its velocity changes.

    The angular velocity of a ball that slides or flies doesn't follow from its velocity anyway.

    Contract: call this before any impulse on a ball, in scenes with sliding.
    """
    if balls.state[i].phase not in (st.SLIDING, st.FLYING):
        balls.state[i].wx = -balls.state[i].vy / balls.state[i].radius
        balls.state[i].wy = balls.state[i].vx / balls.state[i].radius
        balls.state[i].phase = st.SLIDING


@kernel
def friction_against(vx: float, vy: float, deceleration: float) -> tuple[float, float]:
    """Return the acceleration by a deceleration against (vx, vy), as x and y [m/s^2].

    For a rolling ball, mu g against its velocity (paper, 5.2); for a sliding ball, against its
    slip. For motion along an axis the result is exactly along the axis, so that two balls rolling
    the same way have no relative acceleration.
    """
    largest = max(abs(vx), abs(vy))
    if largest == 0.0 or deceleration == 0.0:
        return 0.0, 0.0
    ux, uy = vx / largest, vy / largest
    norm = math.sqrt(ux * ux + uy * uy)
    return -deceleration * (ux / norm), -deceleration * (uy / norm)


@kernel(inline=True)
def predict_motion(balls: Balls, i: int, laws: Laws) -> None:
    """Set the phase of ball i, its accelerations and its own next event, from its velocities.

    A slide has constant accelerations, because the direction of its slip is constant, and ends
    after 2 |u| / (7 mu_s g). A roll is straight and ends after |v| / (mu_r g).
    """
    balls.state[i].bz = 0.0
    straighten(balls, i)
    if _moves_by_itself(balls, i, laws):
        return
    duration = _start_slide(balls, i, laws) if balls.state[i].phase == st.SLIDING else _NO_MOTION
    if duration == _NO_MOTION:
        duration = _start_roll(balls, i, laws)
    if duration != _NO_MOTION:
        predict_obstacles(balls, i, laws, duration, 0)
        if in_air(balls, laws):
            trim_piece(balls, i)


@kernel(inline=True)
def _moves_by_itself(balls: Balls, i: int, laws: Laws) -> bool:
    """Start a flight, or bounces too low to be followed; return False if the ball has neither."""
    height = balls.height
    if height is None:
        return False
    if balls.state[i].phase == st.FLYING:
        fly(height, balls, i, laws)
        if in_air(balls, laws):
            trim_piece(balls, i)
        return True
    if height[i, st.LASTS] > 0.0:
        bounce_on(balls, i)
        predict_obstacles(balls, i, laws, height[i, st.LASTS], 0)
        return True
    return False


@kernel
def predict_again(balls: Balls, i: int, laws: Laws) -> None:
    """Call `predict_motion` without inlining its code; for callers that rarely run."""
    predict_motion(balls, i, laws)


@kernel(inline=True)
def _start_roll(balls: Balls, i: int, laws: Laws) -> float:
    """Let ball i roll or rest; return the time until it stops, or _NO_MOTION if it rests [s]."""
    vx, vy = balls.state[i].vx, balls.state[i].vy
    deceleration = balls.state[i].roll_slowing
    balls.state[i].ax, balls.state[i].ay = friction_against(vx, vy, deceleration)
    if vx == 0.0 and vy == 0.0:
        if balls.state[i].phase != st.GONE:
            balls.state[i].phase = st.RESTING
        balls.state[i].own_time = math.inf
        balls.own_kind[i] = st.OWN_NONE
        return _NO_MOTION
    balls.state[i].phase = st.ROLLING
    balls.own_kind[i] = st.OWN_REST
    if in_air(balls, laws):
        return roll_piece(balls, i, laws)
    if deceleration == 0.0:
        return math.inf
    duration: float = speed_of(vx, vy) / deceleration
    return duration


@kernel(inline=True)
def _start_slide(balls: Balls, i: int, laws: Laws) -> float:
    """Let ball i slide; return the duration [s], or _NO_MOTION if its slip is only rounding."""
    ux, uy = slip(balls, i)
    size = speed_of(ux, uy)
    radius = balls.state[i].radius
    terms = abs(balls.state[i].vx) + abs(balls.state[i].vy)
    terms += radius * (abs(balls.state[i].wx) + abs(balls.state[i].wy))
    if size <= SLIP_ROUNDING * terms:
        return _NO_MOTION
    if in_air(balls, laws):
        return slide_piece(balls, i, laws, ux, uy, size)
    ax, ay = friction_against(ux, uy, balls.state[i].slide_slowing)
    balls.state[i].ax = ax
    balls.state[i].ay = ay
    balls.state[i].bx = 2.5 * ay / radius
    balls.state[i].by = -2.5 * ax / radius
    balls.own_kind[i] = st.OWN_ROLL
    friction = balls.state[i].slide_slowing
    duration: float = size / (3.5 * friction) if friction > 0.0 else math.inf
    return duration


@kernel(inline=True)
def predict_obstacles(balls: Balls, i: int, laws: Laws, duration: float, held: int) -> None:
    """Set the next event of ball i: the first obstacle it reaches within `duration` [s], if any.

    Contract: `own_kind` holds the event at the end of `duration`; it stays the next event if no
    obstacle is reached. Obstacles whose bit is set in `held` are skipped, because a contact step
    keeps the ball away from them. A `duration` below the resolution of the clock takes precedence
    over any obstacle, so that a ball that has almost stopped does stop.
    """
    if duration <= TIME_ROUNDING * balls.state[i].epoch:
        balls.state[i].own_time = balls.state[i].epoch
        return
    lasts, only = duration, ALL
    for k in range(len(laws.obstacles)):
        if k == laws.outer and held == 0:
            # The other obstacles are outside the frame. The ball mostly reaches at most one.
            only = cushion_ahead(balls, i, laws, duration)
            if only == NONE:
                break
        if held >> k & 1 or only not in (ALL, k):
            continue
        s, met = time_to_obstacle(balls, i, laws, k, duration, lasts)
        if s < duration:
            duration = s
            balls.own_kind[i] = st.OWN_CUSHION + k if met else st.OWN_PIECE
    balls.state[i].own_time = balls.state[i].epoch + duration

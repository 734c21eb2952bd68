"""Flight in air: the path of a flying ball with drag, piece by piece.

v' = -g z - k |v| v, with the whole velocity in space. The spin is constant, because no Magnus force
and no torque of the air are modelled. In plan the path is straight, so two numbers are enough: p
along the path and q upwards, p' = -k s p and q' = -g - k s q with s^2 = p^2 + q^2. They are power
series of the time, computed with recurrences as on the cloth (`motion.drag`). The truncation error
of each piece is far below the rounding of the state. The end of a piece is not an event.

The series converges up to the next time, real or complex, at which s^2 vanishes: without drag that
is |v| / g away. So pieces get shorter where the ball is slow, for example at the top of a steep
throw. Below a speed at which the effect of air is below double precision, a piece is a parabola. A
piece that is exactly vertical has a series of its own, without s, and ends at its top.

In any air the height rises first and then falls: the upward speed is 0 at most once. So a ball has
landed within a piece if and only if the piece ends below the cloth, and it has passed a line if and
only if the piece ends beyond the line.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws
from ghostball.engine.core.tolerances import TIME_ROUNDING
from ghostball.engine.motion.geometry import speed_of
from ghostball.engine.motion.series import (
    DEGREE,
    LEFT_OUT,
    OVER,
    PART_OF_SERIES,
    STRAIGHT_DEGREE,
    WORK_OF_SERIES,
    extend_speed,
    falls_to_zero,
    first_zero,
    note_bend,
    put_power,
    shorter,
    straight_series,
)

_PART_OF_FALL = 1.25
"""Longest piece, in units of the time of flight without air.

No piece needs to be longer than the flight, and air changes the time of typical flights by a
thousandth only.
"""

_UNSEEN = 64.0
"""Number of roundings of the clock. Below the speed that gravity gives in this time, a piece is a
parabola."""

# Rows of `Balls.series`, each by power of the time: speed along the path, speed upwards, their
# length, and scratch for roots.
_ALONG, _UP, _SPEED, _ROOT = 0, 1, 2, 3


@kernel
def flight_piece(height: FloatArray, balls: Balls, i: int, laws: Laws) -> float:
    """Start a piece of ball i's flight in air; return its duration [s].

    Contract: there is air drag. `own_kind` is set to the event at the end: landing, or a new piece.
    """
    powers, row = balls.powers, balls.series
    if powers is None or row is None:
        return math.inf
    balls.counters[st.WORK] += WORK_OF_SERIES
    ball = balls.state[i]
    rise, up, gravity = height[i, st.RISE], height[i, st.UP_SPEED], laws.gravity
    along = speed_of(ball.vx, ball.vy)
    speed = speed_of(along, up)
    root = math.sqrt(up * up + 2.0 * gravity * rise)
    free = 0.0
    if up > 0.0:
        free = (up + root) / gravity
    elif rise > 0.0:
        free = 2.0 * rise / (root - up)
    # Bound on the gain of squared speed: that of a free fall, or the terminal speed.
    gained = min(2.0 * gravity * rise, gravity / laws.air_drag)
    fastest = math.sqrt(speed * speed + gained)
    still = max(
        _still_speed(laws.air_drag, gravity, fastest),
        _UNSEEN * TIME_ROUNDING * gravity * ball.epoch,
    )
    row[_ALONG, 0], row[_UP, 0] = along, up
    slowed, degree = 0.0, 1
    if speed <= still:
        row[_ALONG, 1], row[_UP, 1] = 0.0, -gravity
        duration: float = still / gravity
    elif along == 0.0:
        degree = STRAIGHT_DEGREE
        drag = laws.air_drag if up > 0.0 else -laws.air_drag
        slowed = -drag * up * up
        duration = straight_series(row[_UP], up, gravity, drag)
        if up > 0.0:
            duration = min(duration, first_zero(balls.counters, row[_UP], duration))
        for n in range(1, degree + 1):
            row[_ALONG, n] = 0.0
    else:
        slowed = -laws.air_drag * speed * up
        near = speed / (gravity + laws.air_drag * speed * speed)
        longest = min(PART_OF_SERIES * near, _PART_OF_FALL * free)
        duration, degree = _arc(row, laws.air_drag, gravity, speed, near, longest, fastest)
    lands = _time_to_land(balls, row, rise, up, degree, duration, free)
    balls.own_kind[i] = st.OWN_LAND if lands <= duration else st.OWN_PIECE
    duration = min(lands, max(duration, 2.0 * TIME_ROUNDING * ball.epoch))
    _put_piece(powers, row, balls, i, along, slowed, degree, duration)
    return duration


@kernel(inline=True)
def _still_speed(drag: float, gravity: float, fastest: float) -> float:
    """Return the speed [m/s] below which a piece may be a parabola.

    Within the time v / g the speed is at most 2 v. Air would then change the speed by 4 k v^3 / g,
    which must be below the truncation error of a series, relative to `fastest` [m/s]. The third
    root is bounded from below with square roots: exponent 1/4 + 1/16 for 1/3.
    """
    least = math.sqrt(0.25 * LEFT_OUT * gravity / drag)
    part = max(fastest / least, 1.0)
    root = math.sqrt(math.sqrt(part))
    slowest: float = least * (root * math.sqrt(math.sqrt(root)))
    return slowest


@kernel
def _arc(
    row: FloatArray,
    drag: float,
    gravity: float,
    speed: float,
    near: float,
    longest: float,
    fastest: float,
) -> tuple[float, int]:
    """Compute the series of a curved piece; return its duration [s], and its degree."""
    row[_SPEED, 0] = speed
    allowed = LEFT_OUT * fastest
    degree, small, scale, last = DEGREE, 0, 1.0, 0.0
    for n in range(DEGREE):
        if n > 0:
            extend_speed(row, _SPEED, _ALONG, _UP, n)
        along, up = 0.0, 0.0
        for j in range(n + 1):
            along += row[_SPEED, j] * row[_ALONG, n - j]
            up += row[_SPEED, j] * row[_UP, n - j]
        row[_ALONG, n + 1] = -OVER[n + 1] * (drag * along)
        row[_UP, n + 1] = -OVER[n + 1] * (drag * up + (gravity if n == 0 else 0.0))
        scale *= longest
        before, last = last, abs(row[_ALONG, n + 1]) + abs(row[_UP, n + 1])
        small = small + 1 if scale * last <= 0.25 * allowed else 0
        if n > 1 and small > 1:
            degree = n + 1
            break
        if n == DEGREE - 1:
            longest *= shorter(allowed / (scale * max(last, before / near)))
    return longest, degree


@kernel(inline=True)
def _time_to_land(
    balls: Balls,
    row: FloatArray,
    rise: float,
    up: float,
    degree: int,
    duration: float,
    free: float,
) -> float:
    """Return the time at which a ball lands within a duration [s], or inf.

    `free` [s]: the time without air. For a flight that starts on the cloth, the height is divided
    by the time, so that the start is not a root.
    """
    if rise > 0.0:
        row[_ROOT, 0], row[_ROOT, 1] = rise, up
        for n in range(1, degree + 1):
            row[_ROOT, n + 1] = row[_UP, n] * OVER[n + 1]
        return falls_to_zero(balls.counters, row[_ROOT], degree + 1, duration, free)
    if up <= 0.0:
        return 0.0
    for n in range(degree + 1):
        row[_ROOT, n] = row[_UP, n] * OVER[n + 1]
    return falls_to_zero(balls.counters, row[_ROOT], degree, duration, free)


@kernel(inline=True)
def _put_piece(
    powers: FloatArray,
    row: FloatArray,
    balls: Balls,
    i: int,
    along: float,
    slowed: float,
    degree: int,
    duration: float,
) -> None:
    """Store the series of a piece in ball i's motion.

    `slowed`: vertical deceleration by air at the start.
    """
    ball = balls.state[i]
    dx, dy = 0.0, 0.0
    if along > 0.0:
        dx, dy = ball.vx / along, ball.vy / along
    ball.ax, ball.ay = row[_ALONG, 1] * dx, row[_ALONG, 1] * dy
    put_power(powers, i, 2, 0.0, 0.0, 0.5 * slowed)
    for n in range(2, degree + 1):
        power = row[_ALONG, n] * OVER[n + 1]
        put_power(powers, i, n + 1, power * dx, power * dy, row[_UP, n] * OVER[n + 1])
    if degree > 1:
        note_bend(powers, i, degree, duration)


@kernel
def time_to_pass(balls: Balls, i: int, away: float, rate: float, duration: float) -> float:
    """Return the time at which ball i passes a line on the piece that has just started [s], or inf.

    `away` [m]: distance of the line. `rate` [m/s]: rate of change of this distance, negative.
    `duration` [s]: only passes before it count.
    """
    powers, row = balls.powers, balls.series
    if powers is None or row is None:
        return math.inf
    degree = int(powers[i, st.COUNT])
    part = rate / row[_ALONG, 0]
    row[_ROOT, 0] = away
    for n in range(degree + 1):
        row[_ROOT, n + 1] = part * (row[_ALONG, n] * OVER[n + 1])
    if away == 0.0:
        return 0.0
    return falls_to_zero(balls.counters, row[_ROOT], degree + 1, duration, away / -rate)

"""Flight in air: how a ball that feels drag goes up, down and along, piece by piece.

v' = -g z - k |v| v, of the whole velocity in space; the spin stays, since no Magnus force and no
torque of the air are modelled. In plan the ball goes straight on, so that two numbers tell all:
p along its way and q upwards, p' = -k s p and q' = -g - k s q with s^2 = p^2 + q^2. They are power
series of the time, found by recurrences as on the cloth (`motion.drag`), and each piece is cut
where what it leaves out is far below the rounding of the state. A piece that ends is no event.

The series converges up to the next time, be it complex, at which s^2 vanishes: without drag that is
|v| / g away. So pieces get shorter where the ball is slow, as at the top of a steep throw. There,
below a speed at which air does nothing that a double could tell, one of them is a parabola. One
that goes exactly up or down has a series of its own, without s, and ends a piece at its top.

Height rises and then falls, in any air: v is 0 upwards once at most. So a ball has landed within a
piece if and only if the piece ends below the cloth, and along its way it has passed a line if and
only if the piece ends beyond it.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws
from ghostball.engine.core.tolerances import EPS, TIME_ROUNDING
from ghostball.engine.motion.geometry import speed_of
from ghostball.engine.motion.series import (
    DEGREE,
    LEFT_OUT,
    OVER,
    PART_OF_SERIES,
    STRAIGHT_DEGREE,
    WORK_OF_SERIES,
    extend_speed,
    first_zero,
    note_bend,
    put_power,
    shorter,
    straight_series,
)

_PART_OF_FALL = 1.25
"""Longest piece, in units of the time that the ball would fly without air, since none needs to be
longer than the flight: air changes the time of a flight at play by a thousandth."""

_UNSEEN = 64.0
"""Speed that gravity gives in so many roundings of the clock, below which a piece is a parabola."""

# Rows of `Balls.series`, each by power of the time: along its way, upwards, the speed, and room.
_ALONG, _UP, _SPEED, _ROOT = 0, 1, 2, 3


@kernel
def flight_piece(
    powers: FloatArray, row: FloatArray, height: FloatArray, balls: Balls, i: int, laws: Laws
) -> float:
    """Begin a piece of ball i's flight in air; return how long it lasts [s].

    Contract: air drags, and `own_kind` is set to what happens then: it lands, or the piece ends.
    """
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
    # How fast it may become: as by the fall alone, or to where the air holds it.
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
            duration = min(duration, first_zero(row[_UP], duration))
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
    """Return below which speed a piece may be a parabola, beside one so fast [m/s].

    Within the time v / g it is no faster than 2 v; then what air would have taken, 4 k v^3 / g, is
    to be what a series may leave out of the fastest. The third root is taken from below, by square
    roots: 1/4 + 1/16 for 1/3.
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
    """Find the series of a piece along an arc; return how long it lasts [s], and its degree."""
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
    """Return when a ball lands within a duration [s], or inf; `free` is when it would without air.

    The time of a flight from the cloth is a root of what is left of the height over the time: the
    start is no landing.
    """
    if rise > 0.0:
        row[_ROOT, 0], row[_ROOT, 1] = rise, up
        for n in range(1, degree + 1):
            row[_ROOT, n + 1] = row[_UP, n] * OVER[n + 1]
        return _falls_to_zero(balls, row[_ROOT], degree + 1, duration, free)
    if up <= 0.0:
        return 0.0
    for n in range(degree + 1):
        row[_ROOT, n] = row[_UP, n] * OVER[n + 1]
    return _falls_to_zero(balls, row[_ROOT], degree, duration, free)


@kernel
def _falls_to_zero(balls: Balls, c: FloatArray, degree: int, longest: float, guess: float) -> float:
    """Return when a polynomial that is positive at first comes to 0 within a time [s], or inf.

    Contract: it does so once at most. By Newton's steps, from a guess, and by halves where they
    would leave what is known to hold the root.
    """
    value = 0.0
    for n in range(degree, -1, -1):
        value = value * longest + c[n]
    if value > 0.0:
        return math.inf
    least, most = 0.0, longest
    s = guess if guess < longest else longest
    for _ in range(128):
        balls.counters[st.WORK] += 1
        value, slope = 0.0, 0.0
        for n in range(degree, -1, -1):
            slope = slope * s + value
            value = value * s + c[n]
        if value > 0.0:
            least = s
        else:
            most = s
        later = s - value / slope if slope < 0.0 else least
        if not least < later < most:
            if value == 0.0 or abs(later - s) <= 2.0 * EPS * s:
                return s
            later = 0.5 * (least + most)
        if abs(later - s) <= 2.0 * EPS * s:
            return later
        s = later
    return s


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
    """Put the series of a piece in ball i's motion; air first slows its rise by `slowed`."""
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
def time_to_pass(
    powers: FloatArray,
    row: FloatArray,
    balls: Balls,
    i: int,
    away: float,
    rate: float,
    duration: float,
) -> float:
    """Return when ball i passes a line on the piece that has just begun [s], or inf.

    It is `away` from the line [m], which it approaches at `rate` < 0 [m/s]; within `duration` [s].
    """
    degree = int(powers[i, st.COUNT])
    part = rate / row[_ALONG, 0]
    row[_ROOT, 0] = away
    for n in range(degree + 1):
        row[_ROOT, n + 1] = part * (row[_ALONG, n] * OVER[n + 1])
    if away == 0.0:
        return 0.0
    return _falls_to_zero(balls, row[_ROOT], degree + 1, duration, away / -rate)

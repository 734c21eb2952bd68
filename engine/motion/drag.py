"""Motion on the cloth if air, or rolling friction, slows fast balls more than slow ones.

The drag is dv/dt = -k |v| v, in addition to friction. A rolling ball feels 5/7 of it, because the
cloth takes the rest. So it moves straight, with the deceleration a + b v^2. Neither a roll nor a
slide is a polynomial then: the motion consists of pieces, each the power series of the exact
motion. The truncation error of a straight piece is far below the rounding of the state; that of a
turning piece is `SLIDE_ERROR`. The end of a piece is not an event.

Straight motion has one unknown, p' = -(a + b p^2), whose series has the recurrence
(n + 1) p_{n+1} = -(a [n = 0] + b sum p_i p_{n-i}). This includes slides with a slip parallel to the
velocity. Any other slide turns: its power series needs two more recurrences, for |u| and u / |u|,
where u is the slip.

The direction of the slip turns like a power of the remaining slip, so the series of a slide
converges at most up to its end, and pieces get shorter towards the end (`_PART_OF_SERIES`). The
last piece starts when the remaining turn changes the position by less than `SLIDE_ERROR`. Then the
slip ends as with a constant drag, for which the time has a closed form, and the velocity loses the
parts that cloth and air take in this time. The end of this piece is exact; during the piece the
motion is a parabola.

A ball keeps rolling in any air: the code doesn't check whether the cloth's friction is large enough
to turn the ball so fast, (2/7) k v^2 <= mu_s g. For k and mu_s of a pool ball this holds up to
40 m/s.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws
from ghostball.engine.core.tolerances import EPS, SLIDE_ERROR, TIME_ROUNDING
from ghostball.engine.motion.air import felt_drag
from ghostball.engine.motion.geometry import speed_of
from ghostball.engine.motion.series import (
    DEGREE,
    LEFT_OUT,
    OVER,
    STRAIGHT_DEGREE,
    WORK_OF_SERIES,
    first_zero,
    note_bend,
    put_power,
    shorter,
    straight_series,
)
from ghostball.model.trajectory.polynomial import OF_WX, OF_WY, OF_X, OF_Y, OF_Z, PER_POWER

_STILL = 2.0**-18
"""Speed, relative to the slip, below which the effect of air is below double precision, if the drag
at the speed of the slip isn't much larger than friction."""

_STRAIGHT = 4.0 * EPS
"""Sine of the angle between slip and velocity that counts as rounding."""

_PART_OF_SERIES = 0.5
"""Longest piece of a slide, in units of an estimate of the series' radius of convergence.

n powers take n^2 products, and shorter pieces need fewer powers. With the limit for flight, 0.75,
slides take 5 % more time. The last coefficients decide how long the piece may be."""

# Rows of `Balls.series`, each by power of the time: velocity, slip, size and direction of the slip,
# speed.
_VX, _VY, _UX, _UY, _SLIP, _EX, _EY, _SPEED = 0, 1, 2, 3, 4, 5, 6, 7


@kernel
def slide_piece(balls: Balls, i: int, laws: Laws, ux: float, uy: float, size: float) -> float:
    """Start a piece of ball i's slide with the slip (ux, uy) [m/s]; return its duration [s].

    Contract: the slip isn't 0. `own_kind` is set to the event at the end of the piece.
    """
    powers, series = balls.powers, balls.series
    if powers is None or series is None:
        return math.inf
    balls.counters[st.WORK] += WORK_OF_SERIES
    ball = balls.state[i]
    friction = ball.slide_slowing
    ex, ey = ux / size, uy / size
    speed = speed_of(ball.vx, ball.vy)
    balls.own_kind[i] = st.OWN_PIECE
    if friction == 0.0:
        if speed == 0.0:  # an impact has stopped the ball: no deceleration any more
            return _go_straight(powers, series, balls, i, 1.0, 0.0, 0.0, 0.0, 0.0)
        dx, dy = ball.vx / speed, ball.vy / speed
        return _go_straight(powers, series, balls, i, dx, dy, speed, 0.0, laws.air_drag)
    if abs(ex * ball.vy - ey * ball.vx) <= _STRAIGHT * speed:
        return _slide_straight(powers, series, balls, i, laws.air_drag, ex, ey, size)
    duration = _last_piece(balls, i, laws.air_drag, ux, uy, size, speed)
    if duration > 0.0:
        balls.own_kind[i] = st.OWN_ROLL
        return duration
    return _turn(powers, series, balls, i, laws.air_drag, ux, uy, size, speed)


@kernel
def roll_piece(balls: Balls, i: int, laws: Laws) -> float:
    """Start a piece of ball i's roll; return its duration [s].

    Contract: the ball moves. `own_kind` is set to the event at the end of the piece.
    """
    powers, series = balls.powers, balls.series
    if powers is None or series is None:
        return math.inf
    ball = balls.state[i]
    speed = speed_of(ball.vx, ball.vy)
    dx, dy = ball.vx / speed, ball.vy / speed
    drag = laws.roll_quadratic + felt_drag(laws) * laws.air_drag
    duration = _go_straight(powers, series, balls, i, dx, dy, speed, ball.roll_slowing, drag)
    stops = first_zero(balls.counters, series[_SPEED], duration)
    balls.own_kind[i] = st.OWN_REST if stops <= duration else st.OWN_PIECE
    return min(stops, duration)


@kernel
def _go_straight(
    powers: FloatArray,
    series: FloatArray,
    balls: Balls,
    i: int,
    dx: float,
    dy: float,
    speed: float,
    a: float,
    b: float,
) -> float:
    """Start a piece along (dx, dy) with the deceleration a + b p^2; return its validity [s]."""
    p = series[_SPEED]
    duration: float = straight_series(p, speed, a, b)
    ball = balls.state[i]
    ball.ax, ball.ay = p[1] * dx, p[1] * dy
    put_power(powers, i, 2, 0.0, 0.0, 0.0)
    for n in range(2, STRAIGHT_DEGREE + 1):
        power = p[n] * OVER[n + 1]
        put_power(powers, i, n + 1, power * dx, power * dy, 0.0)
    ball.bx, ball.by = 0.0, 0.0
    if b > 0.0 and speed > 0.0:
        # p'' = 2 b p (a + b p^2): the deceleration decreases.
        powers[i, st.JERK_X], powers[i, st.JERK_Y] = 2.0 * abs(p[2] * dx), 2.0 * abs(p[2] * dy)
        powers[i, st.COUNT] = STRAIGHT_DEGREE
    else:
        note_bend(powers, i, STRAIGHT_DEGREE, duration)
    return duration


@kernel
def _slide_straight(
    powers: FloatArray,
    series: FloatArray,
    balls: Balls,
    i: int,
    k: float,
    ex: float,
    ey: float,
    size: float,
) -> float:
    """Start a piece of a slide parallel to its slip, along (ex, ey); return its duration [s].

    The piece ends if the ball reverses its direction, because the drag then changes its sign.
    """
    ball = balls.state[i]
    friction = ball.slide_slowing
    speed = ex * ball.vx + ey * ball.vy
    # From rest, or from a speed that vanishes within the rounding of the clock, friction moves
    # the ball against the slip.
    unseen = TIME_ROUNDING * ball.epoch * friction
    with_slip = speed > max(_STILL * size, unseen)
    drag = k if with_slip else -k
    duration = _go_straight(powers, series, balls, i, ex, ey, speed, friction, drag)
    p = series[_SPEED]
    spins = -2.5 * friction / ball.radius  # friction alone turns the ball, at a constant rate
    ball.bx, ball.by = spins * ey, -spins * ex
    slip = series[_SLIP]
    slip[0], slip[1] = size, p[1] - 2.5 * friction
    for n in range(2, STRAIGHT_DEGREE + 1):
        slip[n] = p[n]
    ends = first_zero(balls.counters, slip, duration)
    turns = first_zero(balls.counters, p, duration) if with_slip else math.inf
    if ends <= min(turns, duration):
        balls.own_kind[i] = st.OWN_ROLL
        return ends
    return min(turns, duration)


@kernel
def _last_piece(
    balls: Balls, i: int, k: float, ux: float, uy: float, size: float, speed: float
) -> float:
    """Start the last piece of a slide and return its duration [s], or return 0 if it is too early.

    In the remaining time t, the turn changes the position by at most (2/7) k v^2 t^2. For a
    constant drag D, d/dt (c |u| - D.u) = D^2 - c^2, where c is the deceleration of the slip. The
    cloth takes 2/7 of the slip from v, and the air 5/7 of what it would take without the cloth;
    both hold for any direction of the slip.
    """
    ball = balls.state[i]
    slows = 3.5 * ball.slide_slowing
    left: float = size / slows
    place = max(abs(ball.x) + abs(ball.y), ball.radius)
    most = speed + size / 3.5
    if 2.0 * k * most * most * left * left > 7.0 * SLIDE_ERROR * place:
        return 0.0
    # The drag in the middle of the piece.
    x, y = ball.vx - ux / 7.0, ball.vy - uy / 7.0
    drag = k * math.sqrt(x * x + y * y)
    x, y = drag * x, drag * y
    duration: float = (slows * size - (x * ux + y * uy)) / (slows * slows - (x * x + y * y))
    ax = -(ux / 3.5) / duration - x / 1.4
    ay = -(uy / 3.5) / duration - y / 1.4
    ball.ax, ball.ay = ax, ay
    ball.bx, ball.by = (uy / duration + ay) / -ball.radius, (ux / duration + ax) / ball.radius
    return duration


@kernel
def _turn(
    powers: FloatArray,
    series: FloatArray,
    balls: Balls,
    i: int,
    k: float,
    ux: float,
    uy: float,
    size: float,
    speed: float,
) -> float:
    """Start a piece of a turning slide; return its duration [s]."""
    ball = balls.state[i]
    friction, row = ball.slide_slowing, series
    slows = 3.5 * friction
    drag = k * speed * speed
    if speed <= _STILL * size:
        k = 0.0
    # About the time at which the slip or the velocity vanishes, possibly a complex time: the radius
    # of convergence of the power series.
    near = size / (slows + drag)
    if k > 0.0:
        near = min(near, speed / (friction + drag))
    longest: float = _PART_OF_SERIES * near
    if k == 0.0:
        longest = min(longest, _STILL * size / friction)
    row[_VX, 0], row[_VY, 0], row[_UX, 0], row[_UY, 0] = ball.vx, ball.vy, ux, uy
    row[_SLIP, 0], row[_EX, 0], row[_EY, 0], row[_SPEED, 0] = size, ux / size, uy / size, speed
    allowed = SLIDE_ERROR * (speed + size)
    degree, small, scale, last = DEGREE, 0, 1.0, 0.0
    for n in range(DEGREE):
        air_x, air_y = speed * ball.vx, speed * ball.vy
        if n > 0:
            air_x, air_y = _extend(row, n, k > 0.0)
        over = OVER[n + 1]
        row[_VX, n + 1] = -over * (friction * row[_EX, n] + k * air_x)
        row[_VY, n + 1] = -over * (friction * row[_EY, n] + k * air_y)
        row[_UX, n + 1] = -over * (slows * row[_EX, n] + k * air_x)
        row[_UY, n + 1] = -over * (slows * row[_EY, n] + k * air_y)
        scale *= longest
        before, last = last, abs(row[_UX, n + 1]) + abs(row[_UY, n + 1])
        last += abs(row[_VX, n + 1]) + abs(row[_VY, n + 1])
        small = small + 1 if scale * last <= 0.25 * allowed else 0
        if n > 1 and small > 1:
            degree = n + 1
            break
        if n == DEGREE - 1:
            longest *= shorter(allowed / (scale * max(last, before / near)))
    ball.ax, ball.ay = row[_VX, 1], row[_VY, 1]
    turn = 2.5 * friction / ball.radius
    ball.bx, ball.by = -turn * row[_EY, 0], turn * row[_EX, 0]
    put_power(powers, i, 2, 0.0, 0.0, 0.0)
    for n in range(2, degree + 1):
        put_power(powers, i, n + 1, row[_VX, n] * OVER[n + 1], row[_VY, n] * OVER[n + 1], 0.0)
        at = st.POWERS + PER_POWER * (n - 2)
        powers[i, at + OF_WX] = -turn * row[_EY, n - 1] * OVER[n]
        powers[i, at + OF_WY] = turn * row[_EX, n - 1] * OVER[n]
    note_bend(powers, i, degree, longest)
    return longest


@kernel(inline=True)
def _extend(row: FloatArray, n: int, drags: bool) -> tuple[float, float]:
    """Compute power n > 0 of the slip's size r and direction e, from u = r e, and of the speed.

    Return power n of the speed times the velocity, x and y. The four sums are computed in the same
    loops: each addition waits for the previous one, so four sums take no longer than one.
    """
    half = (n + 1) // 2
    slip = row[_UX, 0] * row[_UX, n] + row[_UY, 0] * row[_UY, n]
    fast = row[_VX, 0] * row[_VX, n] + row[_VY, 0] * row[_VY, n]
    for j in range(1, half):
        k = n - j
        slip += (
            row[_UX, j] * row[_UX, k] + row[_UY, j] * row[_UY, k] - row[_SLIP, j] * row[_SLIP, k]
        )
        fast += (
            row[_VX, j] * row[_VX, k] + row[_VY, j] * row[_VY, k] - row[_SPEED, j] * row[_SPEED, k]
        )
    if n % 2 == 0:
        square = row[_UX, half] * row[_UX, half] + row[_UY, half] * row[_UY, half]
        slip += 0.5 * (square - row[_SLIP, half] * row[_SLIP, half])
        square = row[_VX, half] * row[_VX, half] + row[_VY, half] * row[_VY, half]
        fast += 0.5 * (square - row[_SPEED, half] * row[_SPEED, half])
    over = 1.0 / row[_SLIP, 0]
    slip *= over
    fast = fast / row[_SPEED, 0] if drags else 0.0
    row[_SLIP, n], row[_SPEED, n] = slip, fast
    x, y = row[_UX, n] - slip * row[_EX, 0], row[_UY, n] - slip * row[_EY, 0]
    air_x = row[_SPEED, 0] * row[_VX, n] + fast * row[_VX, 0]
    air_y = row[_SPEED, 0] * row[_VY, n] + fast * row[_VY, 0]
    for j in range(1, n):
        slip, fast = row[_SLIP, j], row[_SPEED, j]
        x -= slip * row[_EX, n - j]
        y -= slip * row[_EY, n - j]
        air_x += fast * row[_VX, n - j]
        air_y += fast * row[_VY, n - j]
    row[_EX, n], row[_EY, n] = over * x, over * y
    return air_x, air_y


@kernel
def trim_piece(balls: Balls, i: int) -> None:
    """Remove the last powers of ball i's piece that have no effect until its own next event."""
    powers = balls.powers
    if powers is None:
        return
    ball = balls.state[i]
    duration, count = ball.own_time - ball.epoch, int(powers[i, st.COUNT])
    if count == 0 or not duration < math.inf:
        return
    scale = duration * duration
    allowed = 0.25 * LEFT_OUT * (abs(ball.vx) + abs(ball.vy))
    kept = 1
    for power in range(1, count):
        at = st.POWERS + PER_POWER * power
        size = abs(powers[i, at + OF_X]) + abs(powers[i, at + OF_Y]) + abs(powers[i, at + OF_Z])
        if scale * (power + 2) * size > allowed:
            kept = power + 1
        scale *= duration
    powers[i, st.COUNT] = kept

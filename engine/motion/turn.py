"""A piece of a slide in air that turns, found at nodes: longer than its power series reaches.

With the slip u = r e, the velocity v, the deceleration f by friction and the drag k |v| v:

    r' = -(7/2) f - k |v| v.e,   z' = -(5/7) k |v| v for z = v - (2/7) u,
    w' = (1 + w^2) / 2 phi',     phi' = -k |v| v.n / r,

w the tangent of half the angle phi that e has turned since the piece began, n across e. All of it
is integrated at the nodes of `motion.nodes`, by Picard's iteration: what the air does is small, so
that each turn multiplies an error by about k v^2 / ((7/2) f) times -log of the slip that is left.
What the motion then is at more points gives the powers of the time.

How far the velocity may be off at the end of the piece, in units of the speeds, is the sum of three
that are asked of every piece. What the iteration leaves: its last change, seen where the piece ends
and at its middle, times that factor and its powers. What the nodes leave out: by the last Chebyshev
coefficient of the rates. And, largest by far, what the powers leave out (`left_out`): beyond the
last coefficients of their Chebyshev series others follow that fall no slower than by the rho of
`motion.nodes`, and those that come down onto lower ones double them (Trefethen 2013, theorem 8.2
and chapter 4). As errors of a slide never grow (friction and drag are gradients of convex
functions: `reference_adapters.certified.slide`), those of the pieces add up, and no more. A piece
that would err by more than is allowed is a power series instead (`motion.drag`).
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Air, Balls, FloatArray
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.motion.nodes import (
    BENDS,
    BEYOND,
    BEYOND_NODES,
    FALLS_TO,
    INTEGRALS,
    NODES,
    OVER_POINT,
    OVER_RHO,
    PARTS,
    POINT,
    POINTS,
    SPAN,
    TAKEN,
    TIMES,
    TO_CHEBYSHEV,
    TO_POINTS,
    TO_POWERS,
    TURNED,
)
from ghostball.engine.motion.series import OVER

POWERS_LEAVE_OUT = EPS / 2.0
"""What the powers of a piece may leave out of the velocity, in units of the speeds, as `left_out`
estimates it; in slides that were compared with 34 digits it is a tenth of that, or less."""

_NODES_LEAVE_OUT = EPS / 32.0
"""The same of the nodes, and of the iteration."""

_LIKELY = 0.024
"""What the powers of a piece leave out, as far as one can tell before: in units of what friction
does to the velocity while the direction turns, and of rho^-POINTS / (rho - 1).

From how fast the coefficients of a power of the slip fall, and measured, as the largest of 1100
pieces. It only says which piece is tried."""

_MOST_GAIN = 0.5
"""Largest factor by which a turn of the iteration may multiply an error."""

_MOST_TURNS = 24

_WORK = 30
"""Units of work of one turn of the iteration."""

_WORK_OF_POWERS = 100
"""And of what takes the motion from the nodes to powers."""

# Rows of `Air.nodes` and of `Air.series`, between which it goes to and fro, so that the compiler
# can tell what is read from what is written. By node: the turn w, what is added to z and to r; and
# their rates.
_W, _ZX, _ZY, _R = 0, 1, 2, 3
# Then by point, by degree and by power: acceleration and direction, beyond those at first, over the
# time.
_AX, _AY, _EX, _EY = 0, 1, 2, 3


@kernel
def turn_piece(
    higher: FloatArray,
    air: Air,
    balls: Balls,
    i: int,
    k: float,
    ux: float,
    uy: float,
    size: float,
    speed: float,
) -> float:
    """Begin a piece of ball i's slide that turns; return its duration [s], or 0 where that fails.

    Contract: neither slip (ux, uy) nor speed is 0; what was left of an earlier piece is overwritten
    but where it fails. No allocation.
    """
    ball = balls.state[i]
    friction = ball.slide_slowing
    slows, speeds = 3.5 * friction, speed + size
    most = speed + size / 3.5
    drag = k * most * most
    if not drag < slows:
        return 0.0
    part = _longest(k, ball.vx, ball.vy, ux, uy, friction, size, speed)
    if part < 0:
        return 0.0
    gain = drag / (slows - drag) * SPAN[part]
    if gain > _MOST_GAIN:
        return 0.0
    # As the slip would end by the drag at first; see `motion.drag`.
    rate = k * speed
    now = rate * speed
    lasts = slows * size - rate * (ball.vx * ux + ball.vy * uy)
    duration: float = TAKEN[part] * lasts / (slows * slows - now * now)
    row, room = air.nodes, air.series
    if not _iterate(row, room, balls, i, part, k, ux, uy, size, speed, duration, gain):
        return 0.0
    balls.counters[st.WORK] += _WORK_OF_POWERS
    _take_to_points(row, room, balls, i, part, k, ux, uy, size, speed, duration)
    _take_to_degrees(row, room)
    if not left_out(row, part, duration) <= POWERS_LEAVE_OUT * speeds:
        return 0.0
    _begin(higher, air, balls, i, k, ux / size, uy / size, speed, duration)
    return duration


@kernel(inline=True)
def _longest(
    k: float,
    vx: float,
    vy: float,
    ux: float,
    uy: float,
    friction: float,
    size: float,
    speed: float,
) -> int:
    """Return which piece is the longest that is likely to leave out little enough; -1: none."""
    across = abs(vx * uy - vy * ux) / size
    turns = k * speed * across / (3.5 * friction)
    likely = _LIKELY * turns * (size / 3.5)
    part = len(PARTS) - 1
    while part >= 0:
        if likely * FALLS_TO[part] * BEYOND[part] <= POWERS_LEAVE_OUT * (speed + size):
            break
        part -= 1
    return part


@kernel(inline=True)
def _at_first(
    balls: Balls, i: int, rate: float, ux: float, uy: float, size: float
) -> tuple[tuple[float, float], tuple[float, float], float, tuple[float, float]]:
    """Return the slip's direction, the drag [m/s^2], its part along the slip, and z [m/s].

    As the piece begins; `rate` [1/s] is the drag over the velocity.
    """
    ball = balls.state[i]
    ex, ey = ux / size, uy / size
    along = rate * (ball.vx * ex + ball.vy * ey)
    z = ball.vx - ux / 3.5, ball.vy - uy / 3.5
    return (ex, ey), (rate * ball.vx, rate * ball.vy), along, z


@kernel
def _iterate(
    row: FloatArray,
    rates: FloatArray,
    balls: Balls,
    i: int,
    part: int,
    k: float,
    ux: float,
    uy: float,
    size: float,
    speed: float,
    duration: float,
    gain: float,
) -> bool:
    """Put the motion at the nodes in `row`, its rates in `rates`.

    Return whether it is as exact as it must be.
    """
    ball = balls.state[i]
    friction, rate = ball.slide_slowing, k * speed
    (ex, ey), (dx, dy), dr, (zx, zy) = _at_first(balls, i, rate, ux, uy, size)
    falls = (3.5 * friction + dr) * duration
    spins, takes = -0.5 * duration, -duration / 1.4
    # At a rate that changes but by the turn itself; the air at first.
    turns = spins * rate * (ball.vy * ex - ball.vx * ey) / size
    more = 0.5 * rate * (zx * ex + zy * ey) / (3.5 * friction + dr) * TAKEN[part]
    for j in range(NODES):
        turned = TURNED[part, j]
        row[_W, j], row[_R, j] = turns * turned * (1.0 + more * turned), 0.0
        row[_ZX, j], row[_ZY, j] = takes * TIMES[part, j] * dx, takes * TIMES[part, j] * dy
    # What an error of w does to the velocity: e is off by twice that.
    weight = 2.0 * friction * duration
    allowed = _NODES_LEAVE_OUT * (speed + size)
    share = gain / (1.0 - gain)
    drags = 2.0 * k * (speed + size / 3.5) * duration
    for _ in range(_MOST_TURNS):
        balls.counters[st.WORK] += _WORK
        for j in range(NODES):
            w = row[_W, j]
            square = w * w
            over = 1.0 / (1.0 + square)
            c, s = (1.0 - square) * over, 2.0 * w * over
            x, y = c * ex - s * ey, c * ey + s * ex
            slip = size - falls * TIMES[part, j] + row[_R, j]
            vx = zx + row[_ZX, j] + slip * x / 3.5
            vy = zy + row[_ZY, j] + slip * y / 3.5
            drag = k * math.sqrt(vx * vx + vy * vy)
            rates[_W, j] = spins * (1.0 + square) * drag * (vy * x - vx * y) / slip
            rates[_ZX, j] = takes * drag * vx
            rates[_ZY, j] = takes * drag * vy
            rates[_R, j] = -duration * (drag * (vx * x + vy * y) - dr)
        w, half = row[_W, NODES - 1], row[_W, NODES // 2]
        x, y, r = row[_ZX, NODES - 1], row[_ZY, NODES - 1], row[_R, NODES - 1]
        for quantity in range(4):
            _integrate(row, rates, quantity, part)
        change = weight * (abs(row[_W, NODES - 1] - w) + abs(row[_W, NODES // 2] - half))
        change += abs(row[_ZX, NODES - 1] - x) + abs(row[_ZY, NODES - 1] - y)
        change += gain * abs(row[_R, NODES - 1] - r)
        if share * change <= allowed:
            return (1.0 + share) * _resolved(rates, part, weight, drags) <= allowed
    return False


@kernel(inline=True)
def _integrate(row: FloatArray, rates: FloatArray, quantity: int, part: int) -> None:
    """Put in `row` the integrals of a quantity's rate up to each node.

    A sum for each: the compiler takes four at once, each in its order.
    """
    for j in range(NODES):
        total = 0.0
        for node in range(NODES):
            total += rates[quantity, node] * INTEGRALS[part, node, j]
        row[quantity, j] = total


@kernel(inline=True)
def _interpolate(row: FloatArray, points: FloatArray, quantity: int, part: int) -> None:
    """Put in `points` what a quantity is there."""
    for j in range(POINTS):
        total = 0.0
        for node in range(NODES):
            total += row[quantity, node] * TO_POINTS[part, node, j]
        points[quantity, j] = total


@kernel(inline=True)
def _resolved(rates: FloatArray, part: int, weight: float, drags: float) -> float:
    """Return what the nodes leave out of the velocity [m/s].

    By the last Chebyshev coefficient of the rates in sigma, and those that are likely to follow:
    each of two integrations, of the rate and of what it does to the acceleration, divides it by its
    degree. `weight`, `drags`: what w, and what the velocity, do to that [m/s] and [1].
    """
    w, x, y, r, sign = 0.0, 0.0, 0.0, 0.0, 1.0
    for j in range(NODES):
        half = 0.5 * sign if j in (0, NODES - 1) else sign
        w += half * rates[_W, j]
        x += half * rates[_ZX, j]
        y += half * rates[_ZY, j]
        r += half * rates[_R, j]
        sign = -sign
    last = (weight * abs(w) + drags * (abs(x) + abs(y) + abs(r))) * OVER[NODES - 1]
    left: float = 2.0 * last * BEYOND_NODES[part] * OVER[NODES - 2] * OVER[NODES - 2]
    return left


@kernel
def _take_to_points(
    row: FloatArray,
    points: FloatArray,
    balls: Balls,
    i: int,
    part: int,
    k: float,
    ux: float,
    uy: float,
    size: float,
    speed: float,
    duration: float,
) -> None:
    """Put in `points` acceleration and direction beyond those at first, over the time."""
    friction = balls.state[i].slide_slowing
    for quantity in range(4):
        _interpolate(row, points, quantity, part)
    (ex, ey), (dx, dy), dr, (zx, zy) = _at_first(balls, i, k * speed, ux, uy, size)
    falls = (3.5 * friction + dr) * duration
    often = 1.0 / duration
    for j in range(POINTS):
        w = points[_W, j]
        square = w * w
        over = 1.0 / (1.0 + square)
        c, s = -2.0 * square * over, 2.0 * w * over
        x, y = c * ex - s * ey, c * ey + s * ex
        slip = size - falls * POINT[j] + points[_R, j]
        vx = zx + points[_ZX, j] + slip * (ex + x) / 3.5
        vy = zy + points[_ZY, j] + slip * (ey + y) / 3.5
        drag = k * math.sqrt(vx * vx + vy * vy)
        over = OVER_POINT[j] * often
        points[_AX, j] = -(friction * x + (drag * vx - dx)) * over
        points[_AY, j] = -(friction * y + (drag * vy - dy)) * over
        points[_EX, j], points[_EY, j] = x * over, y * over


@kernel
def _take_to_degrees(row: FloatArray, points: FloatArray) -> None:
    """Put in `row` the Chebyshev coefficients of what is in `points`."""
    for axis in range(4):
        for n in range(POINTS):
            total = 0.0
            for j in range(POINTS):
                total += points[axis, j] * TO_CHEBYSHEV[j, n]
            row[axis, n] = total


@kernel(inline=True)
def left_out(row: FloatArray, part: int, duration: float) -> float:
    """Estimate what the powers leave out of the velocity [m/s], from `row` by degree.

    What is left out of the acceleration is the time s times b_n T_n + ..., n from POINTS on, and as
    much again that comes down on lower degrees. The integral of s T_n up to any s is at most
    duration^2 / (n - 1), by parts.
    """
    last, before = POINTS - 1, POINTS - 2
    tail = abs(row[_AX, last]) + abs(row[_AY, last])
    tail = max(tail, (abs(row[_AX, before]) + abs(row[_AY, before])) * OVER_RHO[part])
    left: float = 2.0 * duration * duration * tail * BEYOND[part] * OVER[POINTS - 2]
    return left


@kernel
def _begin(
    higher: FloatArray,
    air: Air,
    balls: Balls,
    i: int,
    k: float,
    ex: float,
    ey: float,
    speed: float,
    duration: float,
) -> None:
    """Write the piece into ball i's rows: powers of the time, and how fast its acceleration bends.

    Chebyshev's polynomials are integers at each power: they leave the coefficients their digits.
    """
    row, powers, ball = air.nodes, air.series, balls.state[i]
    friction, drag = ball.slide_slowing, k * speed
    ball.ax, ball.ay = -friction * ex - drag * ball.vx, -friction * ey - drag * ball.vy
    turn = 2.5 * friction / ball.radius
    ball.bx, ball.by = -turn * ey, turn * ex
    bend_x, bend_y = 0.0, 0.0
    for n in range(POINTS):
        bend_x += BENDS[n] * abs(row[_AX, n])
        bend_y += BENDS[n] * abs(row[_AY, n])
    for axis in range(4):
        for power in range(POINTS):
            total = 0.0
            for n in range(POINTS):
                total += row[axis, n] * TO_POWERS[n, power]
            powers[axis, power] = total
    often, scale = 1.0 / duration, 1.0
    for power in range(POINTS):
        at = 2 * power
        once = scale * OVER[power + 2]
        twice = once * OVER[power + 3]
        higher[i, st.HIGHER + at] = powers[_AX, power] * twice
        higher[i, st.HIGHER + at + 1] = powers[_AY, power] * twice
        air.turning[i, at] = -turn * powers[_EY, power] * once
        air.turning[i, at + 1] = turn * powers[_EX, power] * once
        scale *= often
    higher[i, 0], higher[i, 1] = bend_x, bend_y
    higher[i, st.POWERS] = POINTS

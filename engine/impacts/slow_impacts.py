"""Slow impacts of a ball in flight: a ball that lies on other balls, or on noses, bounces there.

An impact is slow whose rebound would rise less than `CAPTURE_HEIGHT`. A slow impact is elastic and
knows no friction: with less energy at each bounce, a ball would bounce ever faster before it slides
off. A ball on the table that is loaded from above doesn't move downwards, and stays at a cushion
behind it. Between bounces, the ball above would else push it a nanometre to and fro: the cushion
would take energy from each bounce, until the balls sink into each other.

Bounces that have become lower, since what the ball lies on yields, are raised again. The energy
comes from the slip, as if a friction took it, so that the energy of both balls stays the same.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws, World
from ghostball.engine.core.tolerances import CAPTURE_HEIGHT, LOWEST_BOUNCE
from ghostball.engine.impacts.lying_still import capture_speed
from ghostball.engine.impacts.on_table import respond_by_table, set_free
from ghostball.engine.motion.geometry import list_near, rolls_on
from ghostball.engine.motion.obstacles import facing, nose_reach
from ghostball.engine.motion.position import pair_reach, relative_motion

_LEAST_LEAN = 2.0**-20
"""Least sideways part of the normal of a ball that falls slowly on the top of another ball: nothing
else would decide where the ball falls, or the ball would take seconds to fall off."""

_PART_OF_SLIP = 2.0**-8
"""Largest part of the energy of a slip that a bounce takes: a bounce that lacks more takes none.

A ball that begins to fall off another ball is e times as fast after some 200 such bounces. What
each bounce took of a slower slip kept the ball on top."""


@kernel
def part_slowly(
    height: FloatArray,
    world: World,
    i: int,
    j: int,
    nx: float,
    ny: float,
    nz: float,
    distance: float,
    overlap: float,
) -> None:
    """Let ball i and ball j, or a nose if j is -1, part as fast as they approach; then the table.

    The normal (nx, ny, nz) points from ball i to the other centre, or to the nose, `distance` [m]
    away. A ball exactly above another one falls off along x.

    Contract: both are advanced to the instant of the impact and approach each other.
    """
    balls, laws = world.balls, world.laws
    k_i, u_i, x_i, y_i = _mobility(height, world, i, -nx, -ny, -nz)
    k_j, u_j, x_j, y_j = _mobility(height, world, j, nx, ny, nz)
    ax, ay, az = _velocity(height, balls, i, k_i, u_i, x_i, y_i)
    bx, by, bz = _velocity(height, balls, j, k_j, u_j, x_j, y_j)
    vx, vy, vz = ax - bx, ay - by, az - bz
    level = math.sqrt(nx * nx + ny * ny)
    if level < _LEAST_LEAN and j >= 0:
        lean_x = _LEAST_LEAN * (nx / level) if level > 0.0 else math.copysign(_LEAST_LEAN, nz)
        lean_y = _LEAST_LEAN * (ny / level) if level > 0.0 else 0.0
        if vx * lean_x + vy * lean_y + vz * nz > 0.0:
            nx, ny = lean_x, lean_y
    speed = vx * nx + vy * ny + vz * nz
    cx, cy, cz = _given(k_i, u_i, x_i, y_i, nx, ny, nz)
    more_x, more_y, more_z = _given(k_j, u_j, x_j, y_j, nx, ny, nz)
    cx, cy, cz = cx + more_x, cy + more_y, cz + more_z
    compliance = cx * nx + cy * ny + cz * nz
    px, py, pz, lost = 0.0, 0.0, 0.0, 0.0
    if compliance > 0.0 and speed > 0.0:
        across = max(vx * vx + vy * vy + vz * vz - speed * speed, 0.0)
        # Up or down the slope alone: by the rest of the slip, a ball falls off a ridge.
        sx, sy, sz, slip = 0.0, 0.0, 0.0, 0.0
        level = math.sqrt(nx * nx + ny * ny)
        if level > 0.0:
            sx, sy, sz = -nz * nx / level, -nz * ny / level, level
            slip = vx * sx + vy * sy + vz * sz
        if slip < 0.0:
            slip, sx, sy, sz = -slip, -sx, -sy, -sz
        fall = height[j, st.FALL] if j >= 0 else 0.0
        loaded = (fall - height[i, st.FALL]) * nz > across / distance
        lacking = _lacking_square(laws, distance, overlap, speed, slip, loaded) / compliance
        if lacking > 0.0 and slip > 0.0:
            dx, dy, dz = _given(k_i, u_i, x_i, y_i, sx, sy, sz)
            more_x, more_y, more_z = _given(k_j, u_j, x_j, y_j, sx, sy, sz)
            dx, dy, dz = dx + more_x, dy + more_y, dz + more_z
            yields = dx * sx + dy * sy + dz * sz
            if yields > 0.0:
                rub = min(0.5 * lacking / slip, slip / yields)
                lost = rub * (slip - 0.5 * rub * yields)
                speed -= rub * (dx * nx + dy * ny + dz * nz)
                px, py, pz = rub * sx, rub * sy, rub * sz
        push = (speed + math.sqrt(speed * speed + 2.0 * compliance * lost)) / compliance
        px, py, pz = px + push * nx, py + push * ny, pz + push * nz
    _push(height, balls, i, k_i, u_i, x_i, y_i, -px, -py, -pz)
    if j >= 0:
        _push(height, balls, j, k_j, u_j, x_j, y_j, px, py, pz)
    respond_by_table(height, balls, i, laws)
    if j >= 0:
        respond_by_table(height, balls, j, laws)


@kernel(inline=True)
def _lacking_square(
    laws: Laws, reach: float, overlap: float, speed: float, slip: float, loaded: bool
) -> float:
    """Return what the square of the speed of a rebound lacks [m^2/s^2], and the slip may give.

    Balls that overlap by `overlap` [m], and would come less than half out again, part fast enough
    to come out, and higher by `LOWEST_BOUNCE`. A ball that loads another one keeps the speed of the
    highest slow bounce.
    """
    square, given = speed * speed, _PART_OF_SLIP * slip * slip
    if square < laws.gravity * overlap:
        lacking = 2.0 * laws.gravity * (overlap + LOWEST_BOUNCE * reach) - square
        deep = overlap > 2.0 * LOWEST_BOUNCE * reach
        return lacking if deep or lacking <= given else 0.0
    slow: float = capture_speed(laws, 0.5 * reach)
    lacking = slow * slow - square
    return lacking if loaded and lacking <= given else 0.0


@kernel
def _mobility(
    height: FloatArray, world: World, k: int, nx: float, ny: float, nz: float
) -> tuple[float, float, float, float]:
    """Return how ball k yields to an impulse along a normal: level and upwards [1/kg]; (bx, by).

    The ball doesn't move along the level unit vector (bx, by), if that isn't 0. A ball on the table
    that is loaded from above doesn't move downwards; nor to or from a cushion that holds it, itself
    or by a row of balls. In a corner, in front of a cushion and a row, and where k is -1, the ball
    doesn't move.
    """
    if k < 0:
        return 0.0, 0.0, 0.0, 0.0
    balls = world.balls
    ball = balls.state[k]
    over = 1.0 / ball.mass
    if height[k, st.RISE] > 0.0 or height[k, st.UP_SPEED] > 0.0 or nz >= 0.0:
        return over, over, 0.0, 0.0
    if rolls_on(balls, k):
        over /= 1.4
    touched, bx, by = _held_behind(world, k, nx, ny)
    if touched == 1:
        along = nx * bx + ny * by
        more, _, _ = _held_behind(world, k, nx - along * bx, ny - along * by)
        touched += more
    return (over, 0.0, bx, by) if touched < 2 else (0.0, 0.0, 0.0, 0.0)


@kernel
def _held_behind(world: World, k: int, nx: float, ny: float) -> tuple[int, float, float]:
    """Return how many cushions hold ball k against a push, and the unit vector from the last one.

    A cushion holds the ball itself, or by a row of balls: the vector is then that from the row. The
    push acts along the level vector (nx, ny).
    """
    balls = world.balls
    size = math.sqrt(nx * nx + ny * ny)
    if size < _LEAST_LEAN:
        return 0, 0.0, 0.0
    nx, ny = nx / size, ny / size
    touched, bx, by = _cushion_behind(world, k, nx, ny)
    last, rx, ry = k, 0.0, 0.0
    for _ in range(len(balls.own_kind) if touched == 0 else 0):
        behind, x, y = _ball_behind(world, last, nx, ny)
        if behind < 0:
            break
        if last == k:
            rx, ry = x, y
        last = behind
        held, _, _ = _cushion_behind(world, last, nx, ny)
        if held > 0:
            return 1, rx, ry
    return touched, bx, by


@kernel
def _ball_behind(world: World, k: int, nx: float, ny: float) -> tuple[int, float, float]:
    """Return the ball behind ball k, as seen along the unit vector (nx, ny); or -1.

    And the unit vector from that ball to ball k. Of all balls that ball k touches, or nearly, it is
    the one that a push along (nx, ny) presses ball k into most.
    """
    balls = world.balls
    first, most, bx, by = -1, _LEAST_LEAN, 0.0, 0.0
    for c in range(list_near(balls, world.cells, k)):
        balls.counters[st.WORK] += 1
        j = int(balls.near[c])
        if balls.state[j].phase in (st.FLYING, st.GONE):
            continue
        rx, ry, vx, vy, _, _ = relative_motion(balls, j, k, balls.state[k].epoch)
        distance = math.sqrt(rx * rx + ry * ry)
        rx, ry = rx / distance, ry / distance
        near = distance <= (1.0 + 2.0 * CAPTURE_HEIGHT) * pair_reach(balls, j, k)
        slow = abs(rx * vx + ry * vy) <= capture_speed(world.laws, balls.state[k].radius)
        if near and slow and -(rx * nx + ry * ny) > most:
            first, most, bx, by = j, -(rx * nx + ry * ny), rx, ry
    return first, bx, by


@kernel
def _cushion_behind(world: World, k: int, nx: float, ny: float) -> tuple[int, float, float]:
    """Return how many cushions behind ball k it touches, or nearly, and the normal of the last.

    A push along the unit vector (nx, ny) presses ball k into them.
    """
    balls, laws = world.balls, world.laws
    ball, touched, bx, by = balls.state[k], 0, 0.0, 0.0
    slow = capture_speed(laws, ball.radius)
    balls.counters[st.WORK] += len(laws.obstacles)
    for row in range(len(laws.obstacles)):
        inward_x, inward_y, away = facing(laws, row, ball.x, ball.y)
        pressed = nx * inward_x + ny * inward_y < -_LEAST_LEAN
        if not pressed or laws.obstacles[row].law == st.TAKES_OUT:
            continue
        near = away - nose_reach(balls, k, laws, row) <= 4.0 * CAPTURE_HEIGHT * ball.radius
        if near and abs(inward_x * ball.vx + inward_y * ball.vy) <= slow:
            touched, bx, by = touched + 1, inward_x, inward_y
    return touched, bx, by


@kernel(inline=True)
def _velocity(
    height: FloatArray, balls: Balls, k: int, level: float, up: float, bx: float, by: float
) -> tuple[float, float, float]:
    """Return the velocity [m/s] of ball k in the directions in which it yields."""
    if level == 0.0:
        return 0.0, 0.0, 0.0
    ball = balls.state[k]
    held = ball.vx * bx + ball.vy * by
    return ball.vx - held * bx, ball.vy - held * by, height[k, st.UP_SPEED] if up > 0.0 else 0.0


@kernel(inline=True)
def _given(
    level: float, up: float, bx: float, by: float, px: float, py: float, pz: float
) -> tuple[float, float, float]:
    """Return the velocity that an impulse (px, py, pz) gives a ball of that mobility."""
    held = px * bx + py * by
    return level * (px - held * bx), level * (py - held * by), up * pz


@kernel
def _push(
    height: FloatArray,
    balls: Balls,
    k: int,
    level: float,
    up: float,
    bx: float,
    by: float,
    px: float,
    py: float,
    pz: float,
) -> None:
    """Give ball k an impulse (px, py, pz); on the cloth, it continues rolling if it rolls."""
    ball = balls.state[k]
    vx, vy, _ = _velocity(height, balls, k, level, up, bx, by)
    dx, dy, dz = _given(level, up, bx, by, px, py, pz)
    if ball.vx == vx + dx and ball.vy == vy + dy and dz == 0.0:
        return
    if up == 0.0 and rolls_on(balls, k):
        ball.phase = st.ROLLING
    else:
        set_free(balls, k)
    ball.vx, ball.vy = vx + dx, vy + dy
    height[k, st.UP_SPEED] += dz

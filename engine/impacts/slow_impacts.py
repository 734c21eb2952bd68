"""Slow impacts of a ball in flight: the bounces of a ball that lies on other balls or on noses.

An impact is slow if its rebound would rise less than `CAPTURE_HEIGHT`. Slow impacts are elastic and
have no friction: if each bounce took energy, a ball would bounce ever faster before it slides off.
A ball on the table that is loaded from above doesn't move downwards, and stays at a cushion behind
it. Otherwise, the ball above would push it to and fro by a nanometre between bounces, and the
cushion would take energy from each bounce, until the balls overlap.

If bounces have become lower because the lower ball yields, they are raised again. The energy is
taken from the slip, like the work of friction, so the total energy of both balls stays the same.
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
"""Smallest sideways component of the normal of a ball that falls slowly on the top of another ball.
With a smaller component, rounding would decide where the ball falls, or falling would take seconds.
"""

_PART_OF_SLIP = 2.0**-8
"""Largest part of the energy of a slip that a bounce takes; a bounce that needs more takes none.

A ball that starts to fall off another ball becomes e times as fast in about 200 such bounces. When
each bounce took energy from a slower slip, too, the ball stayed on top.
"""


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
    """Separate ball i and ball j, or a nose if j is -1, at their approach speed.

    The normal (nx, ny, nz) points from ball i to the other centre, or to the nose, `distance` [m]
    away. A ball exactly above another ball falls off along x. Then the table responds.

    Contract: both balls are advanced to the time of the impact and approach each other.
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
        # Use the slip up or down the slope only: with the rest of the slip, a ball falls off a
        # ridge.
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
    """Return by how much the square of the rebound speed must be increased [m^2/s^2].

    Balls that overlap by `overlap` [m], and whose rebound would remove less than half of the
    overlap, separate fast enough to remove it and to rise by `LOWEST_BOUNCE`. A ball that loads
    another ball keeps the speed of the highest slow bounce. The result is 0 if the slip can't
    provide the energy.
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
    """Return the response of ball k to an impulse along a normal.

    The results are the mobilities in the plane and upwards [1/kg], and a horizontal unit vector
    (bx, by) along which the ball doesn't move; or 0. A ball on the table that is loaded from above
    doesn't move downwards; nor to or from a cushion that holds the ball, directly or through a row
    of balls. In a corner, between a cushion and a row, or if k is -1, nothing moves.
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

    The push acts along the horizontal vector (nx, ny). If a cushion holds the ball through a row of
    balls, the vector is that from the row.
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
    """Return the ball behind ball k in the direction (nx, ny), or -1; and the unit vector from it.

    Of all balls that ball k touches or nearly touches, this is the ball that ball k is pressed
    against most by a push along the unit vector (nx, ny).
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
    """Return how many cushions behind ball k it nearly touches, and the normal of the last one.

    A push along the unit vector (nx, ny) presses ball k against these cushions.
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
    """Return the velocity of ball k in the directions in which it can move [m/s]."""
    if level == 0.0:
        return 0.0, 0.0, 0.0
    ball = balls.state[k]
    held = ball.vx * bx + ball.vy * by
    return ball.vx - held * bx, ball.vy - held * by, height[k, st.UP_SPEED] if up > 0.0 else 0.0


@kernel(inline=True)
def _given(
    level: float, up: float, bx: float, by: float, px: float, py: float, pz: float
) -> tuple[float, float, float]:
    """Return the change of velocity of a ball with this mobility by an impulse (px, py, pz)."""
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
    """Apply an impulse (px, py, pz) to ball k; a ball that rolls on the cloth continues to roll."""
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

"""Slow impacts of a ball in flight: what lies on others bounces there, until it falls off or rests.

An impact is slow whose rebound would rise less than `CAPTURE_HEIGHT`. It takes no energy and knows
no friction: else a ball that lies on others would bounce ever faster before it slides off. One on
the table that is loaded from above doesn't move downwards then, by the joint law.

What other balls take from such bounces comes back from the slip, so that they stay as high as that:
lower ones are more, of a motion that is the same. The balls below are loaded meanwhile: what a
bounce kicks them by is ended together with all the balls that they touch, by inelastic impulses, as
friction ends bounces on the cloth (`resting_contact`), and so are impacts of loaded balls that are
as slow. They would go through all balls of a rack, one by one, for each of the bounces.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws, World
from ghostball.engine.core.tolerances import LOWEST_BOUNCE
from ghostball.engine.impacts.lying_still import capture_speed, hold, is_held, lies_still
from ghostball.engine.impacts.on_table import respond_by_table, set_free
from ghostball.engine.motion.flight import motion_in_space
from ghostball.engine.motion.geometry import (
    blocking_ball,
    obstacle_in_contact,
    rolls_on,
)
from ghostball.engine.motion.obstacles import facing

_ASIDE = 2.0**-20
"""How much the normal of a ball that is exactly above another, to which it falls slowly, is taken
to lean at least: nothing else would decide where it falls, or it would take seconds to."""

_OF_SLIP = 2.0**-8
"""Most of the energy of a slip that a bounce takes; a bounce that would need more takes none. A
ball that begins to fall off another one is e times as fast after some 200 such bounces: what each
took of a slower slip, though little, kept it on top."""


@kernel
def lies_on(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws, t: float) -> bool:
    """Whether the impact of balls i and j at t [s] is a bounce of one that lies on the other."""
    a, b = balls.state[i], balls.state[j]
    if (a.phase == st.FLYING) == (b.phase == st.FLYING):
        return False
    rx, ry, rz, vx, vy, vz, ax, ay, az = motion_in_space(height, balls, i, j, t)
    distance = math.sqrt(rx * rx + ry * ry + rz * rz)
    speed = -(vx * rx + vy * ry + vz * rz) / distance
    if speed > capture_speed(laws, 0.5 * (a.radius + b.radius)):
        return False
    # One that clips another's top at speed isn't loaded by it.
    across = vx * vx + vy * vy + vz * vz - speed * speed
    return bool(rx * ax + ry * ay + rz * az + across < 0.0)


@kernel
def part_slowly(
    height: FloatArray,
    world: World,
    i: int,
    j: int,
    nx: float,
    ny: float,
    nz: float,
    overlap: float,
) -> None:
    """Let two balls, of which one flies, part as fast as they approach, without friction.

    One on the table that is loaded from above moves across only, and along a cushion that it
    touches: it continues rolling if it rolls. A ball exactly above another falls off along x. Then
    the table responds. One that lies still is held instead, and the other left alone.

    Where they overlap by `overlap` [m], and would come less than half out again, they part fast
    enough to come out, and higher by `LOWEST_BOUNCE`; where one lies on the other, as fast as a
    slow impact may be. What is missing for that comes from the slip. The impulse along it acts as a
    friction does, and no energy comes in. One on the cloth that is pushed into others moves as
    heavily as all of them: they take its part of the impulse as the bounce ends, and would else
    press it back, with more overlap at each bounce.
    """
    balls, laws = world.balls, world.laws
    if is_held(height, balls, i, j, laws):
        return
    vx, vy = balls.state[i].vx - balls.state[j].vx, balls.state[i].vy - balls.state[j].vy
    vz = height[i, st.UP_SPEED] - height[j, st.UP_SPEED]
    level = math.sqrt(nx * nx + ny * ny)
    if level < _ASIDE:
        lean_x = _ASIDE * (nx / level) if level > 0.0 else math.copysign(_ASIDE, nz)
        lean_y = _ASIDE * (ny / level) if level > 0.0 else 0.0
        lean_z = math.copysign(math.sqrt(1.0 - _ASIDE * _ASIDE), nz)
        approach = vx * lean_x + vy * lean_y + vz * lean_z
        if approach > 0.0:
            nx, ny, nz = lean_x, lean_y, lean_z
    held = True
    with_i, with_j = 1.0, 1.0
    xx, xy, yy, zz, vx, vy = _joint_compliance(
        height, balls, i, j, laws, held, with_i, with_j, nx, ny, nz
    )
    if not vx * nx + vy * ny + vz * nz > 0.0:
        held = False  # that it comes off its cushion is all of the approach
        xx, xy, yy, zz, vx, vy = _joint_compliance(
            height, balls, i, j, laws, held, with_i, with_j, nx, ny, nz
        )
    speed = vx * nx + vy * ny + vz * nz
    if overlap > 2.0 * LOWEST_BOUNCE * (balls.state[i].radius + balls.state[j].radius):
        with_i = _mass_behind(world, i, -nx, -ny)
        with_j = _mass_behind(world, j, nx, ny)
        xx, xy, yy, zz, vx, vy = _joint_compliance(
            height, balls, i, j, laws, held, with_i, with_j, nx, ny, nz
        )
    compliance = xx * nx * nx + 2.0 * xy * nx * ny + yy * ny * ny + zz * nz * nz
    if compliance == 0.0:
        respond_by_table(height, balls, i, laws)
        respond_by_table(height, balls, j, laws)
        return
    px, py, pz, returned = 0.0, 0.0, 0.0, speed
    reach = balls.state[i].radius + balls.state[j].radius
    across = vx * vx + vy * vy + vz * vz - speed * speed
    loaded = (height[j, st.FALL] - height[i, st.FALL]) * nz > across / reach
    missing = _missing(laws, reach, overlap, speed, loaded) / compliance
    if missing > 0.0:
        # An impulse P gives the relative velocity v the change -Y P, Y the compliance of both, and
        # the energy -P.v + P.Y P / 2. With P = part d and n.Y d = 0 the normal speed stays, and the
        # energy given is -part q + part^2 r / 2.
        dx, dy, dz = vx - speed * nx, vy - speed * ny, vz - speed * nz
        tilt = ((xx * nx + xy * ny) * dx + (xy * nx + yy * ny) * dy + zz * nz * dz) / compliance
        dx, dy, dz = dx - tilt * nx, dy - tilt * ny, dz - tilt * nz
        q = dx * vx + dy * vy + dz * vz
        r = xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy + zz * dz * dz
        if r > 0.0 and q != 0.0:
            taken = _from_slip(missing, q * q / r, _is_sunk(laws, overlap, speed))
            part = taken / (q + math.copysign(math.sqrt(max(q * q - r * taken, 0.0)), q))
            px, py, pz = part * dx, part * dy, part * dz
            returned = math.sqrt(speed * speed + taken * compliance)
    push = (speed + returned) / compliance
    px, py, pz = px + push * nx, py + push * ny, pz + push * nz
    for k, sign in ((i, -1.0), (j, 1.0)):
        xx, xy, yy, zz, _, _ = _compliance(
            height, balls, k, laws, held, 1.0, sign * nx, sign * ny, sign * nz
        )
        if xx != 0.0 or yy != 0.0:
            ball = balls.state[k]
            if zz == 0.0 and rolls_on(balls, k):
                ball.phase = st.ROLLING
            else:
                set_free(balls, k)
            ball.vx += sign * (xx * px + xy * py)
            ball.vy += sign * (xy * px + yy * py)
            height[k, st.UP_SPEED] += sign * zz * pz
    respond_by_table(height, balls, i, laws)
    respond_by_table(height, balls, j, laws)


@kernel
def _mass_behind(world: World, k: int, nx: float, ny: float) -> float:
    """Return the mass of ball k and of a line of balls that it is pushed into, over its own."""
    balls = world.balls
    mass: float = balls.state[k].mass
    last = k
    for _ in range(len(balls.own_kind)):
        balls.counters[st.WORK] += len(balls.own_kind)
        if balls.state[last].phase == st.FLYING:
            break
        behind = blocking_ball(world, last, nx, ny, balls.state[k].epoch)
        if behind < 0:
            break
        mass += balls.state[behind].mass
        last = behind
    own: float = balls.state[k].mass
    return mass / own


@kernel(inline=True)
def _is_sunk(laws: Laws, overlap: float, speed: float) -> bool:
    """Whether what overlaps by `overlap` [m] comes less than half out again at `speed` [m/s]."""
    return speed * speed < laws.gravity * overlap


@kernel(inline=True)
def _from_slip(missing: float, slip: float, sunk: bool) -> float:
    """Return what a rebound takes from the square of a slip [m^2/s^2].

    All of it, where it has sunk; else what is missing, or nothing where that is more than a part
    of `_OF_SLIP`.
    """
    if sunk:
        return min(missing, slip)
    return missing if missing <= _OF_SLIP * slip else 0.0


@kernel(inline=True)
def _missing(laws: Laws, reach: float, overlap: float, speed: float, loaded: bool) -> float:
    """Return by how much the square of a rebound's speed [m^2/s^2] is less than it should be."""
    if _is_sunk(laws, overlap, speed):
        return 2.0 * laws.gravity * (overlap + LOWEST_BOUNCE * reach) - speed * speed
    if not loaded:
        return 0.0
    slow: float = capture_speed(laws, 0.5 * reach)
    return slow * slow - speed * speed


@kernel(inline=True)
def _joint_compliance(
    height: FloatArray,
    balls: Balls,
    i: int,
    j: int,
    laws: Laws,
    held: bool,
    with_i: float,
    with_j: float,
    nx: float,
    ny: float,
    nz: float,
) -> tuple[float, float, float, float, float, float]:
    """Return what `_compliance` does, of ball i and ball j together: sums, and what is between."""
    xx, xy, yy, zz, vx, vy = _compliance(height, balls, i, laws, held, with_i, -nx, -ny, -nz)
    more_xx, more_xy, more_yy, more_zz, ux, uy = _compliance(
        height, balls, j, laws, held, with_j, nx, ny, nz
    )
    return xx + more_xx, xy + more_xy, yy + more_yy, zz + more_zz, vx - ux, vy - uy


@kernel
def _compliance(
    height: FloatArray,
    balls: Balls,
    k: int,
    laws: Laws,
    held: bool,
    heavier: float,
    nx: float,
    ny: float,
    nz: float,
) -> tuple[float, float, float, float, float, float]:
    """Return which velocity an impulse along a normal gives ball k, and which it has meanwhile.

    Of the matrix xx, xy, yy and zz [1/kg], of the velocity x and y [m/s]; as if it were so many
    times heavier. One on the table that is
    loaded from above doesn't move downwards, nor, where cushions have `held` it, into one that it
    touches; in a corner it moves not at all.
    """
    ball = balls.state[k]
    over = 1.0 / (heavier * ball.mass)
    if height[k, st.RISE] > 0.0 or height[k, st.UP_SPEED] > 0.0 or nz >= 0.0:
        return over, 0.0, over, over, ball.vx, ball.vy
    if rolls_on(balls, k):
        over /= 1.4
    touched, bx, by = 0, 0.0, 0.0
    for row in range(len(laws.obstacles) if held else 0):
        inward_x, inward_y, _ = facing(laws, row, ball.x, ball.y)
        if nx * inward_x + ny * inward_y < 0.0 and obstacle_in_contact(balls, k, laws, row):
            touched, bx, by = touched + 1, inward_x, inward_y
    if touched == 0:
        return over, 0.0, over, 0.0, ball.vx, ball.vy
    if touched > 1:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    along = bx * ball.vy - by * ball.vx
    return over * by * by, -over * bx * by, over * bx * bx, 0.0, -by * along, bx * along


@kernel
def part_from_nose(
    height: FloatArray,
    balls: Balls,
    i: int,
    laws: Laws,
    nx: float,
    ny: float,
    nz: float,
    speed: float,
    overlap: float,
) -> None:
    """Let ball i, which flies, part from a nose as fast as it approaches: as `part_slowly`."""
    ball = balls.state[i]
    if lies_still(height, balls, i, laws, ball.radius):
        hold(height, balls, i)
        return
    sx, sy, sz = ball.vx - speed * nx, ball.vy - speed * ny, height[i, st.UP_SPEED] - speed * nz
    slip = sx * sx + sy * sy + sz * sz
    loaded = -height[i, st.FALL] * nz > slip / ball.radius
    missing = _missing(laws, 2.0 * ball.radius, overlap, speed, loaded)
    taken = _from_slip(max(missing, 0.0), slip, _is_sunk(laws, overlap, speed))
    left = math.sqrt((slip - taken) / slip) if slip > 0.0 else 1.0
    returned = math.sqrt(speed * speed + taken)
    ball.vx, ball.vy = left * sx - returned * nx, left * sy - returned * ny
    height[i, st.UP_SPEED] = left * sz - returned * nz
    respond_by_table(height, balls, i, laws)

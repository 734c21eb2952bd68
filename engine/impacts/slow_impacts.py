"""Slow impacts in flight: a ball on top of other balls bounces until it falls off or rests.

An impact is slow if its rebound would rise less than `CAPTURE_HEIGHT`. A slow impact loses no
energy and has no friction; otherwise a ball on top of other balls would bounce more and more often
before it slides off. A ball on the table that is loaded from above doesn't move downwards, because
ball and table take part in the impact together.

Other balls take energy from the bounces. The slip replaces this energy, so that bounces keep the
height `CAPTURE_HEIGHT`: with lower bounces the ball would move in the same way, but have more
impacts. The balls below count as loaded meanwhile. The approach speeds that a bounce gives them end
at once, together with those of all balls that they touch, by inelastic impulses, as friction ends
bounces on the cloth (`resting_contact`). Equally slow impacts of loaded balls end in the same way.
Otherwise, each bounce would cause impacts of all balls of a rack, one by one.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws, World
from ghostball.engine.core.tolerances import LOWEST_BOUNCE
from ghostball.engine.impacts.lying_still import capture_speed, hold, is_held, lies_still
from ghostball.engine.impacts.on_table import respond_by_table
from ghostball.engine.motion.flight import motion_in_space
from ghostball.engine.motion.geometry import (
    blocking_ball,
    obstacle_in_contact,
    rolls_on,
)
from ghostball.engine.motion.next_piece import keep_spin
from ghostball.engine.motion.obstacles import facing

_ASIDE = 2.0**-20
"""Least lean of the normal between a ball and the ball exactly below it, in a slow impact.

Without this lean, nothing would decide in which direction the ball falls, or the fall would take
seconds.
"""

_OF_SLIP = 2.0**-8
"""Largest part of a slip's energy that a bounce takes; a bounce that needs more takes none.

The speed of a ball that starts to fall off another one grows by the factor e in about 200 bounces.
When each bounce took a little energy even from a slower slip, the ball stayed on top.
"""


@kernel
def lies_on(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws, t: float) -> bool:
    """Return whether the impact of balls i and j at t [s] is a bounce of one ball on the other."""
    a, b = balls.state[i], balls.state[j]
    if (a.phase == st.FLYING) == (b.phase == st.FLYING):
        return False
    rx, ry, rz, vx, vy, vz, ax, ay, az = motion_in_space(height, balls, i, j, t)
    distance = math.sqrt(rx * rx + ry * ry + rz * rz)
    speed = -(vx * rx + vy * ry + vz * rz) / distance
    if speed > capture_speed(laws, 0.5 * (a.radius + b.radius)):
        return False
    # A ball that touches the top of another one at high speed doesn't load it.
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
    """Let two balls, one of which flies, part as fast as they approach, without friction.

    A ball on the table that is loaded from above moves only horizontally, and only along a cushion
    that it touches; it keeps rolling if it rolls. A ball exactly above another falls off along x.
    Then the table responds. If both balls lie still, they are held instead.

    If the balls overlap by `overlap` [m] and their rebound would undo less than half of it, they
    part fast enough to undo it and to rise by `LOWEST_BOUNCE`. If one lies on the other, they part
    at the highest speed of a slow impact. The missing energy comes from the slip: the impulse along
    the slip acts like friction, and no energy is added. A ball on the cloth that is pushed into
    other balls has the mass of all these balls. The other balls take their part of the impulse when
    the bounce ends; otherwise they would push the ball back, with more overlap at each bounce.
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
        held = False  # the balls approach only if one may move off its cushion
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
        # An impulse P changes the relative velocity v by -Y P, where Y is the compliance of both
        # balls, and the energy by -P.v + P.Y P / 2. With P = part d and n.Y d = 0 the normal speed
        # stays the same, and the energy changes by -part q + part^2 r / 2.
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
                keep_spin(balls, k)
            ball.vx += sign * (xx * px + xy * py)
            ball.vy += sign * (xy * px + yy * py)
            height[k, st.UP_SPEED] += sign * zz * pz
    respond_by_table(height, balls, i, laws)
    respond_by_table(height, balls, j, laws)


@kernel
def _mass_behind(world: World, k: int, nx: float, ny: float) -> float:
    """Return the mass of ball k and of a line of balls that it is pushed into, over k's mass."""
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
    """Return whether a rebound at `speed` [m/s] undoes less than half of an `overlap` [m]."""
    return speed * speed < laws.gravity * overlap


@kernel(inline=True)
def _from_slip(missing: float, slip: float, sunk: bool) -> float:
    """Return the part of the square of a slip that a rebound takes [m^2/s^2].

    This is the `missing` part, at most the whole, if the balls have sunk into each other. Otherwise
    it is the missing part, or 0 if more than the fraction `_OF_SLIP` is missing.
    """
    if sunk:
        return min(missing, slip)
    return missing if missing <= _OF_SLIP * slip else 0.0


@kernel(inline=True)
def _missing(laws: Laws, reach: float, overlap: float, speed: float, loaded: bool) -> float:
    """Return how much is missing in the square of a rebound's speed [m^2/s^2]; negative: none."""
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
    """Return `_compliance` of both balls: the sum of the matrices, and i's velocity minus j's."""
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
    """Return the velocity of ball k per impulse along a normal, and its velocity in that motion.

    The results are xx, xy, yy and zz of the matrix [1/kg], and the velocity along x and y [m/s].
    `heavier` multiplies the ball's mass. A ball on the table that is loaded from above doesn't move
    downwards. If `held`, it also doesn't move into a cushion that it touches, and in a corner it
    doesn't move at all.
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
    """Let flying ball i part from a nose as fast as it approaches, as in `part_slowly`."""
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

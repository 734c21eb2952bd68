"""Slow impacts of a ball in flight: what lies on others hops there, until it falls off or rests.

An impact is slow whose rebound would rise less than `CAPTURE_HEIGHT`. It takes no energy and knows
no friction: else a ball that lies on others would bounce ever faster before it slides off. One on
the table that is pressed down doesn't yield downwards then, by the joint law.

What other balls take from such hops comes back from the slip, so that they stay as high as that:
lower ones are more, of a motion that is the same. The balls below are loaded meanwhile: what a hop
kicks them by is ended together with all the balls that they touch, by inelastic impulses, as
friction ends hops on the cloth (`resting_contact`), and so are impacts of loaded balls that are as
slow. They would go through all balls of a rack, one by one, for each of the hops.

A ball that has gone nowhere for so long that it would have fallen off, had it been out of balance,
and by so little that its hops are all that there is, lies still: it is held where it is, until
something hits it, or moves what it lies on. No force holds it there, since nothing needs one.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ALOFT,
    FALL,
    FIRST,
    FLYING,
    GONE,
    HELD,
    HOPPING,
    HOPS,
    LOADED,
    RISE,
    ROLLING,
    SECOND,
    STILL_RISE,
    STILL_SINCE,
    STILL_X,
    STILL_Y,
    UP_SPEED,
    WORK,
    Balls,
    Cells,
    FloatArray,
    Laws,
)
from ghostball.engine.core.tolerances import CAPTURE_HEIGHT, CONTACT_REACH, LOWEST_HOP
from ghostball.engine.impacts.on_table import answer_by_table, set_free
from ghostball.engine.motion.flight import is_near, motion_in_space
from ghostball.engine.motion.geometry import (
    at_rest,
    blocking_ball,
    contact_tolerance,
    list_near,
    obstacle_in_contact,
    rolls_on,
)
from ghostball.engine.motion.next_piece import mark, predict_again
from ghostball.engine.motion.obstacles import facing
from ghostball.engine.motion.position import advance, pair_reach, relative_motion

_ASIDE = 2.0**-20
"""How much the normal of a ball that is exactly above another, to which it falls slowly, is taken
to lean at least: nothing else would decide where it falls, or it would take seconds to."""

_OF_SLIP = 2.0**-8
"""Most of the energy of a slip that a hop takes; a hop that would need more takes none. A ball that
begins to fall off another one is e times as fast after some 200 such hops: what each took of a
slower slip, though little, kept it on top."""

_STILL = 2.0 * CAPTURE_HEIGHT
"""Way, in diameters, by which a ball that lies still may have gone."""

_LONG = 4.0
"""How long it has to, in units of the time in which a ball that is out of balance on another one
goes e times as far from there: by then what leans as little as `_ASIDE` has gone farther."""

_MOST_HOPS = 2**17
"""Slow impacts of a ball, from one landing on the cloth to the next, after which a run ends: some
ten times what one comes to that is dropped exactly on top of another."""


@kernel(inline=True)
def capture_speed(laws: Laws, radius: float) -> float:
    """Speed [m/s] of a rebound that rises `CAPTURE_HEIGHT`."""
    return 2.0 * math.sqrt(laws.gravity * CAPTURE_HEIGHT * radius)


@kernel
def lies_on(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws, t: float) -> bool:
    """Whether the impact of balls i and j at t [s] is a hop of one that lies on the other."""
    a, b = balls.state[i], balls.state[j]
    if (a.phase == FLYING) == (b.phase == FLYING):
        return False
    rx, ry, rz, vx, vy, vz, ax, ay, az = motion_in_space(height, balls, i, j, t)
    distance = math.sqrt(rx * rx + ry * ry + rz * rz)
    speed = -(vx * rx + vy * ry + vz * rz) / distance
    if speed > capture_speed(laws, 0.5 * (a.radius + b.radius)):
        return False
    # One that clips another's top at speed isn't pressed to it.
    across = vx * vx + vy * vy + vz * vz - speed * speed
    return bool(rx * ax + ry * ay + rz * az + across < 0.0)


@kernel
def part_slowly(
    height: FloatArray,
    balls: Balls,
    i: int,
    j: int,
    laws: Laws,
    cells: Cells | None,
    nx: float,
    ny: float,
    nz: float,
    depth: float,
) -> None:
    """Let two balls, of which one flies, part as fast as they approach, without friction.

    One on the table that is pressed down yields across only, and along a cushion that it touches:
    it goes on rolling if it rolls. A ball exactly above another falls off along x. Then the table
    answers. One that lies still is held instead, and the other left alone.

    Notes
    -----
    Where they overlap by `depth` [m], and would come less than half out again, they part fast
    enough to come out, and higher by `LOWEST_HOP`; where one lies on the other, as fast as a slow
    impact may be. What is missing for that comes from the slip. The impulse along it acts as a
    friction does, and no energy comes in. One on the cloth that is pushed into others yields as
    heavily as all of them: they take its part of the impulse as the hop ends, and would else press
    it back, deeper at each hop.
    """
    if _is_held(height, balls, i, j, laws):
        return
    vx, vy = balls.state[i].vx - balls.state[j].vx, balls.state[i].vy - balls.state[j].vy
    vz = height[i, UP_SPEED] - height[j, UP_SPEED]
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
    xx, xy, yy, zz, vx, vy = _yielding_together(
        height, balls, i, j, laws, held, with_i, with_j, nx, ny, nz
    )
    if not vx * nx + vy * ny + vz * nz > 0.0:
        held = False  # that it comes off its cushion is all of the approach
        xx, xy, yy, zz, vx, vy = _yielding_together(
            height, balls, i, j, laws, held, with_i, with_j, nx, ny, nz
        )
    speed = vx * nx + vy * ny + vz * nz
    if depth > 2.0 * LOWEST_HOP * (balls.state[i].radius + balls.state[j].radius):
        with_i = _mass_behind(balls, cells, i, -nx, -ny)
        with_j = _mass_behind(balls, cells, j, nx, ny)
        xx, xy, yy, zz, vx, vy = _yielding_together(
            height, balls, i, j, laws, held, with_i, with_j, nx, ny, nz
        )
    yielding = xx * nx * nx + 2.0 * xy * nx * ny + yy * ny * ny + zz * nz * nz
    if yielding == 0.0:
        answer_by_table(height, balls, i, laws)
        answer_by_table(height, balls, j, laws)
        return
    px, py, pz, returned = 0.0, 0.0, 0.0, speed
    reach = balls.state[i].radius + balls.state[j].radius
    across = vx * vx + vy * vy + vz * vz - speed * speed
    pressed = (height[j, FALL] - height[i, FALL]) * nz > across / reach
    missing = _missing(laws, reach, depth, speed, pressed) / yielding
    if missing > 0.0:
        # An impulse P gives the relative velocity v the change -Y P, Y how both yield, and the
        # energy -P.v + P.Y P / 2. With P = part d and n.Y d = 0 the normal speed stays, and the
        # energy given is -part q + part^2 r / 2.
        dx, dy, dz = vx - speed * nx, vy - speed * ny, vz - speed * nz
        tilt = ((xx * nx + xy * ny) * dx + (xy * nx + yy * ny) * dy + zz * nz * dz) / yielding
        dx, dy, dz = dx - tilt * nx, dy - tilt * ny, dz - tilt * nz
        q = dx * vx + dy * vy + dz * vz
        r = xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy + zz * dz * dz
        if r > 0.0 and q != 0.0:
            taken = _from_slip(missing, q * q / r, _is_sunk(laws, depth, speed))
            part = taken / (q + math.copysign(math.sqrt(max(q * q - r * taken, 0.0)), q))
            px, py, pz = part * dx, part * dy, part * dz
            returned = math.sqrt(speed * speed + taken * yielding)
    push = (speed + returned) / yielding
    px, py, pz = px + push * nx, py + push * ny, pz + push * nz
    for k, sign in ((i, -1.0), (j, 1.0)):
        xx, xy, yy, zz, _, _ = _yielding(
            height, balls, k, laws, held, 1.0, sign * nx, sign * ny, sign * nz
        )
        if xx != 0.0 or yy != 0.0:
            ball = balls.state[k]
            if zz == 0.0 and rolls_on(balls, k):
                ball.phase = ROLLING
            else:
                set_free(balls, k)
            ball.vx += sign * (xx * px + xy * py)
            ball.vy += sign * (xy * px + yy * py)
            height[k, UP_SPEED] += sign * zz * pz
    answer_by_table(height, balls, i, laws)
    answer_by_table(height, balls, j, laws)


@kernel
def _mass_behind(balls: Balls, cells: Cells | None, k: int, nx: float, ny: float) -> float:
    """Return the mass of ball k and of a row of balls that it is pushed into, over its own."""
    mass: float = balls.state[k].mass
    last = k
    for _ in range(len(balls.own_kind)):
        balls.counters[WORK] += len(balls.own_kind)
        if balls.state[last].phase == FLYING:
            break
        behind = blocking_ball(balls, cells, last, nx, ny, balls.state[k].epoch)
        if behind < 0:
            break
        mass += balls.state[behind].mass
        last = behind
    own: float = balls.state[k].mass
    return mass / own


@kernel(inline=True)
def _is_sunk(laws: Laws, depth: float, speed: float) -> bool:
    """Whether what overlaps by `depth` [m] comes less than half out again at `speed` [m/s]."""
    return speed * speed < laws.gravity * depth


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
def _missing(laws: Laws, reach: float, depth: float, speed: float, pressed: bool) -> float:
    """Return by how much the square of a rebound's speed [m^2/s^2] is less than it should be."""
    if _is_sunk(laws, depth, speed):
        return 2.0 * laws.gravity * (depth + LOWEST_HOP * reach) - speed * speed
    if not pressed:
        return 0.0
    slow: float = capture_speed(laws, 0.5 * reach)
    return slow * slow - speed * speed


@kernel(inline=True)
def _yielding_together(
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
    """Return what `_yielding` does, of ball i and ball j together: sums, and what is between."""
    xx, xy, yy, zz, vx, vy = _yielding(height, balls, i, laws, held, with_i, -nx, -ny, -nz)
    more_xx, more_xy, more_yy, more_zz, ux, uy = _yielding(
        height, balls, j, laws, held, with_j, nx, ny, nz
    )
    return xx + more_xx, xy + more_xy, yy + more_yy, zz + more_zz, vx - ux, vy - uy


@kernel
def _yielding(
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
    pressed down doesn't yield downwards, nor, where cushions have `held` it, into one that it
    touches; in a corner it yields not at all.
    """
    ball = balls.state[k]
    over = 1.0 / (heavier * ball.mass)
    if height[k, RISE] > 0.0 or height[k, UP_SPEED] > 0.0 or nz >= 0.0:
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
    depth: float,
) -> None:
    """Let ball i, which flies, part from a nose as fast as it approaches: as `part_slowly`."""
    ball = balls.state[i]
    if _lies_still(height, balls, i, laws, ball.radius):
        _hold(height, balls, i)
        return
    sx, sy, sz = ball.vx - speed * nx, ball.vy - speed * ny, height[i, UP_SPEED] - speed * nz
    slip = sx * sx + sy * sy + sz * sz
    pressed = -height[i, FALL] * nz > slip / ball.radius
    missing = _missing(laws, 2.0 * ball.radius, depth, speed, pressed)
    taken = _from_slip(max(missing, 0.0), slip, _is_sunk(laws, depth, speed))
    left = math.sqrt((slip - taken) / slip) if slip > 0.0 else 1.0
    returned = math.sqrt(speed * speed + taken)
    ball.vx, ball.vy = left * sx - returned * nx, left * sy - returned * ny
    height[i, UP_SPEED] = left * sz - returned * nz
    answer_by_table(height, balls, i, laws)


# --- what is loaded


@kernel(inline=True)
def load(height: FloatArray, balls: Balls, laws: Laws, i: int, j: int, t: float) -> None:
    """Note that one of two balls lies on the other: until it has hopped twice as high, at least."""
    lasts = 8.0 * math.sqrt(CAPTURE_HEIGHT * balls.state[i].radius / laws.gravity)
    height[i, LOADED], height[j, LOADED] = t + lasts, t + lasts


@kernel(inline=True)
def share_load(height: FloatArray, i: int, j: int) -> None:
    """Note that what loads one of two balls that touch loads both."""
    until = max(height[i, LOADED], height[j, LOADED])
    height[i, LOADED], height[j, LOADED] = until, until


@kernel
def list_touching(
    balls: Balls, cells: Cells | None, k: int, t: float, count: int, closing: bool
) -> int:
    """List in `balls.hits`, from row `count` on, balls on the cloth that ball k touches at t [s].

    Where `closing`, only what it approaches; as far as there is room. Return how many rows are
    listed then.
    """
    if balls.state[k].phase == FLYING:
        return count
    for c in range(list_near(balls, cells, k)):
        other = int(balls.near[c])
        if count == len(balls.hits) or balls.state[other].phase in (FLYING, GONE):
            continue
        rx, ry, vx, vy, _, _ = relative_motion(balls, k, other, t)
        gap = math.sqrt(rx * rx + ry * ry) - pair_reach(balls, k, other)
        touches = gap <= CONTACT_REACH * contact_tolerance(balls, k, other)
        if touches and (rx * vx + ry * vy < 0.0 or not closing):
            balls.hits[count, FIRST], balls.hits[count, SECOND] = k, other
            count += 1
    return count


# --- what lies still


@kernel
def _is_held(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws) -> bool:
    """Hold those of two balls that lie still, if both do; return whether they do."""
    reach = balls.state[i].radius + balls.state[j].radius
    first, second = balls.state[i].phase == FLYING, balls.state[j].phase == FLYING
    still_i = _lies_still(height, balls, i, laws, reach) if first else at_rest(balls, i)
    still_j = _lies_still(height, balls, j, laws, reach) if second else at_rest(balls, j)
    if not (still_i and still_j):
        return False
    if first:
        _hold(height, balls, i)
    if second:
        _hold(height, balls, j)
    return True


@kernel
def _lies_still(height: FloatArray, balls: Balls, k: int, laws: Laws, reach: float) -> bool:
    """Whether ball k, which flies and has a slow impact now, has gone nowhere for long enough.

    Where it has gone farther, its time begins anew. And count the impact.
    """
    ball = balls.state[k]
    height[k, HOPS] += 1.0
    if height[k, HOPS] > _MOST_HOPS:
        balls.counters[HOPPING] = k + 1
    way = max(abs(ball.x - height[k, STILL_X]), abs(ball.y - height[k, STILL_Y]))
    way = max(way, abs(height[k, RISE] - height[k, STILL_RISE]))
    if way > _STILL * 2.0 * ball.radius:
        height[k, STILL_X], height[k, STILL_Y] = ball.x, ball.y
        height[k, STILL_RISE], height[k, STILL_SINCE] = height[k, RISE], ball.epoch
        return False
    if height[k, RISE] <= _STILL * 2.0 * ball.radius:
        return False  # it is the table that it comes to rest on
    up, slow = height[k, UP_SPEED], capture_speed(laws, ball.radius)
    hops = ball.vx * ball.vx + ball.vy * ball.vy + up * up <= 4.0 * slow * slow
    long = _LONG * math.sqrt(reach / laws.gravity)
    return bool(hops and ball.epoch - height[k, STILL_SINCE] > long)


@kernel
def _hold(height: FloatArray, balls: Balls, k: int) -> None:
    """Hold ball k where it is, with its spin, which nothing slows there."""
    balls.state[k].vx, balls.state[k].vy = 0.0, 0.0
    height[k, UP_SPEED], height[k, FALL], height[k, HELD] = 0.0, 0.0, 1.0
    balls.counters[ALOFT] += 1


@kernel
def let_go(height: FloatArray, balls: Balls, k: int) -> None:
    """Hold ball k no more: whoever calls it has it predicted anew."""
    if height[k, HELD] == 1.0:
        height[k, HELD] = 0.0
        balls.counters[ALOFT] -= 1


@kernel
def let_go_above(height: FloatArray, balls: Balls, laws: Laws, t: float) -> None:
    """Let go what lies on balls that move after the event at t [s]; those that lie on it, too."""
    m = 1
    while m <= balls.touched[0] and balls.counters[ALOFT] > 0:  # each ball is touched once
        i = int(balls.touched[m])
        m += 1
        for k in range(0 if at_rest(balls, i) else len(balls.own_kind)):
            if height[k, HELD] == 1.0 and is_near(height, balls, k, i, t):
                let_go(height, balls, k)
                advance(balls, k, t)
                predict_again(balls, k, laws)
                mark(balls, k)

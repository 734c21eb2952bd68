"""Balls that lie on others: what they load, and when they lie still.

A ball that has gone nowhere for so long that it would have fallen off, had it been out of balance,
and by so little that its bounces are all that there is, lies still: it is held where it is, until
something hits it, or moves what it lies on. No force holds it there, since nothing needs one.

A ball that has fallen into the wedge between two others, or noses, has too many impacts. It is held
there at once, if it is in balance.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws, World
from ghostball.engine.core.tolerances import CAPTURE_HEIGHT, CONTACT_REACH
from ghostball.engine.impacts.impact import has_collapsed
from ghostball.engine.motion.flight import is_near, motion_in_space
from ghostball.engine.motion.geometry import (
    at_rest,
    contact_tolerance,
    list_near,
    negligible_bounce,
    speed_of,
)
from ghostball.engine.motion.next_piece import mark, predict_again
from ghostball.engine.motion.obstacles import above_nose, facing
from ghostball.engine.motion.position import advance, pair_reach, relative_motion

_STILL = 2.0 * CAPTURE_HEIGHT
"""Distance, in diameters, by which a ball that lies still may have gone."""

_LONG = 4.0
"""How long it has to, in units of the time in which a ball that is out of balance on another one
goes e times as far from there: by then what leans as little as `_ASIDE` has gone farther."""

_LEAN = 2.0**-23
"""Largest sideways part of the pushes on a ball in balance, over the ball's weight: in the time
`_LONG`, which multiplies a lean by cosh 4 = 27, the ball goes less than `_STILL`."""

_MANY_SLOW_IMPACTS = 2**12
"""Slow impacts of a ball, since it last landed on the cloth, after which a wedge may hold it.

Five times as many as bounces of the height `CAPTURE_HEIGHT` in the time `_LONG`. The bounces in a
wedge are lower.
"""

_MOST_SLOW_IMPACTS = 2**17
"""Slow impacts of a ball, from one landing on the cloth to the next, after which a run ends: some
ten times what one comes to that is dropped exactly on top of another."""


@kernel(inline=True)
def capture_speed(laws: Laws, radius: float) -> float:
    """Speed [m/s] of a rebound that rises `CAPTURE_HEIGHT`."""
    return 2.0 * math.sqrt(laws.gravity * CAPTURE_HEIGHT * radius)


@kernel(inline=True)
def load(height: FloatArray, balls: Balls, laws: Laws, i: int, j: int, t: float) -> None:
    """Note that one of two balls lies on the other: until it has bounced twice as high."""
    lasts = 8.0 * math.sqrt(CAPTURE_HEIGHT * balls.state[i].radius / laws.gravity)
    height[i, st.LOADED], height[j, st.LOADED] = t + lasts, t + lasts


@kernel(inline=True)
def share_load(height: FloatArray, i: int, j: int) -> None:
    """Note that what loads one of two balls that touch loads both."""
    until = max(height[i, st.LOADED], height[j, st.LOADED])
    height[i, st.LOADED], height[j, st.LOADED] = until, until


@kernel
def list_touching(world: World, k: int, t: float, count: int, closing: bool) -> int:
    """List in `balls.touching`, from row `count` on, what ball k touches on the cloth at t [s].

    Where `closing`, only what it approaches; as far as there is room. Return how many rows are
    listed then.
    """
    balls = world.balls
    if balls.state[k].phase == st.FLYING:
        return count
    for c in range(list_near(balls, world.cells, k)):
        other = int(balls.near[c])
        if count == len(balls.touching) or balls.state[other].phase in (st.FLYING, st.GONE):
            continue
        rx, ry, vx, vy, _, _ = relative_motion(balls, k, other, t)
        gap = math.sqrt(rx * rx + ry * ry) - pair_reach(balls, k, other)
        touches = gap <= CONTACT_REACH * contact_tolerance(balls, k, other)
        if touches and (rx * vx + ry * vy < 0.0 or not closing):
            balls.touching[count, st.FIRST], balls.touching[count, st.SECOND] = k, other
            count += 1
    return count


@kernel
def is_held(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws) -> bool:
    """Hold those of two balls that lie still, if both do; return whether they do."""
    reach = balls.state[i].radius + balls.state[j].radius
    first, second = balls.state[i].phase == st.FLYING, balls.state[j].phase == st.FLYING
    still_i = lies_still(height, balls, i, laws, reach) if first else at_rest(balls, i)
    still_j = lies_still(height, balls, j, laws, reach) if second else at_rest(balls, j)
    if not (still_i and still_j):
        return False
    if first:
        hold(height, balls, i)
    if second:
        hold(height, balls, j)
    return True


@kernel
def lies_still(height: FloatArray, balls: Balls, k: int, laws: Laws, reach: float) -> bool:
    """Whether ball k, which flies and has a slow impact now, has gone nowhere for long enough.

    Where it has gone farther, its time begins anew. And count the impact.
    """
    ball = balls.state[k]
    height[k, st.SLOW_IMPACTS] += 1.0
    if height[k, st.SLOW_IMPACTS] > _MOST_SLOW_IMPACTS:
        balls.counters[st.ENDLESS] = k + 1
    distance = max(abs(ball.x - height[k, st.STILL_X]), abs(ball.y - height[k, st.STILL_Y]))
    distance = max(distance, abs(height[k, st.RISE] - height[k, st.STILL_RISE]))
    if distance > _STILL * 2.0 * ball.radius:
        height[k, st.STILL_X], height[k, st.STILL_Y] = ball.x, ball.y
        height[k, st.STILL_RISE], height[k, st.STILL_SINCE] = height[k, st.RISE], ball.epoch
        return False
    if height[k, st.RISE] <= _STILL * 2.0 * ball.radius:
        return False  # it is the table that it comes to rest on
    up, slow = height[k, st.UP_SPEED], capture_speed(laws, ball.radius)
    bounces = ball.vx * ball.vx + ball.vy * ball.vy + up * up <= 4.0 * slow * slow
    long = _LONG * math.sqrt(reach / laws.gravity)
    return bool(bounces and ball.epoch - height[k, st.STILL_SINCE] > long)


@kernel(inline=True)
def bounces_on(height: FloatArray, balls: Balls, k: int, laws: Laws) -> bool:
    """Whether ball k has had so many impacts, slow or at one instant, that they may not end."""
    many: bool = height[k, st.SLOW_IMPACTS] > _MANY_SLOW_IMPACTS
    return many or has_collapsed(balls, k, laws)


@kernel
def settle(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws) -> bool:
    """Hold those of two balls that fly, if each is wedged; return whether they are held.

    What bears them is stopped: it would roll less far than what lies still may go.
    """
    for k in (i, j):
        if balls.state[k].phase == st.FLYING:
            if not (bounces_on(height, balls, k, laws) and is_wedged(height, balls, k, laws)):
                return False
        elif not _hardly_moves(balls, k):
            return False
    for k in (i, j):
        if balls.state[k].phase == st.FLYING:
            hold(height, balls, k)
        else:
            balls.state[k].vx, balls.state[k].vy = 0.0, 0.0
            balls.state[k].phase = st.ROLLING
    return True


@kernel
def is_wedged(height: FloatArray, balls: Balls, k: int, laws: Laws) -> bool:
    """Whether ball k, which flies, is as slow as its bounces, and in balance between two supports.

    Bounces to and fro in a wedge take their energy in a finite time, in which the clock stands
    still, so a run can't wait for the next motion of the ball. The balance of the ball is found
    from the weight, which pushes of both supports carry.
    """
    ball, up = balls.state[k], height[k, st.UP_SPEED]
    slow = capture_speed(laws, ball.radius)
    if ball.vx * ball.vx + ball.vy * ball.vy + up * up > 4.0 * slow * slow:
        return False
    supports = len(balls.own_kind) + len(laws.obstacles)
    balls.counters[st.WORK] += 4 * supports
    for c in range(supports):
        nx, ny, nz, reach = _support(height, balls, k, laws, c)
        for other in range(c + 1, supports if reach > 0.0 else 0):
            balls.counters[st.WORK] += 4
            ox, oy, oz, other_reach = _support(height, balls, k, laws, other)
            if other_reach == 0.0:
                continue
            same = nx * ox + ny * oy + nz * oz
            square = (1.0 - same) * (1.0 + same)
            push, push_too = nz - same * oz, oz - same * nz
            if not (square > 0.0 and push > 0.0 and push_too > 0.0):
                continue
            # Across both normals: the part of the weight that no push carries, and the velocity.
            ax, ay, az = ny * oz - nz * oy, nz * ox - nx * oz, nx * oy - ny * ox
            speed = ax * ball.vx + ay * ball.vy + az * up
            far = _LEAN * _LEAN * square
            if az * az <= far and speed * speed <= far * laws.gravity * min(reach, other_reach):
                return True
    return False


@kernel
def _support(
    height: FloatArray, balls: Balls, k: int, laws: Laws, c: int
) -> tuple[float, float, float, float]:
    """Return the unit normal from support c to ball k, at its epoch, and their distance [m].

    Of all supports, balls are the first, then come obstacles. The distance is 0 where support c
    doesn't bear ball k.
    """
    n, ball = len(balls.own_kind), balls.state[k]
    if c < n:
        in_air = balls.state[c].phase == st.FLYING and height[c, st.HELD] == 0.0
        if c == k or in_air or balls.state[c].phase == st.GONE:
            return 0.0, 0.0, 0.0, 0.0
        x, y, z, _, _, _, _, _, _ = motion_in_space(height, balls, c, k, ball.epoch)
        reach = balls.state[c].radius + ball.radius
    else:
        if laws.obstacles[c - n].law == st.TAKES_OUT:
            return 0.0, 0.0, 0.0, 0.0
        nx, ny, away = facing(laws, c - n, ball.x, ball.y)
        x, y, z, reach = nx * away, ny * away, above_nose(height, k, laws, c - n), ball.radius
    distance = math.sqrt(x * x + y * y + z * z)
    if distance > (1.0 + _STILL) * reach or distance == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    return x / distance, y / distance, z / distance, distance


@kernel
def _hardly_moves(balls: Balls, i: int) -> bool:
    """Whether ball i, on the cloth, rests, or will within the distance that what lies still may go.

    Not faster than the sum of its velocity and its slip it rolls then.
    """
    ball = balls.state[i]
    speed = speed_of(ball.vx, ball.vy)
    if ball.phase == st.SLIDING:
        speed += speed_of(ball.vx - ball.radius * ball.wy, ball.vy + ball.radius * ball.wx)
    return negligible_bounce(speed, ball.roll_slowing, _STILL * 2.0 * ball.radius)


@kernel
def hold(height: FloatArray, balls: Balls, k: int) -> None:
    """Hold ball k where it is, with its spin, which nothing slows there."""
    balls.state[k].vx, balls.state[k].vy = 0.0, 0.0
    height[k, st.UP_SPEED], height[k, st.FALL], height[k, st.HELD] = 0.0, 0.0, 1.0
    balls.counters[st.ALOFT] += 1


@kernel
def let_go(height: FloatArray, balls: Balls, k: int) -> None:
    """Hold ball k no more: whoever calls it has it predicted anew."""
    if height[k, st.HELD] == 1.0:
        height[k, st.HELD] = 0.0
        balls.counters[st.ALOFT] -= 1


@kernel
def _stays(balls: Balls, i: int) -> bool:
    """Whether what lies on ball i goes on lying there."""
    on_cloth = balls.state[i].phase not in (st.FLYING, st.GONE)
    return at_rest(balls, i) or (on_cloth and _hardly_moves(balls, i))


@kernel
def let_go_above(height: FloatArray, balls: Balls, laws: Laws, t: float) -> None:
    """Let go what lies on balls that move after the event at t [s]; those that lie on it, too."""
    m = 1
    while m <= balls.touched[0] and balls.counters[st.ALOFT] > 0:  # each ball is touched once
        i = int(balls.touched[m])
        m += 1
        for k in range(0 if _stays(balls, i) else len(balls.own_kind)):
            if height[k, st.HELD] == 1.0 and is_near(height, balls, k, i, t):
                let_go(height, balls, k)
                advance(balls, k, t)
                predict_again(balls, k, laws)
                mark(balls, k)

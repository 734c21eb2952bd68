"""Balls that lie on other balls: which balls they load, and when they are held still.

A ball on top of other balls has slow impacts. It lies still if it has moved no farther than its
bounces for so long that an unbalanced ball would have fallen off. It is then held at its position
until something hits it, or until a ball below it moves. No contact force is computed, because no
result needs it.

A ball that has fallen into the wedge between two balls or noses has too many impacts. It is held
there at once if it is in balance.
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
"""Distance, in diameters, by which a ball that lies still may have moved."""

_LONG = 4.0
"""Time after which a ball that has not moved lies still, in units of sqrt(distance of centres / g).

In one unit the displacement of an unbalanced ball grows by the factor e. In `_LONG` units even a
ball that leans by only `slow_impacts._ASIDE` moves farther than `_STILL`.
"""

_LEAN = 2.0**-23
"""Largest part of a ball's weight that its supports don't carry if the ball is in balance.

In the time `_LONG` a displacement grows by the factor cosh 4 = 27, so the ball moves less than
`_STILL`.
"""

_MANY_SLOW_IMPACTS = 2**12
"""Number of slow impacts since a ball last landed on the cloth after which a wedge may hold it.

This is five times the number of bounces of the height `CAPTURE_HEIGHT` in the time `_LONG`. The
bounces in a wedge are lower.
"""

_MOST_SLOW_IMPACTS = 2**17
"""Number of slow impacts of a ball since it last landed on the cloth, after which a run ends.

A ball that is dropped exactly on top of another one has about a tenth of this number.
"""


@kernel(inline=True)
def capture_speed(laws: Laws, radius: float) -> float:
    """Return the speed [m/s] of a rebound that rises by `CAPTURE_HEIGHT`."""
    return 2.0 * math.sqrt(laws.gravity * CAPTURE_HEIGHT * radius)


@kernel(inline=True)
def load(height: FloatArray, balls: Balls, laws: Laws, i: int, j: int, t: float) -> None:
    """Mark two balls as loaded, because one lies on the other.

    The mark lasts twice as long as a bounce of the height `CAPTURE_HEIGHT`, for the larger ball.
    """
    radius = max(balls.state[i].radius, balls.state[j].radius)
    lasts = 8.0 * math.sqrt(CAPTURE_HEIGHT * radius / laws.gravity)
    height[i, st.LOADED], height[j, st.LOADED] = t + lasts, t + lasts


@kernel(inline=True)
def share_load(height: FloatArray, i: int, j: int) -> None:
    """Mark both of two touching balls as loaded until the later of their two times."""
    until = max(height[i, st.LOADED], height[j, st.LOADED])
    height[i, st.LOADED], height[j, st.LOADED] = until, until


@kernel
def list_touching(world: World, k: int, t: float, count: int, closing: bool) -> int:
    """List in `balls.touching`, from row `count` on, the balls on the cloth that ball k touches.

    If `closing`, only balls that ball k approaches are listed. Balls without room in the list are
    left out. Return the number of listed rows. `t` [s] is the present time.
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
    """Hold each flying ball of a pair if both balls are still; return whether both are still."""
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
    """Return whether flying ball k, which has a slow impact now, hasn't moved for long enough.

    If the ball has moved, its time starts again. The function also counts the impact.
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
        return False  # the ball comes to rest on the table
    up, slow = height[k, st.UP_SPEED], capture_speed(laws, ball.radius)
    bounces = ball.vx * ball.vx + ball.vy * ball.vy + up * up <= 4.0 * slow * slow
    long = _LONG * math.sqrt(reach / laws.gravity)
    return bool(bounces and ball.epoch - height[k, st.STILL_SINCE] > long)


@kernel(inline=True)
def bounces_on(height: FloatArray, balls: Balls, k: int, laws: Laws) -> bool:
    """Return whether ball k had so many impacts, slow or at one time, that they may never end."""
    many: bool = height[k, st.SLOW_IMPACTS] > _MANY_SLOW_IMPACTS
    return many or has_collapsed(balls, k, laws)


@kernel
def settle(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws) -> bool:
    """Hold each flying ball of a pair if all of them are wedged; return whether they are held.

    A ball on the cloth that supports the other ball is stopped: it would roll less than `_STILL`.
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
    """Return whether flying ball k is as slow as its bounces, and in balance between two supports.

    Bounces to and fro in a wedge lose their energy within a time that the clock can't resolve, so a
    run can't wait until the ball moves on. A ball is in balance if pushes of both supports carry
    its weight.
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

    The balls are the first supports, the obstacles follow. The distance is 0 if support c doesn't
    support ball k.
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
    """Return whether ball i, on the cloth, rests, or comes to rest within the distance `_STILL`.

    A sliding ball starts to roll no faster than the sum of its speed and its slip.
    """
    ball = balls.state[i]
    speed = speed_of(ball.vx, ball.vy)
    if ball.phase == st.SLIDING:
        speed += speed_of(ball.vx - ball.radius * ball.wy, ball.vy + ball.radius * ball.wx)
    return negligible_bounce(speed, ball.roll_slowing, _STILL * 2.0 * ball.radius)


@kernel
def hold(height: FloatArray, balls: Balls, k: int) -> None:
    """Hold ball k at its position; its spin stays, because nothing slows it there."""
    balls.state[k].vx, balls.state[k].vy = 0.0, 0.0
    height[k, st.UP_SPEED], height[k, st.FALL], height[k, st.HELD] = 0.0, 0.0, 1.0
    balls.counters[st.ALOFT] += 1


@kernel
def let_go(height: FloatArray, balls: Balls, k: int) -> None:
    """Stop holding ball k; the caller must predict its motion again."""
    if height[k, st.HELD] == 1.0:
        height[k, st.HELD] = 0.0
        balls.counters[st.ALOFT] -= 1


@kernel
def _stays(balls: Balls, i: int) -> bool:
    """Return whether a ball that is held on ball i stays held, because ball i hardly moves."""
    on_cloth = balls.state[i].phase not in (st.FLYING, st.GONE)
    return at_rest(balls, i) or (on_cloth and _hardly_moves(balls, i))


@kernel
def let_go_above(height: FloatArray, balls: Balls, laws: Laws, t: float) -> None:
    """Release held balls on moving balls after an event at t [s], and the held balls on these."""
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

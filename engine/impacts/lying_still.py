"""Balls that lie on others: what they load, and when they lie still.

A ball that has gone nowhere for so long that it would have fallen off, had it been out of balance,
and by so little that its bounces are all that there is, lies still: it is held where it is, until
something hits it, or moves what it lies on. No force holds it there, since nothing needs one.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws, World
from ghostball.engine.core.tolerances import CAPTURE_HEIGHT, CONTACT_REACH
from ghostball.engine.motion.flight import is_near
from ghostball.engine.motion.geometry import at_rest, contact_tolerance, list_near
from ghostball.engine.motion.next_piece import mark, predict_again
from ghostball.engine.motion.position import advance, pair_reach, relative_motion

_STILL = 2.0 * CAPTURE_HEIGHT
"""Distance, in diameters, by which a ball that lies still may have gone."""

_LONG = 4.0
"""How long it has to, in units of the time in which a ball that is out of balance on another one
goes e times as far from there: by then what leans as little as `_ASIDE` has gone farther."""

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
def let_go_above(height: FloatArray, balls: Balls, laws: Laws, t: float) -> None:
    """Let go what lies on balls that move after the event at t [s]; those that lie on it, too."""
    m = 1
    while m <= balls.touched[0] and balls.counters[st.ALOFT] > 0:  # each ball is touched once
        i = int(balls.touched[m])
        m += 1
        for k in range(0 if at_rest(balls, i) else len(balls.own_kind)):
            if height[k, st.HELD] == 1.0 and is_near(height, balls, k, i, t):
                let_go(height, balls, k)
                advance(balls, k, t)
                predict_again(balls, k, laws)
                mark(balls, k)

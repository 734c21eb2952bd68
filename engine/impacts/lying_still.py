"""Balls that lie on other balls or on noses: when the engine holds and releases them.

A ball in flight is held at its position if it has had some slow impacts there and is in balance on
its supports. It is held until a ball hits it or a support moves. No force is computed for a held
ball, because none is needed. A ball out of balance bounces until it falls off.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws
from ghostball.engine.core.tolerances import CAPTURE_HEIGHT
from ghostball.engine.motion.flight import is_near, motion_in_space
from ghostball.engine.motion.geometry import at_rest, negligible_bounce, speed_of
from ghostball.engine.motion.next_piece import mark, predict_again
from ghostball.engine.motion.obstacles import above_nose, facing
from ghostball.engine.motion.position import advance

_STILL = 2.0 * CAPTURE_HEIGHT
"""Distance, in diameters, by which a ball that lies still may have moved."""

_FEW = 64.0
"""Number of slow impacts at one place after which a ball in balance is held."""

_LONG = 0.25
"""Time at one place after which a ball in balance is held, in units of sqrt(R / g).

13 ms for pool balls. A ball on balls that nothing holds pushes them apart, and sinks by more than
`_STILL` in this time. Exceptions are balls that accelerate by less than g / 2000, which is a
fifteenth of the deceleration by rolling friction.
"""

_LEAN = 2.0**-23
"""Largest sideways component of the pushes on a ball in balance, relative to the weight of the
ball."""

_MOST_SLOW_IMPACTS = 2**17
"""Number of slow impacts of a ball between two landings on the cloth after which a run ends: about
ten times as many as of a ball that is dropped exactly on top of another ball."""


@kernel(inline=True)
def capture_speed(laws: Laws, radius: float) -> float:
    """Return the speed of a rebound that rises by `CAPTURE_HEIGHT` [m/s]."""
    return 2.0 * math.sqrt(laws.gravity * CAPTURE_HEIGHT * radius)


@kernel
def lies_still(height: FloatArray, balls: Balls, k: int, laws: Laws) -> bool:
    """Count a slow impact of ball k in flight; return whether the ball lies still.

    The ball lies still if it has had `_FEW` slow impacts at one place above the table for the time
    `_LONG`, is no faster than its bounces, and is in balance.
    """
    ball = balls.state[k]
    height[k, st.SLOW_IMPACTS] += 1.0
    height[k, st.STILL_IMPACTS] += 1.0
    if height[k, st.SLOW_IMPACTS] > _MOST_SLOW_IMPACTS:
        balls.counters[st.ENDLESS] = k + 1
    distance = max(abs(ball.x - height[k, st.STILL_X]), abs(ball.y - height[k, st.STILL_Y]))
    distance = max(distance, abs(height[k, st.RISE] - height[k, st.STILL_RISE]))
    still = _STILL * 2.0 * ball.radius
    if distance > still:
        height[k, st.STILL_X], height[k, st.STILL_Y] = ball.x, ball.y
        height[k, st.STILL_RISE], height[k, st.STILL_IMPACTS] = height[k, st.RISE], 0.0
        height[k, st.STILL_SINCE] = ball.epoch
    long = _LONG * math.sqrt(ball.radius / laws.gravity)
    too_soon = ball.epoch - height[k, st.STILL_SINCE] < long
    if too_soon or height[k, st.STILL_IMPACTS] < _FEW or height[k, st.RISE] <= still:
        return False  # too early, or the ball comes to rest on the table
    up, slow = height[k, st.UP_SPEED], capture_speed(laws, ball.radius)
    bounces = ball.vx * ball.vx + ball.vy * ball.vy + up * up <= 4.0 * slow * slow
    return bool(bounces and _is_in_balance(height, balls, k, laws))


@kernel
def is_held(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws) -> bool:
    """Hold the flying balls of a pair if each lies still; return whether they are held.

    A ball on the cloth that supports the other ball is stopped if it hardly moves.
    """
    still = True
    for k in (i, j):
        if balls.state[k].phase == st.FLYING and height[k, st.HELD] == 0.0:
            still = lies_still(height, balls, k, laws) and still
        else:
            still = _stays(balls, k) and still
    if not still:
        return False
    for k in (i, j):
        if balls.state[k].phase == st.FLYING:
            hold(height, balls, k)
        elif not at_rest(balls, k):
            balls.state[k].vx, balls.state[k].vy = 0.0, 0.0
            balls.state[k].phase = st.ROLLING
    return True


@kernel
def _is_in_balance(height: FloatArray, balls: Balls, k: int, laws: Laws) -> bool:
    """Return whether ball k has supports on all sides, so that it can't fall off.

    Seen from above, each support has another support on each of its sides, or one straight across.
    """
    supports = len(balls.own_kind) + len(laws.obstacles)
    count = 0
    for c in range(supports):
        nx, ny, nz = _support(height, balls, k, laws, c)
        if nz == 0.0:
            continue
        count += 1
        borne = False
        for other in range(supports):
            ox, oy, oz = _support(height, balls, k, laws, other)
            across, same = nx * oy - ny * ox, nx * ox + ny * oy
            square = (1.0 - same - nz * oz) * (1.0 + same + nz * oz)
            opposite = same < 0.0 and across * across <= _LEAN * _LEAN * square
            if oz > 0.0 and (across > 0.0 or opposite):
                borne = True
        if not borne:
            return False
    return count > 1


@kernel
def _support(
    height: FloatArray, balls: Balls, k: int, laws: Laws, c: int
) -> tuple[float, float, float]:
    """Return the unit normal from support c to ball k, at its epoch.

    The supports are all balls, then all obstacles. The normal is 0 if support c doesn't support
    ball k.
    """
    balls.counters[st.WORK] += 1
    n, ball = len(balls.own_kind), balls.state[k]
    if c < n:
        if c == k or balls.state[c].phase == st.GONE or not _stays(balls, c):
            return 0.0, 0.0, 0.0
        x, y, z, _, _, _, _, _, _ = motion_in_space(height, balls, c, k, ball.epoch)
        reach = balls.state[c].radius + ball.radius
    else:
        if laws.obstacles[c - n].law == st.TAKES_OUT:
            return 0.0, 0.0, 0.0
        nx, ny, away = facing(laws, c - n, ball.x, ball.y)
        x, y, z, reach = nx * away, ny * away, above_nose(height, k, laws, c - n), ball.radius
    distance = math.sqrt(x * x + y * y + z * z)
    if distance > (1.0 + _STILL) * reach or z <= 0.0:
        return 0.0, 0.0, 0.0
    return x / distance, y / distance, z / distance


@kernel
def _stays(balls: Balls, i: int) -> bool:
    """Return whether ball i rests, or will rest within the distance that a still ball may move.

    A ball on the cloth then rolls no faster than the sum of its velocity and its slip.
    """
    ball = balls.state[i]
    if at_rest(balls, i):
        return True
    if ball.phase in (st.FLYING, st.GONE):
        return False
    speed = speed_of(ball.vx, ball.vy)
    if ball.phase == st.SLIDING:
        speed += speed_of(ball.vx - ball.radius * ball.wy, ball.vy + ball.radius * ball.wx)
    return negligible_bounce(speed, ball.roll_slowing, _STILL * 2.0 * ball.radius)


@kernel
def hold(height: FloatArray, balls: Balls, k: int) -> None:
    """Hold ball k at its position, with its spin, which nothing slows there."""
    balls.state[k].vx, balls.state[k].vy = 0.0, 0.0
    height[k, st.UP_SPEED], height[k, st.FALL] = 0.0, 0.0
    if height[k, st.HELD] == 0.0:
        height[k, st.HELD] = 1.0
        balls.counters[st.ALOFT] += 1


@kernel
def let_go(height: FloatArray, balls: Balls, k: int) -> None:
    """Stop holding ball k; the caller must predict the ball again."""
    if height[k, st.HELD] == 1.0:
        height[k, st.HELD] = 0.0
        balls.counters[st.ALOFT] -= 1


@kernel
def let_go_above(height: FloatArray, balls: Balls, laws: Laws, t: float) -> None:
    """Release balls that lie on balls that move after the event at t [s], and those above them."""
    m = 1
    while m <= balls.touched[0] and balls.counters[st.ALOFT] > 0:  # each ball is marked once
        i = int(balls.touched[m])
        m += 1
        for k in range(0 if _stays(balls, i) else len(balls.own_kind)):
            if height[k, st.HELD] == 1.0 and is_near(height, balls, k, i, t):
                let_go(height, balls, k)
                advance(balls, k, t)
                predict_again(balls, k, laws)
                mark(balls, k)

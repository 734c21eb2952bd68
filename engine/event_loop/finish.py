"""The end of a run: move every ball to the last time of the run."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, World
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.event_loop.record import is_finite
from ghostball.engine.motion.position import advance, flies


@kernel
def finish(world: World, status: int, end: FloatArray) -> int:
    """Move every ball to the time `log.clock[END]` at which a run with the result `status` ends.

    Put its position there into `end`, (p, n, 3), its velocity if p > 1, and its angular velocity if
    p > 2.

    If all centres rest, the run ends when the last vertical spin has decayed, too; a spin that no
    friction slows doesn't prolong the run. Return `status`, or RUN_T_MAX if a ball still spins at
    `t_max`.
    """
    balls, laws, log = world.balls, world.laws, world.log
    t = log.clock[st.NOW]
    if status == st.RUN_T_MAX:
        t = laws.t_max
    elif status == st.RUN_RESTED:
        t = log.clock[st.LAST_EVENT]
        for i in range(len(balls.own_kind)):
            spin, rate = balls.state[i].wz, balls.state[i].spin_slowing
            if spin != 0.0 and rate > 0.0 and not flies(balls, i):
                # Four ulps late, so that the spin computed from its decay at this time is 0.
                t = max(t, (balls.state[i].epoch + abs(spin) / rate) * (1.0 + 4.0 * EPS))
    if t > laws.t_max:
        t, status = laws.t_max, st.RUN_T_MAX
    log.clock[st.END] = t
    broken = False
    for i in range(len(balls.own_kind)):
        if balls.own_kind[i] == st.OWN_LEG:
            balls.state[i].phase = st.SLIDING  # so `advance` changes its angular velocity
        advance(balls, i, t)
        log.clock[st.FARTHEST] = max(
            log.clock[st.FARTHEST], abs(balls.state[i].x), abs(balls.state[i].y)
        )
        _put_state(balls, i, end)
        finite = is_finite(balls, i) and abs(balls.state[i].radius) < math.inf
        if status != st.RUN_NOT_FINITE and not finite:
            # A resting ball has no event, so this couldn't be detected earlier.
            log.counters[st.NOT_FINITE] = i
            broken = True
    return st.RUN_NOT_FINITE if broken else status


@kernel
def _put_state(balls: Balls, i: int, end: FloatArray) -> None:
    """Put position, velocity and angular velocity into end[:, i], as far as `end` has rows."""
    ball = balls.state[i]
    end[0, i, 0], end[0, i, 1] = ball.x, ball.y
    rise, up = 0.0, 0.0
    if balls.height is not None:
        rise, up = balls.height[i, st.RISE], balls.height[i, st.UP_SPEED]
    end[0, i, 2] = ball.radius + rise
    if len(end) > 1:
        end[1, i, 0], end[1, i, 1], end[1, i, 2] = ball.vx, ball.vy, up
    if len(end) > 2:
        turns = ball.phase == st.SLIDING or flies(balls, i)
        end[2, i, 0] = ball.wx if turns else -ball.vy / ball.radius
        end[2, i, 1] = ball.wy if turns else ball.vx / ball.radius
        end[2, i, 2] = ball.wz

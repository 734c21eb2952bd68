"""The end of a run: every ball is brought to its last instant."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    END,
    FARTHEST,
    LAST_EVENT,
    NOW,
    RISE,
    RUN_NOT_FINITE,
    RUN_RESTED,
    RUN_T_MAX,
    SLIDING,
    UNSOUND,
    UP_SPEED,
    Balls,
    FloatArray,
    Laws,
    Log,
)
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.event_loop.record import is_sound
from ghostball.engine.motion.flight import flies
from ghostball.engine.motion.position import advance


@kernel
def finish(balls: Balls, laws: Laws, log: Log, status: int, end: FloatArray) -> int:
    """Move every ball to the instant `log.clock[END]` at which a run that returned `status` ends.

    And put in `end`, (3, n, 3), its position, velocity and angular velocity there.

    When all centres rest, that is when the last spin about the vertical has decayed, too; a spin
    that no friction slows goes on, and isn't waited for. Return `status`, or RUN_T_MAX where a ball
    still spins then.
    """
    t = log.clock[NOW]
    if status == RUN_T_MAX:
        t = laws.t_max
    elif status == RUN_RESTED:
        t = log.clock[LAST_EVENT]
        for i in range(len(balls.own_kind)):
            spin, rate = balls.state[i].wz, balls.state[i].spin_slowing
            if spin != 0.0 and rate > 0.0:
                # Late by more than rounding, so that whoever computes the spin then finds none.
                t = max(t, (balls.state[i].epoch + abs(spin) / rate) * (1.0 + 4.0 * EPS))
    if t > laws.t_max:
        t, status = laws.t_max, RUN_T_MAX
    log.clock[END] = t
    unsound = False
    for i in range(len(balls.own_kind)):
        advance(balls, i, t)
        log.clock[FARTHEST] = max(log.clock[FARTHEST], abs(balls.state[i].x), abs(balls.state[i].y))
        _put_state(balls, i, end)
        sound = is_sound(balls, i) and abs(balls.state[i].radius) < math.inf
        if status != RUN_NOT_FINITE and not sound:
            # A resting ball has no event at which it would have been seen before.
            log.counters[UNSOUND] = i
            unsound = True
    return RUN_NOT_FINITE if unsound else status


@kernel
def _put_state(balls: Balls, i: int, end: FloatArray) -> None:
    """Put in end[:, i] the position, velocity and angular velocity of ball i."""
    vx, vy, radius = balls.state[i].vx, balls.state[i].vy, balls.state[i].radius
    slides = balls.state[i].phase == SLIDING or flies(balls.height, balls, i)
    end[0, i, 0] = balls.state[i].x
    end[0, i, 1] = balls.state[i].y
    end[0, i, 2] = radius
    end[1, i, 0] = vx
    end[1, i, 1] = vy
    end[1, i, 2] = 0.0
    end[2, i, 0] = balls.state[i].wx if slides else -vy / radius
    end[2, i, 1] = balls.state[i].wy if slides else vx / radius
    end[2, i, 2] = balls.state[i].wz
    _put_height(balls.height, i, end)


@kernel(inline=True)
def _put_height(height: FloatArray | None, i: int, end: FloatArray) -> None:
    if height is not None:
        end[0, i, 2] += height[i, RISE]
        end[1, i, 2] = height[i, UP_SPEED]

"""The event loop: find the next event, advance its balls, resolve it, predict, record."""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import World
from ghostball.engine.core.tolerances import ONE_INSTANT
from ghostball.engine.event_loop.find import find
from ghostball.engine.event_loop.predict import predict
from ghostball.engine.event_loop.record import record
from ghostball.engine.event_loop.resolve import advance_to, resolve

_MOST_AT_ONCE = 64
"""Largest number of events at one time per pair; a frozen line of n balls has about n^2 events."""


@kernel
def run(world: World, limit: int) -> int:
    """Process events until every ball rests, `t_max`, a full log, or `limit` events and steps.

    Returns one of RUN_RESTED, RUN_T_MAX, RUN_EVENT_LIMIT, RUN_LOG_FULL, RUN_NOT_FINITE;
    RUN_STANDSTILL if events follow each other endlessly within `ONE_INSTANT`; RUN_ENDLESS if a ball
    on top of other balls bounces endlessly; RUN_PAUSED if the work has reached PAUSE_AT; or
    RUN_NO_ROOM if more balls touch at once than fit in the arrays.

    The scheduler works with `pairs` or with `cells`, whichever isn't empty; see
    `scheduling.scheduler`.

    Contract: every ball is marked at the start of the run. No allocation, no raising. The whole
    state is in the arguments, so a run that returned RUN_LOG_FULL, RUN_EVENT_LIMIT or RUN_PAUSED
    continues where it stopped when called again. After RUN_NOT_FINITE, NOT_FINITE is the ball whose
    motion isn't finite.
    """
    log = world.log
    log.counters[st.NOT_FINITE] = st.FREE
    held = 0
    while True:
        predict(world, held, log.clock[st.NOW])
        status = record(world, log.clock[st.NOW])
        if status != st.RUN_CONTINUES:
            return status
        status, event = find(world, limit)
        if status != st.RUN_CONTINUES:
            return status
        advance_to(world, event)
        held = resolve(world, event)
        log.clock[st.NOW] = event.t
        if _stands_still(world, event.t):
            return st.RUN_STANDSTILL


@kernel(inline=True)
def _stands_still(world: World, t: float) -> bool:
    """Count events within `ONE_INSTANT`; return whether there are too many of them."""
    log = world.log
    if t - log.clock[st.STOOD_SINCE] > ONE_INSTANT * t:
        log.clock[st.STOOD_SINCE] = t
        log.counters[st.AT_ONCE] = 0
        return False
    log.counters[st.AT_ONCE] += 1
    n = len(world.balls.own_kind) + 32
    return bool(log.counters[st.AT_ONCE] > _MOST_AT_ONCE * n * n)

"""Find the next event: one ball's own event, or the pairs that touch first."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Cells, Contacts, Log, World
from ghostball.engine.event_loop.record import is_full
from ghostball.engine.motion.geometry import at_rest, has_cells
from ghostball.engine.scheduling.due_pairs import Event, own_event, touching
from ghostball.engine.scheduling.scheduler import earliest, update

_MAX_FRUITLESS_BOUNDS = 64
"""Number of bounds without an event after which a run fails, over (n + 32)^2 for n balls.

This prevents an endless loop, which a NaN in an unchecked number could cause. A shot needs 1 or 2
for each pair.
"""

_BALLS_A_UNIT = 8
"""Number of balls searched per unit of work, if all balls are searched."""

_WORK_BY_CELLS = 128
"""Largest work per event if cells give the balls nearby, for any number of balls."""


@kernel(inline=True)
def find(world: World, limit: int) -> tuple[int, Event]:
    """Return RUN_CONTINUES and the next event, or the reason why the run ends before it."""
    balls, log = world.balls, world.log
    update(world, log.clock[st.NOW])
    _unmark(balls)
    in_vain, turn = 0, _work_of_turn(world.cells, len(balls.own_kind))
    while True:
        t, single, row = earliest(world)
        status = _status_at(world, t, single, row, limit)
        # The work is counted after the status, so that a run that continues after a pause advances.
        log.counters[st.WORK] += turn
        _count_turns(world.contacts, log)
        if status != st.RUN_CONTINUES or single >= 0:
            return status, own_event(t, single)
        event = touching(world, t, row)
        if log.counters[st.NO_ROOM] > 0:
            return st.RUN_NO_ROOM, event
        if event.t < math.inf:
            return st.RUN_CONTINUES, event
        in_vain += 1
        if in_vain > _MAX_FRUITLESS_BOUNDS * (len(balls.own_kind) + 32) ** 2:
            log.counters[st.NOT_FINITE] = row
            return st.RUN_NOT_FINITE, event


@kernel(inline=True)
def _work_of_turn(cells: Cells, count: int) -> int:
    """Return the work of finding the next event of `count` balls."""
    work = 4 + count // _BALLS_A_UNIT
    return min(work, _WORK_BY_CELLS) if has_cells(cells) else work


@kernel(inline=True)
def _count_turns(contacts: Contacts, log: Log) -> None:
    """Add the work of solving for contacts to WORK."""
    log.counters[st.WORK] += contacts.turns[0]
    contacts.turns[0] = 0


@kernel(inline=True)
def _status_at(world: World, t: float, single: int, row: int, limit: int) -> int:
    """Return whether a run continues to the next time t [s], or why it ends before."""
    log = world.log
    if log.counters[st.NOT_FINITE] != st.FREE:
        return st.RUN_NOT_FINITE
    if not t >= log.clock[st.NOW]:
        log.counters[st.NOT_FINITE] = single if single >= 0 else row
        return st.RUN_NOT_FINITE
    if t == math.inf and _all_rest(world.balls):
        return st.RUN_RESTED
    if t > world.laws.t_max:
        return st.RUN_T_MAX
    if t == math.inf:  # a ball moves, but has no next event
        log.counters[st.NOT_FINITE] = single
        return st.RUN_NOT_FINITE
    if log.counters[st.EVENTS] + log.counters[st.CONTACT_STEPS] >= limit:
        return st.RUN_EVENT_LIMIT
    if log.counters[st.WORK] >= log.counters[st.PAUSE_AT]:
        return st.RUN_PAUSED
    return st.RUN_LOG_FULL if is_full(log, len(world.balls.own_kind)) else st.RUN_CONTINUES


@kernel
def _all_rest(balls: Balls) -> bool:
    for i in range(len(balls.own_kind)):  # noqa: SIM110 - the compiler takes no generator
        if not at_rest(balls, i):
            return False
    return True


@kernel(inline=True)
def _unmark(balls: Balls) -> None:
    for m in range(1, balls.touched[0] + 1):
        balls.changed[balls.touched[m]] = False
    balls.touched[0] = 0

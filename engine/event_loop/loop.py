"""The event loop: find the next event, advance its balls, resolve it, predict, record."""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    FREE,
    NOW,
    RUN_CONTACTS,
    RUN_GOES_ON,
    UNSOUND,
    Balls,
    Cells,
    Contacts,
    Laws,
    Log,
    Pairs,
)
from ghostball.engine.event_loop.find import find
from ghostball.engine.event_loop.predict import predict
from ghostball.engine.event_loop.record import record
from ghostball.engine.event_loop.resolve import NEEDS_CONTACTS, advance_to, resolve


@kernel
def run(
    balls: Balls,
    laws: Laws,
    pairs: Pairs | None,
    cells: Cells | None,
    contacts: Contacts | None,
    log: Log,
    limit: int,
) -> int:
    """Process events until every ball rests, `t_max`, a full log, or `limit` events and steps.

    Returns one of RUN_RESTED, RUN_T_MAX, RUN_EVENT_LIMIT, RUN_LOG_FULL, RUN_NOT_FINITE; or
    RUN_PAUSED, where its loops have done all the work that PAUSE_AT permits; or RUN_NO_ROOM, where
    more balls touch at once than the arrays have room for; or RUN_CONTACTS, where balls press each
    other, or hit several at once, and `contacts` is None.

    One of `pairs` and `cells` is None: which scheduler works, `scheduling.scheduler` says.

    Contract: every ball is marked when the run begins. No allocation, no raising. Everything is in
    the arguments, so a run that returned RUN_LOG_FULL, RUN_EVENT_LIMIT, RUN_PAUSED or RUN_CONTACTS
    goes on where it stopped when called again. A run that returned RUN_NOT_FINITE has in UNSOUND
    which ball's motion isn't.
    """
    log.counters[UNSOUND] = FREE
    begun = False
    while True:
        held = 0
        if begun:
            status, event = find(balls, laws, pairs, cells, contacts, log, limit)
            if status != RUN_GOES_ON:
                return status
            advance_to(balls, laws, contacts, event)
            held = resolve(balls, laws, cells, contacts, event, log)
            if held == NEEDS_CONTACTS:
                return RUN_CONTACTS
            log.clock[NOW] = event.t
        # The first turn is this alone: every ball that is marked begins to move.
        predict(balls, laws, cells, contacts, held, log.clock[NOW], log.counters)
        status = record(balls, contacts, log.clock[NOW], log)
        if status != RUN_GOES_ON:
            return status
        begun = True

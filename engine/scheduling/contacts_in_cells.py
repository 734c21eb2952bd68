"""Which pairs touch, among many: the bounds of one instant in `scheduling.cells`, judged.

The answers are those of `scheduling.all_pairs` to the bit.
"""

from __future__ import annotations

import math

from engine.core.kernel import kernel
from engine.core.state import (
    ADVANCEMENTS,
    FIRST,
    LEAST,
    LEAVES,
    MATE,
    NOWHERE,
    OTHERS,
    PENDING,
    PENDING_VERDICT,
    SECOND,
    Balls,
    Cells,
    Contacts,
    IntArray,
    Laws,
)
from engine.motion.geometry import list_near, tie_rounding
from engine.scheduling.cells import enter_next, next_bound, refill_slot
from engine.scheduling.contact_time import IMPACT, NOT_YET, PRESSED, holds, touch
from engine.scheduling.priority_queue import enter_instant, first_due, least_of_others
from engine.scheduling.ties import (
    comes_before,
    hand_over,
    has_room,
    is_listed,
    is_pair_listed,
    list_hit,
    when_tied,
)


@kernel(inline=True)
def touching_in_cells(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    t: float,
    row: int,
    counters: IntArray,
) -> float:
    """Judge every pair whose bound is the instant t [s], as `scheduling.scheduler.touching`.

    Contract: `earliest_in_cells` has returned t and `row`, and no own event.
    """
    if row < 0:
        several = _touching_several(balls, laws, cells, contacts, t, counters)
        return t if several else math.inf
    # Advance the one pair from its bound until it touches, or something else comes first.
    mate = cells.link[row, MATE]
    end = min(balls.state[row].own_time, balls.state[mate].own_time)
    others = min(cells.slot[row, OTHERS], cells.slot[row, LEAVES], balls.state[row].own_time)
    until = min(others, least_of_others(cells.tree, row), laws.t_max)
    first = t
    while True:
        counters[ADVANCEMENTS] += 1
        verdict, bound, speed = touch(balls, row, mate, t, 0.0)
        if verdict != NOT_YET:
            break
        bound = bound if bound <= end else math.inf
        if not bound < until:
            break
        t = bound
    if verdict == NOT_YET:
        _advance_slot(balls, laws, cells, contacts, row, mate, bound, first, t, counters)
        return math.inf
    if t > first:
        cells.slot[row, LEAST] = t
        enter_instant(cells.tree, row, t)
    list_hit(balls, 0, row, mate)
    counters[PENDING] = 1
    counters[PENDING_VERDICT] = verdict
    if verdict == IMPACT and laws.simultaneous:
        until = t + tie_rounding(balls, row, mate, t) / speed
        if _is_more_due(balls, cells, 1, t, until):
            count = _join_ties(balls, laws, cells, contacts, t, until, 1, counters)
            hand_over(balls, count, 0, counters)
    return t


@kernel
def _touching_several(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    t: float,
    counters: IntArray,
) -> bool:
    """`touching_in_cells`, where more than one bound is the instant t [s]."""
    count, pressed, fastest = 0, 0, 0.0
    i = first_due(cells.tree, t, 0)
    while i != NOWHERE:
        near = 1
        if cells.slot[i, OTHERS] <= t:
            # Another pair as early; or the same, which the ball met again in another cell.
            refill_slot(balls, laws, cells, contacts, i, t, counters)
            if cells.slot[i, LEAST] > t:
                near = 0
            elif cells.slot[i, OTHERS] <= t:
                near = list_near(balls, cells, i)
        for c in range(near):
            j = balls.near[c] if cells.slot[i, OTHERS] <= t else cells.link[i, MATE]
            if near > 1 and not _touches(balls, laws, contacts, i, j, t, counters):
                continue
            if is_pair_listed(balls, 0, count, i, j):
                continue
            last = balls.hits.shape[0]
            if is_pair_listed(balls, last - pressed, last, i, j):
                continue
            counters[ADVANCEMENTS] += 1
            verdict, bound, speed = touch(balls, i, j, t, 0.0)
            if verdict == NOT_YET:
                _advance_slot(balls, laws, cells, contacts, i, j, bound, t, t, counters)
                _advance_slot(balls, laws, cells, contacts, j, i, bound, t, t, counters)
            elif not has_room(balls, count, pressed, counters):
                return True
            elif verdict == PRESSED:
                # From the other end, out of the way of impacts.
                pressed += 1
                list_hit(balls, last - pressed, i, j)
            elif laws.simultaneous or comes_before(balls, count, speed, fastest, i, j, t):
                count = count + 1 if laws.simultaneous else 1
                fastest = max(speed, fastest)
                list_hit(balls, count - 1, i, j)
        i = first_due(cells.tree, t, i + 1)
    if count > 0 and laws.simultaneous:
        until = when_tied(balls, count, t, fastest)
        if _is_more_due(balls, cells, count, t, until):
            count = _join_ties(balls, laws, cells, contacts, t, until, count, counters)
    return hand_over(balls, count, pressed, counters)


@kernel
def _touches(
    balls: Balls,
    laws: Laws,
    contacts: Contacts | None,
    i: int,
    j: int,
    t: float,
    counters: IntArray,
) -> bool:
    """Whether balls i and j touch at the instant t [s], and no contact step holds them."""
    if contacts is not None and holds(contacts, i, j):
        return False
    return next_bound(balls, laws, i, j, t, counters) <= t


@kernel
def _advance_slot(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    j: int,
    bound: float,
    was: float,
    t: float,
    counters: IntArray,
) -> None:
    """Move on ball i's slot to its next bound with ball j, if it still has that which `was` [s].

    All before the instant t [s] is known.
    """
    if cells.slot[i, LEAST] != was or cells.link[i, MATE] != j:
        return
    end = min(balls.state[i].own_time, balls.state[j].own_time)
    if bound <= end and bound <= cells.slot[i, OTHERS]:
        cells.slot[i, LEAST] = bound
        enter_next(balls, cells, i)
    else:
        refill_slot(balls, laws, cells, contacts, i, t, counters)


@kernel
def _join_ties(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    t: float,
    until: float,
    listed: int,
    counters: IntArray,
) -> int:
    """List also the pairs that touch but for rounding, as `scheduling.all_pairs._join_ties`."""
    count = listed
    for c in range(listed):
        for i in (balls.hits[c, FIRST], balls.hits[c, SECOND]):
            for k in range(list_near(balls, cells, i)):
                j = balls.near[k]
                if is_pair_listed(balls, 0, count, i, j):
                    continue
                if contacts is not None and holds(contacts, i, j):
                    continue
                bound = next_bound(balls, laws, i, j, t, counters)
                if not t < bound <= until:
                    continue
                verdict, _, _ = touch(balls, i, j, t, tie_rounding(balls, i, j, t))
                if verdict == IMPACT:
                    if not has_room(balls, count, 0, counters):
                        return count
                    list_hit(balls, count, i, j)
                    count += 1
    return count


@kernel(inline=True)
def _is_more_due(balls: Balls, cells: Cells, listed: int, t: float, until: float) -> bool:
    """Whether a slot may have a bound past the instant t, up to `until` [s].

    Those at t are of the listed pairs.
    """
    for c in range(listed):
        for i in (balls.hits[c, FIRST], balls.hits[c, SECOND]):
            if t < cells.slot[i, LEAST] <= until or cells.slot[i, OTHERS] <= until:
                return True
    i = first_due(cells.tree, until, 0)
    while i != NOWHERE:
        if not is_listed(balls, listed, i):
            return True
        i = first_due(cells.tree, until, i + 1)
    return False

"""When the next two balls touch, among many: bounds with neighbours only, in a grid of cells.

The other scheduler, `_pairs`, keeps a bound for every pair. Here (`_grid`) a ball only meets those
in its own cell and the eight around it; when it moves into another, it meets the balls of three new
ones. Each ball keeps only its earliest bound, in a slot: with whom, and a bound for all the others.
A slot whose mate has changed its motion meanwhile is found out by its stamp, when its turn comes,
and filled anew when that of the others does. A tournament (`_tree`) finds the earliest.

The answers are those of `_pairs` to the bit. The bounds of a pair are a sequence that begins where
the later of the two changed its motion, each found from the one before; whoever asks, and when,
gets the first of them that is not past.
"""

from __future__ import annotations

import math

from engine._geometry import list_near, relative_motion, tie_rounding
from engine._grid import cell_number, settle, step_on, time_in_cell
from engine._jit import kernel
from engine._motion import first_crossing, first_meeting
from engine._state import (
    ADVANCEMENTS,
    AFTER,
    BOUNDS,
    CELL_MOVES,
    COLUMN,
    EPOCH,
    FIRST,
    LEAST,
    LEAVES,
    MATE,
    MATE_STAMP,
    NEXT,
    NOWHERE,
    OTHERS,
    OWN_TIME,
    PARTNER,
    PENDING,
    PENDING_VERDICT,
    RADIUS,
    ROW,
    SECOND,
    STAMP,
    WAY,
    Balls,
    Cells,
    Contacts,
    IntArray,
    Laws,
)
from engine._ties import (
    hand_over,
    is_listed,
    is_pair_listed,
    list_hit,
    takes_precedence,
    when_tied,
)
from engine._touch import IMPACT, NOT_YET, PRESSED, first_bound, touch
from engine._tree import enter_instant, first_due, least_of_others

_CLEARLY = 2.0**-30
"""What a bound must be later by, relative to the distance, to be seen without computing it."""


@kernel(inline=True)
def update_in_cells(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    t: float,
    counters: IntArray,
) -> None:
    """Fill anew the slots of the balls in `balls.touched`, whose motion changed at t [s]."""
    for m in range(1, balls.touched[0] + 1):
        i = balls.touched[m]
        cells.link[i, STAMP] += 1
        if cells.link[i, COLUMN] == 0:
            settle(balls, cells, i)
    for m in range(1, balls.touched[0] + 1):
        # A pair of two that changed goes to the slot of the one that comes later.
        i = balls.touched[m]
        cells.slot[i, LEAVES] = time_in_cell(balls, cells, i, t)
        _fill_slot(balls, laws, cells, contacts, i, t, True, counters)


@kernel(inline=True)
def _next_bound(balls: Balls, laws: Laws, i: int, j: int, t: float, counters: IntArray) -> float:
    """Return a bound, past the instant t [s], of when i and j touch; or t if they do then."""
    counters[BOUNDS] += 1
    end = min(balls.state[i, OWN_TIME], balls.state[j, OWN_TIME])
    bound = first_bound(balls, laws, i, j)
    bound = bound if bound <= end else math.inf
    return bound if bound > t else _later_bound(balls, i, j, bound, t, end, counters)


@kernel
def _later_bound(
    balls: Balls, i: int, j: int, bound: float, t: float, end: float, counters: IntArray
) -> float:
    """Advance a bound that is not past the instant t [s] until it is, or the pair touches."""
    while bound <= t:
        counters[ADVANCEMENTS] += 1
        verdict, later, _ = touch(balls, i, j, bound, 0.0)
        if verdict != NOT_YET:
            return bound
        bound = later if later <= end else math.inf
    return bound


@kernel
def _holds(contacts: Contacts, i: int, j: int) -> bool:
    """Whether a contact step holds ball i to ball j."""
    row = contacts.first_held[i]
    while row != NOWHERE:
        if contacts.held[row, PARTNER] == j:
            return True
        row = contacts.held[row, NEXT]
    return False


@kernel(inline=True)
def _fill_slot(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    t: float,
    shares: bool,
    counters: IntArray,
) -> None:
    """Put in ball i's slot its earliest bound from the instant t [s] on, and the next after that.

    Where it shares, pairs with balls that changed too and come later are left to those.
    """
    cells.slot[i, LEAST] = math.inf
    cells.slot[i, OTHERS] = math.inf
    cells.link[i, MATE] = NOWHERE
    column, row = cells.link[i, COLUMN], cells.link[i, ROW]
    for y in range(-1, 2):
        for x in range(-1, 2):
            cell = cell_number(cells, column + x, row + y)
            _meet_cell(balls, laws, cells, contacts, i, cell, t, shares, counters)
    _enter_next(balls, cells, i)


@kernel
def _refill_slot(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    t: float,
    counters: IntArray,
) -> None:
    """`_fill_slot`, but not written into the caller: where it is rare."""
    _fill_slot(balls, laws, cells, contacts, i, t, False, counters)


@kernel(inline=True)
def _meet_cell(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    cell: int,
    t: float,
    shares: bool,
    counters: IntArray,
) -> None:
    """Enter in ball i's slot its bounds with the balls of one cell; but not with its mate again."""
    j = cells.first[cell]
    while j != NOWHERE:
        known = j == cells.link[i, MATE] and cells.link[j, STAMP] == cells.link[i, MATE_STAMP]
        left = j == i or known or (shares and j > i and balls.changed[j])
        if contacts is not None:
            left = left or _holds(contacts, i, j)
        if not left:
            _meet_ball(balls, laws, cells, i, j, t, counters)
        j = cells.link[j, AFTER]


@kernel(inline=True)
def _meet_ball(
    balls: Balls, laws: Laws, cells: Cells, i: int, j: int, t: float, counters: IntArray
) -> None:
    """Enter in ball i's slot its bound with ball j, if it is one of the first two.

    Notes
    -----
    Most neighbours move away, or come later than two others: seen before roots are taken. For this,
    `_pairs._bound_block`'s quadratic is looked at when the second of those is due, with a gap that
    is smaller: (d - D)(d + D) / 2 <= d (d - D). Where the quadratic is positive then, and bends
    down, or is bounded by its tangent, it has had no root.
    """
    start = max(balls.state[i, EPOCH], balls.state[j, EPOCH])
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, start)
    rate, pull = rx * vx + ry * vy, rx * ax + ry * ay
    if rate >= 0.0 and pull >= 0.0:
        return
    others = cells.slot[i, OTHERS]
    square = rx * rx + ry * ry
    if others < math.inf:
        s = others - start
        gap = 0.5 * (square - cells.frame[3] * cells.frame[3]) - _CLEARLY * square
        if gap > 0.0 and gap + s * (rate + 0.5 * min(pull, 0.0) * s) > 0.0:
            return
    counters[BOUNDS] += 1
    end = min(balls.state[i, OWN_TIME], balls.state[j, OWN_TIME])
    reach = balls.state[i, RADIUS] + balls.state[j, RADIUS]
    if laws.uniform:
        bound = start + first_meeting(rx, ry, vx, vy, reach)
    else:
        distance = math.sqrt(square)
        bound = start + first_crossing(distance * (distance - reach), rate, pull)
    bound = bound if bound <= end else math.inf
    if bound <= t:
        bound = _later_bound(balls, i, j, bound, t, end, counters)
    if bound < cells.slot[i, LEAST]:
        cells.slot[i, OTHERS] = cells.slot[i, LEAST]
        cells.slot[i, LEAST] = bound
        cells.link[i, MATE] = j
        cells.link[i, MATE_STAMP] = cells.link[j, STAMP]
    elif bound < others:
        cells.slot[i, OTHERS] = bound


@kernel(inline=True)
def _enter_next(balls: Balls, cells: Cells, i: int) -> None:
    """Enter ball i's next instant in the tree."""
    slot = min(cells.slot[i, LEAST], cells.slot[i, LEAVES])
    enter_instant(cells.tree, i, min(slot, balls.state[i, OWN_TIME]))


@kernel(inline=True)
def earliest_in_cells(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    counters: IntArray,
) -> tuple[float, int, int]:
    """Return the next instant and whose it is, as `_schedule.earliest`.

    What concerns no ball's motion is done on the way: balls move to other cells, and slots that a
    mate left are filled anew. Of several own events at one instant, as `_pairs.earliest`.
    """
    while True:
        t = cells.tree[1]
        if not t < math.inf:
            return t, -1, -1
        single, settled = NOWHERE, True
        first = first_due(cells.tree, t, 0)
        only = cells.slot[first, OTHERS] > t
        i = first
        while i != NOWHERE:
            only = only and i == first
            if balls.state[i, OWN_TIME] == t:
                if single == NOWHERE or takes_precedence(balls, i, single):
                    single = i
            elif cells.slot[i, LEAVES] == t:
                _move_on(balls, laws, cells, contacts, i, t, counters)
                settled = False
            elif cells.link[i, MATE] == NOWHERE:
                _fill_slot(balls, laws, cells, contacts, i, t, False, counters)
                settled = False
            elif cells.link[cells.link[i, MATE], STAMP] != cells.link[i, MATE_STAMP]:
                # Nothing with the others is due before `OTHERS`; often an event comes sooner.
                cells.slot[i, LEAST] = cells.slot[i, OTHERS]
                cells.link[i, MATE] = NOWHERE
                _enter_next(balls, cells, i)
                settled = False
            i = first_due(cells.tree, t, i + 1)
        if settled:
            return t, single, first if only else -1


@kernel(inline=True)
def _move_on(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    t: float,
    counters: IntArray,
) -> None:
    """Move ball i to the next cell on its way, at t [s]; there it meets the balls of three more."""
    counters[CELL_MOVES] += 1
    way = cells.link[i, WAY]
    step_on(cells, i)
    cells.slot[i, LEAVES] = time_in_cell(balls, cells, i, t)
    column, row = cells.link[i, COLUMN], cells.link[i, ROW]
    step = -1 if way % 2 == 0 else 1
    for k in range(-1, 2):
        x, y = (column + step, row + k) if way < 2 else (column + k, row + step)
        cell = cell_number(cells, x, y)
        _meet_cell(balls, laws, cells, contacts, i, cell, t, False, counters)
    _enter_next(balls, cells, i)


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
    """Judge every pair whose bound is the instant t [s], as `_schedule.touching`.

    Contract: `earliest_in_cells` has returned t and `row`, and no own event.
    """
    if row < 0:
        several = _touching_several(balls, laws, cells, contacts, t, counters)
        return t if several else math.inf
    # Advance the one pair from its bound until it touches, or something else comes first.
    mate = cells.link[row, MATE]
    end = min(balls.state[row, OWN_TIME], balls.state[mate, OWN_TIME])
    others = min(cells.slot[row, OTHERS], cells.slot[row, LEAVES], laws.t_max)
    until = min(others, least_of_others(cells.tree, row))
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
            _refill_slot(balls, laws, cells, contacts, i, t, counters)
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
            elif verdict == PRESSED:
                # From the other end, out of the way of impacts.
                pressed += 1
                list_hit(balls, last - pressed, i, j)
            elif laws.simultaneous or speed > fastest:
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
    if contacts is not None and _holds(contacts, i, j):
        return False
    return _next_bound(balls, laws, i, j, t, counters) <= t


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
    """Move on ball i's slot to its next bound with ball j, if the one that `was` [s] is there.

    All before the instant t [s] is known.
    """
    if cells.slot[i, LEAST] != was or cells.link[i, MATE] != j:
        return
    end = min(balls.state[i, OWN_TIME], balls.state[j, OWN_TIME])
    if bound <= end and bound <= cells.slot[i, OTHERS]:
        cells.slot[i, LEAST] = bound
        _enter_next(balls, cells, i)
    else:
        _refill_slot(balls, laws, cells, contacts, i, t, counters)


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
    """List also the pairs that touch but for rounding, as `_pairs._join_ties`."""
    count = listed
    for c in range(listed):
        for i in (balls.hits[c, FIRST], balls.hits[c, SECOND]):
            for k in range(list_near(balls, cells, i)):
                j = balls.near[k]
                if is_pair_listed(balls, 0, count, i, j):
                    continue
                if contacts is not None and _holds(contacts, i, j):
                    continue
                bound = _next_bound(balls, laws, i, j, t, counters)
                if not t < bound <= until:
                    continue
                verdict, _, _ = touch(balls, i, j, t, tie_rounding(balls, i, j, t))
                if verdict == IMPACT:
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

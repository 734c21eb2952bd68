"""Many balls: a broad phase by cells bounds the times of impact with neighbours only.

The other scheduler, `scheduling.all_pairs`, keeps a bound for every pair. Here (`scheduling.grid`)
a ball only meets those in its own cell and the eight around it; when it moves into another, it
meets the balls of three new ones. Each ball keeps in its slot only its earliest bound, with whom
(its mate), and one bound for all the others. Whether the mate has changed its motion meanwhile is
seen by a stamp when the slot is due; then only the bound for the others is left, and the slot is
filled anew when that is due. A tournament (`scheduling.priority_queue`) finds the earliest.

The answers are those of `scheduling.all_pairs` to the bit. The bounds of a pair are a sequence that
begins where the later of the two changed its motion, each found from the one before; whoever asks,
and when, gets the first of them that is not past.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ADVANCEMENTS,
    AFTER,
    BOUNDS,
    CELL_MOVES,
    COLUMN,
    FIRST,
    LEAST,
    LEAVES,
    MATE,
    MATE_STAMP,
    NOWHERE,
    PAUSE_AT,
    ROW,
    SECOND,
    SECOND_BOUND,
    STAMP,
    UNSOUND,
    WAY,
    WORK,
    Balls,
    Cells,
    Contacts,
    IntArray,
    Laws,
)
from ghostball.engine.motion.flight import one_flies
from ghostball.engine.motion.geometry import list_near
from ghostball.engine.motion.position import jerk, meets_until, pair_reach, relative_motion
from ghostball.engine.scheduling.contact_time import (
    NOT_YET,
    first_bound,
    holds,
    time_to_bound,
    touch,
)
from ghostball.engine.scheduling.grid import cell_number, settle, step_on, time_in_cell
from ghostball.engine.scheduling.priority_queue import enter_instant, first_due, least_of_others
from ghostball.engine.scheduling.ties import is_listed, takes_precedence

_REJECT_MARGIN = 2.0**-30
"""What a bound must be later by, relative to the distance, to be seen without computing it."""

_MOST_STEPS = 2**20
"""Steps towards a contact after which a run fails: a few are enough, since each is nearer by the
square."""


@kernel(inline=True)
def update(
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
def bound_of(
    balls: Balls,
    laws: Laws,
    contacts: Contacts | None,
    i: int,
    j: int,
    t: float,
    counters: IntArray,
) -> float:
    """As `scheduling.scheduler.bound_of`, found anew: t if they touch then, or a later one."""
    if contacts is not None and holds(contacts, i, j):
        return math.inf
    counters[BOUNDS] += 1
    end = min(meets_until(balls, i), meets_until(balls, j))
    start = max(balls.state[i].epoch, balls.state[j].epoch)
    bound = first_bound(balls, laws, i, j, start)
    bound = bound if bound <= end else math.inf
    return bound if bound > t else _later_bound(balls, laws, i, j, bound, t, end, counters)


@kernel
def _later_bound(
    balls: Balls,
    laws: Laws,
    i: int,
    j: int,
    bound: float,
    t: float,
    end: float,
    counters: IntArray,
) -> float:
    """Advance a bound that is not past the instant t [s] until it is, or the pair touches."""
    for _ in range(_MOST_STEPS):
        if not bound <= t:
            return bound
        counters[ADVANCEMENTS] += 1
        counters[WORK] += 1
        verdict, later, _ = touch(balls, laws, i, j, bound, 0.0)
        if verdict != NOT_YET:
            return bound
        bound = later if later <= end else math.inf
    counters[UNSOUND] = i
    return bound


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
    cells.slot[i, SECOND_BOUND] = math.inf
    cells.link[i, MATE] = NOWHERE
    column, row = cells.link[i, COLUMN], cells.link[i, ROW]
    for y in range(-1, 2):
        for x in range(-1, 2):
            cell = cell_number(cells, column + x, row + y)
            _meet_cell(balls, laws, cells, contacts, i, cell, t, shares, counters)
    enter_next(balls, cells, i)


@kernel
def refill_slot(
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
            left = left or holds(contacts, i, j)
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
    Most neighbours move away, or come later than two others: seen before roots are taken. A bound
    is the first root of c + b s + p s^2 / 2, with b = r . v, p = r . a and c = d (d - D); where all
    move uniformly, of (d^2 - D^2) / 2 + b s + v^2 s^2 / 2. Both lie above the same with c = (d^2 -
    D^2) / 2, which is (d - D)(d + D) / 2 <= d (d - D), with the largest diameter for D, and without
    what bends up. Where that is positive at first and when the second of the others is due, it was
    so in between, being straight or bending down: no root yet. `_REJECT_MARGIN` d^2 covers rounding
    of the sum, while |b| s is below 2^20 d^2 or so; a larger one has long been negative.

    A pair that is left out comes no sooner than `SECOND_BOUND`, which stays a bound for all but the
    mate.
    """
    start = max(balls.state[i].epoch, balls.state[j].epoch)
    if jerk(balls, i) + jerk(balls, j) > 0.0 or one_flies(balls.height, balls, i, j):
        bound = first_bound(balls, laws, i, j, start)
        _enter_bound(balls, laws, cells, i, j, bound, t, counters)
        return
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, start)
    rate = rx * vx + ry * vy
    pull = rx * ax + ry * ay
    if rate >= 0.0 and pull >= 0.0:
        return
    others = cells.slot[i, SECOND_BOUND]
    square = rx * rx + ry * ry
    if others < math.inf:
        s = others - start
        gap = 0.5 * (square - cells.frame[3] * cells.frame[3]) - _REJECT_MARGIN * square
        if gap > 0.0 and gap + s * (rate + 0.5 * min(pull, 0.0) * s) > 0.0:
            return
    reach = pair_reach(balls, i, j)
    bound = start + time_to_bound(laws, rx, ry, vx, vy, rate, pull, reach)
    _enter_bound(balls, laws, cells, i, j, bound, t, counters)


@kernel(inline=True)
def _enter_bound(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    i: int,
    j: int,
    bound: float,
    t: float,
    counters: IntArray,
) -> None:
    """Enter in ball i's slot a bound with ball j, found without looking, if it is among the two."""
    counters[BOUNDS] += 1
    others = cells.slot[i, SECOND_BOUND]
    end = min(meets_until(balls, i), meets_until(balls, j))
    bound = bound if bound <= end else math.inf
    if bound <= t:
        bound = _later_bound(balls, laws, i, j, bound, t, end, counters)
    if bound < cells.slot[i, LEAST]:
        cells.slot[i, SECOND_BOUND] = cells.slot[i, LEAST]
        cells.slot[i, LEAST] = bound
        cells.link[i, MATE] = j
        cells.link[i, MATE_STAMP] = cells.link[j, STAMP]
    elif bound < others:
        cells.slot[i, SECOND_BOUND] = bound


@kernel(inline=True)
def enter_next(balls: Balls, cells: Cells, i: int) -> None:
    """Enter ball i's next instant in the tree."""
    slot = min(cells.slot[i, LEAST], cells.slot[i, LEAVES])
    enter_instant(cells.tree, i, min(slot, balls.state[i].own_time))


@kernel(inline=True)
def earliest(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    counters: IntArray,
) -> tuple[float, int, int]:
    """As `scheduling.scheduler.earliest`.

    What concerns no ball's motion is done on the way: balls move to other cells, and slots that a
    mate left are filled anew.
    """
    while True:
        t = cells.tree[1]
        if not t < math.inf or counters[WORK] >= counters[PAUSE_AT]:
            return t, -1, -1
        single, settled = NOWHERE, True
        first = first_due(cells.tree, t, 0)
        alone = least_of_others(cells.tree, first) > t
        i = first
        while i != NOWHERE:
            if balls.state[i].own_time == t:
                if single == NOWHERE or takes_precedence(balls, i, single):
                    single = i
            elif cells.slot[i, LEAVES] == t:
                _move_on(balls, laws, cells, contacts, i, t, counters)
                settled = False
            elif cells.link[i, MATE] == NOWHERE:
                _fill_slot(balls, laws, cells, contacts, i, t, False, counters)
                settled = False
            elif cells.link[cells.link[i, MATE], STAMP] != cells.link[i, MATE_STAMP]:
                # Nothing with the others is due before `SECOND_BOUND`; often an event comes sooner.
                cells.slot[i, LEAST] = cells.slot[i, SECOND_BOUND]
                cells.link[i, MATE] = NOWHERE
                enter_next(balls, cells, i)
                settled = False
            i = NOWHERE if alone else first_due(cells.tree, t, i + 1)
        if settled:
            only = alone and cells.slot[first, SECOND_BOUND] > t
            return t, single, first if only else -1
        counters[WORK] += 2


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
    """Move ball i to the next cell on its way, at t [s]; there it meets the balls of three more.

    Where it is only said that it can't leave before t, see when it does from there.
    """
    if cells.link[i, WAY] == NOWHERE:
        cells.slot[i, LEAVES] = time_in_cell(balls, cells, i, t)
        enter_next(balls, cells, i)
        return
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
    enter_next(balls, cells, i)


@kernel(inline=True)
def set_aside(balls: Balls, cells: Cells, i: int) -> float:
    """As `scheduling.scheduler.set_aside`; nothing is moved."""
    others = min(cells.slot[i, SECOND_BOUND], cells.slot[i, LEAVES], balls.state[i].own_time)
    until: float = min(others, least_of_others(cells.tree, i))
    return until


@kernel(inline=True)
def put_bound(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    j: int,
    bound: float,
    t: float,
    counters: IntArray,
) -> None:
    """As `scheduling.scheduler.put_bound`: in the slots of both, where they have it."""
    if _is_moved_on(cells, i, j, bound, t):
        _advance_slot(balls, laws, cells, contacts, i, bound, t, counters)
    if _is_moved_on(cells, j, i, bound, t):
        _advance_slot(balls, laws, cells, contacts, j, bound, t, counters)


@kernel(inline=True)
def _is_moved_on(cells: Cells, i: int, j: int, bound: float, t: float) -> bool:
    """Whether ball i's slot has a bound with ball j that is due at t, and another than `bound`."""
    least = cells.slot[i, LEAST]
    return bool(least <= t and least < bound and cells.link[i, MATE] == j)


@kernel
def _advance_slot(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    bound: float,
    t: float,
    counters: IntArray,
) -> None:
    """Move on ball i's slot to its next bound with its mate, if that is still its earliest."""
    if bound < math.inf and bound <= cells.slot[i, SECOND_BOUND]:
        cells.slot[i, LEAST] = bound
        enter_next(balls, cells, i)
    else:
        refill_slot(balls, laws, cells, contacts, i, t, counters)


@kernel(inline=True)
def next_due(cells: Cells, t: float, start: int) -> int:
    """As `scheduling.scheduler.next_due`."""
    return first_due(cells.tree, t, start)


@kernel(inline=True)
def list_due(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    t: float,
    counters: IntArray,
) -> int:
    """As `scheduling.scheduler.list_due`."""
    if cells.slot[i, SECOND_BOUND] > t:
        balls.near[0] = cells.link[i, MATE]
        return 1
    return _list_several(balls, laws, cells, contacts, i, t, counters)


@kernel
def _list_several(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    i: int,
    t: float,
    counters: IntArray,
) -> int:
    """`list_due`, where another pair is as early; or the same, met again in another cell."""
    refill_slot(balls, laws, cells, contacts, i, t, counters)
    if cells.slot[i, LEAST] > t:
        return 0
    if cells.slot[i, SECOND_BOUND] > t:
        balls.near[0] = cells.link[i, MATE]
        return 1
    count = 0
    for c in range(list_near(balls, cells, i)):
        j = int(balls.near[c])
        if bound_of(balls, laws, contacts, i, j, t, counters) <= t:
            balls.near[count] = j
            count += 1
    return count


@kernel(inline=True)
def more_due(balls: Balls, cells: Cells, listed: int, t: float, until: float) -> bool:
    """As `scheduling.scheduler.more_due`."""
    for c in range(listed):
        for i in (balls.hits[c, FIRST], balls.hits[c, SECOND]):
            if t < cells.slot[i, LEAST] <= until or cells.slot[i, SECOND_BOUND] <= until:
                return True
    i = first_due(cells.tree, until, 0)
    while i != NOWHERE:
        if not is_listed(balls, listed, i):
            return True
        i = first_due(cells.tree, until, i + 1)
    return False

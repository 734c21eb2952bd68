"""When the next two balls touch, among many: bounds with neighbours only, in a grid of cells.

The other scheduler, `_pairs`, keeps a bound for every pair. Here the cloth is divided into cells no
smaller than the largest ball, so that a ball can only touch those in its own cell and the eight
around it; when it moves into another, it meets the balls of three new ones. Each ball keeps only
its earliest bound, in a slot: with whom, and a bound for all the others. A slot whose partner has
changed its motion meanwhile is found out by its stamp, when its turn comes, and filled anew. A
tournament tree over all balls finds the earliest.

The answers are those of `_pairs` to the bit. The bounds of a pair are a sequence that begins where
the later of the two changed its motion, each found from the one before; whoever asks, and when,
gets the first of them that is not past.
"""

from __future__ import annotations

import math

from engine._geometry import list_near, tie_rounding
from engine._jit import kernel
from engine._motion import first_crossing
from engine._state import (
    ADVANCEMENTS,
    AX,
    AY,
    BOUNDS,
    CELL_MOVES,
    EPOCH,
    FIRST,
    NEXT,
    NOWHERE,
    OWN_TIME,
    PARTNER,
    SECOND,
    VX,
    VY,
    Balls,
    Cells,
    Contacts,
    FloatArray,
    IntArray,
    Laws,
    X,
    Y,
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
        cells.stamp[i] += 1
        if cells.cell[i] == NOWHERE:
            _enter_cell(cells, i, _cell_at(cells, balls.state[i, X], balls.state[i, Y]))
        cells.leaves_at[i] = _time_in_cell(balls, cells, i, t)
    for m in range(1, balls.touched[0] + 1):
        # A pair of two that changed goes to the slot of the one that comes later.
        _fill_slot(balls, laws, cells, contacts, balls.touched[m], t, True, counters)


@kernel
def _cell_at(cells: Cells, x: float, y: float) -> int:
    """Return the cell that holds a place; the outermost reach as far as the cloth."""
    columns, rows = cells.size[0], cells.size[1]
    column = min(max(int((x - cells.frame[0]) / cells.frame[2]), 0), columns - 1)
    row = min(max(int((y - cells.frame[1]) / cells.frame[2]), 0), rows - 1)
    return int(row * columns + column)


@kernel
def _enter_cell(cells: Cells, i: int, cell: int) -> None:
    following = cells.first[cell]
    cells.cell[i] = cell
    cells.before[i] = NOWHERE
    cells.after[i] = following
    if following != NOWHERE:
        cells.before[following] = i
    cells.first[cell] = i


@kernel
def _leave_cell(cells: Cells, i: int) -> None:
    before, after = cells.before[i], cells.after[i]
    if before == NOWHERE:
        cells.first[cells.cell[i]] = after
    else:
        cells.after[before] = after
    if after != NOWHERE:
        cells.before[after] = before


@kernel(inline=True)
def _time_in_cell(balls: Balls, cells: Cells, i: int, t: float) -> float:
    """Return when ball i leaves its cell, as it moves from the instant t on; inf if never so.

    And note the way.
    """
    side = cells.frame[2]
    column, row = cells.cell[i] % cells.size[0], cells.cell[i] // cells.size[0]
    s = t - balls.state[i, EPOCH]
    ax, ay = balls.state[i, AX], balls.state[i, AY]
    x = balls.state[i, X] + s * (balls.state[i, VX] + 0.5 * ax * s) - cells.frame[0]
    y = balls.state[i, Y] + s * (balls.state[i, VY] + 0.5 * ay * s) - cells.frame[1]
    vx, vy = balls.state[i, VX] + ax * s, balls.state[i, VY] + ay * s
    least, way = math.inf, 0
    for k in range(4):
        # Left, right, down, up: there is no way out of the outermost.
        along = k < 2
        place, last = (column, cells.size[0] - 1) if along else (row, cells.size[1] - 1)
        up = k % 2 == 1
        if place == (last if up else 0):
            continue
        at, rate, pull = (x, vx, ax) if along else (y, vy, ay)
        gap = (place + 1) * side - at if up else at - place * side
        rate, pull = (-rate, -pull) if up else (rate, pull)
        if rate >= 0.0 and pull >= 0.0:
            continue
        leaves = first_crossing(gap, rate, pull)
        if leaves < least:
            least, way = leaves, k
    cells.way[i] = way
    return t + least


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
    cells.least[i] = math.inf
    cells.others[i] = math.inf
    columns, rows = cells.size[0], cells.size[1]
    column, row = cells.cell[i] % columns, cells.cell[i] // columns
    for y in range(max(row - 1, 0), min(row + 2, rows)):
        for x in range(max(column - 1, 0), min(column + 2, columns)):
            _meet_cell(balls, laws, cells, contacts, i, y * columns + x, t, shares, counters)
    _update_tree(balls, cells, i)


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
    """Enter in ball i's slot its bounds with the balls of one cell."""
    j = cells.first[cell]
    while j != NOWHERE:
        left = j == i or (shares and j > i and balls.changed[j])
        if contacts is not None:
            left = left or _holds(contacts, i, j)
        if not left:
            bound = _next_bound(balls, laws, i, j, t, counters)
            if bound < cells.least[i]:
                cells.others[i] = cells.least[i]
                cells.least[i] = bound
                cells.partner[i] = j
                cells.partner_stamp[i] = cells.stamp[j]
            elif bound < cells.others[i]:
                cells.others[i] = bound
        j = cells.after[j]


@kernel(inline=True)
def _update_tree(balls: Balls, cells: Cells, i: int) -> None:
    """Carry ball i's next instant up the tree, as far as it changes anything."""
    tree = cells.tree
    place = len(tree) // 2 + i
    tree[place] = min(cells.least[i], cells.leaves_at[i], balls.state[i, OWN_TIME])
    place >>= 1
    while place > 0:
        value = min(tree[2 * place], tree[2 * place + 1])
        if tree[place] == value:
            return
        tree[place] = value
        place >>= 1


@kernel
def _leaf_due(tree: FloatArray, t: float, start: int) -> int:
    """Return the first ball from `start` on whose next instant is t [s] or sooner, or NOWHERE."""
    leaves = len(tree) // 2
    if start >= leaves:
        return NOWHERE
    place = leaves + start
    if not tree[place] <= t:
        # Up, until a subtree to the right has it.
        while place & 1 or not tree[place + 1] <= t:
            place >>= 1
            if place <= 1:
                return NOWHERE
        place += 1
    while place < leaves:
        place = 2 * place if tree[2 * place] <= t else 2 * place + 1
    return place - leaves


@kernel(inline=True)
def earliest_in_cells(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    counters: IntArray,
) -> tuple[float, int]:
    """Return the instant [s] of the next event or bound, and the ball whose own event it is, or -1.

    What concerns no ball's motion is done on the way: balls move to other cells, and slots that a
    partner left are filled anew. Of several own events at one instant, as `_pairs.earliest`.
    """
    while True:
        t = cells.tree[1]
        if not t < math.inf:
            return t, -1
        single, settled = NOWHERE, True
        i = _leaf_due(cells.tree, t, 0)
        while i != NOWHERE:
            if balls.state[i, OWN_TIME] == t:
                if single == NOWHERE or takes_precedence(balls, i, single):
                    single = i
            elif cells.leaves_at[i] == t:
                _move_on(balls, laws, cells, contacts, i, t, counters)
                settled = False
            elif cells.partner[i] == NOWHERE:
                _fill_slot(balls, laws, cells, contacts, i, t, False, counters)
                settled = False
            elif cells.stamp[cells.partner[i]] != cells.partner_stamp[i]:
                # Nothing with the others is due before `others`; often an event comes sooner.
                cells.least[i] = cells.others[i]
                cells.partner[i] = NOWHERE
                _update_tree(balls, cells, i)
                settled = False
            i = _leaf_due(cells.tree, t, i + 1)
        if settled:
            return t, single


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
    columns, rows = cells.size[0], cells.size[1]
    way = cells.way[i]
    step = -1 if way % 2 == 0 else 1
    cell = cells.cell[i] + (step if way < 2 else step * columns)
    _leave_cell(cells, i)
    _enter_cell(cells, i, cell)
    cells.leaves_at[i] = _time_in_cell(balls, cells, i, t)
    column, row = cell % columns, cell // columns
    for k in range(-1, 2):
        x, y = (column + step, row + k) if way < 2 else (column + k, row + step)
        if 0 <= x < columns and 0 <= y < rows:
            _meet_cell(balls, laws, cells, contacts, i, y * columns + x, t, False, counters)
    _update_tree(balls, cells, i)


@kernel(inline=True)
def touching_in_cells(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    t: float,
    counters: IntArray,
) -> bool:
    """Judge every pair whose bound is the instant t [s], as `_pairs.touching`; whether one touches.

    Contract: `earliest_in_cells` has returned t, and no own event.
    """
    count, pressed, fastest = 0, 0, 0.0
    i = _leaf_due(cells.tree, t, 0)
    while i != NOWHERE:
        near = 1
        if cells.others[i] <= t:
            # Another pair as early; or the same, which the ball met again in another cell.
            _refill_slot(balls, laws, cells, contacts, i, t, counters)
            if cells.least[i] > t:
                near = 0
            elif cells.others[i] <= t:
                near = list_near(balls, cells, i)
        for c in range(near):
            j = balls.near[c] if cells.others[i] <= t else cells.partner[i]
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
                _advance_slot(balls, laws, cells, contacts, i, j, bound, t, counters)
                _advance_slot(balls, laws, cells, contacts, j, i, bound, t, counters)
            elif verdict == PRESSED:
                # From the other end, out of the way of impacts.
                pressed += 1
                list_hit(balls, last - pressed, i, j)
            elif laws.simultaneous or speed > fastest:
                count = count + 1 if laws.simultaneous else 1
                fastest = max(speed, fastest)
                list_hit(balls, count - 1, i, j)
        i = _leaf_due(cells.tree, t, i + 1)
    if count > 0 and laws.simultaneous:
        count = _join_ties(balls, laws, cells, contacts, t, fastest, count, counters)
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
    t: float,
    counters: IntArray,
) -> None:
    """Move on ball i's slot to its next bound with ball j, if the one at t [s] is there."""
    if cells.least[i] != t or cells.partner[i] != j:
        return
    end = min(balls.state[i, OWN_TIME], balls.state[j, OWN_TIME])
    if bound <= end and bound <= cells.others[i]:
        cells.least[i] = bound
        _update_tree(balls, cells, i)
    else:
        _refill_slot(balls, laws, cells, contacts, i, t, counters)


@kernel
def _join_ties(
    balls: Balls,
    laws: Laws,
    cells: Cells,
    contacts: Contacts | None,
    t: float,
    speed: float,
    listed: int,
    counters: IntArray,
) -> int:
    """List also the pairs that touch but for rounding, as `_pairs._join_ties`."""
    until = when_tied(balls, listed, t, speed)
    count = listed
    if not _is_more_due(balls, cells, listed, until):
        return count
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


@kernel
def _is_more_due(balls: Balls, cells: Cells, listed: int, until: float) -> bool:
    """Whether a slot has a bound up to `until` [s], other than those of the listed pairs."""
    for c in range(listed):
        if cells.others[balls.hits[c, FIRST]] <= until:
            return True
        if cells.others[balls.hits[c, SECOND]] <= until:
            return True
    i = _leaf_due(cells.tree, until, 0)
    while i != NOWHERE:
        if not is_listed(balls, listed, i):
            return True
        i = _leaf_due(cells.tree, until, i + 1)
    return False

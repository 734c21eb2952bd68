"""Scheduler for many balls: a grid of cells, with bounds only for neighbours.

The other scheduler, `scheduling.all_pairs`, stores a bound for every pair. This one checks a ball
only against the balls in its own cell and in the eight cells around it (`scheduling.grid`). When
the ball enters another cell, it is checked against the balls of three new cells.

Each ball has one slot, with its earliest bound, the other ball of this bound (the partner), and one
bound for all remaining neighbours. If the partner changes its motion, the slot isn't updated at
once. When the slot is due, a stamp shows that the partner has changed. The bound for the remaining
neighbours then takes its place, and the slot is filled again when this bound is due. A priority
queue (`scheduling.priority_queue`) finds the earliest slot.

The results are bit-identical to those of `scheduling.all_pairs`. The bounds of a pair are a fixed
sequence. It starts at the last change of motion of either ball, and each bound is computed from the
one before. A query at any time returns the first bound of this sequence that isn't past.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Cells, World
from ghostball.engine.motion.geometry import list_near
from ghostball.engine.motion.position import (
    jerk,
    meets_until,
    one_flies,
    pair_reach,
    relative_motion,
)
from ghostball.engine.scheduling.grid import cell_number, put_in_cell, step_on, time_in_cell
from ghostball.engine.scheduling.priority_queue import enter_instant, first_due, least_of_others
from ghostball.engine.scheduling.ties import is_listed, takes_precedence
from ghostball.engine.scheduling.time_of_impact import (
    NOT_YET,
    first_bound,
    holds,
    time_to_bound,
    touch,
)

_REJECT_MARGIN = 2.0**-30
"""Margin, relative to the squared distance, by which a pair must stay open to be skipped without
computing its bound."""

_MOST_STEPS = 2**20
"""Number of advancements towards a contact after which a run fails. Usually a few are enough,
because they converge quadratically."""


@kernel(inline=True)
def update(world: World, t: float) -> None:
    """Refill the slots of the balls in `balls.touched`, whose motion changed at t [s]."""
    balls, cells = world.balls, world.cells
    for m in range(1, balls.touched[0] + 1):
        i = balls.touched[m]
        cells.link[i, st.STAMP] += 1
        if cells.link[i, st.CELL_COLUMN] == 0:
            put_in_cell(world, i)
    for m in range(1, balls.touched[0] + 1):
        # A pair of two changed balls goes into the slot of the ball with the higher index.
        i = balls.touched[m]
        cells.slot[i, st.LEAVES] = time_in_cell(world, i, t)
        _fill_slot(world, i, t, True)


@kernel(inline=True)
def bound_of(world: World, i: int, j: int, t: float) -> float:
    """Implement `scheduling.scheduler.bound_of`: compute the bound again; t if the pair touches."""
    balls = world.balls
    if holds(world.contacts, i, j):
        return math.inf
    world.log.counters[st.BOUNDS] += 1
    end = min(meets_until(balls, i), meets_until(balls, j))
    start = max(balls.state[i].epoch, balls.state[j].epoch)
    bound = first_bound(balls, world.laws, i, j, start)
    bound = bound if bound <= end else math.inf
    return bound if bound > t else _later_bound(world, i, j, bound, t, end)


@kernel
def _later_bound(world: World, i: int, j: int, bound: float, t: float, end: float) -> float:
    """Advance a bound until it is later than t [s], or until the pair touches; return the bound."""
    counters = world.log.counters
    for _ in range(_MOST_STEPS):
        if not bound <= t:
            return bound
        counters[st.ADVANCEMENTS] += 1
        counters[st.WORK] += 1
        verdict, later, _ = touch(world.balls, world.laws, i, j, bound, 0.0)
        if verdict != NOT_YET:
            return bound
        bound = later if later <= end else math.inf
    counters[st.NOT_FINITE] = i
    return bound


@kernel(inline=True)
def _fill_slot(world: World, i: int, t: float, shares: bool) -> None:
    """Put in the slot of ball i its earliest bound from t [s] on, and the next one after it.

    If `shares`, pairs with a changed ball of a higher index are left to the slot of that ball.
    """
    cells = world.cells
    cells.slot[i, st.LEAST] = math.inf
    cells.slot[i, st.SECOND_BOUND] = math.inf
    cells.link[i, st.SLOT_PARTNER] = st.NOWHERE
    column, row = cells.link[i, st.CELL_COLUMN], cells.link[i, st.CELL_ROW]
    for y in range(-1, 2):
        for x in range(-1, 2):
            cell = cell_number(cells, column + x, row + y)
            _meet_cell(world, i, cell, t, shares)
    enter_next(world, i)


@kernel
def refill_slot(world: World, i: int, t: float) -> None:
    """Do the same as `_fill_slot` with `shares` false, without inlining, for rare calls."""
    _fill_slot(world, i, t, False)


@kernel(inline=True)
def _meet_cell(world: World, i: int, cell: int, t: float, shares: bool) -> None:
    """Enter in the slot of ball i its bounds with the balls of a cell, except its partner."""
    cells = world.cells
    j = cells.first[cell]
    while j != st.NOWHERE:
        known = (
            j == cells.link[i, st.SLOT_PARTNER]
            and cells.link[j, st.STAMP] == cells.link[i, st.PARTNER_STAMP]
        )
        left = j == i or known or (shares and j > i and world.balls.changed[j])
        if not left and not holds(world.contacts, i, j):
            _meet_ball(world, i, j, t)
        j = cells.link[j, st.AFTER]


@kernel(inline=True)
def _meet_ball(world: World, i: int, j: int, t: float) -> None:
    """Enter in the slot of ball i its bound with ball j, if it is among the two earliest.

    Most neighbours move apart, or touch later than two other neighbours. A test without a square
    root finds them. A bound is the first root of c + b s + p s^2 / 2 with b = r . v, p = r . a and
    c = d (d - D). If all balls move uniformly, it is the first root of (d^2 - D^2) / 2 + b s + v^2
    s^2 / 2. Let f(s) = (d^2 - D^2) / 2 + b s + min(p, 0) s^2 / 2, with the largest diameter for D.
    Neither polynomial is below f, because (d^2 - D^2) / 2 = (d - D)(d + D) / 2 <= d (d - D). f is
    linear or concave: if it is positive at the start and at the time of `SECOND_BOUND`, it is
    positive in between, and neither polynomial has a root before that time. `_REJECT_MARGIN` d^2
    covers the rounding of the sum if |b| s is below about 2^20 d^2. If |b| s is larger, f is far
    more negative than rounding.

    A skipped pair can't touch before `SECOND_BOUND`, so this remains a bound for all neighbours
    except the partner.
    """
    balls, cells = world.balls, world.cells
    start = max(balls.state[i].epoch, balls.state[j].epoch)
    if jerk(balls, i) + jerk(balls, j) > 0.0 or one_flies(balls, i, j):
        bound = first_bound(balls, world.laws, i, j, start)
        _enter_bound(world, i, j, bound, t)
        return
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, start)
    rate = rx * vx + ry * vy
    pull = rx * ax + ry * ay
    if rate >= 0.0 and pull >= 0.0:
        return
    others = cells.slot[i, st.SECOND_BOUND]
    square = rx * rx + ry * ry
    if others < math.inf:
        s = others - start
        gap = 0.5 * (square - cells.frame[3] * cells.frame[3]) - _REJECT_MARGIN * square
        if gap > 0.0 and gap + s * (rate + 0.5 * min(pull, 0.0) * s) > 0.0:
            return
    reach = pair_reach(balls, i, j)
    bound = start + time_to_bound(world.laws, rx, ry, vx, vy, rate, pull, reach)
    _enter_bound(world, i, j, bound, t)


@kernel(inline=True)
def _enter_bound(world: World, i: int, j: int, bound: float, t: float) -> None:
    """Enter a bound with ball j in the slot of ball i, if it is among the two earliest."""
    cells = world.cells
    world.log.counters[st.BOUNDS] += 1
    others = cells.slot[i, st.SECOND_BOUND]
    end = min(meets_until(world.balls, i), meets_until(world.balls, j))
    bound = bound if bound <= end else math.inf
    if bound <= t:
        bound = _later_bound(world, i, j, bound, t, end)
    if bound < cells.slot[i, st.LEAST]:
        cells.slot[i, st.SECOND_BOUND] = cells.slot[i, st.LEAST]
        cells.slot[i, st.LEAST] = bound
        cells.link[i, st.SLOT_PARTNER] = j
        cells.link[i, st.PARTNER_STAMP] = cells.link[j, st.STAMP]
    elif bound < others:
        cells.slot[i, st.SECOND_BOUND] = bound


@kernel(inline=True)
def enter_next(world: World, i: int) -> None:
    """Enter the time of the next entry of ball i in the priority queue."""
    cells = world.cells
    slot = min(cells.slot[i, st.LEAST], cells.slot[i, st.LEAVES])
    own_time = world.balls.state[i].own_time
    enter_instant(cells.tree, i, min(slot, own_time))
    if own_time == cells.frame[st.TIED_AT] and world.balls.own_kind[i] < cells.frame[st.TIED_KIND]:
        cells.frame[st.TIED_KIND] = world.balls.own_kind[i]


@kernel(inline=True)
def earliest(world: World) -> tuple[float, int, int]:
    """Implement `scheduling.scheduler.earliest`.

    The function also does the work that changes no motion: it moves balls to other cells, and
    refills slots whose partner has changed. If own events tie, it stores the smallest kind among
    them, so that the next event of that kind is found without comparing all. Balls that reach
    cushions simultaneously are ordered by position, so each is compared with all other balls.
    """
    cells, counters = world.cells, world.log.counters
    while True:
        t = cells.tree[1]
        if not t < math.inf or counters[st.WORK] >= counters[st.PAUSE_AT]:
            return t, -1, -1
        single, is_done, looked = st.NOWHERE, True, 0
        first = first_due(cells.tree, t, 0)
        alone = least_of_others(cells.tree, first) > t
        i = first
        while i != st.NOWHERE:
            if world.balls.state[i].own_time == t:
                if t == cells.frame[st.TIED_AT] and _is_of_tied_kind(world, i):
                    return t, i, -1
                if single == st.NOWHERE or takes_precedence(world.balls, i, single):
                    single = i
            elif cells.slot[i, st.LEAVES] == t:
                _move_on(world, i, t)
                is_done = False
            elif cells.link[i, st.SLOT_PARTNER] == st.NOWHERE:
                _fill_slot(world, i, t, False)
                is_done = False
            elif (
                cells.link[cells.link[i, st.SLOT_PARTNER], st.STAMP]
                != cells.link[i, st.PARTNER_STAMP]
            ):
                # No other neighbour is due before `SECOND_BOUND`, and often another event comes
                # first.
                cells.slot[i, st.LEAST] = cells.slot[i, st.SECOND_BOUND]
                cells.link[i, st.SLOT_PARTNER] = st.NOWHERE
                enter_next(world, i)
                is_done = False
            i = st.NOWHERE if alone else first_due(cells.tree, t, i + 1)
            looked += 1
        if is_done:
            # Stay below the pause, so that a continued run first resolves the event found here.
            spare = max(counters[st.PAUSE_AT] - 1 - counters[st.WORK], 0)
            counters[st.WORK] += min(looked, spare)
            if single != st.NOWHERE and not alone:
                cells.frame[st.TIED_AT] = t
                cells.frame[st.TIED_KIND] = world.balls.own_kind[single]
            only = alone and cells.slot[first, st.SECOND_BOUND] > t
            return t, single, first if only else -1
        counters[st.WORK] += 1 + looked


@kernel(inline=True)
def _is_of_tied_kind(world: World, i: int) -> bool:
    """Return whether the own event of ball i has the smallest kind at `TIED_AT`.

    Any ball with such an event may come first, except at cushions.
    """
    kind = world.balls.own_kind[i]
    return bool(kind == world.cells.frame[st.TIED_KIND] and kind < st.OWN_CUSHION)


@kernel(inline=True)
def _move_on(world: World, i: int, t: float) -> None:
    """Move ball i to the next cell on its path, at t [s], and check it against three new cells.

    If t is only a bound on the time at which the ball leaves, compute this time again instead.
    """
    cells = world.cells
    if cells.link[i, st.LEAVES_BY] == st.NOWHERE:
        cells.slot[i, st.LEAVES] = time_in_cell(world, i, t)
        enter_next(world, i)
        return
    world.log.counters[st.CELL_MOVES] += 1
    side = cells.link[i, st.LEAVES_BY]
    step_on(cells, i)
    cells.slot[i, st.LEAVES] = time_in_cell(world, i, t)
    column, row = cells.link[i, st.CELL_COLUMN], cells.link[i, st.CELL_ROW]
    step = -1 if side % 2 == 0 else 1
    for k in range(-1, 2):
        x, y = (column + step, row + k) if side < 2 else (column + k, row + step)
        cell = cell_number(cells, x, y)
        _meet_cell(world, i, cell, t, False)
    enter_next(world, i)


@kernel(inline=True)
def set_aside(world: World, i: int) -> float:
    """Implement `scheduling.scheduler.set_aside`; nothing is stored."""
    cells = world.cells
    others = min(
        cells.slot[i, st.SECOND_BOUND], cells.slot[i, st.LEAVES], world.balls.state[i].own_time
    )
    until: float = min(others, least_of_others(cells.tree, i))
    return until


@kernel(inline=True)
def put_bound(world: World, i: int, j: int, bound: float, t: float) -> None:
    """Implement `scheduling.scheduler.put_bound` for each of the two slots that has the pair."""
    if _is_moved_on(world.cells, i, j, bound, t):
        _advance_slot(world, i, bound, t)
    if _is_moved_on(world.cells, j, i, bound, t):
        _advance_slot(world, j, bound, t)


@kernel(inline=True)
def _is_moved_on(cells: Cells, i: int, j: int, bound: float, t: float) -> bool:
    """Return whether the slot of ball i has a bound with ball j due at t and below `bound`."""
    least = cells.slot[i, st.LEAST]
    return bool(least <= t and least < bound and cells.link[i, st.SLOT_PARTNER] == j)


@kernel
def _advance_slot(world: World, i: int, bound: float, t: float) -> None:
    """Set the slot of ball i to the next bound with its partner, if this is still the earliest."""
    if bound < math.inf and bound <= world.cells.slot[i, st.SECOND_BOUND]:
        world.cells.slot[i, st.LEAST] = bound
        enter_next(world, i)
    else:
        refill_slot(world, i, t)


@kernel(inline=True)
def next_due(cells: Cells, t: float, start: int) -> int:
    """Implement `scheduling.scheduler.next_due`."""
    return first_due(cells.tree, t, start)


@kernel(inline=True)
def list_due(world: World, i: int, t: float) -> int:
    """Implement `scheduling.scheduler.list_due`."""
    if world.cells.slot[i, st.SECOND_BOUND] > t:
        world.balls.near[0] = world.cells.link[i, st.SLOT_PARTNER]
        return 1
    return _list_several(world, i, t)


@kernel
def _list_several(world: World, i: int, t: float) -> int:
    """Do the same as `list_due` if two entries are due: two pairs, or one pair from two cells."""
    balls, cells = world.balls, world.cells
    refill_slot(world, i, t)
    if cells.slot[i, st.LEAST] > t:
        return 0
    if cells.slot[i, st.SECOND_BOUND] > t:
        balls.near[0] = cells.link[i, st.SLOT_PARTNER]
        return 1
    count = 0
    for c in range(list_near(balls, cells, i)):
        j = int(balls.near[c])
        if bound_of(world, i, j, t) <= t:
            balls.near[count] = j
            count += 1
    return count


@kernel(inline=True)
def more_due(world: World, listed: int, t: float, until: float) -> bool:
    """Implement `scheduling.scheduler.more_due`."""
    balls, cells = world.balls, world.cells
    for c in range(listed):
        for i in (balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]):
            if t < cells.slot[i, st.LEAST] <= until or cells.slot[i, st.SECOND_BOUND] <= until:
                return True
    i = first_due(cells.tree, until, 0)
    while i != st.NOWHERE:
        if not is_listed(balls, listed, i):
            return True
        i = first_due(cells.tree, until, i + 1)
    return False

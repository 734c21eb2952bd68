"""The one interface of both schedulers, which know when which pairs may touch next.

`scheduling.all_pairs` for few balls, `scheduling.broad_phase` for many. Which of them the kernels
contain is decided where they are compiled, by which of `pairs` and `cells` is None. They differ in
how they keep the bounds of pairs: each has a function for each here, of the same name. What becomes
of bounds that are due is judged for both by `scheduling.due_pairs`.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import NOWHERE, Balls, Cells, Contacts, IntArray, Laws, Pairs
from ghostball.engine.scheduling import all_pairs, broad_phase as in_cells


@kernel(inline=True)
def update(
    balls: Balls,
    laws: Laws,
    pairs: Pairs | None,
    cells: Cells | None,
    contacts: Contacts | None,
    t: float,
    counters: IntArray,
) -> None:
    """Bound anew every pair of the balls in `balls.touched`, whose motion changed at t [s]."""
    if pairs is not None:
        all_pairs.update(balls, laws, pairs, contacts, t, counters)
    if cells is not None:
        in_cells.update(balls, laws, cells, contacts, t, counters)


@kernel(inline=True)
def earliest(
    balls: Balls,
    laws: Laws,
    pairs: Pairs | None,
    cells: Cells | None,
    contacts: Contacts | None,
    counters: IntArray,
) -> tuple[float, int, int]:
    """Return the instant [s] of the next event or bound; and whose.

    That is the ball whose own event it is, or -1, and the only row or slot of bounds that has it,
    or -1. Of several own events at one instant, the first as `scheduling.ties` orders them.
    """
    if pairs is not None:
        return all_pairs.earliest(balls, pairs)
    if cells is not None:
        return in_cells.earliest(balls, laws, cells, contacts, counters)
    return math.nan, -1, -1


@kernel(inline=True)
def next_due(pairs: Pairs | None, cells: Cells | None, t: float, start: int) -> int:
    """Return the first row or slot from `start` on that has a bound due at t [s], or NOWHERE."""
    if pairs is not None:
        return all_pairs.next_due(pairs, t, start)
    if cells is not None:
        return in_cells.next_due(cells, t, start)
    return NOWHERE


@kernel(inline=True)
def list_due(
    balls: Balls,
    laws: Laws,
    pairs: Pairs | None,
    cells: Cells | None,
    contacts: Contacts | None,
    i: int,
    t: float,
    counters: IntArray,
) -> int:
    """Put in `balls.near` the balls with which row or slot i has a bound due at t; say how many.

    The same pair may be listed for either of its balls.
    """
    if pairs is not None:
        return all_pairs.list_due(balls, pairs, i, t)
    if cells is not None:
        return in_cells.list_due(balls, laws, cells, contacts, i, t, counters)
    return 0


@kernel(inline=True)
def more_due(
    balls: Balls, pairs: Pairs | None, cells: Cells | None, listed: int, t: float, until: float
) -> bool:
    """Whether a pair may have a bound up to `until` [s] that isn't one of the listed.

    Those are the first `listed` of `balls.hits`, which touch at the instant t [s]. A single one is
    set aside.
    """
    if pairs is not None:
        return all_pairs.more_due(pairs, until)
    if cells is not None:
        return in_cells.more_due(balls, cells, listed, t, until)
    return False


@kernel(inline=True)
def bound_of(
    balls: Balls,
    laws: Laws,
    pairs: Pairs | None,
    cells: Cells | None,
    contacts: Contacts | None,
    i: int,
    j: int,
    t: float,
    counters: IntArray,
) -> float:
    """Return the bound of a pair at the instant t [s]; inf where a contact step holds it."""
    if pairs is not None:
        return all_pairs.bound_of(pairs, i, j)
    if cells is not None:
        return in_cells.bound_of(balls, laws, contacts, i, j, t, counters)
    return math.inf


@kernel(inline=True)
def set_aside(balls: Balls, pairs: Pairs | None, cells: Cells | None, i: int, j: int) -> float:
    """Take from row or slot i its bound with ball j; return when anything else is due [s]."""
    if pairs is not None:
        return all_pairs.set_aside(balls, pairs, i, j)
    if cells is not None:
        return in_cells.set_aside(balls, cells, i)
    return math.inf


@kernel(inline=True)
def put_bound(
    balls: Balls,
    laws: Laws,
    pairs: Pairs | None,
    cells: Cells | None,
    contacts: Contacts | None,
    i: int,
    j: int,
    bound: float,
    t: float,
    counters: IntArray,
) -> None:
    """Move on the bound of a pair that was set aside; all up to the instant t [s] is known."""
    if pairs is not None:
        all_pairs.put_bound(pairs, i, j, bound)
    if cells is not None:
        in_cells.put_bound(balls, laws, cells, contacts, i, j, bound, t, counters)

"""What comes next: the one interface of both schedulers.

`scheduling.all_pairs` for few balls, `scheduling.cells` for many. Which of them the kernels contain
is decided where they are compiled, by which of `pairs` and `cells` is None.
"""

from __future__ import annotations

import math

from engine.core.kernel import kernel
from engine.core.state import Balls, Cells, Contacts, IntArray, Laws, Pairs
from engine.scheduling.all_pairs import earliest_of_pairs, touching_pairs, update_pairs
from engine.scheduling.cells import earliest_in_cells, update_in_cells
from engine.scheduling.contacts_in_cells import touching_in_cells


@kernel(inline=True)
def update_balls(
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
        update_pairs(balls, laws, pairs, contacts, t, counters)
    if cells is not None:
        update_in_cells(balls, laws, cells, contacts, t, counters)


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
    or -1.
    """
    if pairs is not None:
        return earliest_of_pairs(balls, pairs)
    if cells is not None:
        return earliest_in_cells(balls, laws, cells, contacts, counters)
    return math.nan, -1, -1


@kernel(inline=True)
def touching(
    balls: Balls,
    laws: Laws,
    pairs: Pairs | None,
    cells: Cells | None,
    contacts: Contacts | None,
    t: float,
    row: int,
    counters: IntArray,
) -> float:
    """Judge every pair whose bound is the instant t [s]; `earliest` returned t and `row`.

    Return when the first of them touches, if nothing else comes before: PENDING of them are then in
    the first rows of `balls.hits`, by their indices, and PENDING_VERDICT is IMPACT, for all pairs
    that approach, or for the fastest of them where impacts are sequential; or else PRESSED. Return
    inf where all those bounds have moved on. More than there is room for leave NO_ROOM.
    """
    if pairs is not None:
        return touching_pairs(balls, laws, pairs, t, row, counters)
    if cells is not None:
        return touching_in_cells(balls, laws, cells, contacts, t, row, counters)
    return math.nan

"""Common interface of the two schedulers, which predict when pairs of balls can touch next.

A scene with `Cells` uses `scheduling.broad_phase`, made for many balls; other scenes use
`scheduling.all_pairs`. The two differ in how they store the bounds of pairs. Each implements the
functions of this module under the same names. `scheduling.due_pairs` handles expired bounds for
both.

A bound of a pair is a time before which the two balls can't touch. It is due when that time comes.
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import World
from ghostball.engine.motion.geometry import has_cells
from ghostball.engine.scheduling import all_pairs, broad_phase as in_cells


@kernel(inline=True)
def update(world: World, t: float) -> None:
    """Recompute the bounds of the balls in `balls.touched`, whose motion changed at t [s]."""
    if not has_cells(world.cells):
        all_pairs.update(world, t)
    else:
        in_cells.update(world, t)


@kernel(inline=True)
def earliest(world: World) -> tuple[float, int, int]:
    """Return the time [s] of the next event or bound, its ball, and its row.

    The ball is that of an own event, or -1 if the next is a bound. The row is the only row or slot
    with an entry at that time, or -1 if there are several. If several own events have the same
    time, `scheduling.ties` decides which ball is returned.
    """
    if not has_cells(world.cells):
        return all_pairs.earliest(world)
    return in_cells.earliest(world)


@kernel(inline=True)
def next_due(world: World, t: float, start: int) -> int:
    """Return the first row or slot from `start` on that has a bound due at t [s], or NOWHERE."""
    if not has_cells(world.cells):
        return all_pairs.next_due(world.pairs, t, start)
    return in_cells.next_due(world.cells, t, start)


@kernel(inline=True)
def list_due(world: World, i: int, t: float) -> int:
    """Put in `balls.near` the balls with a bound due at t in row or slot i; return their number.

    A pair may be listed twice, once for each of its balls.
    """
    if not has_cells(world.cells):
        return all_pairs.list_due(world, i, t)
    return in_cells.list_due(world, i, t)


@kernel(inline=True)
def more_due(world: World, listed: int, t: float, until: float) -> bool:
    """Return whether a pair that isn't listed may have a bound up to `until` [s].

    The listed pairs are the first `listed` rows of `balls.touching`, which touch at t [s]. If there
    is only one, it was set aside.
    """
    if not has_cells(world.cells):
        return all_pairs.more_due(world.pairs, until)
    return in_cells.more_due(world, listed, t, until)


@kernel(inline=True)
def bound_of(world: World, i: int, j: int, t: float) -> float:
    """Return the bound of a pair at time t [s]; inf if a contact step holds the pair together."""
    if not has_cells(world.cells):
        return all_pairs.bound_of(world.pairs, i, j)
    return in_cells.bound_of(world, i, j, t)


@kernel(inline=True)
def set_aside(world: World, i: int, j: int) -> float:
    """Remove the bound with ball j from row or slot i; return when another entry is due [s]."""
    if not has_cells(world.cells):
        return all_pairs.set_aside(world, i, j)
    return in_cells.set_aside(world, i)


@kernel(inline=True)
def put_bound(world: World, i: int, j: int, bound: float, t: float) -> None:
    """Store the next bound of a pair that was set aside; everything up to t [s] is resolved."""
    if not has_cells(world.cells):
        all_pairs.put_bound(world.pairs, i, j, bound)
    else:
        in_cells.put_bound(world, i, j, bound, t)

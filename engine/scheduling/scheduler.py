"""The one interface of both schedulers, which know when which pairs may touch next.

`scheduling.all_pairs` for few balls, `scheduling.broad_phase` for many: the latter where a scene
has `Cells`. They differ in how they keep the bounds of pairs: each has a function for each here, of
the same name. What becomes of bounds that are due is judged for both by `scheduling.due_pairs`.
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import World
from ghostball.engine.motion.geometry import has_cells
from ghostball.engine.scheduling import all_pairs, broad_phase as in_cells


@kernel(inline=True)
def update(world: World, t: float) -> None:
    """Bound anew every pair of the balls in `balls.touched`, whose motion changed at t [s]."""
    if not has_cells(world.cells):
        all_pairs.update(world, t)
    else:
        in_cells.update(world, t)


@kernel(inline=True)
def earliest(world: World) -> tuple[float, int, int]:
    """Return the instant [s] of the next event or bound; and whose.

    That is the ball whose own event it is, or -1, and the only row or slot of bounds that has it,
    or -1. Of several own events at one instant, the first as `scheduling.ties` orders them.
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
    """Put in `balls.near` the balls with which row or slot i has a bound due at t; say how many.

    The same pair may be listed for either of its balls.
    """
    if not has_cells(world.cells):
        return all_pairs.list_due(world, i, t)
    return in_cells.list_due(world, i, t)


@kernel(inline=True)
def more_due(world: World, listed: int, t: float, until: float) -> bool:
    """Whether a pair may have a bound up to `until` [s] that isn't one of the listed.

    Those are the first `listed` of `balls.touching`, which touch at the instant t [s]. A single one
    is set aside.
    """
    if not has_cells(world.cells):
        return all_pairs.more_due(world.pairs, until)
    return in_cells.more_due(world, listed, t, until)


@kernel(inline=True)
def bound_of(world: World, i: int, j: int, t: float) -> float:
    """Return the bound of a pair at the instant t [s]; inf where a contact step holds it."""
    if not has_cells(world.cells):
        return all_pairs.bound_of(world.pairs, i, j)
    return in_cells.bound_of(world, i, j, t)


@kernel(inline=True)
def set_aside(world: World, i: int, j: int) -> float:
    """Take from row or slot i its bound with ball j; return when anything else is due [s]."""
    if not has_cells(world.cells):
        return all_pairs.set_aside(world, i, j)
    return in_cells.set_aside(world, i)


@kernel(inline=True)
def put_bound(world: World, i: int, j: int, bound: float, t: float) -> None:
    """Move on the bound of a pair that was set aside; all up to the instant t [s] is known."""
    if not has_cells(world.cells):
        all_pairs.put_bound(world.pairs, i, j, bound)
    else:
        in_cells.put_bound(world, i, j, bound, t)

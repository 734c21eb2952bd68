"""Grid of cells for the broad phase: which cell a ball is in, when it leaves, and by which side.

A cell is no smaller than the largest ball, so a ball can only touch balls in its own cell and the
eight around it. The balls of a cell form a doubly linked list. A border of empty cells surrounds
the grid, so that every cell inside has eight neighbours.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Cells, World
from ghostball.engine.motion.crossings import first_crossing
from ghostball.engine.motion.position import acceleration, bend, position_at, velocity

_LATE = 2.0**-24
"""Distance beyond the side of its cell at which a ball leaves, as a fraction of the side. The
distance is less than the margin by which a cell exceeds the largest ball. A ball that moved along
the side would otherwise change cells endlessly at one time, because rounding puts it on either
side."""


@kernel(inline=True)
def cell_number(cells: Cells, column: int, row: int) -> int:
    """Return the index of a cell in `cells.first`."""
    return int(row * (cells.size[0] + 2) + column)


@kernel
def put_in_cell(world: World, i: int) -> None:
    """Put ball i in the cell at its position; a ball outside the grid goes to the nearest cell."""
    cells = world.cells
    x, y = world.balls.state[i].x - cells.frame[0], world.balls.state[i].y - cells.frame[1]
    column = min(max(int(x / cells.frame[2]), 0), cells.size[0] - 1)
    row = min(max(int(y / cells.frame[2]), 0), cells.size[1] - 1)
    _enter(cells, i, column + 1, row + 1)


@kernel(inline=True)
def _enter(cells: Cells, i: int, column: int, row: int) -> None:
    cell = cell_number(cells, column, row)
    following = cells.first[cell]
    cells.link[i, st.CELL_COLUMN], cells.link[i, st.CELL_ROW] = column, row
    cells.link[i, st.BEFORE], cells.link[i, st.AFTER] = st.NOWHERE, following
    if following != st.NOWHERE:
        cells.link[following, st.BEFORE] = i
    cells.first[cell] = i


@kernel(inline=True)
def _leave(cells: Cells, i: int) -> None:
    before, after = cells.link[i, st.BEFORE], cells.link[i, st.AFTER]
    if before == st.NOWHERE:
        cells.first[
            cell_number(cells, cells.link[i, st.CELL_COLUMN], cells.link[i, st.CELL_ROW])
        ] = after
    else:
        cells.link[before, st.AFTER] = after
    if after != st.NOWHERE:
        cells.link[after, st.BEFORE] = before


@kernel(inline=True)
def step_on(cells: Cells, i: int) -> None:
    """Move ball i to the next cell on its path."""
    _leave(cells, i)
    side = cells.link[i, st.LEAVES_BY]
    step = -1 if side % 2 == 0 else 1
    column, row = cells.link[i, st.CELL_COLUMN], cells.link[i, st.CELL_ROW]
    _enter(cells, i, column + (step if side < 2 else 0), row + (0 if side < 2 else step))


@kernel(inline=True)
def time_in_cell(world: World, i: int, t: float) -> float:
    """Return when ball i leaves its cell [s], from its motion at time t; inf if it never does.

    Also store the side by which it leaves.
    """
    balls, cells = world.balls, world.cells
    side = cells.frame[2]
    column, row = cells.link[i, st.CELL_COLUMN], cells.link[i, st.CELL_ROW]
    (x, y), (vx, vy) = position_at(balls, i, t), velocity(balls, i, t)
    x, y = x - cells.frame[0], y - cells.frame[1]
    ax, ay = acceleration(balls, i, t)
    left = balls.state[i].own_time - t
    bx, by = bend(balls, i, left)
    nearer = -_LATE * side
    # Left, right, down, up. A ball can't leave the grid.
    inside = (column > 1, column < cells.size[0], row > 1, row < cells.size[1])
    gaps = (x - (column - 1) * side, column * side - x, y - (row - 1) * side, row * side - y)
    rates, pulls = (vx, -vx, vy, -vy), (ax - bx, -ax - bx, ay - by, -ay - by)
    least, leaves_by = math.inf, 0
    for k in range(4):
        leaves = _time_to(gaps[k] - nearer, rates[k], pulls[k]) if inside[k] else math.inf
        if leaves < least:
            least, leaves_by = leaves, k
    # If the motion has jerk, the time is a bound; a few repetitions reach the side.
    if bx + by > 0.0 and gaps[leaves_by] > 0.5 * nearer:
        leaves_by = st.NOWHERE
    cells.link[i, st.LEAVES_BY] = leaves_by
    return t + least


@kernel(inline=True)
def _time_to(gap: float, rate: float, pull: float) -> float:
    """Return the duration [s] until the ball reaches a side of the cell, or inf."""
    if rate >= 0.0 and pull >= 0.0:
        return math.inf
    if pull == 0.0:
        return max(gap, 0.0) / -rate
    crossing: float = first_crossing(gap, rate, pull)
    return crossing

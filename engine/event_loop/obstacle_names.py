"""The numbers by which events name the obstacles that balls hit."""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Laws


@kernel(inline=True)
def name_of_obstacle(balls: Balls, laws: Laws, i: int, k: int) -> int:
    """Return the number that events use for an obstacle that ball i hits."""
    if laws.obstacles[k].kind != st.SEGMENT:
        return _index(laws, k)
    return _name_of_segment(laws, k, balls.state[i].x, balls.state[i].y)


@kernel
def _name_of_segment(laws: Laws, k: int, x: float, y: float) -> int:
    """Return the number of a segment or, at its start, of the segment that ends there, if any.

    Their common corner is a point; rounding decides which of the two the ball hits.
    """
    x0, y0 = laws.obstacles[k].x, laws.obstacles[k].y
    dx, dy = laws.obstacles[k].nx - x0, laws.obstacles[k].ny - y0
    if (x - x0) * dx + (y - y0) * dy <= 0.0:
        for other in range(len(laws.obstacles)):
            row = laws.obstacles[other]
            if row.kind == st.SEGMENT and row.nx == x0 and row.ny == y0:
                return _index(laws, other)
    return _index(laws, k)


@kernel(inline=True)
def _index(laws: Laws, k: int) -> int:
    return int(laws.obstacles[k].index)

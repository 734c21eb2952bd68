"""The numbers by which events name the obstacles that balls hit."""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Laws


@kernel
def name_of_obstacle(balls: Balls, laws: Laws, i: int, k: int) -> int:
    """Return the number that events use for an obstacle that ball i hits.

    At the start of a segment, this is the number of the segment that ends there, if any. Their
    common corner is a point; rounding decides which of the two the ball hits.
    """
    row, ball = laws.obstacles[k], balls.state[i]
    if row.kind == st.SEGMENT:
        along = (ball.x - row.x) * (row.nx - row.x) + (ball.y - row.y) * (row.ny - row.y)
        for other in range(len(laws.obstacles) if along <= 0.0 else 0):
            one = laws.obstacles[other]
            if one.kind == st.SEGMENT and one.nx == row.x and one.ny == row.y:
                return int(one.index)
    return int(row.index)

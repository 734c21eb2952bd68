"""What stands still on the table: lines, segments and discs, each a row of `Laws.obstacles`.

Each is convex, so that a ball must cross the line through its nearest point, across the way there,
before it can touch: a bound of when it does is found as for two balls.
"""

from __future__ import annotations

import math

from engine.core.kernel import kernel
from engine.core.state import (
    LINE,
    O_INDEX,
    O_KIND,
    O_NX,
    O_NY,
    O_RADIUS,
    O_X,
    O_Y,
    SEGMENT,
    Balls,
    Laws,
)
from engine.core.tolerances import GAP_ROUNDING, TIME_ROUNDING
from engine.motion.crossings import first_crossing


@kernel
def facing(laws: Laws, k: int, x: float, y: float) -> tuple[float, float, float]:
    """Return obstacle k's unit normal towards a place, and how far from it that is [m]."""
    row = laws.obstacles[k]
    if row[O_KIND] == LINE:
        nx, ny = row[O_NX], row[O_NY]
        return nx, ny, nx * (x - row[O_X]) + ny * (y - row[O_Y])
    rx, ry = x - row[O_X], y - row[O_Y]
    if row[O_KIND] == SEGMENT:
        dx, dy = row[O_NX] - row[O_X], row[O_NY] - row[O_Y]
        part = (rx * dx + ry * dy) / (dx * dx + dy * dy)
        part = min(max(part, 0.0), 1.0)
        rx, ry = rx - part * dx, ry - part * dy
    size = math.sqrt(rx * rx + ry * ry)
    return rx / size, ry / size, size - row[O_RADIUS]


@kernel
def row_of(laws: Laws, index: int) -> int:
    """Return the row of the obstacle that events call `index`, or -1."""
    for k in range(len(laws.obstacles)):
        if laws.obstacles[k, O_INDEX] == index:
            return k
    return -1


@kernel(inline=True)
def time_to_obstacle(balls: Balls, i: int, laws: Laws, k: int) -> tuple[float, bool]:
    """Return in how long ball i may touch obstacle k [s], inf for never; and whether it will then.

    From its epoch, as it moves until its own next event. A line is touched then; anything else must
    be looked at again, until it touches but for rounding.
    """
    ball = balls.state[i]
    nx, ny, distance = facing(laws, k, ball.x, ball.y)
    gap = max(distance - ball.radius, 0.0)
    rate = nx * ball.vx + ny * ball.vy
    pull = nx * ball.ax + ny * ball.ay
    if rate >= 0.0 and pull >= 0.0:
        return math.inf, False
    # Without pull the root is that of a line: the same number, without a square root.
    s = gap / -rate if pull == 0.0 else first_crossing(gap, rate, pull)
    if laws.obstacles[k, O_KIND] == LINE:
        return s, True
    near = gap <= GAP_ROUNDING * ball.radius or not s > TIME_ROUNDING * ball.epoch
    return s, near and rate < 0.0

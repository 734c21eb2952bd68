"""What stands still on the table: lines, segments and discs, each a row of `Laws.obstacles`.

Each is convex, so that a ball must cross the line through its nearest point, across the way there,
before it can touch: a bound of when it does is found as for two balls.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    LINE,
    SEGMENT,
    Balls,
    Laws,
)
from ghostball.engine.core.tolerances import EPS, GAP_ROUNDING, GAP_ULPS, TIME_ROUNDING
from ghostball.engine.motion.crossings import first_crossing
from ghostball.engine.motion.pieces import bend


@kernel(inline=True)
def facing(laws: Laws, k: int, x: float, y: float) -> tuple[float, float, float]:
    """Return obstacle k's unit normal towards a place, and how far from it that is [m]."""
    if laws.obstacles[k].kind == LINE:
        nx, ny = laws.obstacles[k].nx, laws.obstacles[k].ny
        away = nx * (x - laws.obstacles[k].x) + ny * (y - laws.obstacles[k].y)
        return nx, ny, away
    return _facing_nearest(laws, k, x, y)


@kernel
def _facing_nearest(laws: Laws, k: int, x: float, y: float) -> tuple[float, float, float]:
    """`facing`, where the nearest point isn't everywhere in the same direction."""
    rx, ry = x - laws.obstacles[k].x, y - laws.obstacles[k].y
    if laws.obstacles[k].kind == SEGMENT:
        dx = laws.obstacles[k].nx - laws.obstacles[k].x
        dy = laws.obstacles[k].ny - laws.obstacles[k].y
        part = min(max((rx * dx + ry * dy) / (dx * dx + dy * dy), 0.0), 1.0)
        rx, ry = rx - part * dx, ry - part * dy
    size = math.sqrt(rx * rx + ry * ry)
    return rx / size, ry / size, size - laws.obstacles[k].radius


@kernel
def row_of(laws: Laws, index: int) -> int:
    """Return the row of the obstacle that events call `index`, or -1."""
    for k in range(len(laws.obstacles)):
        if laws.obstacles[k].index == index:
            return k
    return -1


@kernel(inline=True)
def time_to_obstacle(
    balls: Balls, i: int, laws: Laws, k: int, duration: float
) -> tuple[float, bool]:
    """Return in how long ball i may touch obstacle k [s], inf for never; and whether it will then.

    From its epoch, as it moves for a duration [s]. A line is touched then, by a ball whose motion
    is a quadratic; anything else must be looked at again, until it touches but for rounding.
    """
    ball = balls.state[i]
    bent = bend(balls, i, duration, 1.0, 1.0) > 0.0
    if laws.obstacles[k].kind == LINE and not bent:
        nx, ny = laws.obstacles[k].nx, laws.obstacles[k].ny
        rate, pull = nx * ball.vx + ny * ball.vy, nx * ball.ax + ny * ball.ay
        if rate >= 0.0 and pull >= 0.0:
            return math.inf, False
        _, _, away = facing(laws, k, ball.x, ball.y)
        gap = max(away - ball.radius, 0.0)
        # Without pull the root is that of a line: the same number, without a square root.
        return gap / -rate if pull == 0.0 else first_crossing(gap, rate, pull), True
    return _time_to_look(balls, i, laws, k, duration)


@kernel
def _time_to_look(balls: Balls, i: int, laws: Laws, k: int, duration: float) -> tuple[float, bool]:
    """`time_to_obstacle`, where it is a bound but for a ball that touches."""
    ball = balls.state[i]
    nx, ny, away = facing(laws, k, ball.x, ball.y)
    gap = max(away - ball.radius, 0.0)
    rate = nx * ball.vx + ny * ball.vy
    pull = nx * ball.ax + ny * ball.ay - bend(balls, i, duration, nx, ny)
    if rate >= 0.0 and pull >= 0.0:
        return math.inf, False
    s = first_crossing(gap, rate, pull)
    # Nearer than its coordinates can tell, it would be looked at for ever.
    rounding = GAP_ROUNDING * ball.radius + GAP_ULPS * EPS * (abs(ball.x) + abs(ball.y))
    near = gap <= rounding or not s > TIME_ROUNDING * ball.epoch
    return s, near and rate < 0.0

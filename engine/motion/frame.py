"""Find the obstacle that a ball reaches on a table with pockets, from its path to the frame.

The frame is the rectangle of the noses. The straight pieces of cushions lie along its sides; jaws,
facings and holes lie behind them. While a ball is inside the frame, it touches nothing; if it
leaves the frame at a straight piece, it hits that piece. All obstacles, about three dozen, are
checked only near a mouth. The result is bit-identical to checking all obstacles.
"""

from __future__ import annotations

import math
from typing import Final

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Laws
from ghostball.engine.core.tolerances import AT_THE_FRAME
from ghostball.engine.motion.crossings import first_crossing
from ghostball.engine.motion.obstacles import nose_reach
from ghostball.engine.motion.position import jerk

ALL: Final = -1
"""All obstacles must be checked."""

NONE: Final = -2
"""No obstacle is reached."""


@kernel
def cushion_ahead(balls: Balls, i: int, laws: Laws, duration: float) -> int:
    """Return the row of the cushion that ball i hits within a duration [s], or `ALL` or `NONE`.

    Contract: no allocation. Without jerk, the time compared here has the same bits as that computed
    for the cushion itself.
    """
    ball = balls.state[i]
    if jerk(balls, i) != 0.0:
        return ALL
    x, y, radius = ball.x, ball.y, nose_reach(balls, i, laws, laws.outer)
    low_x, high_x = x - radius, laws.frame_x - x - radius
    low_y, high_y = y - radius, laws.frame_y - y - radius
    edge = AT_THE_FRAME * radius
    left = _time_out(low_x, ball.vx, ball.ax, edge)
    right = _time_out(high_x, -ball.vx, -ball.ax, edge)
    bottom = _time_out(low_y, ball.vy, ball.ay, edge)
    top = _time_out(high_y, -ball.vy, -ball.ay, edge)
    first = min(left, right, bottom, top)
    if first > (1.0 + AT_THE_FRAME) * duration:
        return NONE
    soon = (1.0 + AT_THE_FRAME) * first
    sides = int(left <= soon) + int(right <= soon) + int(bottom <= soon) + int(top <= soon)
    if not first > 0.0 or sides != 1:
        return ALL
    if first in (left, right):
        along = y + (ball.vy + 0.5 * ball.ay * first) * first
        return _cushion_at(laws, True, 0.0 if left == first else laws.frame_x, along, edge)
    along = x + (ball.vx + 0.5 * ball.ax * first) * first
    return _cushion_at(laws, False, 0.0 if bottom == first else laws.frame_y, along, edge)


@kernel
def flies_inside(balls: Balls, i: int, laws: Laws, duration: float) -> bool:
    """Return whether ball i, in flight, touches no side of the frame within a duration [s].

    In plan its path is straight, and its speed doesn't increase.
    """
    ball = balls.state[i]
    x, y, radius = ball.x + duration * ball.vx, ball.y + duration * ball.vy, ball.radius
    inside = min(x, ball.x) > radius and max(x, ball.x) < laws.frame_x - radius
    return bool(inside and min(y, ball.y) > radius and max(y, ball.y) < laws.frame_y - radius)


@kernel(inline=True)
def _time_out(away: float, rate: float, pull: float, edge: float) -> float:
    """Return the time until a ball reaches a side of the frame [s]; 0 if it isn't inside the frame.

    `away` [m]: gap to the side. A ball that touches the side to within `edge` [m] counts as inside
    if it moves away from it.
    """
    if away < edge and not (rate > 0.0 and away > -edge):
        return 0.0
    if rate >= 0.0 and pull >= 0.0:
        return math.inf
    return first_crossing(away, rate, pull)


@kernel(inline=True)
def _cushion_at(laws: Laws, upright: bool, side: float, along: float, edge: float) -> int:
    """Return the row of the cushion that contains a place on a side in its middle part, or `ALL`.

    `along` [m]: coordinate of the place along the side. Places within `edge` [m] of a cushion's end
    don't count.
    """
    for k in range(laws.outer, len(laws.obstacles)):
        row = laws.obstacles[k]
        if row.kind != st.SEGMENT:
            return ALL  # straight noses come first in the list
        across, other = (row.x, row.nx) if upright else (row.y, row.ny)
        start, end = (row.y, row.ny) if upright else (row.x, row.nx)
        inside = along > min(start, end) + edge and along < max(start, end) - edge
        if across == side and other == side and inside:
            return k
    return ALL


@kernel
def only_cushion(laws: Laws, k: int, x: float, y: float, reach: float) -> bool:
    """Return whether obstacle k is a straight nose and the only obstacle within a reach [m].

    The reach is measured from a place at the nose. The opposite cushion must be farther, too.
    """
    row = laws.obstacles[k]
    if k < laws.outer or row.kind != st.SEGMENT:
        return False
    upright, level = row.x == row.nx, row.y == row.ny
    if not (upright or level):
        return False
    along = y if upright else x
    start, end = (row.y, row.ny) if upright else (row.x, row.nx)
    room = laws.frame_x if upright else laws.frame_y
    inside = along > min(start, end) + reach and along < max(start, end) - reach
    return bool(inside and room > 2.0 * reach)

"""Tests whether balls are near each other, at rest, or in contact; the tolerances of gaps.

Nothing is moved here. The module also computes lengths and reduced masses without over- or
underflow.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Cells, Laws, World
from ghostball.engine.core.tolerances import (
    APPROACH_ROUNDING,
    CAPTURE_HEIGHT,
    CONTACT_REACH,
    EPS,
    GAP_ULPS,
    LEAST_SPEED,
    STOP_DISTANCE,
)
from ghostball.engine.motion.obstacles import facing, nose_reach
from ghostball.engine.motion.position import (
    flies,
    one_flies,
    pair_reach,
    relative_motion,
    velocity,
)
from ghostball.model.rounding import CONTACT_TOLERANCE


@kernel
def reduced_mass(a: float, b: float) -> float:
    """Return a b / (a + b) [kg], with the same bits for (b, a), without over- or underflow."""
    return min(a, b) * (max(a, b) / (a + b))


@kernel
def speed_of(vx: float, vy: float) -> float:
    """Return the length of a velocity [m/s], scaled so that no square under- or overflows."""
    largest = max(abs(vx), abs(vy))
    if largest == 0.0:
        return 0.0
    ux, uy = vx / largest, vy / largest
    return largest * math.sqrt(ux * ux + uy * uy)


@kernel
def at_rest(balls: Balls, i: int) -> bool:
    """Return whether the centre of ball i rests, and stays at rest if nothing hits it."""
    slides = balls.state[i].phase == st.SLIDING and balls.state[i].slide_slowing > 0.0
    if balls.height is not None and flies(balls, i) and balls.height[i, st.HELD] == 0.0:
        return False
    return bool(balls.state[i].vx == 0.0 and balls.state[i].vy == 0.0 and not slides)


@kernel
def friction_limit(balls: Balls, i: int) -> float:
    """Return the largest deceleration [m/s^2] that the cloth can give ball i."""
    deceleration: float = max(balls.state[i].roll_slowing, balls.state[i].slide_slowing)
    return deceleration


@kernel(inline=True)
def rolls_on(balls: Balls, i: int) -> bool:
    """Return whether ball i, on the cloth, keeps rolling when a small impulse changes its velocity.

    The cloth then turns the ball. A cloth without friction doesn't, and the ball slips.
    """
    return bool(
        balls.state[i].phase not in (st.SLIDING, st.FLYING) and friction_limit(balls, i) > 0.0
    )


@kernel
def gap_rounding(balls: Balls, i: int, j: int) -> float:
    """Return the rounding [m] of a gap computed from the coordinates of balls i and j."""
    at_i: float = abs(balls.state[i].x) + abs(balls.state[i].y)
    at_j: float = abs(balls.state[j].x) + abs(balls.state[j].y)
    return GAP_ULPS * EPS * max(at_i, at_j)


@kernel
def tie_rounding(balls: Balls, i: int, j: int, t: float) -> float:
    """Return the rounding [m] of a gap between balls i and j at the time t [s] of an event.

    This is the rounding of the coordinates, plus the distance that the balls move within the
    rounding of the clock. For a ball and a cushion, j is i.
    """
    speed = abs(balls.state[i].vx) + abs(balls.state[i].vy)
    speed += abs(balls.state[j].vx) + abs(balls.state[j].vy)
    rounding: float = gap_rounding(balls, i, j) + GAP_ULPS * EPS * t * speed
    return rounding


@kernel
def contact_tolerance(balls: Balls, i: int, j: int) -> float:
    """Return the gap or overlap [m] that a contact step may leave between balls i and j.

    For a ball and a cushion, j is i.
    """
    reach: float = balls.state[i].radius + balls.state[j].radius
    return CONTACT_TOLERANCE * reach + 8.0 * gap_rounding(balls, i, j)


@kernel
def capture_height(balls: Balls, i: int, j: int) -> float:
    """Return the height [m] of a bounce of balls i and j that isn't followed; `CAPTURE_HEIGHT`.

    For a ball and a cushion, j is i.
    """
    reach: float = balls.state[i].radius + balls.state[j].radius
    return CAPTURE_HEIGHT * reach + 8.0 * gap_rounding(balls, i, j)


@kernel
def stop_distance(balls: Balls, i: int) -> float:
    """Return the distance [m] in which the cloth ends a negligible slip; see `STOP_DISTANCE`."""
    distance: float = STOP_DISTANCE * 2.0 * balls.state[i].radius
    return distance


@kernel
def negligible_bounce(rate: float, acceleration: float, height: float) -> bool:
    """Return whether a gap that opens at `rate` and is pulled back opens by at most `height` [m].

    A bounce at speed v with acceleration a rises to v^2 / 2a.
    """
    return rate * rate <= 2.0 * acceleration * height


@kernel(inline=True)
def rounding_of(size: float) -> float:
    """Return the approach speed [m/s] that counts as 0 for balls with a speed of `size` [m/s].

    See `APPROACH_ROUNDING` and `LEAST_SPEED`.
    """
    return max(APPROACH_ROUNDING * size, LEAST_SPEED)


@kernel
def approach_rounding(balls: Balls, i: int, j: int, t: float) -> float:
    """Return the speed [m/s] up to which balls i and j don't approach at the time t [s]."""
    size: float = _size(balls, i, t) + _size(balls, j, t)
    return rounding_of(size)


@kernel
def _size(balls: Balls, i: int, t: float) -> float:
    """Return the largest 1-norm that ball i's velocity has had at the time t so far [m/s]."""
    vx, vy = velocity(balls, i, t)
    size: float = abs(vx) + abs(vy)
    return size if t > balls.state[i].epoch else max(size, balls.state[i].fastest)


@kernel
def in_contact(gap: float, rate: float, tolerance: float, pull: float, noise: float) -> bool:
    """Return whether a gap [m] that changes at `rate` [m/s] is closed when a contact step starts.

    `pull` [m/s^2] is the most that friction can change the rate. A rate of up to `noise` counts as
    0, which matters if there is no friction.
    """
    touching = gap <= CONTACT_REACH * tolerance
    return touching and (abs(rate) <= noise or negligible_bounce(rate, pull, tolerance))


@kernel
def obstacle_in_contact(balls: Balls, i: int, laws: Laws, k: int) -> bool:
    """Return whether ball i counts as in contact with an obstacle, at its epoch."""
    ball = balls.state[i]
    if ball.phase == st.GONE or flies(balls, i) or laws.obstacles[k].law == st.TAKES_OUT:
        return False
    nx, ny, distance = facing(laws, k, ball.x, ball.y)
    gap = distance - nose_reach(balls, i, laws, k)
    rate = nx * ball.vx + ny * ball.vy
    noise = rounding_of(abs(ball.vx) + abs(ball.vy))
    pull = 3.0 * friction_limit(balls, i)
    return in_contact(gap, rate, contact_tolerance(balls, i, i), pull, noise)


@kernel
def pair_in_contact(balls: Balls, i: int, j: int, t: float) -> bool:
    """Return whether balls i and j count as in contact at the time t [s].

    The cloth's friction on both balls may pull them together; the factor 3/2 also allows for the
    friction that stops a ball that was hit while at rest.
    """
    if balls.state[i].phase == st.GONE or balls.state[j].phase == st.GONE:
        return False
    if one_flies(balls, i, j):
        return False
    rx, ry, vx, vy, _, _ = relative_motion(balls, i, j, t)
    distance = math.sqrt(rx * rx + ry * ry)
    gap = distance - pair_reach(balls, i, j)
    rate = (rx * vx + ry * vy) / distance
    pull = 1.5 * (friction_limit(balls, i) + friction_limit(balls, j))
    noise = approach_rounding(balls, i, j, t)
    return in_contact(gap, rate, contact_tolerance(balls, i, j), pull, noise)


@kernel
def stands_before(balls: Balls, i: int, j: int) -> bool:
    """Return whether ball i comes before ball j in the order of x, then y, at their epoch."""
    same = balls.state[i].x == balls.state[j].x
    below = same and balls.state[i].y < balls.state[j].y
    return bool(balls.state[i].x < balls.state[j].x or below)


@kernel(inline=True)
def has_cells(cells: Cells) -> bool:
    """Return whether the scheduler uses `Cells` rather than `Pairs`."""
    return len(cells.slot) > 0


@kernel
def list_near(balls: Balls, cells: Cells, i: int) -> int:
    """Put all balls that may touch ball i now into `balls.near`; return their number."""
    count = 0
    if not has_cells(cells):
        for j in range(len(balls.own_kind)):
            if j != i:
                balls.near[count] = j
                count += 1
        return count
    stride = cells.size[0] + 2
    middle = cells.link[i, st.CELL_ROW] * stride + cells.link[i, st.CELL_COLUMN]
    for y in range(-1, 2):
        for x in range(-1, 2):
            k = cells.first[middle + y * stride + x]
            while k != st.NOWHERE:
                if k != i:
                    # In the order of their indices, as without cells.
                    index = count
                    while index > 0 and balls.near[index - 1] > k:
                        balls.near[index] = balls.near[index - 1]
                        index -= 1
                    balls.near[index] = k
                    count += 1
                k = cells.link[k, st.AFTER]
    return count


@kernel
def blocking_ball(world: World, i: int, nx: float, ny: float, t: float) -> int:
    """Return a ball in contact with ball i on the side of the direction (nx, ny), or -1."""
    balls = world.balls
    for c in range(list_near(balls, world.cells, i)):
        j = int(balls.near[c])
        if pair_in_contact(balls, i, j, t):
            rx, ry, _, _, _, _ = relative_motion(balls, i, j, t)
            if rx * nx + ry * ny > 0.0:
                return j
    return -1

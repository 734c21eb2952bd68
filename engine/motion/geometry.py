"""Which balls are near each other, at rest, or in contact at an instant; which gaps are closed.

Nothing is moved. What a gap may be off by, in tolerances and rounding, is here, too, and so are a
length and a reduced mass that are right for numbers of any size.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Cells, FloatArray, Laws, World
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
from ghostball.engine.motion.position import pair_reach, relative_motion, velocity
from ghostball.model.rounding import CONTACT_TOLERANCE


@kernel
def reduced_mass(a: float, b: float) -> float:
    """Return a b / (a + b) [kg]: the same bits for (b, a), and neither over- nor underflow."""
    return min(a, b) * (max(a, b) / (a + b))


@kernel
def speed_of(vx: float, vy: float) -> float:
    """Length of a velocity [m/s], scaled so that no square under- or overflows."""
    largest = max(abs(vx), abs(vy))
    if largest == 0.0:
        return 0.0
    ux, uy = vx / largest, vy / largest
    return largest * math.sqrt(ux * ux + uy * uy)


@kernel
def at_rest(balls: Balls, i: int) -> bool:
    """Whether the centre of ball i rests, and stays so if nothing hits it."""
    slides = balls.state[i].phase == st.SLIDING and balls.state[i].slide_slowing > 0.0
    if _falls(balls.height, balls, i):
        return False
    return bool(balls.state[i].vx == 0.0 and balls.state[i].vy == 0.0 and not slides)


@kernel(inline=True)
def _falls(height: FloatArray | None, balls: Balls, i: int) -> bool:
    """Whether ball i is in the air, and nothing holds it there."""
    if height is None:
        return False
    return bool(balls.state[i].phase == st.FLYING and height[i, st.HELD] == 0.0)


@kernel(inline=True)
def _in_air(height: FloatArray | None, balls: Balls, i: int, j: int) -> bool:
    """Whether one of two balls is in the air."""
    if height is None:
        return False
    return bool(balls.state[i].phase == st.FLYING or balls.state[j].phase == st.FLYING)


@kernel
def friction_limit(balls: Balls, i: int) -> float:
    """Largest deceleration [m/s^2] that the cloth can give ball i."""
    deceleration: float = max(balls.state[i].roll_slowing, balls.state[i].slide_slowing)
    return deceleration


@kernel(inline=True)
def rolls_on(balls: Balls, i: int) -> bool:
    """Whether ball i, on the cloth, rolls on when a small impulse changes its velocity.

    The cloth turns it then; a cloth without friction turns nothing, and the ball slips.
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
    """Return the rounding [m] of a gap between balls i and j at an event's instant t [s].

    That of the coordinates, and how far the balls go in the rounding of the clock. For a ball and a
    cushion, j is i.
    """
    speed = abs(balls.state[i].vx) + abs(balls.state[i].vy)
    speed += abs(balls.state[j].vx) + abs(balls.state[j].vy)
    rounding: float = gap_rounding(balls, i, j) + GAP_ULPS * EPS * t * speed
    return rounding


@kernel
def contact_tolerance(balls: Balls, i: int, j: int) -> float:
    """Gap or overlap [m] that a contact step may leave between balls i and j.

    For a ball and a cushion, j is i.
    """
    reach: float = balls.state[i].radius + balls.state[j].radius
    return CONTACT_TOLERANCE * reach + 8.0 * gap_rounding(balls, i, j)


@kernel
def capture_height(balls: Balls, i: int, j: int) -> float:
    """Height [m] of a bounce between balls i and j that is not followed; see `CAPTURE_HEIGHT`.

    For a ball and a cushion, j is i.
    """
    reach: float = balls.state[i].radius + balls.state[j].radius
    return CAPTURE_HEIGHT * reach + 8.0 * gap_rounding(balls, i, j)


@kernel
def stop_distance(balls: Balls, i: int) -> float:
    """Distance [m] in which the cloth can end a slip that counts as ended; see `STOP_DISTANCE`."""
    distance: float = STOP_DISTANCE * 2.0 * balls.state[i].radius
    return distance


@kernel
def negligible_bounce(rate: float, acceleration: float, height: float) -> bool:
    """Whether a gap that opens at `rate`, and is pulled back, opens by no more than `height` [m].

    A bounce at speed v under a rises v^2 / 2a.
    """
    return rate * rate <= 2.0 * acceleration * height


@kernel(inline=True)
def rounding_of(size: float) -> float:
    """Return up to which speed [m/s] an approach is none, of balls of this speed [m/s].

    See `APPROACH_ROUNDING` and `LEAST_SPEED`.
    """
    return max(APPROACH_ROUNDING * size, LEAST_SPEED)


@kernel
def approach_rounding(balls: Balls, i: int, j: int, t: float) -> float:
    """Return up to which speed [m/s] balls i and j don't approach at the instant t [s]."""
    size: float = _size(balls, i, t) + _size(balls, j, t)
    return rounding_of(size)


@kernel
def _size(balls: Balls, i: int, t: float) -> float:
    """Largest size of the velocity of ball i at the instant t so far [m/s], in the 1-norm."""
    vx, vy = velocity(balls, i, t)
    size: float = abs(vx) + abs(vy)
    return size if t > balls.state[i].epoch else max(size, balls.state[i].fastest)


@kernel
def in_contact(gap: float, rate: float, tolerance: float, pull: float, noise: float) -> bool:
    """Whether a gap [m], changing at `rate` [m/s], counts as closed when a contact step starts.

    `pull` is the most that friction can take from the rate [m/s^2]; one of up to `noise` is none,
    which counts where no cloth rubs.
    """
    touching = gap <= CONTACT_REACH * tolerance
    return touching and (abs(rate) <= noise or negligible_bounce(rate, pull, tolerance))


@kernel
def obstacle_in_contact(balls: Balls, i: int, laws: Laws, k: int) -> bool:
    """Whether ball i counts as in contact with an obstacle, at its epoch."""
    ball = balls.state[i]
    if (
        ball.phase == st.GONE
        or _in_air(balls.height, balls, i, i)
        or laws.obstacles[k].law == st.TAKES_OUT
    ):
        return False
    nx, ny, distance = facing(laws, k, ball.x, ball.y)
    gap = distance - nose_reach(balls, i, laws, k)
    rate = nx * ball.vx + ny * ball.vy
    noise = rounding_of(abs(ball.vx) + abs(ball.vy))
    pull = 3.0 * friction_limit(balls, i)
    return in_contact(gap, rate, contact_tolerance(balls, i, i), pull, noise)


@kernel
def pair_in_contact(balls: Balls, i: int, j: int, t: float) -> bool:
    """Whether balls i and j count as in contact at the instant t [s].

    Friction pulls two balls together with what the cloth can give both, and stops one that was
    struck at rest with as much again.
    """
    if balls.state[i].phase == st.GONE or balls.state[j].phase == st.GONE:
        return False
    if _in_air(balls.height, balls, i, j):
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
    """Whether ball i is before ball j in the order of places; both at one instant."""
    same = balls.state[i].x == balls.state[j].x
    below = same and balls.state[i].y < balls.state[j].y
    return bool(balls.state[i].x < balls.state[j].x or below)


@kernel(inline=True)
def has_cells(cells: Cells) -> bool:
    """Whether the balls of a scene are scheduled by `Cells`, and not by `Pairs`."""
    return len(cells.slot) > 0


@kernel
def list_near(balls: Balls, cells: Cells, i: int) -> int:
    """Put in `balls.near` all balls that may touch ball i now; return how many."""
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
                    # In the order of their numbers, as without cells.
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
    """Return a ball in contact with ball i on the side that (nx, ny) points to, or -1."""
    balls = world.balls
    for c in range(list_near(balls, world.cells, i)):
        j = int(balls.near[c])
        if pair_in_contact(balls, i, j, t):
            rx, ry, _, _, _, _ = relative_motion(balls, i, j, t)
            if rx * nx + ry * ny > 0.0:
                return j
    return -1

"""The time of impact of two balls: judged at an instant, from where and how fast they are then."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    NEXT,
    NOWHERE,
    PARTNER,
    Balls,
    Contacts,
    Laws,
)
from ghostball.engine.core.tolerances import APPROACH_ROUNDING, GAP_ROUNDING, TIME_ROUNDING
from ghostball.engine.motion.crossings import first_crossing, first_meeting
from ghostball.engine.motion.geometry import at_rest, capture_height, negligible_hop
from ghostball.engine.motion.pieces import acceleration, relative_bend, relative_motion, velocity

NOT_YET = 0
"""The bound moved on; the pair doesn't touch at this instant."""
IMPACT = 1
"""The pair touches and approaches: collide it now."""
PRESSED = 2
"""The pair touches, and is pulled together so that it would not part by what is resolved."""


@kernel(inline=True)
def first_bound(balls: Balls, laws: Laws, i: int, j: int, start: float) -> float:
    """Return the first bound of when the pair touches [s], from the instant `start` on; or inf.

    Where that is when the later of the two changed its motion, it is to the bit what
    `scheduling.all_pairs` has in its rows, which are this without branches.
    """
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, start)
    reach = balls.state[i].radius + balls.state[j].radius
    rate = rx * vx + ry * vy
    pull = rx * ax + ry * ay - relative_bend(balls, i, j, start, rx, ry)
    bound: float = start + time_to_bound(laws, rx, ry, vx, vy, rate, pull, reach)
    return bound


@kernel(inline=True)
def time_to_bound(
    laws: Laws,
    rx: float,
    ry: float,
    vx: float,
    vy: float,
    rate: float,
    pull: float,
    reach: float,
) -> float:
    """Return in how long a pair may touch at the soonest [s], from its relative motion; or inf.

    `rate` is r . v, `pull` is r . a less what the bends may take from it: over the distance, how
    the projected gap changes.
    """
    if laws.uniform:
        met: float = first_meeting(rx, ry, vx, vy, reach)
        return met
    distance = math.sqrt(rx * rx + ry * ry)
    closed: float = first_crossing(distance * (distance - reach), rate, pull)
    return closed


@kernel
def holds(contacts: Contacts, i: int, j: int) -> bool:
    """Whether a contact step holds ball i to ball j, so that they can't meet."""
    row = contacts.first_held[i]
    while row != NOWHERE:
        if contacts.held[row, PARTNER] == j:
            return True
        row = contacts.held[row, NEXT]
    return False


@kernel(inline=True)
def touch(balls: Balls, i: int, j: int, t: float, slack: float) -> tuple[int, float, float]:
    """Judge the pair at the instant t: a verdict, the next bound, the speed of approach.

    A gap of up to `slack` [m] counts as closed.
    """
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, t)
    reach = balls.state[i].radius + balls.state[j].radius
    distance = math.sqrt(rx * rx + ry * ry)
    gap = distance - reach
    rate = (rx * vx + ry * vy) / distance
    pull = (rx * ax + ry * ay) / distance
    bent = relative_bend(balls, i, j, t, rx / distance, ry / distance)
    s = first_crossing(gap, rate, pull - bent)
    progress = s > TIME_ROUNDING * t
    if gap > max(GAP_ROUNDING * reach, slack) and progress:
        return NOT_YET, t + s, 0.0
    # They touch, as far as doubles can tell. While r . v = 0, the gap opens at first as
    # `opening` s^2 / 2: the lines of centres turn away, or friction pulls together.
    noise = APPROACH_ROUNDING * (_speed(balls, i, t) + _speed(balls, j, t))
    across = max(vx * vx + vy * vy - rate * rate, 0.0)
    opening = across / distance + pull
    pulled = opening < -APPROACH_ROUNDING * (_pull(balls, i, t) + _pull(balls, j, t))
    if rate < -noise:
        # A rebound that slow ends within `CAPTURE_HEIGHT`, where friction pulls the balls together
        # again; the cloth also stops one that was struck at rest.
        struck = at_rest(balls, i) or at_rest(balls, j)
        closing = _stopping(balls, i) + _stopping(balls, j) - opening
        height = capture_height(balls, i, j)
        hop = (pulled or struck) and negligible_hop(rate, closing, height)
        return (PRESSED if hop else IMPACT), t, -rate
    if rate > noise and progress:
        return NOT_YET, t + s, 0.0
    if pulled:
        return PRESSED, t, 0.0
    bent = relative_bend(balls, i, j, t, 1.0, 1.0)
    s = _next_approach(distance * max(opening, 0.0), vx, vy, ax, ay, distance, bent)
    return (NOT_YET, t + s, 0.0) if s > TIME_ROUNDING * t else (PRESSED, t, 0.0)


@kernel
def _next_approach(
    opening: float, vx: float, vy: float, ax: float, ay: float, distance: float, bend: float
) -> float:
    """Return when a touching pair that neither approaches nor recedes can approach next [s].

    With r . v = 0, half the rate of |r|^2 is s (A + B s + C s^2), A = v^2 + r . a = `opening`,
    B = 3/2 v . a, C = a^2 / 2: the pair opens while that is positive. An acceleration that is off
    by up to b = `bend` takes no more than |r| b from A, 3/2 |v| b from B, (|a| + b / 2) b from C.
    """
    linear = 1.5 * (vx * ax + vy * ay) - 1.5 * (abs(vx) + abs(vy)) * bend
    quadratic = 0.5 * (ax * ax + ay * ay) - (abs(ax) + abs(ay) + 0.5 * bend) * bend
    opening = max(opening - distance * bend, 0.0)
    discriminant = linear * linear - 4.0 * quadratic * opening
    if (linear >= 0.0 and quadratic >= 0.0) or discriminant < 0.0:
        return math.inf
    return 2.0 * opening / (math.sqrt(discriminant) - linear)


@kernel
def _stopping(balls: Balls, i: int) -> float:
    """Deceleration [m/s^2] that will stop ball i where an impact makes it leave its rest."""
    deceleration: float = balls.state[i].roll_slowing if at_rest(balls, i) else 0.0
    return deceleration


@kernel
def _pull(balls: Balls, i: int, t: float) -> float:
    """Size of the acceleration of ball i at the instant t [m/s^2], in the 1-norm."""
    ax, ay = acceleration(balls, i, t)
    size: float = abs(ax) + abs(ay)
    return size


@kernel
def _speed(balls: Balls, i: int, t: float) -> float:
    """Size of the velocity of ball i at the instant t [m/s], in the 1-norm."""
    vx, vy = velocity(balls, i, t)
    size: float = abs(vx) + abs(vy)
    return size

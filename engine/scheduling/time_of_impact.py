"""When two balls touch: bounds of it from below, and whether they do at an instant.

On the cloth and in space. Those that touch collide, or their contact lasts, and a contact step
holds them.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Contacts, FloatArray, Laws
from ghostball.engine.core.tolerances import APPROACH_ROUNDING, GAP_ROUNDING, TIME_ROUNDING
from ghostball.engine.motion.air import in_air
from ghostball.engine.motion.crossings import first_bent_crossing, first_crossing, first_meeting
from ghostball.engine.motion.flight import (
    jerk_up,
    motion_in_space,
    one_flies,
    one_is_loaded,
    soonest_crossing,
    time_to_impact,
)
from ghostball.engine.motion.geometry import (
    approach_rounding,
    at_rest,
    capture_height,
    negligible_bounce,
)
from ghostball.engine.motion.position import (
    acceleration,
    both_last,
    displacement,
    jerk,
    jerk_along,
    neither_bends,
    pair_reach,
    relative_jerk,
    relative_motion,
    speed,
)

NOT_YET = 0
"""The bound moved on; the pair doesn't touch at this instant."""
IMPACT = 1
"""The pair touches and approaches: collide it now."""
LASTING = 2
"""The pair touches, and is pulled together so that it would not part by what is resolved."""


@kernel(inline=True)
def first_bound(balls: Balls, laws: Laws, i: int, j: int, start: float) -> float:
    """Return the first bound of when the pair touches [s], from the instant `start` on; or inf.

    Where that is when the later of the two changed its motion, it is to the bit what
    `scheduling.all_pairs` has in its rows, which are this without branches.
    """
    if one_flies(balls.height, balls, i, j):
        return start + time_to_bound_in_space(balls, i, j, start)
    return start + _time_to_first_bound(balls.powers, balls, laws, i, j, start)


@kernel(inline=True)
def _time_to_first_bound(
    powers: FloatArray | None, balls: Balls, laws: Laws, i: int, j: int, start: float
) -> float:
    if powers is not None and in_air(balls.powers, laws):
        return _bent_bound(balls, i, j, start)
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, start)
    rate, pull = rx * vx + ry * vy, rx * ax + ry * ay
    closed: float = time_to_bound(laws, rx, ry, vx, vy, rate, pull, pair_reach(balls, i, j))
    return closed


@kernel
def _bent_bound(balls: Balls, i: int, j: int, start: float) -> float:
    """Return in how long a pair may touch at the soonest, of which one is on no parabola, or inf.

    Each ball is on its parabola but for jerk s^3 / 6, s from its epoch on: looking up where it is
    would cost more than a bound that comes later saves.
    """
    a, b = balls.state[i], balls.state[j]
    s_a, s_b = start - a.epoch, start - b.epoch
    rx = (b.x + displacement(b.vx, b.ax, s_b)) - (a.x + displacement(a.vx, a.ax, s_a))
    ry = (b.y + displacement(b.vy, b.ay, s_b)) - (a.y + displacement(a.vy, a.ay, s_a))
    vx = speed(b.vx, b.ax, s_b) - speed(a.vx, a.ax, s_a)
    vy = speed(b.vy, b.ay, s_b) - speed(a.vy, a.ay, s_a)
    bent_a, bent_b = jerk(balls, i), jerk(balls, j)
    return time_to_bent_bound(
        rx,
        ry,
        vx,
        vy,
        b.ax - a.ax,
        b.ay - a.ay,
        pair_reach(balls, i, j),
        bent_a * s_a + bent_b * s_b,
        bent_a * s_a * s_a + bent_b * s_b * s_b,
        bent_a * s_a * s_a * s_a + bent_b * s_b * s_b * s_b,
        bent_a + bent_b,
        both_last(balls, i, j, start),
    )


@kernel(inline=True)
def time_to_bent_bound(
    rx: float,
    ry: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    reach: float,
    bent: float,
    drifted: float,
    moved: float,
    jerk: float,
    left: float,
) -> float:
    """Return in how long a pair may touch at the soonest [s]; or inf, or later than `left` [s].

    From the parabolas that they are on but for their jerks j, in sum `jerk`, which have changed the
    relative acceleration by up to `bent` (j s), the velocity by half of `drifted` (j s^2), the
    place by a sixth of `moved` (j s^3) since the parabolas began. Without branches, so that the
    compiler makes vector instructions of a row of pairs.
    """
    # All scaled by the distance, which saves dividing by it.
    distance = math.sqrt(rx * rx + ry * ry)
    gap = distance * (distance - reach - moved / 6.0)
    rate = rx * vx + ry * vy - distance * (0.5 * drifted)
    pull = rx * ax + ry * ay - distance * (bent + jerk * left / 3.0)
    soonest: float = first_crossing(gap, rate, pull)
    return soonest


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

    `rate` is r . v, `pull` is r . a: over the distance, how the projected gap changes.
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
    while row != st.NOWHERE:
        if contacts.held[row, st.PARTNER] == j:
            return True
        row = contacts.held[row, st.NEXT]
    return False


@kernel(inline=True)
def touch(
    balls: Balls, laws: Laws, i: int, j: int, t: float, tolerance: float
) -> tuple[int, float, float]:
    """Judge the pair at the instant t: a verdict, the next bound, the speed of approach.

    A gap of up to `tolerance` [m] counts as closed.
    """
    if one_flies(balls.height, balls, i, j):
        return touch_in_space(balls, i, j, t)
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, t)
    reach = pair_reach(balls, i, j)
    distance = math.sqrt(rx * rx + ry * ry)
    gap = distance - reach
    rate = (rx * vx + ry * vy) / distance
    pull = (rx * ax + ry * ay) / distance
    s = _time_to_gap(balls.powers, balls, i, j, t, gap, rate, pull)
    progress = s > TIME_ROUNDING * t
    if gap > max(GAP_ROUNDING * reach, tolerance) and progress:
        return NOT_YET, t + s, 0.0
    # They touch, as far as doubles can tell. While r . v = 0, the gap opens at first as
    # `opening` s^2 / 2: the lines of centres turn away, or friction pulls together.
    noise = approach_rounding(balls, i, j, t)
    across = max(vx * vx + vy * vy - rate * rate, 0.0)
    opening = across / distance + pull
    pulled = opening < -APPROACH_ROUNDING * (_pull(balls, i, t) + _pull(balls, j, t))
    if rate < -noise:
        # A rebound that slow ends within `CAPTURE_HEIGHT`, where friction pulls the balls together
        # again; the cloth also stops one that was struck at rest.
        struck = at_rest(balls, i) or at_rest(balls, j)
        closing = _stopping(balls, i) + _stopping(balls, j) - opening
        height = capture_height(balls, i, j)
        bounce = (pulled or struck) and negligible_bounce(rate, closing, height)
        if one_is_loaded(balls.height, i, j, t):
            bounce = bounce or negligible_bounce(rate, laws.gravity, height)
        return (LASTING if bounce else IMPACT), t, -rate
    if rate > noise and progress:
        return NOT_YET, t + s, 0.0
    if pulled:
        return LASTING, t, 0.0
    bend = _bend_meanwhile(balls.powers, balls, i, j, t)
    s = _next_approach(distance * max(opening, 0.0), vx, vy, ax, ay, distance, bend)
    return (NOT_YET, t + s, 0.0) if s > TIME_ROUNDING * t else (LASTING, t, 0.0)


@kernel(inline=True)
def _time_to_gap(
    powers: FloatArray | None,
    balls: Balls,
    i: int,
    j: int,
    t: float,
    gap: float,
    rate: float,
    pull: float,
) -> float:
    """Return in how long after t [s] a gap closes at the soonest, of parabolas or of what bends."""
    if powers is None or neither_bends(powers, i, j):
        straight: float = first_crossing(gap, rate, pull)
        return straight
    left = both_last(balls, i, j, t)
    bent = _jerk_between(powers, balls, i, j, t, left)
    soonest: float = first_bent_crossing(gap, rate, pull, bent, left)
    return soonest


@kernel(inline=True)
def _bend_meanwhile(powers: FloatArray | None, balls: Balls, i: int, j: int, t: float) -> float:
    """Return by how much the relative acceleration changes at most while both pieces last."""
    if powers is None or neither_bends(powers, i, j):
        return 0.0
    left = both_last(balls, i, j, t)
    change: float = _jerk_between(powers, balls, i, j, t, left) * left
    return change


@kernel
def _jerk_between(powers: FloatArray, balls: Balls, i: int, j: int, t: float, left: float) -> float:
    """Return how fast the relative acceleration of two balls changes at most [m/s^3].

    From t [s] on, for `left` [s]. Two that go along together bend alike, and so not at all as seen
    from each other.
    """
    began = balls.state[i].epoch
    if began == balls.state[j].epoch:
        same: float = relative_jerk(powers, i, j, left + (t - began))
        return same
    total: float = jerk(balls, i) + jerk(balls, j)
    return total


@kernel
def time_to_bound_in_space(balls: Balls, i: int, j: int, start: float) -> float:
    """Return in how long a pair of which one flies may touch at the soonest [s], or inf.

    From the instant `start` on; where the line of centres is now, as in the plane.
    """
    return _time_to_bound_in_space(balls.height, balls, i, j, start)


@kernel(inline=True)
def _time_to_bound_in_space(
    height: FloatArray | None, balls: Balls, i: int, j: int, start: float
) -> float:
    if height is None:
        return math.inf
    return _next_in_space(height, balls, i, j, start)[0]


@kernel
def _next_in_space(
    height: FloatArray, balls: Balls, i: int, j: int, t: float
) -> tuple[float, float]:
    """Return in how long after t [s] a pair of which one flies may have an impact; its approach.

    0: now, as far as doubles can tell. Where the pair is apart, in how long it may touch.
    """
    rx, ry, rz, vx, vy, vz, ax, ay, az = motion_in_space(height, balls, i, j, t)
    reach = balls.state[i].radius + balls.state[j].radius
    distance = math.sqrt(rx * rx + ry * ry + rz * rz)
    gap = distance - reach
    rate = (rx * vx + ry * vy + rz * vz) / distance
    pull = (rx * ax + ry * ay + rz * az) / distance
    bent, left = _bend_in_space(balls.powers, balls, i, j, t, rx, ry, rz, distance)
    s = soonest_crossing(gap, rate, pull, bent, left)
    if gap <= GAP_ROUNDING * reach or s <= TIME_ROUNDING * t:
        gravity = max(height[i, st.FALL], height[j, st.FALL])
        across = max(vx * vx + vy * vy + vz * vz - rate * rate, 0.0)
        opening = pull + across / distance
        s = time_to_impact(gravity, -gap, rate, pull, opening, 0.5 * reach, bent, left)
        s = max(s, 2.0 * TIME_ROUNDING * t) if s > 0.0 else 0.0
    return s, -rate


@kernel(inline=True)
def _bend_in_space(
    powers: FloatArray | None,
    balls: Balls,
    i: int,
    j: int,
    t: float,
    rx: float,
    ry: float,
    rz: float,
    distance: float,
) -> tuple[float, float]:
    """Return how fast the acceleration along the line of centres changes at most [m/s^3].

    And how long after t [s] that holds: while both pieces last.
    """
    if powers is None:
        return 0.0, 0.0
    level = jerk_along(balls, i, rx, ry) + jerk_along(balls, j, rx, ry)
    bent = level + abs(rz) * (jerk_up(powers, i) + jerk_up(powers, j))
    return bent / distance, both_last(balls, i, j, t)


@kernel
def touch_in_space(balls: Balls, i: int, j: int, t: float) -> tuple[int, float, float]:
    """Judge a pair of which one flies, as `touch`: nothing holds it, so no contact lasts."""
    return _touch_in_space(balls.height, balls, i, j, t)


@kernel(inline=True)
def _touch_in_space(
    height: FloatArray | None, balls: Balls, i: int, j: int, t: float
) -> tuple[int, float, float]:
    if height is None:
        return NOT_YET, math.inf, 0.0
    s, speed = _next_in_space(height, balls, i, j, t)
    return (NOT_YET if s > 0.0 else IMPACT), t + s, speed


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
    if opening == 0.0:
        return 0.0
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

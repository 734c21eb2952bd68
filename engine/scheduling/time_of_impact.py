"""Time at which two balls touch: lower bounds, and a check whether they touch at a given time.

The functions treat balls on the cloth and in the air. Two balls that touch either collide, or are
in resting contact, which a contact step then handles.
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
    one_is_loaded,
    time_to_impact,
)
from ghostball.engine.motion.geometry import (
    approach_rounding,
    at_rest,
    capture_height,
    gap_rounding,
    negligible_bounce,
)
from ghostball.engine.motion.position import (
    acceleration,
    both_last,
    displacement,
    jerk,
    jerk_along,
    neither_bends,
    one_flies,
    pair_reach,
    relative_jerk,
    relative_motion,
    speed,
)

NOT_YET = 0
"""The pair doesn't touch at this time; its bound is later."""
IMPACT = 1
"""The pair touches and approaches: resolve a collision now."""
LASTING = 2
"""The pair touches and is pushed together, so that a collision wouldn't separate it."""


@kernel(inline=True)
def first_bound(balls: Balls, laws: Laws, i: int, j: int, start: float) -> float:
    """Return the first lower bound on the contact time of a pair [s], from `start`; or inf.

    If `start` is the last change of motion of either ball, the result is bit-identical to the bound
    in the rows of `scheduling.all_pairs`, which computes it without branches.
    """
    if balls.height is not None and one_flies(balls, i, j):
        return start + _next_in_space(balls.height, balls, i, j, start)[0]
    if in_air(balls, laws):
        return start + _bent_bound(balls, i, j, start)
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, start)
    rate, pull = rx * vx + ry * vy, rx * ax + ry * ay
    return start + time_to_bound(laws, rx, ry, vx, vy, rate, pull, pair_reach(balls, i, j))


@kernel
def _bent_bound(balls: Balls, i: int, j: int, start: float) -> float:
    """Return a lower bound on the duration until a pair with jerk touches [s], or inf.

    Each ball follows its parabola up to a deviation of jerk s^3 / 6, with s the time since its
    epoch. Computing the exact position would cost more than a later bound saves.
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
    """Return a lower bound on the duration until a pair with jerk touches [s]; or inf, or > `left`.

    The first six numbers are the relative motion on the two parabolas. The jerks, with sum `jerk`,
    have changed the relative acceleration by at most `bent` (j s), the velocity by at most half of
    `drifted` (j s^2) and the position by at most a sixth of `moved` (j s^3) since the parabolas
    began. The code has no branches, so that the compiler can vectorise a row of pairs.
    """
    # All three are multiplied by the distance, which saves divisions.
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
    """Return a lower bound on the duration until a pair touches [s], or inf.

    `rate` is r . v and `pull` is r . a. Divided by the distance, they are the first two derivatives
    of the projected gap.
    """
    if laws.uniform:
        met: float = first_meeting(rx, ry, vx, vy, reach)
        return met
    distance = math.sqrt(rx * rx + ry * ry)
    closed: float = first_crossing(distance * (distance - reach), rate, pull)
    return closed


@kernel
def holds(contacts: Contacts, i: int, j: int) -> bool:
    """Return whether a contact step holds balls i and j together, so that they can't collide."""
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
    """Check a pair at time t: return a verdict, the next bound [s] and the approach speed [m/s].

    A gap of at most `tolerance` [m] counts as closed.
    """
    if balls.height is not None and one_flies(balls, i, j):
        s, closing = _next_in_space(balls.height, balls, i, j, t)
        return (NOT_YET if s > 0.0 else IMPACT), t + s, closing  # no resting contact in flight
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, t)
    reach = pair_reach(balls, i, j)
    distance = math.sqrt(rx * rx + ry * ry)
    gap = distance - reach
    rate = (rx * vx + ry * vy) / distance
    pull = (rx * ax + ry * ay) / distance
    s = _time_to_gap(balls, i, j, t, gap, rate, pull)
    progress = s > TIME_ROUNDING * t
    if gap > max(GAP_ROUNDING * reach, tolerance) and progress:
        return NOT_YET, t + s, 0.0
    # The pair touches, within rounding. If r . v = 0, the gap opens at first as `opening` s^2 / 2,
    # because the line of centres turns; friction can make `opening` negative.
    noise = approach_rounding(balls, i, j, t)
    across = max(vx * vx + vy * vy - rate * rate, 0.0)
    opening = across / distance + pull
    pulled = opening < -APPROACH_ROUNDING * (_pull(balls, i, t) + _pull(balls, j, t))
    if rate < -noise:
        # A slow rebound ends within `CAPTURE_HEIGHT`: friction pushes the balls together again, or
        # the cloth stops a ball that was at rest.
        struck = at_rest(balls, i) or at_rest(balls, j)
        closing = _stopping(balls, i) + _stopping(balls, j) - opening
        height = capture_height(balls, i, j)
        bounce = (pulled or struck) and negligible_bounce(rate, closing, height)
        if one_is_loaded(balls, i, j, t):
            bounce = bounce or negligible_bounce(rate, laws.gravity, height)
        return (LASTING if bounce else IMPACT), t, -rate
    if rate > noise and progress:
        return NOT_YET, t + s, 0.0
    if pulled:
        return LASTING, t, 0.0
    bend = _bend_meanwhile(balls, i, j, t)
    s = _next_approach(distance * max(opening, 0.0), vx, vy, ax, ay, distance, bend)
    return (NOT_YET, t + s, 0.0) if s > TIME_ROUNDING * t else (LASTING, t, 0.0)


@kernel(inline=True)
def _time_to_gap(
    balls: Balls, i: int, j: int, t: float, gap: float, rate: float, pull: float
) -> float:
    """Return a lower bound on the duration from t [s] until a gap closes, with or without jerk."""
    if balls.powers is None or neither_bends(balls.powers, i, j):
        straight: float = first_crossing(gap, rate, pull)
        return straight
    left = both_last(balls, i, j, t)
    bent = _jerk_between(balls.powers, balls, i, j, t, left)
    soonest: float = first_bent_crossing(gap, rate, pull, bent, left)
    return soonest


@kernel(inline=True)
def _bend_meanwhile(balls: Balls, i: int, j: int, t: float) -> float:
    """Return a bound on the change of the relative acceleration until either piece ends [m/s^2]."""
    if balls.powers is None or neither_bends(balls.powers, i, j):
        return 0.0
    left = both_last(balls, i, j, t)
    change: float = _jerk_between(balls.powers, balls, i, j, t, left) * left
    return change


@kernel
def _jerk_between(powers: FloatArray, balls: Balls, i: int, j: int, t: float, left: float) -> float:
    """Return a bound on the rate of change of the relative acceleration of two balls [m/s^3].

    The bound holds from t [s] for `left` [s]. Two balls that move together have nearly equal jerks,
    which cancel in their relative motion.
    """
    began = balls.state[i].epoch
    if began == balls.state[j].epoch:
        same: float = relative_jerk(powers, i, j, left + (t - began))
        return same
    total: float = jerk(balls, i) + jerk(balls, j)
    return total


@kernel
def _next_in_space(
    height: FloatArray, balls: Balls, i: int, j: int, t: float
) -> tuple[float, float]:
    """Return the duration from t [s] to the next possible impact of a pair with a flying ball.

    The duration is 0 if the impact is now, within rounding. If the pair is apart, it is a lower
    bound. The second number is the approach speed.
    """
    rx, ry, rz, vx, vy, vz, ax, ay, az = motion_in_space(height, balls, i, j, t)
    reach = balls.state[i].radius + balls.state[j].radius
    distance = math.sqrt(rx * rx + ry * ry + rz * rz)
    gap = distance - reach
    rate = (rx * vx + ry * vy + rz * vz) / distance
    pull = (rx * ax + ry * ay + rz * az) / distance
    # A bound on the rate of change of the acceleration along the line of centres [m/s^3], and the
    # duration for which it holds: until either piece ends [s].
    level = jerk_along(balls, i, rx, ry) + jerk_along(balls, j, rx, ry)
    bent = (level + abs(rz) * (jerk_up(balls, i) + jerk_up(balls, j))) / distance
    left = both_last(balls, i, j, t)
    s = first_bent_crossing(gap, rate, pull, bent, left)
    closed = GAP_ROUNDING * reach
    if balls.state[i].impacts > 0.0 and balls.state[j].impacts > 0.0:
        # Both balls have an impact at this instant, so rounding decided their gap.
        closed = max(closed, gap_rounding(balls, i, j))
    if gap <= closed or s <= TIME_ROUNDING * t:
        gravity = max(height[i, st.FALL], height[j, st.FALL])
        across = max(vx * vx + vy * vy + vz * vz - rate * rate, 0.0)
        opening = pull + across / distance
        s = time_to_impact(gravity, -gap, rate, pull, opening, 0.5 * reach, bent, left)
        s = max(s, 2.0 * TIME_ROUNDING * t) if s > 0.0 else 0.0
    return s, -rate


@kernel
def _next_approach(
    opening: float, vx: float, vy: float, ax: float, ay: float, distance: float, bend: float
) -> float:
    """Return the time [s] after which a touching pair with zero approach speed can approach.

    With r . v = 0, half the time derivative of |r|^2 is s (A + B s + C s^2), where A = v^2 + r . a
    = `opening`, B = 3/2 v . a and C = a^2 / 2. The pair separates while this is positive. If the
    acceleration is uncertain by up to b = `bend`, A can be smaller by |r| b, B by 3/2 |v| b and C
    by (|a| + b / 2) b.
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
    """Return the deceleration that will stop ball i after an impact, if it is at rest [m/s^2]."""
    deceleration: float = balls.state[i].roll_slowing if at_rest(balls, i) else 0.0
    return deceleration


@kernel
def _pull(balls: Balls, i: int, t: float) -> float:
    """Return the 1-norm of the acceleration of ball i at time t [m/s^2]."""
    ax, ay = acceleration(balls, i, t)
    size: float = abs(ax) + abs(ay)
    return size

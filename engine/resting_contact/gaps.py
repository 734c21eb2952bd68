"""Gaps of contacts: where they are now, where they are after a while, where a step aims at."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Contacts, Laws, World
from ghostball.engine.motion.crossings import first_crossing
from ghostball.engine.motion.geometry import contact_tolerance, friction_limit, gap_rounding
from ghostball.engine.motion.obstacles import facing, nose_reach
from ghostball.engine.motion.position import displacement, pair_reach
from ghostball.engine.resting_contact.cloth_response import permitted_gap, stopping

LARGE_OVERLAP = 0.75
"""Overlap, in tolerances, from which two balls at rest are pushed apart, gently."""

_WITHIN = 29.0 / 32.0
"""Part of the tolerance that a gap may reach where it is looked at, each eighth of the step: a
cubic that is closed at the end goes at most 6.8 % beyond the largest of what it has there."""


@kernel(inline=True)
def gap_between(
    balls: Balls, laws: Laws, a: int, b: int, x: float, y: float, to_x: float, to_y: float
) -> tuple[float, float, float]:
    """Return the normal, outward from ball a, and the gap [m], if a is at (x, y).

    To ball b at (to_x, to_y), or where b is -1 minus an obstacle's row to that.
    """
    if b < 0:
        inward_x, inward_y, distance = facing(laws, -1 - b, x, y)
        return -inward_x, -inward_y, distance - nose_reach(balls, a, laws, -1 - b)
    rx, ry = to_x - x, to_y - y
    distance = math.sqrt(rx * rx + ry * ry)
    return rx / distance, ry / distance, distance - pair_reach(balls, a, b)


@kernel
def gap_now(world: World, c: int) -> tuple[float, float, float]:
    """Return contact c's normal, outward from its first ball, and its gap [m], now."""
    balls = world.balls
    a, b = world.contacts.ends[c, st.FIRST], world.contacts.ends[c, st.SECOND]
    ball, other = balls.state[a], balls.state[max(b, 0)]
    nx, ny, gap = gap_between(balls, world.laws, a, b, ball.x, ball.y, other.x, other.y)
    return nx, ny, gap


@kernel
def normal_after(world: World, c: int, s: float) -> tuple[float, float]:
    """Return contact c's normal in s seconds, by the accelerations that a step gives its balls."""
    balls = world.balls
    a, b = world.contacts.ends[c, st.FIRST], world.contacts.ends[c, st.SECOND]
    x, y = _displacement_of(world, a, s)
    x, y = balls.state[a].x + x, balls.state[a].y + y
    to_x, to_y = 0.0, 0.0
    if b >= 0:
        to_x, to_y = _displacement_of(world, b, s)
        to_x, to_y = balls.state[b].x + to_x, balls.state[b].y + to_y
    nx, ny, _ = gap_between(balls, world.laws, a, b, x, y, to_x, to_y)
    return nx, ny


@kernel
def gap_after(world: World, c: int, s: float) -> float:
    """Return contact c's gap [m] in s seconds, as `normal_after`; GAP is what it is now.

    What changes it is found from the balls' displacements, not from their places: over a short step
    the rounding of those, another one for every force tried, was more than what forces do.
    """
    laws, contacts = world.laws, world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    gap: float = contacts.forces[c].gap
    wx, wy = _displacement_of(world, a, s)
    ball = world.balls.state[a]
    if b < 0:
        inward_x, inward_y, distance = facing(laws, -1 - b, ball.x, ball.y)
        if laws.obstacles[-1 - b].kind == st.LINE:
            gap += inward_x * wx + inward_y * wy
            return gap
        _, _, moved = facing(laws, -1 - b, ball.x + wx, ball.y + wy)
        gap += moved - distance
        return gap
    other = world.balls.state[b]
    rx, ry = other.x - ball.x, other.y - ball.y
    to_x, to_y = _displacement_of(world, b, s)
    wx, wy = to_x - wx, to_y - wy
    x, y = rx + wx, ry + wy
    both = math.sqrt(x * x + y * y) + math.sqrt(rx * rx + ry * ry)
    gap += ((x + rx) * wx + (y + ry) * wy) / both
    return gap


@kernel(inline=True)
def _displacement_of(world: World, k: int, s: float) -> tuple[float, float]:
    """Return how far ball k goes in s seconds by the acceleration that the step gives it [m]."""
    ball, new = world.balls.state[k], world.contacts.motion
    return displacement(ball.vx, new[k].new_ax, s), displacement(ball.vy, new[k].new_ay, s)


@kernel
def _aim(balls: Balls, a: int, b: int, now: float, duration: float) -> float:
    """Return the gap [m] that a step aims at, between members a and b, or a and a cushion: b is a.

    A closed one; but an overlap that rounding or an earlier step left is not pushed apart faster
    than friction would do it. Two balls that the cloth brings to rest keep the gap that they have:
    to close it, one of them would have to move until it pushes the next.
    """
    tolerance = contact_tolerance(balls, a, b)
    push = 0.25 * max(friction_limit(balls, a), friction_limit(balls, b)) * duration * duration
    if stopping(balls, a) and stopping(balls, b):
        if now >= -LARGE_OVERLAP * tolerance:
            return min(now, 0.5 * tolerance)
        return now + max(min(push, 0.25 * tolerance), 2.0 * gap_rounding(balls, a, b))
    return min(0.0, now + push)


@kernel
def excess(world: World, c: int, duration: float) -> float:
    """Return how far the gap of contact c [m] ends above what the step aims at."""
    a, b = balls_of(world.contacts, c)
    aim = _aim(world.balls, a, b, world.contacts.forces[c].gap, duration)
    return gap_after(world, c, duration) - aim


@kernel
def permitted_error(world: World, c: int, duration: float) -> float:
    """Return how far the gap of contact c [m] may end from what the step aims at.

    The larger the overlap already is, the less it may grow: many steps must not add up.
    """
    balls = world.balls
    a, b = balls_of(world.contacts, c)
    share = 1.0 + min(0.0, max(-1.0, world.contacts.forces[c].gap / contact_tolerance(balls, a, b)))
    return max(share * permitted_gap(balls, a, b, duration), gap_rounding(balls, a, b))


@kernel
def overlap_to_end(world: World, count: int, duration: float) -> tuple[float, float]:
    """Return the most by which a step aims to end an overlap [m]; and the least permitted error."""
    most, least = 0.0, math.inf
    for c in range(count):
        a, b = balls_of(world.contacts, c)
        now = world.contacts.forces[c].gap
        most = max(most, _aim(world.balls, a, b, now, duration) - now)
        least = min(least, permitted_error(world, c, duration))
    return most, least


@kernel
def gaps_are_closed(world: World, count: int, duration: float, jammed: float) -> bool:
    """Whether every force holds its gap as the step aims at, and no gap without force closes.

    `jammed` [m] is how much of the overlaps no forces can end.
    """
    balls, contacts = world.balls, world.contacts
    for c in range(count):
        now = contacts.forces[c].gap
        a, b = balls_of(contacts, c)
        left = permitted_error(world, c, duration)
        over = excess(world, c, duration)
        if compliance_of(contacts, c) == 0.0 and over < 0.0:
            # An overlap between two that the cloth holds, which no force pushes apart.
            over = min(0.0, over + _aim(balls, a, b, now, duration) - now)
        if over < 0.0:
            over = min(0.0, over + jammed)
        if (contacts.forces[c].force > 0.0 or over < 0.0) and abs(over) > left:
            return False
    return True


@kernel
def stays_closed(world: World, count: int, duration: float) -> bool:
    """Whether no gap leaves the tolerance within the step.

    Looked at seven times. A step is so short that a gap is all but a cubic of time, closed at the
    end; where the overlap is largest depends on whether it opens first. A cubic that is within
    `_WITHIN` of the tolerance at these places, and at the start, is within it everywhere. Of a
    contact that doesn't push, which opens, the way out has no bound.

    And looked at where a ball passes an end of a segment: a cubic before and another one after, for
    the normal begins to turn there. A ball driven into a rail was past the rail's end, and off it,
    before the first of the seven.
    """
    contacts = world.contacts
    for c in range(count):
        a, b = balls_of(contacts, c)
        now = contacts.forces[c].gap
        tolerance = _WITHIN * contact_tolerance(world.balls, a, b)
        allowed = max(tolerance, gap_rounding(world.balls, a, b) - now)
        for part in range(1, 10):
            s = 0.125 * part * duration if part < 8 else _time_to_end(world, c, part == 9)
            if not 0.0 < s < duration:
                continue
            gap = gap_after(world, c, s)
            if gap < -allowed or (contacts.forces[c].force > 0.0 and gap > max(allowed, now)):
                return False
    return True


@kernel
def _time_to_end(world: World, c: int, far: bool) -> float:
    """Return in how long contact c comes to its segment's start, or far end [s]; inf if it doesn't.

    As `normal_after`; from either side.
    """
    a, row = world.contacts.ends[c, st.FIRST], -1 - world.contacts.ends[c, st.SECOND]
    if row < 0 or world.laws.obstacles[row].kind != st.SEGMENT:
        return math.inf
    ball, segment, new = world.balls.state[a], world.laws.obstacles[row], world.contacts.motion[a]
    dx, dy = segment.nx - segment.x, segment.ny - segment.y
    x, y = (segment.nx, segment.ny) if far else (segment.x, segment.y)
    along = (ball.x - x) * dx + (ball.y - y) * dy
    sign = 1.0 if along > 0.0 else -1.0
    rate, pull = ball.vx * dx + ball.vy * dy, new.new_ax * dx + new.new_ay * dy
    s: float = first_crossing(sign * along, sign * rate, sign * pull)
    return s


@kernel
def compliance_of(contacts: Contacts, c: int) -> float:
    """Acceleration of the gap of contact c over its force [1/kg], as the members respond now."""
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    both: float = contacts.motion[a].compliance
    if b >= 0:
        both += contacts.motion[b].compliance
    return both


@kernel
def balls_of(contacts: Contacts, c: int) -> tuple[int, int]:
    """Return the balls of contact c; for a cushion, the ball twice."""
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    return a, b if b >= 0 else a

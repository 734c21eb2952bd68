"""Gaps of contacts: now, after some time, and the gap that a step aims at."""

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
"""Overlap, in tolerances, from which two balls at rest are pushed apart slowly."""

_WITHIN = 29.0 / 32.0
"""Part of the tolerance that a gap may reach at the times at which it is checked, every eighth of
the step. A cubic that is closed at the end exceeds its largest value at these times by at most
6.8 %."""


@kernel(inline=True)
def gap_between(
    balls: Balls, laws: Laws, a: int, b: int, x: float, y: float, to_x: float, to_y: float
) -> tuple[float, float, float]:
    """Return the normal, outward from ball a, and the gap [m], if a is at (x, y).

    The other body is ball b at (to_x, to_y), or an obstacle if b is -1 minus the obstacle's row.
    """
    if b < 0:
        inward_x, inward_y, distance = facing(laws, -1 - b, x, y)
        return -inward_x, -inward_y, distance - nose_reach(balls, a, laws, -1 - b)
    rx, ry = to_x - x, to_y - y
    distance = math.sqrt(rx * rx + ry * ry)
    return rx / distance, ry / distance, distance - pair_reach(balls, a, b)


@kernel
def gap_now(world: World, c: int) -> tuple[float, float, float]:
    """Return contact c's normal, outward from its first ball, and its present gap [m]."""
    balls = world.balls
    a, b = world.contacts.ends[c, st.FIRST], world.contacts.ends[c, st.SECOND]
    ball, other = balls.state[a], balls.state[max(b, 0)]
    nx, ny, gap = gap_between(balls, world.laws, a, b, ball.x, ball.y, other.x, other.y)
    return nx, ny, gap


@kernel
def normal_after(world: World, c: int, s: float) -> tuple[float, float]:
    """Return contact c's normal in s seconds, with the accelerations that the step sets."""
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
    """Return contact c's gap [m] in s seconds, like `normal_after`; `gap` is the present gap.

    The change of the gap is computed from the displacements of the balls, not from their positions.
    Over a short step, the rounding of positions would be larger than the effect of the forces, and
    would differ between two forces that the solver tries.
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
    """Return ball k's displacement in s seconds, with the acceleration that the step sets [m]."""
    ball, new = world.balls.state[k], world.contacts.motion
    return displacement(ball.vx, new[k].new_ax, s), displacement(ball.vy, new[k].new_ay, s)


@kernel
def _aim(balls: Balls, a: int, b: int, now: float, duration: float) -> float:
    """Return the gap [m] that a step aims at, between members a and b; for a cushion, b is a.

    The aim is a closed gap. But an overlap left by rounding or by an earlier step is removed no
    faster than friction would remove it. Two balls that the cloth brings to rest keep their gap: to
    close it, one of them would have to move, until it pushes the next ball.
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
    """Return by how much [m] the gap of contact c at the end exceeds the aim of the step."""
    a, b = balls_of(world.contacts, c)
    aim = _aim(world.balls, a, b, world.contacts.forces[c].gap, duration)
    return gap_after(world, c, duration) - aim


@kernel
def permitted_error(world: World, c: int, duration: float) -> float:
    """Return the permitted difference [m] between the gap of contact c at the end and the aim.

    The larger the present overlap, the less it may grow, so that errors of many steps don't add up.
    """
    balls = world.balls
    a, b = balls_of(world.contacts, c)
    share = 1.0 + min(0.0, max(-1.0, world.contacts.forces[c].gap / contact_tolerance(balls, a, b)))
    return max(share * permitted_gap(balls, a, b, duration), gap_rounding(balls, a, b))


@kernel
def overlap_to_end(world: World, count: int, duration: float) -> tuple[float, float]:
    """Return the largest overlap that a step aims to remove, and the least permitted error.

    Both are in [m].
    """
    most, least = 0.0, math.inf
    for c in range(count):
        a, b = balls_of(world.contacts, c)
        now = world.contacts.forces[c].gap
        most = max(most, _aim(world.balls, a, b, now, duration) - now)
        least = min(least, permitted_error(world, c, duration))
    return most, least


@kernel
def gaps_are_closed(world: World, count: int, duration: float, jammed: float) -> bool:
    """Return whether all gaps with forces reach their aims, and no gap without force overlaps.

    `jammed` [m] is the part of the overlaps that no forces can remove.
    """
    balls, contacts = world.balls, world.contacts
    for c in range(count):
        now = contacts.forces[c].gap
        a, b = balls_of(contacts, c)
        left = permitted_error(world, c, duration)
        over = excess(world, c, duration)
        if compliance_of(contacts, c) == 0.0 and over < 0.0:
            # The cloth holds both balls, so no force can remove their overlap.
            over = min(0.0, over + _aim(balls, a, b, now, duration) - now)
        if over < 0.0:
            over = min(0.0, over + jammed)
        if (contacts.forces[c].force > 0.0 or over < 0.0) and abs(over) > left:
            return False
    return True


@kernel
def stays_closed(world: World, count: int, duration: float) -> bool:
    """Return whether every gap stays within its tolerance during the step.

    Each gap is checked at seven times. Within a step a gap is nearly a cubic in time that is closed
    at the end. The time of its largest overlap depends on whether it opens first. A cubic that is
    within `_WITHIN` of the tolerance at the start and at these times is within the tolerance
    everywhere. Gaps of contacts without a force may open without limit.

    A gap is also checked when the ball passes either end of a segment. The normal starts to turn
    there, so the gap is one cubic before, and another cubic after. (A ball driven into a rail once
    passed the end of the rail, and left it, before the first of the seven times.)
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
    """Return when the ball of contact c passes the start of its segment, or the far end [s].

    The result is inf if the ball doesn't pass this end, from either side. The motion is that of
    `normal_after`.
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
    """Return the acceleration of contact c's gap per force [1/kg], with the present responses."""
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

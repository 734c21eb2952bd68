"""The forces that hold a cluster's gaps closed over one contact step; `_press` has the whole."""

from __future__ import annotations

import math

from engine._geometry import (
    contact_tolerance,
    cushion_gap,
    cushion_side,
    gap_rounding,
    negligible_hop,
)
from engine._jit import kernel
from engine._motion import rolling_resistance, speed_of
from engine._state import (
    AX,
    AY,
    FIRST,
    FORCE,
    MASS,
    NEW_AX,
    NEW_AY,
    NX,
    NY,
    PUSH_X,
    PUSH_Y,
    RADIUS,
    SECOND,
    VX,
    VY,
    Balls,
    Contacts,
    Laws,
    X,
    Y,
)

SWEEPS = 100
"""Most Gauss-Seidel sweeps; where they don't do, the step is halved: in a short one, gaps hardly
change, and little is left to solve."""

_TURN = 0.125
"""Largest change of a ball's velocity in a step, in units of its speed."""


@kernel
def solve(
    balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int, duration: float
) -> bool:
    """Find forces that close every gap at the end of a step; False where the step is too long.

    Complementarity: a force is never negative, and is 0 where the gap opens.
    """
    for m in range(members):
        k = contacts.member[m]
        contacts.motion[PUSH_X, k] = 0.0
        contacts.motion[PUSH_Y, k] = 0.0
        contacts.motion[NEW_AX, k], contacts.motion[NEW_AY, k] = (
            balls.state[AX, k],
            balls.state[AY, k],
        )
        _accelerate(balls, laws, contacts, k, duration)
    for c in range(count):
        nx, ny, _, _ = gap_after(balls, laws, contacts, c, 0.5 * duration)
        contacts.forces[NX, c] = nx
        contacts.forces[NY, c] = ny
        contacts.forces[FORCE, c] = 0.0
    for _ in range(SWEEPS):
        # The forces of the last sweep turn the velocities at mid-step, and so the friction there.
        for m in range(members):
            _accelerate(balls, laws, contacts, contacts.member[m], duration)
        if _settled(balls, laws, contacts, count, duration):
            return _stays_closed(balls, laws, contacts, count, duration) and _turns_little(
                balls, laws, contacts, members, duration
            )
        for c in range(count):
            a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
            mass = balls.state[MASS, a]
            if b >= 0:
                mass *= balls.state[MASS, b] / (balls.state[MASS, a] + balls.state[MASS, b])
            excess = _excess(balls, laws, contacts, c, duration)
            force = contacts.forces[FORCE, c]
            change = max(-force, -2.0 * mass * excess / (duration * duration))
            contacts.forces[FORCE, c] = force + change
            contacts.motion[PUSH_X, a] -= change * contacts.forces[NX, c]
            contacts.motion[PUSH_Y, a] -= change * contacts.forces[NY, c]
            _accelerate(balls, laws, contacts, a, duration)
            if b >= 0:
                contacts.motion[PUSH_X, b] += change * contacts.forces[NX, c]
                contacts.motion[PUSH_Y, b] += change * contacts.forces[NY, c]
                _accelerate(balls, laws, contacts, b, duration)
    return False


@kernel
def _excess(balls: Balls, laws: Laws, contacts: Contacts, c: int, duration: float) -> float:
    """Return how far the gap of contact c [m] ends above what the step aims at.

    That is a closed gap; but an overlap left by rounding or by an earlier step is not pushed apart
    faster than friction would do it.
    """
    _, _, now, _ = gap_after(balls, laws, contacts, c, 0.0)
    _, _, then, _ = gap_after(balls, laws, contacts, c, duration)
    return then - min(0.0, now + 0.25 * laws.deceleration * duration * duration)


@kernel
def _settled(balls: Balls, laws: Laws, contacts: Contacts, count: int, duration: float) -> bool:
    """Whether every force holds its gap as the step aims at, and no gap without force closes."""
    for c in range(count):
        _, _, now, _ = gap_after(balls, laws, contacts, c, 0.0)
        a, b = _ends(contacts, c)
        tolerance = contact_tolerance(balls, a, b)
        # The deeper it already is, the less it may deepen: many steps must not add up.
        slack = 0.125 * (tolerance + min(0.0, max(-tolerance, now)))
        slack = max(slack, gap_rounding(balls, a, b))
        excess = _excess(balls, laws, contacts, c, duration)
        if (contacts.forces[FORCE, c] > 0.0 or excess < 0.0) and abs(excess) > slack:
            return False
    return True


@kernel
def _stays_closed(
    balls: Balls, laws: Laws, contacts: Contacts, count: int, duration: float
) -> bool:
    """Whether no gap leaves the tolerance within the step; it leaves most about the middle."""
    for c in range(count):
        a, b = _ends(contacts, c)
        for part in (0.5, 0.6875):
            _, _, gap, _ = gap_after(balls, laws, contacts, c, part * duration)
            _, _, now, _ = gap_after(balls, laws, contacts, c, 0.0)
            allowed = max(contact_tolerance(balls, a, b), gap_rounding(balls, a, b) - now)
            if gap < -allowed or (contacts.forces[FORCE, c] > 0.0 and gap > allowed):
                return False
    return True


@kernel
def _turns_little(
    balls: Balls, laws: Laws, contacts: Contacts, members: int, duration: float
) -> bool:
    """Whether no member's velocity changes so much that friction would turn with it."""
    for m in range(members):
        k = contacts.member[m]
        speed = speed_of(balls.state[VX, k], balls.state[VY, k])
        change = duration * speed_of(contacts.motion[NEW_AX, k], contacts.motion[NEW_AY, k])
        if change > _TURN * speed and not stopping(balls, laws, k):
            return False
    return True


@kernel
def stopping(balls: Balls, laws: Laws, k: int) -> bool:
    """Whether the cloth alone would stop ball k within the tolerance of a gap; or has."""
    speed = speed_of(balls.state[VX, k], balls.state[VY, k])
    return negligible_hop(speed, laws.deceleration, contact_tolerance(balls, k, k))


@kernel
def _accelerate(balls: Balls, laws: Laws, contacts: Contacts, k: int, duration: float) -> None:
    """Set member k's acceleration: its contact forces, and friction at the middle of the step."""
    fx = contacts.motion[PUSH_X, k] / balls.state[MASS, k]
    fy = contacts.motion[PUSH_Y, k] / balls.state[MASS, k]
    vx, vy = balls.state[VX, k], balls.state[VY, k]
    if stopping(balls, laws, k):
        # So slow, or at rest: the cloth brings it to rest by the end of the step if mu m g can,
        # else it resists with that.
        ux, uy = vx / duration + fx, vy / duration + fy
        size = speed_of(ux, uy)
        if size <= laws.deceleration:
            contacts.motion[NEW_AX, k] = -vx / duration
            contacts.motion[NEW_AY, k] = -vy / duration
        else:
            contacts.motion[NEW_AX, k] = fx - laws.deceleration * (ux / size)
            contacts.motion[NEW_AY, k] = fy - laws.deceleration * (uy / size)
        return
    mid_x = vx + 0.5 * duration * contacts.motion[NEW_AX, k]
    mid_y = vy + 0.5 * duration * contacts.motion[NEW_AY, k]
    rx, ry = rolling_resistance(mid_x, mid_y, laws.deceleration)
    contacts.motion[NEW_AX, k] = rx + fx
    contacts.motion[NEW_AY, k] = ry + fy


@kernel
def _ends(contacts: Contacts, c: int) -> tuple[int, int]:
    """Return the balls of contact c; for a cushion, the ball twice."""
    a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
    return a, b if b >= 0 else a


@kernel
def gap_after(
    balls: Balls, laws: Laws, contacts: Contacts, c: int, s: float
) -> tuple[float, float, float, float]:
    """Return contact c's normal (outward from its first member), gap and reach, in s seconds."""
    a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
    xa = balls.state[X, a] + s * (balls.state[VX, a] + 0.5 * s * contacts.motion[NEW_AX, a])
    ya = balls.state[Y, a] + s * (balls.state[VY, a] + 0.5 * s * contacts.motion[NEW_AY, a])
    radius = balls.state[RADIUS, a]
    if b >= 0:
        rx = (
            balls.state[X, b] + s * (balls.state[VX, b] + 0.5 * s * contacts.motion[NEW_AX, b]) - xa
        )
        ry = (
            balls.state[Y, b] + s * (balls.state[VY, b] + 0.5 * s * contacts.motion[NEW_AY, b]) - ya
        )
        reach = radius + balls.state[RADIUS, b]
        distance = math.sqrt(rx * rx + ry * ry)
        return rx / distance, ry / distance, distance - reach, reach
    cushion = -1 - b
    nx, ny, _ = cushion_side(laws, cushion)
    return -nx, -ny, cushion_gap(xa, ya, radius, laws, cushion), 2.0 * radius

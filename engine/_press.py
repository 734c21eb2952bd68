"""Sustained contact: balls that friction presses together move as one cluster, in short steps.

Two balls that roll side by side in contact, in slightly different directions, are slowed along
different lines, and so may be pressed together. Bouncing, they would meet again and again with
vanishing speed: without end for a restitution below 1. Instead a contact force holds each gap of
the cluster closed for as long as it has to push.

That motion isn't polynomial, because the line of centres and the direction of friction turn. It is
followed in steps of constant acceleration, each as long as keeps every gap within
`CONTACT_TOLERANCE` diameters (4e-13 m for pool balls), checked on the very polynomials that the
balls then follow. Normals and friction are taken at the middle of the step, so that its error is
third order in its length. The forces come from projected Gauss-Seidel on the gaps at the end of the
step. No ball is displaced, and energy can't rise: the impulses are plastic, and the force works on
a gap that stays closed.

Each step is counted in `work["contact_steps"]`.
"""

from __future__ import annotations

import math

from engine._geometry import (
    contact_tolerance,
    cushion_in_contact,
    gap_rounding,
    negligible_hop,
    pair_in_contact,
)
from engine._jit import kernel
from engine._motion import (
    advance,
    cushion_gap,
    predict_cushion,
    predict_motion,
    rolling_resistance,
    speed_of,
)
from engine._state import FREE, OWN_CONTACT, OWN_REST, Balls, Contacts, Laws
from engine._tolerances import APPROACH_ROUNDING

_SWEEPS = 100
"""Most Gauss-Seidel sweeps; where they don't do, the step is halved, which always does in the end:
a gap can't open or close by more than the tolerance in a step that is short enough."""

_HALVINGS = 100
"""Most halvings of a step. 60 shorten it below any clock's resolution, so more are never needed."""

_TURN = 0.125
"""Largest change of a ball's velocity in a step, in units of its speed."""

_RESIDUE = 2.0**-20
"""Hop, in units of a negligible one, left to the contact force: a thousandth of its speed."""

_FIRST_STEP = 2.0**-6
"""First step tried, in units of the time to fall one diameter at the rolling deceleration."""


@kernel
def release(balls: Balls, laws: Laws, contacts: Contacts, i: int, t: float) -> None:
    """Take the contact forces off every ball of i's cluster at the instant t [s].

    Contract: all of them are advanced to t, predicted anew and marked in `contacts.changed`.
    """
    label = contacts.cluster[i]
    if label == FREE:
        return
    for k in range(len(balls.x)):
        if contacts.cluster[k] == label:
            contacts.cluster[k] = FREE
            for other in range(len(balls.x)):
                contacts.held[k, other] = False
                contacts.held[other, k] = False
            advance(balls, k, t)
            predict_motion(balls, k, laws)
            contacts.changed[k] = True


@kernel
def press(balls: Balls, laws: Laws, contacts: Contacts, i: int, j: int, t: float) -> None:
    """Start a contact step, at the instant t [s], for the cluster that the pair i, j belongs to.

    Contract: every member is advanced to t, given its acceleration and an own event no later than
    the step's end, and marked in `contacts.changed`. No allocation: `contacts` has room.
    """
    members = _gather_members(balls, laws, contacts, i, j, t)
    count = _gather_contacts(balls, laws, contacts, members, t)
    _stop_approach(balls, laws, contacts, count)
    step = _next_step(balls, laws, contacts, members)
    duration = min(step, _time_to_stop(balls, laws, contacts, members))
    for _ in range(_HALVINGS):
        if _solve(balls, laws, contacts, members, count, duration):
            break
        duration *= 0.5
        step = duration
    for m in range(members):
        k = contacts.member[m]
        speed = speed_of(balls.vx[k], balls.vy[k])
        rests = 0.0 < speed <= duration * laws.deceleration
        balls.ax[k] = contacts.ax[k]
        balls.ay[k] = contacts.ay[k]
        balls.own_kind[k] = OWN_REST if rests else OWN_CONTACT
        predict_cushion(balls, k, laws, duration, True)
        contacts.step[k] = step
        contacts.changed[k] = True


@kernel
def _gather_members(balls: Balls, laws: Laws, contacts: Contacts, i: int, j: int, t: float) -> int:
    """List the pair and all balls in contact with a listed one; return how many."""
    release(balls, laws, contacts, i, t)
    release(balls, laws, contacts, j, t)
    contacts.member[0] = i
    contacts.member[1] = j
    members, m = 2, 0
    _join(balls, laws, contacts, i, i, t)
    _join(balls, laws, contacts, j, i, t)
    while m < members:
        k = contacts.member[m]
        for other in range(len(balls.x)):
            if contacts.cluster[other] == i:
                continue
            if pair_in_contact(balls, k, other, t, laws.deceleration):
                release(balls, laws, contacts, other, t)
                _join(balls, laws, contacts, other, i, t)
                contacts.member[members] = other
                members += 1
        m += 1
    return members


@kernel
def _join(balls: Balls, laws: Laws, contacts: Contacts, k: int, label: int, t: float) -> None:
    advance(balls, k, t)
    predict_motion(balls, k, laws)
    contacts.cluster[k] = label
    contacts.changed[k] = True


@kernel
def _gather_contacts(balls: Balls, laws: Laws, contacts: Contacts, members: int, t: float) -> int:
    """List the contacts of the members with each other and with cushions; return how many."""
    count = 0
    for m in range(members):
        k = contacts.member[m]
        for other in range(m + 1, members):
            j = contacts.member[other]
            seed = m == 0 and other == 1
            if seed or pair_in_contact(balls, k, j, t, laws.deceleration):
                contacts.first[count] = k
                contacts.second[count] = j
                contacts.held[k, j] = True
                contacts.held[j, k] = True
                count += 1
        for cushion in range(4):
            gap, rate, _ = cushion_gap(balls, k, laws, cushion)
            if cushion_in_contact(balls, k, gap, rate, laws.deceleration):
                contacts.first[count] = k
                contacts.second[count] = -1 - cushion
                count += 1
    return count


@kernel
def _stop_approach(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> None:
    """Take away what approach is left at the contacts, plastically: each is a negligible hop.

    A ball at rest stays so, since the cloth would stop it again within the tolerance; unless that
    doesn't do, as for a ball that others drive like a wedge.
    """
    for sweep in range(_SWEEPS):
        firm = sweep < _SWEEPS // 2
        approaching = False
        for c in range(count):
            a, b = contacts.first[c], contacts.second[c]
            nx, ny, _, _ = _gap_after(balls, laws, contacts, c, 0.0)
            rate = -(nx * balls.vx[a] + ny * balls.vy[a])
            size = abs(balls.vx[a]) + abs(balls.vy[a])
            share = 1.0  # of the change of rate, that ball a takes
            if b >= 0:
                rate += nx * balls.vx[b] + ny * balls.vy[b]
                if firm and _at_rest(balls, a):
                    share = 0.0
                elif not (firm and _at_rest(balls, b)):
                    share = balls.mass[b] / (balls.mass[a] + balls.mass[b])
                size += abs(balls.vx[b]) + abs(balls.vy[b])
            radius = balls.radius[a]
            if rate >= -APPROACH_ROUNDING * size:
                continue
            if negligible_hop(rate, laws.deceleration, _RESIDUE * radius):
                continue
            approaching = True
            balls.vx[a] += share * rate * nx
            balls.vy[a] += share * rate * ny
            if b >= 0:
                balls.vx[b] -= (1.0 - share) * rate * nx
                balls.vy[b] -= (1.0 - share) * rate * ny
        if not approaching:
            return


@kernel
def _at_rest(balls: Balls, k: int) -> bool:
    return bool(balls.vx[k] == 0.0 and balls.vy[k] == 0.0)


@kernel
def _next_step(balls: Balls, laws: Laws, contacts: Contacts, members: int) -> float:
    """Return the step to try [s]: twice what the members' last one was good for."""
    step = math.inf
    for m in range(members):
        k = contacts.member[m]
        if contacts.step[k] > 0.0:
            step = min(step, 2.0 * contacts.step[k])
        else:
            fall = math.sqrt(2.0 * balls.radius[k] / laws.deceleration)
            step = min(step, _FIRST_STEP * fall)
    return step


@kernel
def _time_to_stop(balls: Balls, laws: Laws, contacts: Contacts, members: int) -> float:
    """Return how long a step may be without a member stopping within it [s]."""
    longest = math.inf
    for m in range(members):
        k = contacts.member[m]
        speed = speed_of(balls.vx[k], balls.vy[k])
        if speed > 0.0:
            limit = speed / laws.deceleration
            if not _stopping(balls, laws, k, speed):
                limit *= 0.5  # one that stops within the tolerance is let come to rest
            longest = min(longest, limit)
    return longest


@kernel
def _solve(
    balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int, duration: float
) -> bool:
    """Find forces that close every gap at the end of a step; False where the step is too long.

    Complementarity: a force is never negative, and is 0 where the gap opens.
    """
    for m in range(members):
        k = contacts.member[m]
        contacts.fx[k] = 0.0
        contacts.fy[k] = 0.0
        contacts.ax[k], contacts.ay[k] = balls.ax[k], balls.ay[k]
        _accelerate(balls, laws, contacts, k, duration)
    for c in range(count):
        nx, ny, _, _ = _gap_after(balls, laws, contacts, c, 0.5 * duration)
        contacts.nx[c] = nx
        contacts.ny[c] = ny
        contacts.force[c] = 0.0
    for _ in range(_SWEEPS):
        if _settled(balls, laws, contacts, count, duration):
            return _stays_closed(balls, laws, contacts, count, duration) and _turns_little(
                balls, laws, contacts, members, duration
            )
        for c in range(count):
            a, b = contacts.first[c], contacts.second[c]
            mass = balls.mass[a]
            if b >= 0:
                mass *= balls.mass[b] / (balls.mass[a] + balls.mass[b])
            excess = _excess(balls, laws, contacts, c, duration)
            force = contacts.force[c]
            change = max(-force, -2.0 * mass * excess / (duration * duration))
            contacts.force[c] = force + change
            contacts.fx[a] -= change * contacts.nx[c]
            contacts.fy[a] -= change * contacts.ny[c]
            _accelerate(balls, laws, contacts, a, duration)
            if b >= 0:
                contacts.fx[b] += change * contacts.nx[c]
                contacts.fy[b] += change * contacts.ny[c]
                _accelerate(balls, laws, contacts, b, duration)
    return False


@kernel
def _excess(balls: Balls, laws: Laws, contacts: Contacts, c: int, duration: float) -> float:
    """How far the gap of contact c [m] ends above what the step aims at.

    That is a closed gap; but an overlap left by rounding or by an earlier step is not pushed apart
    faster than friction would do it.
    """
    _, _, now, _ = _gap_after(balls, laws, contacts, c, 0.0)
    _, _, then, _ = _gap_after(balls, laws, contacts, c, duration)
    return then - min(0.0, now + 0.25 * laws.deceleration * duration * duration)


@kernel
def _settled(balls: Balls, laws: Laws, contacts: Contacts, count: int, duration: float) -> bool:
    """Whether every force holds its gap as the step aims at, and no gap without force closes."""
    for c in range(count):
        _, _, now, reach = _gap_after(balls, laws, contacts, c, 0.0)
        tolerance = contact_tolerance(balls, contacts.first[c], reach)
        # The deeper it already is, the less it may deepen: many steps must not add up.
        slack = 0.125 * (tolerance + min(0.0, max(-tolerance, now)))
        slack = max(slack, gap_rounding(balls, contacts.first[c]))
        excess = _excess(balls, laws, contacts, c, duration)
        if (contacts.force[c] > 0.0 or excess < 0.0) and abs(excess) > slack:
            return False
    return True


@kernel
def _stays_closed(
    balls: Balls, laws: Laws, contacts: Contacts, count: int, duration: float
) -> bool:
    """Whether no gap leaves the tolerance within the step; it leaves most about the middle."""
    for c in range(count):
        for part in (0.5, 0.6875):
            _, _, gap, reach = _gap_after(balls, laws, contacts, c, part * duration)
            _, _, now, _ = _gap_after(balls, laws, contacts, c, 0.0)
            allowed = contact_tolerance(balls, contacts.first[c], reach)
            allowed = max(allowed, gap_rounding(balls, contacts.first[c]) - now)
            if gap < -allowed or (contacts.force[c] > 0.0 and gap > allowed):
                return False
    return True


@kernel
def _turns_little(
    balls: Balls, laws: Laws, contacts: Contacts, members: int, duration: float
) -> bool:
    """Whether no member's velocity changes so much that friction would turn with it."""
    for m in range(members):
        k = contacts.member[m]
        speed = speed_of(balls.vx[k], balls.vy[k])
        change = duration * speed_of(contacts.ax[k], contacts.ay[k])
        if change > _TURN * speed and not _stopping(balls, laws, k, speed):
            return False
    return True


@kernel
def _stopping(balls: Balls, laws: Laws, k: int, speed: float) -> bool:
    """Whether the cloth would stop member k within the tolerance of its distance; or has."""
    tolerance = contact_tolerance(balls, k, 2.0 * balls.radius[k])
    return speed * speed <= 2.0 * laws.deceleration * tolerance


@kernel
def _accelerate(balls: Balls, laws: Laws, contacts: Contacts, k: int, duration: float) -> None:
    """Set member k's acceleration: its contact forces, and friction at the middle of the step."""
    fx, fy = contacts.fx[k] / balls.mass[k], contacts.fy[k] / balls.mass[k]
    vx, vy = balls.vx[k], balls.vy[k]
    if _at_rest(balls, k):
        # At rest, the cloth resists a push of up to mu m g.
        push = speed_of(fx, fy)
        left = 1.0 - laws.deceleration / push if push > laws.deceleration else 0.0
        contacts.ax[k] = left * fx
        contacts.ay[k] = left * fy
        return
    mid_x = vx + 0.5 * duration * contacts.ax[k]
    mid_y = vy + 0.5 * duration * contacts.ay[k]
    rx, ry = rolling_resistance(mid_x, mid_y, laws.deceleration)
    contacts.ax[k] = rx + fx
    contacts.ay[k] = ry + fy


@kernel
def _gap_after(
    balls: Balls, laws: Laws, contacts: Contacts, c: int, s: float
) -> tuple[float, float, float, float]:
    """Return contact c's normal (outward from its first member), gap and reach, in s seconds."""
    a, b = contacts.first[c], contacts.second[c]
    xa = balls.x[a] + s * (balls.vx[a] + 0.5 * s * contacts.ax[a])
    ya = balls.y[a] + s * (balls.vy[a] + 0.5 * s * contacts.ay[a])
    radius = balls.radius[a]
    if b >= 0:
        rx = balls.x[b] + s * (balls.vx[b] + 0.5 * s * contacts.ax[b]) - xa
        ry = balls.y[b] + s * (balls.vy[b] + 0.5 * s * contacts.ay[b]) - ya
        reach = radius + balls.radius[b]
        distance = math.sqrt(rx * rx + ry * ry)
        return rx / distance, ry / distance, distance - reach, reach
    if b == -1:
        return -1.0, 0.0, (xa - laws.left) - radius, 2.0 * radius
    if b == -2:
        return 1.0, 0.0, (laws.right - xa) - radius, 2.0 * radius
    if b == -3:
        return 0.0, -1.0, (ya - laws.bottom) - radius, 2.0 * radius
    return 0.0, 1.0, (laws.top - ya) - radius, 2.0 * radius

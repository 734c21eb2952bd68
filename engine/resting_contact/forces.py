"""The forces that hold a cluster's gaps closed over one contact step; `step` has the whole.

Between the members and with cushions; how a member's cloth answers is in
`resting_contact.cloth_response`.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ALONG,
    DEEP,
    FIRST,
    FORCE,
    LOAD_X,
    LOAD_Y,
    MOST_OBSTACLES,
    NEW_AX,
    NEW_AY,
    NEW_BX,
    NEW_BY,
    NOWHERE,
    NX,
    NY,
    SECOND,
    SLIDING,
    TWIST_X,
    TWIST_Y,
    TWIST_Z,
    UP,
    YIELD,
    Balls,
    Contacts,
    Laws,
)
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.motion.geometry import (
    contact_tolerance,
    gap_rounding,
    grip,
    reduced_mass,
)
from ghostball.engine.motion.obstacles import facing
from ghostball.engine.motion.pieces import way
from ghostball.engine.resting_contact.cloth_response import (
    accelerate,
    slack,
    stopping,
    turns_little,
)

SWEEPS = 200
"""Most Gauss-Seidel sweeps; where they don't do, the step is halved: in a short one, gaps hardly
change, and little is left to solve."""

_SHARE = 0.25
"""Part of its answer that a member counts with while the cloth holds it, in case it gives way."""

_DEEP = 0.75
"""Overlap, in tolerances, from which two balls at rest are pushed apart, gently."""

_WITHIN = 29.0 / 32.0
"""Part of the tolerance that a gap may reach where it is looked at, each eighth of the step: a
cubic that is closed at the end goes at most 6.8 % beyond the largest of what it has there."""


@kernel
def solve(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    members: int,
    count: int,
    duration: float,
    rubs: bool,
) -> bool:
    """Find forces that close every gap at the end of a step; False where the step is too long.

    Complementarity: a force is never negative, and is 0 where the gap opens. Friction follows it,
    unless the contacts don't rub.
    """
    for m in range(members):
        k = contacts.member[m]
        for row in (LOAD_X, LOAD_Y, TWIST_X, TWIST_Y, TWIST_Z, NEW_BX, NEW_BY):
            contacts.motion[k, row] = 0.0
        contacts.motion[k, NEW_AX] = balls.state[k].ax
        contacts.motion[k, NEW_AY] = balls.state[k].ay
        accelerate(balls, laws, contacts, k, duration)
    for c in range(count):
        nx, ny, _ = gap_after(balls, laws, contacts, c, 0.5 * duration)
        contacts.forces[c, NX] = nx
        contacts.forces[c, NY] = ny
        # The last step's force is the first guess.
        _, place = _place(contacts, c)
        force = contacts.pressure[place]
        contacts.forces[c, FORCE] = force
        contacts.forces[c, ALONG] = 0.0
        contacts.forces[c, UP] = 0.0
        _load(contacts, contacts.ends[c, FIRST], contacts.ends[c, SECOND], force * nx, force * ny)
    # No friction is in the first guess: that normal forces have settled is not enough.
    steady = False
    for sweep in range(SWEEPS):
        # The forces of the last sweep turn the velocities at mid-step, and so the friction there.
        for m in range(members):
            accelerate(balls, laws, contacts, contacts.member[m], duration)
        if steady and _settled(balls, laws, contacts, count, duration):
            _keep_pressures(contacts, count)
            _mark_deep(balls, laws, contacts, members, count)
            return _is_short(balls, laws, contacts, members, count, duration)
        steady = True
        for place in range(count):
            # To and fro, so that a push runs down a whole line of balls in a sweep, and back.
            c = place if sweep % 2 == 0 else count - 1 - place
            _hold(balls, laws, contacts, c, duration)
            change = _rub(balls, laws, contacts, c, duration) if rubs else 0.0
            a, b = _ends(contacts, c)
            moved = duration * duration * change / _mass(balls, contacts, c)
            steady = steady and moved <= slack(balls, a, b, duration)
    return False


@kernel
def _place(contacts: Contacts, c: int) -> tuple[int, int]:
    """Return the key of contact c, and where in the hash table it stands, or would."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    n, size = len(contacts.cluster), len(contacts.pressed) - 1
    width = n + MOST_OBSTACLES
    key = min(a, b) * width + max(a, b) if b >= 0 else a * width + n - 1 - b
    place = 1 + key % size
    while contacts.pressed[place] != key and contacts.pressed[place] != NOWHERE:
        place = 1 + place % size
    return key, place


@kernel
def _keep_pressures(contacts: Contacts, count: int) -> None:
    """Keep the force of each contact, as a first guess for its next step.

    Where a long run has had more contacts than the table is made for, all guesses are forgotten.
    """
    for c in range(count):
        force = contacts.forces[c, FORCE]
        key, place = _place(contacts, c)
        if contacts.pressed[place] == NOWHERE and force > 0.0:
            if 4 * contacts.pressed[0] > 3 * len(contacts.pressed):
                contacts.pressed[1:] = NOWHERE
                contacts.pressed[0] = 0
                contacts.pressure[:] = 0.0
                key, place = _place(contacts, c)
            contacts.pressed[place] = key
            contacts.pressed[0] += 1
        if contacts.pressed[place] == key:
            contacts.pressure[place] = force


@kernel
def _mark_deep(balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int) -> None:
    for m in range(members):
        contacts.motion[contacts.member[m], DEEP] = 0.0
    for c in range(count):
        a, b = _ends(contacts, c)
        _, _, now = gap_after(balls, laws, contacts, c, 0.0)
        if now < -_DEEP * contact_tolerance(balls, a, b):
            contacts.motion[a, DEEP] = 1.0
            contacts.motion[b, DEEP] = 1.0


@kernel
def _hold(balls: Balls, laws: Laws, contacts: Contacts, c: int, duration: float) -> None:
    """Change the normal force of contact c so that its gap ends where the step aims at."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    excess = _excess(balls, laws, contacts, c, duration)
    force = contacts.forces[c, FORCE]
    answer = _yield(contacts, c)
    if answer > 0.0:
        # A member that the cloth holds may give way: with a part of its answer then.
        if contacts.motion[a, YIELD] == 0.0:
            answer += _SHARE / balls.state[a].mass
        if b >= 0 and contacts.motion[b, YIELD] == 0.0:
            answer += _SHARE / balls.state[b].mass
        change = max(-force, -2.0 * excess / (answer * duration * duration))
    elif excess > 0.0:
        change = -force
    else:
        return  # no force moves two that the cloth holds
    contacts.forces[c, FORCE] = force + change
    _load(contacts, a, b, change * contacts.forces[c, NX], change * contacts.forces[c, NY])
    accelerate(balls, laws, contacts, a, duration)
    if b >= 0:
        accelerate(balls, laws, contacts, b, duration)


@kernel
def _load(contacts: Contacts, a: int, b: int, fx: float, fy: float) -> None:
    """Add a force to ball b, unless it is a cushion, and its opposite to ball a [N]."""
    contacts.motion[a, LOAD_X] -= fx
    contacts.motion[a, LOAD_Y] -= fy
    if b >= 0:
        contacts.motion[b, LOAD_X] += fx
        contacts.motion[b, LOAD_Y] += fy


@kernel
def _yield(contacts: Contacts, c: int) -> float:
    """Acceleration of the gap of contact c over its force [1/kg], as the members answer now."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    both: float = contacts.motion[a, YIELD]
    if b >= 0:
        both += contacts.motion[b, YIELD]
    return both


@kernel
def _mass(balls: Balls, contacts: Contacts, c: int) -> float:
    """Reduced mass of contact c [kg]; a cushion's is infinite."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    mass: float = balls.state[a].mass
    return reduced_mass(mass, balls.state[b].mass) if b >= 0 else mass


@kernel
def _rub(balls: Balls, laws: Laws, contacts: Contacts, c: int, duration: float) -> float:
    """Give contact c the friction of its normal force; return the change [N].

    What leaves no slip of the surfaces at the step's end, but for what the cloth takes of the spin
    about the vertical, if that is within Coulomb's limit; else the limit, against the slip at
    mid-step, or less where that ends it. Reached by projection: to set the direction from the last
    sweep's slip went round in circles where slip is small. A cushion rubs at the height of the
    ball's centre.
    """
    if not laws.slides:
        return 0.0
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    if b < 0 and not laws.cushion_turns:
        return 0.0
    along, up, change_along, change_up = _slip(balls, contacts, c)
    coefficient = laws.cushion_friction
    if b >= 0:
        coefficient = friction_coefficient(laws, math.sqrt(along * along + up * up))
    if coefficient == 0.0:
        return 0.0
    limit = coefficient * contacts.forces[c, FORCE]
    gain = _mass(balls, contacts, c) / (3.5 * duration)
    new_along = contacts.forces[c, ALONG] + gain * (along + duration * change_along)
    new_up = contacts.forces[c, UP] + gain * (up + duration * change_up)
    if not _within(new_along, new_up, limit):
        new_along = contacts.forces[c, ALONG] + gain * (2.0 * along + duration * change_along)
        new_up = contacts.forces[c, UP] + gain * (2.0 * up + duration * change_up)
        if not _within(new_along, new_up, limit):
            size = math.sqrt(new_along * new_along + new_up * new_up)
            new_along, new_up = limit * (new_along / size), limit * (new_up / size)
    more_along = new_along - contacts.forces[c, ALONG]
    more_up = new_up - contacts.forces[c, UP]
    contacts.forces[c, ALONG] = new_along
    contacts.forces[c, UP] = new_up
    tx, ty = -contacts.forces[c, NY], contacts.forces[c, NX]
    _load(contacts, a, b, more_along * tx, more_along * ty)
    for k in (a, b):
        if k >= 0:
            contacts.motion[k, TWIST_X] += more_up * tx
            contacts.motion[k, TWIST_Y] += more_up * ty
            contacts.motion[k, TWIST_Z] -= more_along
            accelerate(balls, laws, contacts, k, duration)
    change: float = abs(more_along) + abs(more_up)
    return change


@kernel
def _within(x: float, y: float, limit: float) -> bool:
    return x * x + y * y <= limit * limit


@kernel
def _slip(balls: Balls, contacts: Contacts, c: int) -> tuple[float, float, float, float]:
    """Velocity of a's surface over the other's [m/s], along and up; and how both change [m/s^2]."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    along, up, change_along, change_up = _surface(balls, contacts, c, a)
    if b >= 0:
        # Its surface is on the other side of its centre.
        b_along, b_up, b_change_along, b_change_up = _surface(balls, contacts, c, b)
        vx, vy = balls.state[b].vx, balls.state[b].vy
        ax, ay = contacts.motion[b, NEW_AX], contacts.motion[b, NEW_AY]
        nx, ny = contacts.forces[c, NX], contacts.forces[c, NY]
        along += b_along - 2.0 * (nx * vy - ny * vx)
        up += b_up
        change_along += b_change_along - 2.0 * (nx * ay - ny * ax)
        change_up += b_change_up
    return along, up, change_along, change_up


@kernel
def _surface(balls: Balls, contacts: Contacts, c: int, k: int) -> tuple[float, float, float, float]:
    """Velocity of ball k's surface where it faces along the normal of contact c; and its change."""
    nx, ny = contacts.forces[c, NX], contacts.forces[c, NY]
    radius = balls.state[k].radius
    wx, wy = balls.state[k].wx, balls.state[k].wy
    if balls.state[k].phase != SLIDING:
        wx, wy = -balls.state[k].vy / radius, balls.state[k].vx / radius
    along = nx * balls.state[k].vy - ny * balls.state[k].vx + radius * balls.state[k].wz
    up = -radius * (nx * wy - ny * wx)
    twist = 2.5 * contacts.motion[k, TWIST_Z] / balls.state[k].mass
    change_along = nx * contacts.motion[k, NEW_AY] - ny * contacts.motion[k, NEW_AX] + twist
    change_up = -radius * (nx * contacts.motion[k, NEW_BY] - ny * contacts.motion[k, NEW_BX])
    return along, up, change_along, change_up


@kernel
def _aim(balls: Balls, a: int, b: int, now: float, duration: float) -> float:
    """Return the gap [m] that a step aims at, between members a and b, or a and a cushion: b is a.

    A closed one; but an overlap left by rounding or by an earlier step is not pushed apart faster
    than friction would do it. Between two balls that the cloth brings to rest it is the gap that
    there is: one of them had else to creep until the next is pushed.
    """
    tolerance = contact_tolerance(balls, a, b)
    push = 0.25 * max(grip(balls, a), grip(balls, b)) * duration * duration
    if stopping(balls, a) and stopping(balls, b):
        if now >= -_DEEP * tolerance:
            return min(now, 0.5 * tolerance)
        return now + max(min(push, 0.25 * tolerance), 2.0 * gap_rounding(balls, a, b))
    return min(0.0, now + push)


@kernel
def _excess(balls: Balls, laws: Laws, contacts: Contacts, c: int, duration: float) -> float:
    """Return how far the gap of contact c [m] ends above what the step aims at."""
    a, b = _ends(contacts, c)
    _, _, now = gap_after(balls, laws, contacts, c, 0.0)
    _, _, then = gap_after(balls, laws, contacts, c, duration)
    return then - _aim(balls, a, b, now, duration)


@kernel
def _settled(balls: Balls, laws: Laws, contacts: Contacts, count: int, duration: float) -> bool:
    """Whether every force holds its gap as the step aims at, and no gap without force closes."""
    for c in range(count):
        _, _, now = gap_after(balls, laws, contacts, c, 0.0)
        a, b = _ends(contacts, c)
        tolerance = contact_tolerance(balls, a, b)
        # The deeper it already is, the less it may deepen: many steps must not add up.
        share = 1.0 + min(0.0, max(-1.0, now / tolerance))
        left = max(share * slack(balls, a, b, duration), gap_rounding(balls, a, b))
        excess = _excess(balls, laws, contacts, c, duration)
        if _yield(contacts, c) == 0.0 and excess < 0.0:
            # An overlap between two that the cloth holds, which no force pushes apart.
            excess = min(0.0, excess + _aim(balls, a, b, now, duration) - now)
        if (contacts.forces[c, FORCE] > 0.0 or excess < 0.0) and abs(excess) > left:
            return False
    return True


@kernel
def _stays_closed(
    balls: Balls, laws: Laws, contacts: Contacts, count: int, duration: float
) -> bool:
    """Whether no gap leaves the tolerance within the step.

    Looked at seven times. A step is so short that a gap is all but a cubic of time, closed at the
    end; where it is deepest depends on whether it opens first. A cubic that is within `_WITHIN` of
    the tolerance at these places, and at the start, is within it everywhere. Of a contact that
    doesn't push, which opens, the way out has no bound.
    """
    for c in range(count):
        a, b = _ends(contacts, c)
        _, _, now = gap_after(balls, laws, contacts, c, 0.0)
        tolerance = _WITHIN * contact_tolerance(balls, a, b)
        allowed = max(tolerance, gap_rounding(balls, a, b) - now)
        for part in range(1, 8):
            _, _, gap = gap_after(balls, laws, contacts, c, 0.125 * part * duration)
            if gap < -allowed or (contacts.forces[c, FORCE] > 0.0 and gap > max(allowed, now)):
                return False
    return True


@kernel
def _is_short(
    balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int, duration: float
) -> bool:
    """Whether no gap leaves the tolerance within the step, and friction keeps its directions."""
    if not _stays_closed(balls, laws, contacts, count, duration):
        return False
    for m in range(members):  # noqa: SIM110 - the compiler takes no generator
        if not turns_little(balls, contacts, contacts.member[m], duration):
            return False
    return True


@kernel
def _ends(contacts: Contacts, c: int) -> tuple[int, int]:
    """Return the balls of contact c; for a cushion, the ball twice."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    return a, b if b >= 0 else a


@kernel
def gap_after(
    balls: Balls, laws: Laws, contacts: Contacts, c: int, s: float
) -> tuple[float, float, float]:
    """Return contact c's normal (outward from its first member) and its gap, in s seconds."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    xa, ya = _place_after(balls, contacts, a, s)
    radius = balls.state[a].radius
    if b >= 0:
        xb, yb = _place_after(balls, contacts, b, s)
        rx, ry = xb - xa, yb - ya
        distance = math.sqrt(rx * rx + ry * ry)
        return rx / distance, ry / distance, distance - (radius + balls.state[b].radius)
    cushion = -1 - b
    nx, ny, distance = facing(laws, cushion, xa, ya)
    return -nx, -ny, distance - radius


@kernel(inline=True)
def _place_after(balls: Balls, contacts: Contacts, k: int, s: float) -> tuple[float, float]:
    """Return where ball k comes in s seconds by the acceleration that the step gives it [m]."""
    ball, new = balls.state[k], contacts.motion
    return (
        ball.x + way(ball.vx, new[k, NEW_AX], s),
        ball.y + way(ball.vy, new[k, NEW_AY], s),
    )

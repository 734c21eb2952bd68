"""Impacts at one instant that share a ball, resolved together.

One after the other, in whatever order, a hit on two touching balls would favour one of them. So all
contacts of the group act at once.

The normal impulses are (1 + e) times those that would just end every approach, e the restitution
(Moreau 1988). For e = 1 that is one generalised reflection of Smith, Kaufman, Vouga, Tamstorf and
Grinspun (2012, section 4): energy is kept, nothing approaches, and what the impulses make approach
next, as in a cradle, is the next impact of the same instant. So balls that touch answer like balls
with vanishing gaps, except where impacts truly coincide.

Friction acts against the mean of the slips before and after the normal impulses, which reverse it
where they throw a ball back. The normal impulses are then found again, so that every contact parts
at e times its approach, friction included: what friction does against that mean is then all that
it changes of the energy, and a loss. It is found with every ball split among its contacts (mass
splitting: Tonge, Benevolenski and Voroshilov 2012): each contact sees its part of the mass, all act
on the same state, and the parts are averaged. All contacts are treated alike, and every sum over
them is taken in an order of its own terms, so that the result has the symmetry of the scene to the
last bit, and doesn't depend on the order of the balls.

A group's friction is Coulomb's, whatever the scene's law for two balls. Each group is counted in
`work["joint_impacts"]`.
"""

from __future__ import annotations

import math

from engine._geometry import reduced_mass
from engine._impact import contact_normal
from engine._jit import kernel
from engine._motion import loosen
from engine._state import (
    ACTIVE,
    DEGREE,
    DIRECTION,
    FIRST,
    FORCE,
    LEFT_OVER,
    MASS,
    NX,
    NY,
    PRODUCT,
    PUSH_X,
    PUSH_Y,
    RADIUS,
    RATE,
    SCALED,
    SECOND,
    TERM,
    TURN_X,
    TURN_Y,
    TURN_Z,
    VX,
    VY,
    WX,
    WY,
    WZ,
    Balls,
    Contacts,
    Laws,
)
from engine._tolerances import EPS
from engine.impact_laws.friction_curve import friction_coefficient

_ROUNDS = 32
"""Most choices of the contacts that have to push; two or three do."""

_STEPS_PER_CONTACT = 4
"""Most steps of conjugate gradients, in units of the contacts; one each does but for rounding."""

_RESIDUE = 64.0 * EPS
"""Approach, in units of the fastest, that rounding may leave a contact that doesn't push."""


@kernel
def collide_together(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> bool:
    """Resolve the first `count` contacts of `contacts.ends` together; False where some approach on.

    Contract: all their balls are advanced to the instant of the impact, all contacts approach, and
    `contacts.motion[DEGREE]` holds how many of the contacts each ball has.
    """
    if laws.slides:
        for k in range(len(balls.own_kind)):
            if contacts.motion[DEGREE, k] > 0.0:
                loosen(balls, k)  # before anything asks how it turns
    for c in range(count):
        nx, ny = contact_normal(balls, contacts.ends[FIRST, c], contacts.ends[SECOND, c])
        contacts.forces[NX, c] = nx
        contacts.forces[NY, c] = ny
        contacts.forces[FORCE, c] = 0.0
        contacts.forces[RATE, c] = _rate(balls, contacts, c)
    solved = _end_approach(balls, contacts, count)
    restitution = laws.ball_restitution
    _scale(contacts, count, 1.0 + restitution)
    if laws.slides and (laws.speed_dependent or laws.ball_friction > 0.0):
        _find_friction(balls, laws, contacts, count)
        _push(balls, contacts, count)
        _turn(balls, contacts, count)
        for c in range(count):
            before = contacts.forces[RATE, c]
            contacts.forces[RATE, c] = _rate(balls, contacts, c) + restitution * before
        solved = _end_approach(balls, contacts, count) and solved
    _push(balls, contacts, count)
    return solved


@kernel
def _scale(contacts: Contacts, count: int, factor: float) -> None:
    """Multiply all impulses along the normals."""
    for c in range(count):
        contacts.forces[FORCE, c] *= factor
        contacts.forces[PUSH_X, c] *= factor
        contacts.forces[PUSH_Y, c] *= factor


@kernel
def _rate(balls: Balls, contacts: Contacts, c: int) -> float:
    """Rate of the gap of contact c [m/s]: negative where the balls approach."""
    a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
    vx, vy = balls.state[VX, b] - balls.state[VX, a], balls.state[VY, b] - balls.state[VY, a]
    rate: float = contacts.forces[NX, c] * vx + contacts.forces[NY, c] * vy
    return rate


@kernel
def _split_mass(balls: Balls, contacts: Contacts, c: int) -> float:
    """Reduced mass [kg] of contact c, of those parts of its two balls that are its own."""
    a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
    part_a = balls.state[MASS, a] / contacts.motion[DEGREE, a]
    part_b = balls.state[MASS, b] / contacts.motion[DEGREE, b]
    return reduced_mass(part_a, part_b)


@kernel
def _end_approach(balls: Balls, contacts: Contacts, count: int) -> bool:
    """Find the impulses [N s] after which no contact approaches, and none where one parts.

    In FORCE their sizes, in PUSH_X and PUSH_Y the vectors, on the second ball of each contact.
    Contacts that would have to pull are left out, and come back if they approach without. False
    where no choice of them did; none such has been seen.
    """
    fastest = 0.0
    for c in range(count):
        contacts.forces[ACTIVE, c] = 1.0
        fastest = max(fastest, -contacts.forces[RATE, c])
    for _ in range(_ROUNDS):
        _end_active_approach(balls, contacts, count, fastest)
        changed = False
        for c in range(count):
            if contacts.forces[FORCE, c] < 0.0:
                contacts.forces[ACTIVE, c] = 0.0
                changed = True
        if not changed:
            _apply(balls, contacts, count, FORCE, PRODUCT)
            for c in range(count):
                left = contacts.forces[RATE, c] + contacts.forces[PRODUCT, c]
                if contacts.forces[ACTIVE, c] == 0.0 and left < -_RESIDUE * fastest:
                    contacts.forces[ACTIVE, c] = 1.0
                    changed = True
        if not changed:
            return True
    for c in range(count):
        contacts.forces[FORCE, c] = max(0.0, contacts.forces[FORCE, c])
    _apply(balls, contacts, count, FORCE, PRODUCT)
    return False


@kernel
def _end_active_approach(balls: Balls, contacts: Contacts, count: int, fastest: float) -> None:
    """Find in FORCE the impulses that end the approach of just the active contacts.

    Conjugate gradients (Hestenes and Stiefel 1952), scaled by each contact's own mass: few steps
    whatever the masses, and the same arithmetic for every contact.
    """
    for c in range(count):
        active = contacts.forces[ACTIVE, c]
        contacts.forces[FORCE, c] = 0.0
        contacts.forces[LEFT_OVER, c] = -active * contacts.forces[RATE, c]
        scaled = _reduced_mass(balls, contacts, c) * contacts.forces[LEFT_OVER, c]
        contacts.forces[SCALED, c] = scaled
        contacts.forces[DIRECTION, c] = scaled
    gain = _dot(contacts, count, LEFT_OVER, SCALED)
    for _ in range(_STEPS_PER_CONTACT * count):
        _apply(balls, contacts, count, DIRECTION, PRODUCT)
        curvature = _dot(contacts, count, DIRECTION, PRODUCT)
        if not curvature > 0.0:
            return
        step = gain / curvature
        worst = 0.0
        for c in range(count):
            if contacts.forces[ACTIVE, c] == 1.0:
                contacts.forces[FORCE, c] += step * contacts.forces[DIRECTION, c]
                contacts.forces[LEFT_OVER, c] -= step * contacts.forces[PRODUCT, c]
                worst = max(worst, abs(contacts.forces[LEFT_OVER, c]))
        if worst <= EPS * fastest:
            return
        for c in range(count):
            mass = _reduced_mass(balls, contacts, c)
            contacts.forces[SCALED, c] = mass * contacts.forces[LEFT_OVER, c]
        previous, gain = gain, _dot(contacts, count, LEFT_OVER, SCALED)
        for c in range(count):
            onward = gain / previous * contacts.forces[DIRECTION, c]
            contacts.forces[DIRECTION, c] = contacts.forces[SCALED, c] + onward


@kernel
def _apply(balls: Balls, contacts: Contacts, count: int, row: int, result: int) -> None:
    """Put in `result` how impulses in `row` change each contact's rate; their vectors in PUSH_*."""
    for c in range(count):
        contacts.forces[PUSH_X, c] = contacts.forces[row, c] * contacts.forces[NX, c]
        contacts.forces[PUSH_Y, c] = contacts.forces[row, c] * contacts.forces[NY, c]
    for c in range(count):
        a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
        gained_x = _gained(balls, contacts, count, b, PUSH_X)
        gained_y = _gained(balls, contacts, count, b, PUSH_Y)
        gained_x -= _gained(balls, contacts, count, a, PUSH_X)
        gained_y -= _gained(balls, contacts, count, a, PUSH_Y)
        change = contacts.forces[NX, c] * gained_x + contacts.forces[NY, c] * gained_y
        contacts.forces[result, c] = change


@kernel
def _reduced_mass(balls: Balls, contacts: Contacts, c: int) -> float:
    """Reduced mass [kg] of the two balls of contact c."""
    mass_a = balls.state[MASS, contacts.ends[FIRST, c]]
    mass_b = balls.state[MASS, contacts.ends[SECOND, c]]
    return reduced_mass(mass_a, mass_b)


@kernel
def _dot(contacts: Contacts, count: int, row: int, other: int) -> float:
    """Sum of the products of two rows, from small to large: in no order of the contacts."""
    for c in range(count):
        term, place = contacts.forces[row, c] * contacts.forces[other, c], c
        while place > 0 and contacts.forces[TERM, place - 1] > term:
            contacts.forces[TERM, place] = contacts.forces[TERM, place - 1]
            place -= 1
        contacts.forces[TERM, place] = term
    total = 0.0
    for place in range(count):
        total += contacts.forces[TERM, place]
    return total


@kernel
def _gained(balls: Balls, contacts: Contacts, count: int, k: int, row: int) -> float:
    """Velocity [m/s] that the impulses in `row` give ball k."""
    gained: float = _sum_at(contacts, count, k, row, -1.0) / balls.state[MASS, k]
    return gained


@kernel
def _push(balls: Balls, contacts: Contacts, count: int) -> None:
    """Give every ball of the group the impulses in PUSH_X and PUSH_Y."""
    for k in range(len(balls.own_kind)):
        if contacts.motion[DEGREE, k] > 0.0:
            balls.state[VX, k] += _gained(balls, contacts, count, k, PUSH_X)
            balls.state[VY, k] += _gained(balls, contacts, count, k, PUSH_Y)


@kernel
def _find_friction(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> None:
    """Put each contact's friction in PUSH_X and PUSH_Y, and how it turns both balls in TURN_*.

    The latter as an impulse [N s]: 5 / (2 m R) times it is the change of angular velocity. On
    entry the normal impulses are in PUSH_X and PUSH_Y.
    """
    for c in range(count):
        contacts.forces[PRODUCT, c] = _change_of_slip(balls, contacts, count, c)
    for c in range(count):
        nx, ny = contacts.forces[NX, c], contacts.forces[NY, c]
        along, up = _slip(balls, contacts, c)
        along += 0.5 * contacts.forces[PRODUCT, c]
        size = math.sqrt(along * along + up * up)
        limit = friction_coefficient(laws, size) * contacts.forces[FORCE, c]
        sticking = _split_mass(balls, contacts, c) * size / 3.5
        part = min(limit, sticking) / size if size > 0.0 else 0.0
        contacts.forces[PUSH_X, c] = -part * along * ny
        contacts.forces[PUSH_Y, c] = part * along * nx
        contacts.forces[TURN_X, c] = -part * up * ny
        contacts.forces[TURN_Y, c] = part * up * nx
        contacts.forces[TURN_Z, c] = -part * along


@kernel
def _change_of_slip(balls: Balls, contacts: Contacts, count: int, c: int) -> float:
    """Change of the slip of contact c [m/s], along t, by the impulses in PUSH_X and PUSH_Y."""
    a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
    gained_x = _gained(balls, contacts, count, a, PUSH_X)
    gained_y = _gained(balls, contacts, count, a, PUSH_Y)
    gained_x -= _gained(balls, contacts, count, b, PUSH_X)
    gained_y -= _gained(balls, contacts, count, b, PUSH_Y)
    change: float = contacts.forces[NX, c] * gained_y - contacts.forces[NY, c] * gained_x
    return change


@kernel
def _turn(balls: Balls, contacts: Contacts, count: int) -> None:
    """Turn every ball of the group by its friction."""
    for k in range(len(balls.own_kind)):
        if contacts.motion[DEGREE, k] > 0.0:
            turn = 2.5 / (balls.state[MASS, k] * balls.state[RADIUS, k])
            balls.state[WX, k] += turn * _sum_at(contacts, count, k, TURN_X, 1.0)
            balls.state[WY, k] += turn * _sum_at(contacts, count, k, TURN_Y, 1.0)
            balls.state[WZ, k] += turn * _sum_at(contacts, count, k, TURN_Z, 1.0)


@kernel
def _slip(balls: Balls, contacts: Contacts, c: int) -> tuple[float, float]:
    """Velocity of a's surface over b's at contact c [m/s]: along t = (-ny, nx), and up."""
    a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
    nx, ny = contacts.forces[NX, c], contacts.forces[NY, c]
    ra, rb = balls.state[RADIUS, a], balls.state[RADIUS, b]
    vx, vy = balls.state[VX, a] - balls.state[VX, b], balls.state[VY, a] - balls.state[VY, b]
    wx = ra * balls.state[WX, a] + rb * balls.state[WX, b]
    wy = ra * balls.state[WY, a] + rb * balls.state[WY, b]
    wz = ra * balls.state[WZ, a] + rb * balls.state[WZ, b]
    return (nx * vy - ny * vx) + wz, -(nx * wy - ny * wx)


@kernel
def _sum_at(contacts: Contacts, count: int, k: int, row: int, on_first: float) -> float:
    """Sum a row of `contacts.forces` over the contacts of ball k, where it is first, `on_first` x.

    The terms of each sign are added from small to large, and then both sums: that doesn't depend on
    the order of the contacts, and if all terms change sign, so does the sum.
    """
    terms = 0
    for c in range(count):
        if contacts.ends[FIRST, c] == k or contacts.ends[SECOND, c] == k:
            first = contacts.ends[FIRST, c] == k
            term = on_first * contacts.forces[row, c] if first else contacts.forces[row, c]
            place = terms
            while place > 0 and abs(contacts.forces[TERM, place - 1]) > abs(term):
                contacts.forces[TERM, place] = contacts.forces[TERM, place - 1]
                place -= 1
            contacts.forces[TERM, place] = term
            terms += 1
    positive, negative = 0.0, 0.0
    for place in range(terms):
        positive += max(contacts.forces[TERM, place], 0.0)
        negative += min(contacts.forces[TERM, place], 0.0)
    return positive + negative

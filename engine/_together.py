"""Impacts at one instant that share a ball, resolved together.

One after the other, in whatever order, a hit on two touching balls would favour one of them. So all
contacts of the group act at once: first the impulses along the normals, then friction.

The normal impulses are (1 + e) times those that would just end every approach, e the restitution
(Moreau 1988). For e = 1 that is one generalised reflection of Smith, Kaufman, Vouga, Tamstorf and
Grinspun (2012, section 4): energy is kept, nothing approaches, and what the impulses make approach
next, as in a cradle, is the next impact of the same instant. So balls that touch answer like balls
with vanishing gaps, except where impacts truly coincide.

Both systems are solved with every ball split among its contacts (mass splitting: Tonge, Benevolenski
and Voroshilov 2012): each contact sees its part of the mass, all act on the same state, and the
parts are averaged. That converges, never adds energy, and treats all contacts alike. Every sum over
a ball's contacts is taken in an order of its own terms, so that the result has the symmetry of the
scene to the last bit, and doesn't depend on the order of the balls.

A group's friction is Coulomb's, whatever the scene's law for two balls. Each group is counted in
`work["joint_impacts"]`.
"""

from __future__ import annotations

import math

from engine._impact import contact_normal
from engine._jit import kernel
from engine._motion import loosen
from engine._state import (
    DEGREE,
    FIRST,
    FORCE,
    MASS,
    NX,
    NY,
    PUSH_X,
    PUSH_Y,
    RADIUS,
    RATE,
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

_SWEEPS = 10_000
"""Most sweeps for the normal impulses. They converge linearly, to rounding in some 50 sweeps for
three balls."""


@kernel
def collide_together(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> None:
    """Resolve the first `count` contacts of `contacts.ends` together.

    Contract: all their balls are advanced to the instant of the impact, all contacts approach, and
    `contacts.motion[DEGREE]` holds how many of the contacts each ball has.
    """
    for c in range(count):
        nx, ny = contact_normal(balls, contacts.ends[FIRST, c], contacts.ends[SECOND, c])
        contacts.forces[NX, c] = nx
        contacts.forces[NY, c] = ny
        contacts.forces[FORCE, c] = 0.0
        contacts.forces[RATE, c] = _rate(balls, contacts, c)
    _end_approach(balls, contacts, count)
    factor = 1.0 + laws.ball_restitution
    for c in range(count):
        contacts.forces[FORCE, c] *= factor
        contacts.forces[PUSH_X, c] *= factor
        contacts.forces[PUSH_Y, c] *= factor
    _push(balls, contacts, count, laws.slides)
    if laws.slides and (laws.speed_dependent or laws.ball_friction > 0.0):
        _find_friction(balls, laws, contacts, count)
        _push(balls, contacts, count, True)
        _turn(balls, contacts, count)


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
    mass: float = part_a * (part_b / (part_a + part_b))
    return mass


@kernel
def _end_approach(balls: Balls, contacts: Contacts, count: int) -> None:
    """Find the impulses [N s] after which no contact approaches, and none where one parts.

    In FORCE their sizes, in PUSH_X and PUSH_Y the vectors, on the second ball of each contact.
    """
    fastest = 0.0
    for c in range(count):
        fastest = max(fastest, -contacts.forces[RATE, c])
    for _ in range(_SWEEPS):
        change = 0.0
        for c in range(count):
            mass = _split_mass(balls, contacts, c)
            impulse = contacts.forces[FORCE, c]
            wanted = max(0.0, impulse - mass * contacts.forces[RATE, c])
            change = max(change, abs(wanted - impulse) / mass)
            contacts.forces[FORCE, c] = wanted
            contacts.forces[PUSH_X, c] = wanted * contacts.forces[NX, c]
            contacts.forces[PUSH_Y, c] = wanted * contacts.forces[NY, c]
        if change <= EPS * fastest:
            return
        for c in range(count):
            a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
            change_x = _gained(balls, contacts, count, b, PUSH_X) - _gained(
                balls, contacts, count, a, PUSH_X
            )
            change_y = _gained(balls, contacts, count, b, PUSH_Y) - _gained(
                balls, contacts, count, a, PUSH_Y
            )
            contacts.forces[RATE, c] = _rate(balls, contacts, c) + (
                contacts.forces[NX, c] * change_x + contacts.forces[NY, c] * change_y
            )


@kernel
def _gained(balls: Balls, contacts: Contacts, count: int, k: int, row: int) -> float:
    """Velocity [m/s] that the impulses in `row` give ball k."""
    gained: float = _sum_at(contacts, count, k, row, -1.0) / balls.state[MASS, k]
    return gained


@kernel
def _push(balls: Balls, contacts: Contacts, count: int, slides: bool) -> None:
    """Give every ball of the group the impulses in PUSH_X and PUSH_Y."""
    for k in range(len(balls.own_kind)):
        if contacts.motion[DEGREE, k] > 0.0:
            if slides:
                loosen(balls, k)
            balls.state[VX, k] += _gained(balls, contacts, count, k, PUSH_X)
            balls.state[VY, k] += _gained(balls, contacts, count, k, PUSH_Y)


@kernel
def _find_friction(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> None:
    """Put each contact's friction in PUSH_X and PUSH_Y, and how it turns both balls in TURN_*.

    The latter as an impulse [N s]: 5 / (2 m R) times it is the change of angular velocity.
    """
    for c in range(count):
        nx, ny = contacts.forces[NX, c], contacts.forces[NY, c]
        along, up = _slip(balls, contacts, c)
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

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
on the same state, and the parts are averaged. The result has the symmetry of the scene to the last
bit, and doesn't depend on the order of the balls (see `impacts.contact_solver`).

A group's friction is Coulomb's, whatever the scene's law for two balls. Each group is counted in
`work["joint_impacts"]`.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ANSWERING,
    DEGREE,
    FIRST,
    FORCE,
    NX,
    NY,
    PUSH_X,
    PUSH_Y,
    RATE,
    SECOND,
    TURN_X,
    TURN_Y,
    TURN_Z,
    Balls,
    Contacts,
    Laws,
)
from ghostball.engine.impacts.contact_solver import (
    add_up,
    end_approach,
    gain_of,
    gap_rate,
    impulse_on,
    scale,
)
from ghostball.engine.impacts.impact import contact_normal
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.motion.geometry import reduced_mass
from ghostball.engine.motion.next_piece import loosen


@kernel
def collide_together(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> bool:
    """Resolve the first `count` contacts of `contacts.ends` together; False where some approach on.

    Contract: all their balls are advanced to the instant of the impact and marked in
    `balls.touched`, all contacts approach, and DEGREE in `contacts.motion` holds how many of the
    contacts each ball has.
    """
    for m in range(1, balls.touched[0] + 1):
        k = balls.touched[m]
        if contacts.motion[k, DEGREE] > 0.0:
            contacts.motion[k, ANSWERING] = balls.state[k].mass
            if laws.slides:
                loosen(balls, k)  # before anything asks how it turns
    for c in range(count):
        # No account of the rounded normal's length, as one impact alone needs: impulses are found
        # here for the very rates along it.
        nx, ny = contact_normal(balls, contacts.ends[c, FIRST], contacts.ends[c, SECOND])
        contacts.forces[c, NX] = nx
        contacts.forces[c, NY] = ny
        contacts.forces[c, RATE] = gap_rate(balls, contacts, c)
    solved = end_approach(contacts, count)
    restitution = laws.ball_restitution
    scale(contacts, count, 1.0 + restitution)
    if laws.slides and (laws.speed_dependent or laws.ball_friction > 0.0):
        _find_friction(balls, laws, contacts, count)
        _rub(balls, contacts, count)
        for c in range(count):
            before = contacts.forces[c, RATE]
            contacts.forces[c, RATE] = gap_rate(balls, contacts, c) + restitution * before
        solved = end_approach(contacts, count) and solved
    _push(balls, contacts)
    return solved


@kernel
def _push(balls: Balls, contacts: Contacts) -> None:
    """Give every ball of the group the velocity that the impulses give it."""
    for m in range(1, balls.touched[0] + 1):
        k = balls.touched[m]
        if contacts.motion[k, DEGREE] > 0.0:
            x, y = gain_of(contacts, k)
            balls.state[k].vx += x
            balls.state[k].vy += y


@kernel
def _split_mass(balls: Balls, contacts: Contacts, c: int) -> float:
    """Reduced mass [kg] of contact c, of those parts of its two balls that are its own."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    part_a = balls.state[a].mass / contacts.motion[a, DEGREE]
    part_b = balls.state[b].mass / contacts.motion[b, DEGREE]
    return reduced_mass(part_a, part_b)


@kernel
def _find_friction(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> None:
    """Put each contact's friction in PUSH_X and PUSH_Y, and how it turns both balls in TURN_*.

    The latter as an impulse [N s]: 5 / (2 m R) times it is the change of angular velocity. On
    entry, FORCE holds the normal impulses, which `gain_of` knows, too.
    """
    for c in range(count):
        a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
        nx, ny = contacts.forces[c, NX], contacts.forces[c, NY]
        (ax, ay), (bx, by) = gain_of(contacts, a), gain_of(contacts, b)
        gain_x, gain_y = ax - bx, ay - by
        along, up = _slip(balls, contacts, c)
        along += 0.5 * (nx * gain_y - ny * gain_x)
        size = math.sqrt(along * along + up * up)
        limit = friction_coefficient(laws, size) * contacts.forces[c, FORCE]
        sticking = _split_mass(balls, contacts, c) * size / 3.5
        part = min(limit, sticking) / size if size > 0.0 else 0.0
        contacts.forces[c, PUSH_X] = -part * along * ny
        contacts.forces[c, PUSH_Y] = part * along * nx
        contacts.forces[c, TURN_X] = -part * up * ny
        contacts.forces[c, TURN_Y] = part * up * nx
        contacts.forces[c, TURN_Z] = -part * along


@kernel
def _rub(balls: Balls, contacts: Contacts, count: int) -> None:
    """Give every ball of the group the friction of its contacts, which moves it and turns it."""
    add_up(contacts, count, PUSH_X, PUSH_Y, -1.0)
    _push(balls, contacts)
    for row in (TURN_X, TURN_Z):
        add_up(contacts, count, row, TURN_Y, 1.0)
        for m in range(1, balls.touched[0] + 1):
            k = balls.touched[m]
            if contacts.motion[k, DEGREE] > 0.0:
                x, y = impulse_on(contacts, k)
                turn = 2.5 / (balls.state[k].mass * balls.state[k].radius)
                if row == TURN_X:
                    balls.state[k].wx += turn * x
                    balls.state[k].wy += turn * y
                else:
                    balls.state[k].wz += turn * x


@kernel
def _slip(balls: Balls, contacts: Contacts, c: int) -> tuple[float, float]:
    """Velocity of a's surface over b's at contact c [m/s]: along t = (-ny, nx), and up."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    nx, ny = contacts.forces[c, NX], contacts.forces[c, NY]
    ra, rb = balls.state[a].radius, balls.state[b].radius
    vx, vy = balls.state[a].vx - balls.state[b].vx, balls.state[a].vy - balls.state[b].vy
    wx = ra * balls.state[a].wx + rb * balls.state[b].wx
    wy = ra * balls.state[a].wy + rb * balls.state[b].wy
    wz = ra * balls.state[a].wz + rb * balls.state[b].wz
    return (nx * vy - ny * vx) + wz, -(nx * wy - ny * wx)

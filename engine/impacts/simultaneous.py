"""Simultaneous impacts that share a ball, resolved together.

If a ball hits two touching balls, resolving one impact after the other, in any order, would favour
one of the balls. Therefore all contacts of the group act at once.

The normal impulses are (1 + e) times those that would just end every approach; e is the restitution
(Moreau 1988). For e = 1 this is one generalised reflection of Smith, Kaufman, Vouga, Tamstorf and
Grinspun (2012, section 4): energy is conserved, and no contact approaches. Contacts that approach
because of these impulses, as in a cradle, are the next impacts at the same time. So a row of
touching balls, along which impacts follow one another, behaves like a row with vanishing gaps. A
touching rack behaves differently from a rack with gaps: the balls of a touching rack are hit at
once, but with gaps, however small, the impacts follow one another.

Friction acts against the mean of the slips before and after the normal impulses, which reverse the
slip if they throw a ball back. The normal impulses are then computed again, so that every contact
parts at e times its approach speed, with friction. The work against this mean slip is then the
only effect of friction on the energy, and it is a loss. Friction is computed with every ball split
among its contacts (mass splitting: Tonge, Benevolenski and Voroshilov 2012): each contact has its
part of the mass, all contacts act on the same state, and the velocities of the parts are averaged.
The result has the symmetry of the scene to the last bit, and doesn't depend on the order of the
balls (see `impacts.contact_solver`).

The friction of a group is Coulomb's, whatever the scene's law for two balls. Each group is counted
in `work["joint_impacts"]`.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.rows import ContactRow, column_of
from ghostball.engine.core.state import World
from ghostball.engine.impacts.contact_solver import (
    PUSH_X,
    PUSH_Y,
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
from ghostball.engine.motion.next_piece import keep_spin

_TURN_X, _TURN_Y, _TURN_Z = (
    column_of(ContactRow, field) for field in ("turn_x", "turn_y", "turn_z")
)


@kernel
def collide_together(world: World, count: int) -> bool:
    """Resolve the first `count` contacts of `contacts.ends` together; False if some still approach.

    Contract: all their balls are advanced to the time of the impact and marked in `balls.touched`,
    all contacts approach, and `degree` in `contacts.motion` is the number of these contacts of each
    ball.
    """
    balls, laws, contacts = world.balls, world.laws, world.contacts
    for m in range(1, balls.touched[0] + 1):
        k = balls.touched[m]
        if contacts.motion[k].degree > 0.0:
            contacts.motion[k].effective_mass = balls.state[k].mass
            if laws.slides:
                keep_spin(balls, k)  # before any code reads the angular velocity
    for c in range(count):
        # No correction for the length of the rounded normal, unlike in a single impact: the
        # impulses are computed here for the rates along the rounded normal.
        nx, ny = contact_normal(balls, contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND])
        contacts.forces[c].nx = nx
        contacts.forces[c].ny = ny
        contacts.forces[c].rate = gap_rate(world, c)
    solved = end_approach(contacts, count, 0.0)
    restitution = laws.ball_restitution
    scale(contacts, count, 1.0 + restitution)
    if laws.slides and (laws.speed_dependent or laws.ball_friction > 0.0):
        _find_friction(world, count)
        _rub(world, count)
        for c in range(count):
            before = contacts.forces[c].rate
            contacts.forces[c].rate = gap_rate(world, c) + restitution * before
        solved = end_approach(contacts, count, 0.0) and solved
    _push(world)
    return solved


@kernel
def _push(world: World) -> None:
    """Change the velocity of every ball of the group by its impulses."""
    balls = world.balls
    for m in range(1, balls.touched[0] + 1):
        k = balls.touched[m]
        if world.contacts.motion[k].degree > 0.0:
            x, y = gain_of(world.contacts, k)
            balls.state[k].vx += x
            balls.state[k].vy += y


@kernel
def _split_mass(world: World, c: int) -> float:
    """Return the reduced mass [kg] of contact c, from the parts of its balls' masses."""
    contacts = world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    part_a = world.balls.state[a].mass / contacts.motion[a].degree
    part_b = world.balls.state[b].mass / contacts.motion[b].degree
    return reduced_mass(part_a, part_b)


@kernel
def _find_friction(world: World, count: int) -> None:
    """Set each contact's friction, `push_x` and `push_y`, and its turning impulse, `turn_...`.

    The turning impulse [N s] times 5 / (2 m R) is the change of angular velocity. On entry, `force`
    holds the normal impulses, and `gain_of` returns their effect.
    """
    contacts = world.contacts
    for c in range(count):
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        nx, ny = contacts.forces[c].nx, contacts.forces[c].ny
        (ax, ay), (bx, by) = gain_of(contacts, a), gain_of(contacts, b)
        gain_x, gain_y = ax - bx, ay - by
        along, up = _slip(world, c)
        along += 0.5 * (nx * gain_y - ny * gain_x)
        size = math.sqrt(along * along + up * up)
        limit = friction_coefficient(world.laws, size) * contacts.forces[c].force
        sticking = _split_mass(world, c) * size / 3.5
        part = min(limit, sticking) / size if size > 0.0 else 0.0
        contacts.forces[c].push_x = -part * along * ny
        contacts.forces[c].push_y = part * along * nx
        contacts.forces[c].turn_x = -part * up * ny
        contacts.forces[c].turn_y = part * up * nx
        contacts.forces[c].turn_z = -part * along


@kernel
def _rub(world: World, count: int) -> None:
    """Apply the friction of its contacts to every ball of the group: to velocity and spin."""
    balls, contacts = world.balls, world.contacts
    add_up(contacts, count, PUSH_X, PUSH_Y, -1.0)
    _push(world)
    for column in (_TURN_X, _TURN_Z):
        add_up(contacts, count, column, _TURN_Y, 1.0)
        for m in range(1, balls.touched[0] + 1):
            k = balls.touched[m]
            if contacts.motion[k].degree > 0.0:
                x, y = impulse_on(contacts, k)
                turn = 2.5 / (balls.state[k].mass * balls.state[k].radius)
                if column == _TURN_X:
                    balls.state[k].wx += turn * x
                    balls.state[k].wy += turn * y
                else:
                    balls.state[k].wz += turn * x


@kernel
def _slip(world: World, c: int) -> tuple[float, float]:
    """Return the slip of a's surface over b's at contact c [m/s]: along t = (-ny, nx), and up."""
    balls, contacts = world.balls, world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    nx, ny = contacts.forces[c].nx, contacts.forces[c].ny
    ra, rb = balls.state[a].radius, balls.state[b].radius
    vx, vy = balls.state[a].vx - balls.state[b].vx, balls.state[a].vy - balls.state[b].vy
    wx = ra * balls.state[a].wx + rb * balls.state[b].wx
    wy = ra * balls.state[a].wy + rb * balls.state[b].wy
    wz = ra * balls.state[a].wz + rb * balls.state[b].wz
    return (nx * vy - ny * vx) + wz, -(nx * wy - ny * wx)

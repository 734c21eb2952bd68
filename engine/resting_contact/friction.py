"""Friction of an island's contacts over one contact step, one contact after the other.

`resting_contact.forces` computes it again after each round of normal forces.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Contacts, World
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.impacts.laws.dispatch import nose_sine
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.motion.geometry import friction_limit, reduced_mass
from ghostball.engine.resting_contact.cloth_response import accelerate, permitted_gap, spin_after
from ghostball.engine.resting_contact.gaps import balls_of

_LITTLE = 2.0**-20
"""Change of friction in a round, relative to the cloth's friction, that counts as steady."""


@kernel
def rub_all(world: World, count: int, duration: float) -> bool:
    """Set every contact's friction from its normal force; return whether it changed little."""
    balls = world.balls
    forces, steady = world.contacts.forces, True
    for c in range(count):
        along, up = forces[c].along, forces[c].up
        _rub(world, c, duration)
        more_along, more_up = forces[c].along - along, forces[c].up - up
        forces[c].along_change, forces[c].up_change = more_along, more_up
        a, b = balls_of(world.contacts, c)
        change = (abs(more_along) + abs(more_up)) / _mass(world, c)
        little = _LITTLE * max(friction_limit(balls, a), friction_limit(balls, b))
        if little == 0.0:
            # A cloth without friction gives no scale. The scale is then the contact's own limit,
            # and the rounding of the velocities.
            little = _LITTLE * forces[c].coulomb_limit / _mass(world, c)
            little = max(little, EPS * (_size(balls, a) + _size(balls, b)) / duration)
        steady = steady and change <= max(
            little, permitted_gap(balls, a, b, duration) / (duration * duration)
        )
    return steady


@kernel(inline=True)
def _size(balls: Balls, k: int) -> float:
    """Return the 1-norm of ball k's velocity [m/s]."""
    size: float = abs(balls.state[k].vx) + abs(balls.state[k].vy)
    return size


@kernel
def _rub(world: World, c: int, duration: float) -> None:
    """Set the friction force of contact c from its normal force.

    Sticking: the force that makes the slip zero at the end of the step, if it is within the Coulomb
    limit. Slipping: the Coulomb limit, against the slip at mid-step, or less if a smaller force
    ends the slip.

    The force is found by projection onto the friction disc. Taking its direction from the slip of
    the previous round did not converge for small slip.

    A cushion acts at the contact height of its impact law, and its force points to the centre of
    the ball; `force` is its component along the normal.
    """
    laws, contacts = world.laws, world.contacts
    b = contacts.ends[c, st.SECOND]
    if not laws.slides or (b < 0 and laws.obstacles[-1 - b].turns == 0.0):
        return
    sine = _nose(world, c)
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    along, up, change_along, change_up = _slip(world, c, sine, cosine, duration)
    if b >= 0:
        coefficient = friction_coefficient(laws, math.sqrt(along * along + up * up))
    else:
        coefficient = laws.obstacles[-1 - b].friction
    if coefficient == 0.0:
        return
    limit = coefficient * contacts.forces[c].force / cosine
    contacts.forces[c].coulomb_limit = limit
    gain = _mass(world, c) / (3.5 * duration)
    new_along = contacts.forces[c].along + gain * (along + duration * change_along)
    new_up = contacts.forces[c].up + gain * (up + duration * change_up)
    if not _within(new_along, new_up, limit):
        size = math.sqrt(new_along * new_along + new_up * new_up)
        mid = gain if size >= 2.0 * limit else gain * (size - limit) / limit
        mid_along, mid_up = new_along + mid * along, new_up + mid * up
        if _within(mid_along, mid_up, limit):
            along, up = new_along - mid_along, new_up - mid_up
            part = part_to_limit(mid_along, mid_up, along, up, limit)
            new_along, new_up = mid_along + part * along, mid_up + part * up
        else:
            size = math.sqrt(mid_along * mid_along + mid_up * mid_up)
            new_along, new_up = limit * (mid_along / size), limit * (mid_up / size)
    more_along = new_along - contacts.forces[c].along
    more_up = new_up - contacts.forces[c].up
    rub_more(world, c, more_along, more_up, duration)


@kernel
def rub_more(world: World, c: int, more_along: float, more_up: float, duration: float) -> None:
    """Increase the friction of contact c [N], and update the accelerations of its balls."""
    contacts = world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    sine = _nose(world, c)
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    contacts.forces[c].along += more_along
    contacts.forces[c].up += more_up
    nx, ny = contacts.forces[c].nx, contacts.forces[c].ny
    tx, ty = -ny, nx
    push = more_up * sine
    load(contacts, a, b, more_along * tx - push * nx, more_along * ty - push * ny)
    for k in (a, b):
        if k >= 0:
            contacts.motion[k].twist_x += more_up * tx + more_along * sine * nx
            contacts.motion[k].twist_y += more_up * ty + more_along * sine * ny
            contacts.motion[k].twist_z -= more_along * cosine
            accelerate(world, k, duration)


@kernel
def load(contacts: Contacts, a: int, b: int, fx: float, fy: float) -> None:
    """Add a force to ball b, unless b is a cushion, and its opposite to ball a [N]."""
    contacts.motion[a].load_x -= fx
    contacts.motion[a].load_y -= fy
    if b >= 0:
        contacts.motion[b].load_x += fx
        contacts.motion[b].load_y += fy


@kernel
def sticks(contacts: Contacts, c: int) -> bool:
    """Return whether the friction of contact c is below Coulomb's limit."""
    forces = contacts.forces
    return _within(forces[c].along, forces[c].up, (1.0 - 2.0**-20) * forces[c].coulomb_limit)


@kernel
def part_to_limit(x: float, y: float, more_x: float, more_y: float, limit: float) -> float:
    """Return the factor on (more_x, more_y) with which friction (x, y) reaches its limit."""
    square = more_x * more_x + more_y * more_y
    if square == 0.0:
        return math.inf
    outward = x * more_x + y * more_y
    left = square * (limit * limit - x * x - y * y)
    return (math.sqrt(outward * outward + left) - outward) / square


@kernel
def _within(x: float, y: float, limit: float) -> bool:
    return x * x + y * y <= limit * limit


@kernel
def _mass(world: World, c: int) -> float:
    """Return the reduced mass of contact c [kg]; the mass of a cushion is infinite."""
    a, b = world.contacts.ends[c, st.FIRST], world.contacts.ends[c, st.SECOND]
    mass: float = world.balls.state[a].mass
    return reduced_mass(mass, world.balls.state[b].mass) if b >= 0 else mass


@kernel
def _nose(world: World, c: int) -> float:
    """Return the sine of contact c's angle above the horizontal, from its first ball's centre."""
    b = world.contacts.ends[c, st.SECOND]
    if b >= 0:
        return 0.0
    radius = world.balls.state[world.contacts.ends[c, st.FIRST]].radius
    sine: float = nose_sine(world.laws, -1 - b, radius)
    return sine


@kernel
def _slip(
    world: World, c: int, sine: float, cosine: float, duration: float
) -> tuple[float, float, float, float]:
    """Return the slip of c's first ball, along and up [m/s], and the rates of change [m/s^2]."""
    contacts = world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    along, up, change_along, change_up = _surface(world, c, a, sine, cosine, duration)
    if b >= 0:
        # The contact is on the other side of ball b's centre.
        b_along, b_up, b_change_along, b_change_up = _surface(world, c, b, 0.0, 1.0, duration)
        vx, vy = world.balls.state[b].vx, world.balls.state[b].vy
        ax, ay = contacts.motion[b].new_ax, contacts.motion[b].new_ay
        nx, ny = contacts.forces[c].nx, contacts.forces[c].ny
        along += b_along - 2.0 * (nx * vy - ny * vx)
        up += b_up
        change_along += b_change_along - 2.0 * (nx * ay - ny * ax)
        change_up += b_change_up
    return along, up, change_along, change_up


@kernel
def _surface(
    world: World, c: int, k: int, sine: float, cosine: float, duration: float
) -> tuple[float, float, float, float]:
    """Return the velocity of the point of ball k's surface on contact c's normal, and its rate.

    `sine`, `cosine`: the angle of this point above the centre. The decay of vertical spin on the
    cloth is included: without it, a slip proportional to the step remained.
    """
    balls, contacts = world.balls, world.contacts
    nx, ny = contacts.forces[c].nx, contacts.forces[c].ny
    radius = balls.state[k].radius
    wx, wy = balls.state[k].wx, balls.state[k].wy
    if balls.state[k].phase != st.SLIDING:
        wx, wy = -balls.state[k].vy / radius, balls.state[k].vx / radius
    vx, vy = balls.state[k].vx, balls.state[k].vy
    along = nx * vy - ny * vx
    along += radius * (cosine * balls.state[k].wz - sine * (nx * wx + ny * wy))
    up = -radius * (nx * wy - ny * wx) - sine * (nx * vx + ny * vy)
    twist = radius * (spin_after(world, k, duration) - balls.state[k].wz) / duration
    ax, ay = contacts.motion[k].new_ax, contacts.motion[k].new_ay
    bx, by = contacts.motion[k].new_bx, contacts.motion[k].new_by
    change_along = nx * ay - ny * ax + cosine * twist - radius * sine * (nx * bx + ny * by)
    change_up = -radius * (nx * by - ny * bx) - sine * (nx * ax + ny * ay)
    return along, up, change_along, change_up

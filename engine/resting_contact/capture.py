"""Remove the approach that remains at the start of a contact step, by inelastic impulses.

After these impulses the balls don't separate. A ball at rest stays at rest if the cloth would stop
it again immediately.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.rows import ContactRow
from ghostball.engine.core.state import World
from ghostball.engine.core.tolerances import APPROACH_ROUNDING, LEAST_SPEED
from ghostball.engine.impacts.contact_solver import (
    end_approach,
    gain_of,
    gap_rate,
    impulse_on,
)
from ghostball.engine.impacts.laws.dispatch import nose_sine
from ghostball.engine.motion.geometry import (
    at_rest,
    capture_height,
    contact_tolerance,
    friction_limit,
    negligible_bounce,
    rolls_on,
    speed_of,
)
from ghostball.engine.motion.next_piece import keep_spin
from ghostball.engine.motion.obstacles import turning
from ghostball.engine.resting_contact.cloth_response import effective_mass
from ghostball.engine.resting_contact.gaps import gap_now

_RESIDUE = 2.0**-20
"""Height of a bounce that is left to the contact force, relative to a negligible one. Its speed is
1/1000 of the speed of a negligible bounce.
"""

_AS_ONE = 1.0 - 2.0**-32
"""Cosine between the normals of two obstacles above which they push a touching ball as one.

The angle is 2e-5: twice the angle between the normals of a cushion and of the jaw at its end, for a
ball that is in contact with both.
"""


@kernel
def stop_approach(world: World, members: int, count: int, held: bool) -> bool:
    """Remove the approach that remains at the contacts, inelastically: negligible bounces.

    A ball at rest stays at rest if the cloth would stop it again within `CAPTURE_HEIGHT`. `held`:
    True if forces hold the contacts from now on, and end the slowest approaches. The result is
    False if some approach remains.
    """
    balls, contacts = world.balls, world.contacts
    for m in range(members):
        k = contacts.member[m]
        # Until the impulses are applied, `stopped` means that the ball moves, or was stopped at
        # this time.
        contacts.stopped[k] = contacts.stopped[k] or not at_rest(balls, k)
    approaches = _approaches(world, count, held)
    if approaches and _stop_wedged(world, count):
        approaches = _approaches(world, count, held)
    if not approaches:
        solved = True
    else:
        for m in range(members):
            k = contacts.member[m]
            firm = at_rest(balls, k)
            contacts.motion[k].effective_mass = (
                math.inf if firm else effective_mass(balls, world.laws, k)
            )
        solved = end_approach(contacts, count, 0.0)
        for _ in range(members):
            if not _free_pushed(world, members, solved):
                break
            solved = end_approach(contacts, count, 0.0)
        _push(world, members)
        rubbed = False
        for c in range(count):
            if contacts.ends[c, st.SECOND] < 0:
                rubbed = _rub_cushion(world, c) or rubbed
        if rubbed and _approaches(world, count, held):
            # In a corner, the friction at one cushion drives the ball into the other.
            solved = end_approach(contacts, count, 0.0) and solved
            _push(world, members)
    for m in range(members):
        k = contacts.member[m]
        if abs(balls.state[k].vx) < LEAST_SPEED and abs(balls.state[k].vy) < LEAST_SPEED:
            balls.state[k].vx, balls.state[k].vy = 0.0, 0.0
        contacts.stopped[k] = contacts.stopped[k] and at_rest(balls, k)
    return solved


@kernel
def _stop_wedged(world: World, count: int) -> bool:
    """Stop every ball that moves into the wedge of two obstacles; return whether there is one.

    The pushes of both obstacles that add up to its velocity are computed directly. If the
    obstacles face each other almost exactly, the pushes grow like the reciprocal of the angle
    between them, and the rounding errors of the general solver took the ball through an obstacle.
    """
    balls, contacts = world.balls, world.contacts
    found = False
    for c in range(count):
        a = contacts.ends[c, st.FIRST]
        for other in range(c + 1, count):
            b = contacts.ends[other, st.SECOND]
            if contacts.ends[other, st.FIRST] != a or contacts.ends[c, st.SECOND] >= 0 or b >= 0:
                continue
            first, second, ball = contacts.forces[c], contacts.forces[other], balls.state[a]
            across, push, push_too = wedge_pushes(first, second, ball.vx, ball.vy)
            if push > 0.0 and push_too > 0.0:
                first.force = ball.mass * (push / (across * across))
                second.force = ball.mass * (push_too / (across * across))
                ball.vx, ball.vy = 0.0, 0.0
                _rub_cushion(world, c)
                _rub_cushion(world, other)
                ball.vx, ball.vy = 0.0, 0.0
                found = True
    return found


@kernel
def wedge_pushes(
    first: ContactRow, second: ContactRow, x: float, y: float
) -> tuple[float, float, float]:
    """Return the components of the vector (x, y) along the normals of two contacts of a ball.

    The first result is the sine of the angle between the normals. The other two are the components,
    multiplied by the square of this sine.
    """
    across = first.nx * second.ny - first.ny * second.nx
    return (
        across,
        (x * second.ny - y * second.nx) * across,
        (first.nx * y - first.ny * x) * across,
    )


@kernel
def _push(world: World, members: int) -> None:
    """Apply the impulses to every member."""
    balls = world.balls
    for m in range(members):
        k = world.contacts.member[m]
        x, y = gain_of(world.contacts, k)
        if world.laws.slides and (x != 0.0 or y != 0.0) and not rolls_on(balls, k):
            keep_spin(balls, k)
        balls.state[k].vx += x
        balls.state[k].vy += y


@kernel
def _rub_cushion(world: World, c: int) -> bool:
    """Apply the friction of contact c's impulse if its ball slides at a cushion; False if none.

    The friction follows Coulomb's law at the contact height of the cushion's impact law, because
    the impulse replaces bounces, which have this friction.
    """
    laws, contacts = world.laws, world.contacts
    row = -1 - contacts.ends[c, st.SECOND]
    ball, cushion = world.balls.state[contacts.ends[c, st.FIRST]], laws.obstacles[row]
    if cushion.turns == 0.0 or ball.phase != st.SLIDING or contacts.forces[c].force == 0.0:
        return False
    nx, ny, radius = contacts.forces[c].nx, contacts.forces[c].ny, ball.radius
    sine = nose_sine(laws, row, radius)
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    turning = nx * ball.wx + ny * ball.wy
    along = (nx * ball.vy - ny * ball.vx) + radius * (cosine * ball.wz - sine * turning)
    down = radius * (nx * ball.wy - ny * ball.wx)
    size = speed_of(along, down)
    if size == 0.0:
        return False
    # Friction provides a part of the normal impulse, so the normal force of the nose is smaller.
    part = cushion.friction / (cosine + cushion.friction * sine * (down / size))
    rubbed = min(part * (contacts.forces[c].force / ball.mass), size / 3.5)
    along, down = -rubbed * (along / size), -rubbed * (down / size)
    turn = 2.5 / radius
    ball.vx -= along * ny
    ball.vy += along * nx
    ball.wx -= turn * (nx * (along * sine) + ny * down)
    ball.wy -= turn * (ny * (along * sine) - nx * down)
    ball.wz += turn * (along * cosine)
    return True


@kernel
def _approaches(world: World, count: int, held: bool) -> bool:
    """Set normals and rates; return whether a contact approaches by more than forces can end.

    If no force will hold the contacts (not `held`), no approach above rounding may remain, because
    the impacts of the two bodies would continue.
    """
    balls, contacts = world.balls, world.contacts
    found = False
    for c in range(count):
        nx, ny, _ = gap_now(world, c)
        contacts.forces[c].nx = nx
        contacts.forces[c].ny = ny
    for c in range(count):
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        if b < 0 and world.laws.obstacles[-1 - b].kind != st.LINE:
            _face_wall(world, c, count)
        rate = gap_rate(world, c)
        contacts.forces[c].rate = rate
        size = abs(balls.state[a].vx) + abs(balls.state[a].vy)
        if b >= 0:
            size += abs(balls.state[b].vx) + abs(balls.state[b].vy)
        other = b if b >= 0 else a
        height = _RESIDUE * contact_tolerance(balls, a, other)
        residue = held and negligible_bounce(
            rate, max(friction_limit(balls, a), friction_limit(balls, other)), height
        )
        found = found or (rate < -APPROACH_ROUNDING * size and not residue)
    return found


@kernel
def _face_wall(world: World, c: int, count: int) -> None:
    """Set the normal of contact c, with an obstacle, to the normal of the wall of the obstacle.

    The normal of a wall is the normal of the flattest obstacle that the ball touches in nearly the
    same direction: the normal of a rail, not of the jaw after the rail, because the ball can't
    reach the jaw before the end of the rail. Just before the end, the tolerance of the gap would
    let the ball hit the jaw at an angle of 1e-5.
    """
    contacts, laws = world.contacts, world.laws
    a, forces = contacts.ends[c, st.FIRST], contacts.forces
    ball = world.balls.state[a]
    least, flattest = turning(laws, -1 - contacts.ends[c, st.SECOND], ball.x, ball.y), c
    first = c  # contacts of a ball with obstacles are listed one after the other
    while first > 0 and contacts.ends[first - 1, st.FIRST] == a:
        first -= 1
    for other in range(first, count):
        b = contacts.ends[other, st.SECOND]
        if contacts.ends[other, st.FIRST] != a:
            break
        if b < 0:
            same = forces[other].nx * forces[c].nx + forces[other].ny * forces[c].ny
            turns = turning(laws, -1 - b, ball.x, ball.y)
            if same > _AS_ONE and turns < least:
                least, flattest = turns, other
    forces[c].nx, forces[c].ny = forces[flattest].nx, forces[flattest].ny


@kernel
def _free_pushed(world: World, members: int, solved: bool) -> bool:
    """Let members at rest respond to their impulses if the cloth doesn't stop them immediately.

    "Immediately" means within `CAPTURE_HEIGHT`; if no impulses were found, all members respond.
    Return whether any member responds now that didn't respond before.
    """
    balls, contacts = world.balls, world.contacts
    found = False
    for m in range(members):
        k = contacts.member[m]
        if not math.isinf(contacts.motion[k].effective_mass):
            continue
        x, y = impulse_on(contacts, k)
        pushed = speed_of(x, y)
        mass = effective_mass(balls, world.laws, k)
        height = capture_height(balls, k, k)
        if not (solved and negligible_bounce(pushed / mass, balls.state[k].roll_slowing, height)):
            contacts.motion[k].effective_mass = mass
            found = True
    return found

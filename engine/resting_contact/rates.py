"""Accelerations of an island's balls at a time, and the forces that keep its gaps closed.

`resting_contact.integrate` integrates the accelerations. Here every contact pushes, and friction at
each contact has a direction. So the forces follow from linear equations: no gap has an
acceleration. When a contact parts, a ball starts to slip, or a slip ends,
`resting_contact.forces` computes the step instead.

A cushion acts at its nose if its impact law does, as Han's (2005), or else at mid-ball. Its force
points from there to the ball's centre, its friction acts across this direction, and the cloth
bears vertical forces.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Contacts, World
from ghostball.engine.impacts.laws.dispatch import nose_sine
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.motion.air import slowed_by_air, slowed_while_rolling
from ghostball.engine.motion.geometry import friction_limit, speed_of
from ghostball.engine.motion.obstacles import facing

_DEPENDENT = 2.0**-40
"""Remaining fraction of a contact's compliance that counts as rounding in the elimination."""

_STUCK = 2.0**-20
"""Slip of a contact, relative to the speeds, below which its friction may hold it."""


@kernel
def find_rates(world: World, members: int, count: int) -> bool:
    """Compute the accelerations of the members from their states, both in `contacts.stage`.

    `force` of each contact may be negative; between balls at rest it is 0. The result is False if a
    friction has no direction, a ball can't keep rolling or resting, or an obstacle isn't a line.
    """
    contacts = world.contacts
    for m in range(members):
        if not _slow_by_cloth(world, m):
            return False
    for c in range(count):
        if not _pose(world, c):
            return False
    _couple(contacts, count)
    _eliminate(contacts, count)
    for c in range(count):
        _push(world, c)
    for m in range(members):
        k = contacts.member[m]
        hold_x, hold_y = contacts.stage[m].hold_x, contacts.stage[m].hold_y
        is_still = contacts.stage[m].is_still == 1.0
        limit = world.balls.state[k].roll_slowing if is_still else friction_limit(world.balls, k)
        if speed_of(hold_x, hold_y) > limit:
            return False
        if contacts.stage[m].sense != 0.0:
            contacts.stage[m].bz += contacts.stage[m].twist
    return True


@kernel(inline=True)
def _slow_by_cloth(world: World, m: int) -> bool:
    """Set member m's accelerations by the cloth alone; return False if they have no direction."""
    balls, laws = world.balls, world.laws
    ball, stage = balls.state[world.contacts.member[m]], world.contacts.stage
    radius = ball.radius
    stage[m].hold_x, stage[m].hold_y = 0.0, 0.0
    stage[m].bz = -stage[m].sense * ball.spin_slowing
    stage[m].twist = 0.0
    if stage[m].is_still == 1.0:
        stage[m].ax, stage[m].ay, stage[m].bx, stage[m].by = 0.0, 0.0, 0.0, 0.0
        return True
    ux, uy, friction = stage[m].vx, stage[m].vy, ball.roll_slowing
    slides = laws.slides and ball.phase == st.SLIDING
    if slides:
        ux, uy = ux - radius * stage[m].wy, uy + radius * stage[m].wx
        friction = ball.slide_slowing
    elif laws.slides:
        stage[m].wx, stage[m].wy = -uy / radius, ux / radius
    size = math.sqrt(ux * ux + uy * uy)
    if size == 0.0:
        return False
    ax, ay = -friction * (ux / size), -friction * (uy / size)
    stage[m].bx, stage[m].by = 0.0, 0.0
    vx, vy = stage[m].vx, stage[m].vy
    if slides:
        stage[m].bx, stage[m].by = 2.5 * ay / radius, -2.5 * ax / radius
        ax, ay = slowed_by_air(balls, laws, vx, vy, ax, ay)
    else:
        ax, ay = slowed_while_rolling(balls, laws, vx, vy, ax, ay)
    stage[m].ax, stage[m].ay = ax, ay
    return True


@kernel(inline=True)
def _pose(world: World, c: int) -> bool:
    """Set contact c's normal, its gap's acceleration without forces, and the effect of a force."""
    laws, contacts = world.laws, world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    i = int(contacts.motion[a].index)
    j = int(contacts.motion[b].index) if b >= 0 else i
    stage, forces = contacts.stage, contacts.forces
    radius, sine, cosine = world.balls.state[a].radius, 0.0, 1.0
    if b >= 0:
        rx, ry = stage[j].x - stage[i].x, stage[j].y - stage[i].y
        distance = math.sqrt(rx * rx + ry * ry)
        nx, ny = rx / distance, ry / distance
        vx, vy = stage[j].vx - stage[i].vx, stage[j].vy - stage[i].vy
        across = nx * vy - ny * vx
        rate = across * across / distance
        rate += nx * (stage[j].ax - stage[i].ax) + ny * (stage[j].ay - stage[i].ay)
        coefficient = 0.0
    else:
        k = -1 - b
        if laws.obstacles[k].kind != st.LINE:
            return False
        inward_x, inward_y, _ = facing(laws, k, stage[i].x, stage[i].y)
        nx, ny = -inward_x, -inward_y
        rate = -(nx * stage[i].ax + ny * stage[i].ay)
        sine = nose_sine(laws, k, radius)
        cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
        coefficient = laws.obstacles[k].friction if laws.obstacles[k].turns == 1.0 else 0.0
    forces[c].nx, forces[c].ny, forces[c].rate = nx, ny, rate
    # The slip of a's surface over the other surface: along (-ny, nx), and down.
    along, down = 0.0, 0.0
    if laws.slides:
        along = nx * stage[i].vy - ny * stage[i].vx
        turning = nx * stage[i].wx + ny * stage[i].wy
        along += radius * (cosine * stage[i].wz - sine * turning)
        down = radius * (nx * stage[i].wy - ny * stage[i].wx)
        down += sine * (nx * stage[i].vx + ny * stage[i].vy)
        if b >= 0:
            other = world.balls.state[b].radius
            along += other * stage[j].wz - (nx * stage[j].vy - ny * stage[j].vx)
            down += other * (nx * stage[j].wy - ny * stage[j].wx)
        size = math.sqrt(along * along + down * down)
        if b >= 0:
            coefficient = friction_coefficient(laws, size)
        rests = stage[i].is_still == 1.0 and (b < 0 or stage[j].is_still == 1.0)
        if coefficient > 0.0 and not rests:
            surface = abs(stage[i].wx) + abs(stage[i].wy) + abs(stage[i].wz)
            speed = abs(stage[i].vx) + abs(stage[i].vy) + radius * surface
            if size <= _STUCK * speed:
                return False
            along, down = -coefficient * (along / size), -coefficient * (down / size)
        else:
            along, down = 0.0, 0.0
    # A force of 1 at the contact: its components on ball a along the normal and along the contact,
    # and its turning effect.
    toward = down * sine - cosine
    forces[c].turn_x = -nx * (along * sine) - ny * down
    forces[c].turn_y = -ny * (along * sine) + nx * down
    forces[c].turn_z = along * cosine
    push_x, push_y = nx * toward - ny * along, ny * toward + nx * along
    _respond(world, c, a, push_x, push_y, st.FIRST)
    if b >= 0:
        _respond(world, c, b, -push_x, -push_y, st.SECOND)
    return True


@kernel(inline=True)
def _respond(world: World, c: int, k: int, push_x: float, push_y: float, end: int) -> None:
    """Put the acceleration of ball k by a push at contact c into `contacts.compliances`."""
    contacts, ball = world.contacts, world.balls.state[k]
    fx, fy = push_x / ball.mass, push_y / ball.mass
    cx, cy = 0.0, 0.0
    if world.laws.slides and ball.phase != st.SLIDING:
        # The ball keeps rolling: the cloth's friction changes a slip by 7/2 of itself.
        turn = 2.5 / ball.mass
        cx = -(fx - turn * contacts.forces[c].turn_y) / 3.5
        cy = -(fy + turn * contacts.forces[c].turn_x) / 3.5
    is_still = contacts.stage[int(contacts.motion[k].index)].is_still == 1.0
    compliance = contacts.compliances[2 * c + end]
    compliance.x = 0.0 if is_still else fx + cx
    compliance.y = 0.0 if is_still else fy + cy
    compliance.hold_x = fx + cx if is_still else cx
    compliance.hold_y = fy + cy if is_still else cy


@kernel(inline=True)
def _couple(contacts: Contacts, count: int) -> None:
    """Put the acceleration of each gap by a force of 1 at each contact into `contacts.matrix`."""
    for c in range(count):
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        nx, ny = contacts.forces[c].nx, contacts.forces[c].ny
        for other in range(count):
            i, j = contacts.ends[other, st.FIRST], contacts.ends[other, st.SECOND]
            x, y = 0.0, 0.0
            for end, ball in ((st.FIRST, i), (st.SECOND, j)):
                compliance = contacts.compliances[2 * other + end]
                if ball == a:
                    x -= compliance.x
                    y -= compliance.y
                elif ball >= 0 and ball == b:
                    x += compliance.x
                    y += compliance.y
            contacts.matrix[c, other] = nx * x + ny * y


@kernel
def _eliminate(contacts: Contacts, count: int) -> None:
    """Store in `force` the forces that cancel `rate` of every contact, by elimination.

    `contacts.matrix`, which needn't be symmetric, contains the effect of each contact's force on
    each rate; it is overwritten. A contact whose rate is determined by the contacts before it,
    except for rounding, gets no force.
    """
    matrix, forces = contacts.matrix, contacts.forces
    for i in range(count):
        forces[i].force = 0.0
        forces[i].scaled = 0.0
        own, left = matrix[i, i], -forces[i].rate
        for j in range(i):
            if forces[j].scaled > 0.0 and matrix[i, j] != 0.0:
                part = matrix[i, j] / forces[j].scaled
                left -= part * forces[j].residual
                for k in range(j + 1, count):
                    matrix[i, k] -= part * matrix[j, k]
        forces[i].residual = left
        forces[i].scaled = matrix[i, i] if matrix[i, i] > _DEPENDENT * own else 0.0
    for i in range(count - 1, -1, -1):
        if forces[i].scaled > 0.0:
            left = forces[i].residual
            for j in range(i + 1, count):
                left -= matrix[i, j] * forces[j].force
            forces[i].force = left / forces[i].scaled


@kernel(inline=True)
def _push(world: World, c: int) -> None:
    """Add the effect of contact c's force to the accelerations of its balls."""
    contacts = world.contacts
    stage, force = contacts.stage, contacts.forces[c].force
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    for k, end in ((a, st.FIRST), (b, st.SECOND)):
        if k < 0:
            continue
        m = int(contacts.motion[k].index)
        compliance = contacts.compliances[2 * c + end]
        turn = 2.5 * force / (world.balls.state[k].mass * world.balls.state[k].radius)
        stage[m].ax += force * compliance.x
        stage[m].ay += force * compliance.y
        stage[m].hold_x += force * compliance.hold_x
        stage[m].hold_y += force * compliance.hold_y
        if world.laws.slides:
            stage[m].bx += turn * contacts.forces[c].turn_x
            stage[m].by += turn * contacts.forces[c].turn_y
            stage[m].twist += turn * contacts.forces[c].turn_z

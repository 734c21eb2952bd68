"""Accelerations of an island's balls at an instant, and the forces that keep its gaps closed.

`resting_contact.follow` integrates them. Every contact pushes, every ball moves, and every friction
has a direction. So the forces follow from linear equations: no gap has an acceleration. Where that
isn't so, a contact parts, a ball starts to slip, or a slip ends; `resting_contact.forces` takes the
step across.

A cushion acts at its nose where its impact law does, as Han's (2005), else at mid-ball: its force
points from there to the ball's centre, friction acts across that, and the cloth bears what is
vertical.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    AT,
    C_FIRST_HOLD,
    C_FIRST_X,
    C_SECOND_HOLD,
    C_SECOND_X,
    C_TURN_X,
    C_TURN_Z,
    FIRST,
    FORCE,
    LEFT_OVER,
    LINE,
    M_AX,
    M_AY,
    M_BX,
    M_BY,
    M_BZ,
    M_HOLD_X,
    M_HOLD_Y,
    M_SPIN,
    M_STILL,
    M_TWIST,
    M_VX,
    M_VY,
    M_WX,
    M_WY,
    M_WZ,
    M_X,
    M_Y,
    NX,
    NY,
    RATE,
    SCALED,
    SECOND,
    SLIDING,
    Balls,
    Contacts,
    Laws,
)
from ghostball.engine.impacts.laws.dispatch import nose_sine
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.motion.drag import slowed_by_air, slowed_by_grip
from ghostball.engine.motion.geometry import grip, speed_of
from ghostball.engine.motion.obstacles import facing

_DEPENDENT = 2.0**-40
"""What other contacts leave of a contact's own answer, in units of that, that is rounding."""

_STUCK = 2.0**-20
"""Slip of a contact, in units of the speeds, below which its friction may hold it."""


@kernel
def find_rates(balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int) -> bool:
    """Find the accelerations of the members from their state, both in `contacts.stage`.

    In FORCE of each contact is its force, which may be negative; none is between balls that rest.
    False where some friction has no direction, or a ball can't go on rolling, or resting.
    """
    for m in range(members):
        if not _slow_by_cloth(balls, laws, contacts, m):
            return False
    for c in range(count):
        if not _pose(balls, laws, contacts, c):
            return False
    _couple(contacts, count)
    _eliminate(contacts, count)
    for c in range(count):
        _push(balls, laws, contacts, c)
    for m in range(members):
        k = contacts.member[m]
        hold_x, hold_y = contacts.stage[m, M_HOLD_X], contacts.stage[m, M_HOLD_Y]
        is_still = contacts.stage[m, M_STILL] == 1.0
        limit = balls.state[k].roll_slowing if is_still else grip(balls, k)
        if speed_of(hold_x, hold_y) > limit:
            return False
        if contacts.stage[m, M_SPIN] != 0.0:
            contacts.stage[m, M_BZ] += contacts.stage[m, M_TWIST]
    return True


@kernel(inline=True)
def _slow_by_cloth(balls: Balls, laws: Laws, contacts: Contacts, m: int) -> bool:
    """Set member m's accelerations by the cloth alone; False where they have no direction."""
    ball, stage = balls.state[contacts.member[m]], contacts.stage
    radius = ball.radius
    stage[m, M_HOLD_X], stage[m, M_HOLD_Y] = 0.0, 0.0
    stage[m, M_BZ] = -stage[m, M_SPIN] * ball.spin_slowing
    stage[m, M_TWIST] = 0.0
    if stage[m, M_STILL] == 1.0:
        for column in (M_AX, M_AY, M_BX, M_BY):
            stage[m, column] = 0.0
        return True
    ux, uy, friction = stage[m, M_VX], stage[m, M_VY], ball.roll_slowing
    slides = laws.slides and ball.phase == SLIDING
    if slides:
        ux, uy = ux - radius * stage[m, M_WY], uy + radius * stage[m, M_WX]
        friction = ball.slide_slowing
    elif laws.slides:
        stage[m, M_WX], stage[m, M_WY] = -uy / radius, ux / radius
    size = math.sqrt(ux * ux + uy * uy)
    if size == 0.0:
        return False
    ax, ay = -friction * (ux / size), -friction * (uy / size)
    stage[m, M_BX], stage[m, M_BY] = 0.0, 0.0
    vx, vy = stage[m, M_VX], stage[m, M_VY]
    if slides:
        stage[m, M_BX], stage[m, M_BY] = 2.5 * ay / radius, -2.5 * ax / radius
        ax, ay = slowed_by_air(balls.air, laws, vx, vy, ax, ay)
    else:
        ax, ay = slowed_by_grip(balls.air, laws, vx, vy, ax, ay)
    stage[m, M_AX], stage[m, M_AY] = ax, ay
    return True


@kernel(inline=True)
def _pose(balls: Balls, laws: Laws, contacts: Contacts, c: int) -> bool:
    """Find contact c's normal, its gap's acceleration without forces, what a force of 1 does."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    i = int(contacts.motion[a, AT])
    j = int(contacts.motion[b, AT]) if b >= 0 else i
    stage, forces = contacts.stage, contacts.forces
    radius, sine, cosine = balls.state[a].radius, 0.0, 1.0
    if b >= 0:
        rx, ry = stage[j, M_X] - stage[i, M_X], stage[j, M_Y] - stage[i, M_Y]
        distance = math.sqrt(rx * rx + ry * ry)
        nx, ny = rx / distance, ry / distance
        vx, vy = stage[j, M_VX] - stage[i, M_VX], stage[j, M_VY] - stage[i, M_VY]
        across = nx * vy - ny * vx
        rate = across * across / distance
        rate += nx * (stage[j, M_AX] - stage[i, M_AX]) + ny * (stage[j, M_AY] - stage[i, M_AY])
        coefficient = 0.0
    else:
        k = -1 - b
        if laws.obstacles[k].kind != LINE:
            return False
        inward_x, inward_y, _ = facing(laws, k, stage[i, M_X], stage[i, M_Y])
        nx, ny = -inward_x, -inward_y
        rate = -(nx * stage[i, M_AX] + ny * stage[i, M_AY])
        sine = nose_sine(laws, int(laws.obstacles[k].law), radius)
        cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
        coefficient = laws.cushion_friction if laws.cushion_turns else 0.0
    forces[c, NX], forces[c, NY], forces[c, RATE] = nx, ny, rate
    # The slip of a's surface over the other's: along (-ny, nx), and down.
    along, down = 0.0, 0.0
    if laws.slides:
        along = nx * stage[i, M_VY] - ny * stage[i, M_VX]
        turning = nx * stage[i, M_WX] + ny * stage[i, M_WY]
        along += radius * (cosine * stage[i, M_WZ] - sine * turning)
        down = radius * (nx * stage[i, M_WY] - ny * stage[i, M_WX])
        down += sine * (nx * stage[i, M_VX] + ny * stage[i, M_VY])
        if b >= 0:
            other = balls.state[b].radius
            along += other * stage[j, M_WZ] - (nx * stage[j, M_VY] - ny * stage[j, M_VX])
            down += other * (nx * stage[j, M_WY] - ny * stage[j, M_WX])
        size = math.sqrt(along * along + down * down)
        if b >= 0:
            coefficient = friction_coefficient(laws, size)
        rests = stage[i, M_STILL] == 1.0 and (b < 0 or stage[j, M_STILL] == 1.0)
        if coefficient > 0.0 and not rests:
            surface = abs(stage[i, M_WX]) + abs(stage[i, M_WY]) + abs(stage[i, M_WZ])
            speed = abs(stage[i, M_VX]) + abs(stage[i, M_VY]) + radius * surface
            if size <= _STUCK * speed:
                return False
            along, down = -coefficient * (along / size), -coefficient * (down / size)
        else:
            along, down = 0.0, 0.0
    # A force of 1 at the contact: on a along the normal and along the contact; and what it turns.
    toward = down * sine - cosine
    stage[c, C_TURN_X] = -nx * (along * sine) - ny * down
    stage[c, C_TURN_X + 1] = -ny * (along * sine) + nx * down
    stage[c, C_TURN_Z] = along * cosine
    push_x, push_y = nx * toward - ny * along, ny * toward + nx * along
    _answer(balls, laws, contacts, c, a, push_x, push_y, C_FIRST_X, C_FIRST_HOLD)
    if b >= 0:
        _answer(balls, laws, contacts, c, b, -push_x, -push_y, C_SECOND_X, C_SECOND_HOLD)
    return True


@kernel(inline=True)
def _answer(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    c: int,
    k: int,
    push_x: float,
    push_y: float,
    answer: int,
    hold: int,
) -> None:
    """Put in two columns what ball k's acceleration is by such a force, and what the cloth does."""
    ball, stage = balls.state[k], contacts.stage
    fx, fy = push_x / ball.mass, push_y / ball.mass
    cx, cy = 0.0, 0.0
    if laws.slides and ball.phase != SLIDING:
        # So that it goes on rolling: the cloth's friction changes a slip by 7/2 of itself.
        turn = 2.5 / ball.mass
        cx = -(fx - turn * stage[c, C_TURN_X + 1]) / 3.5
        cy = -(fy + turn * stage[c, C_TURN_X]) / 3.5
    is_still = stage[int(contacts.motion[k, AT]), M_STILL] == 1.0
    stage[c, answer] = 0.0 if is_still else fx + cx
    stage[c, answer + 1] = 0.0 if is_still else fy + cy
    stage[c, hold] = fx + cx if is_still else cx
    stage[c, hold + 1] = fy + cy if is_still else cy


@kernel(inline=True)
def _couple(contacts: Contacts, count: int) -> None:
    """Put in `contacts.matrix` how a force of 1 at each contact accelerates each gap."""
    stage = contacts.stage
    for c in range(count):
        a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
        nx, ny = contacts.forces[c, NX], contacts.forces[c, NY]
        for other in range(count):
            i, j = contacts.ends[other, FIRST], contacts.ends[other, SECOND]
            x, y = 0.0, 0.0
            for end, ball in ((C_FIRST_X, i), (C_SECOND_X, j)):
                if ball == a:
                    x -= stage[other, end]
                    y -= stage[other, end + 1]
                elif ball >= 0 and ball == b:
                    x += stage[other, end]
                    y += stage[other, end + 1]
            contacts.matrix[c, other] = nx * x + ny * y


@kernel
def _eliminate(contacts: Contacts, count: int) -> None:
    """Find in FORCE what takes every contact's RATE away, directly.

    `contacts.matrix`, which needn't be symmetric, holds how the force of each contact changes the
    rate of each; it is lost. A contact whose rate those before it decide, but for rounding, gets no
    force.
    """
    matrix, forces = contacts.matrix, contacts.forces
    for i in range(count):
        forces[i, FORCE] = 0.0
        forces[i, SCALED] = 0.0
        own, left = matrix[i, i], -forces[i, RATE]
        for j in range(i):
            if forces[j, SCALED] > 0.0 and matrix[i, j] != 0.0:
                part = matrix[i, j] / forces[j, SCALED]
                left -= part * forces[j, LEFT_OVER]
                for k in range(j + 1, count):
                    matrix[i, k] -= part * matrix[j, k]
        forces[i, LEFT_OVER] = left
        forces[i, SCALED] = matrix[i, i] if matrix[i, i] > _DEPENDENT * own else 0.0
    for i in range(count - 1, -1, -1):
        if forces[i, SCALED] > 0.0:
            left = forces[i, LEFT_OVER]
            for j in range(i + 1, count):
                left -= matrix[i, j] * forces[j, FORCE]
            forces[i, FORCE] = left / forces[i, SCALED]


@kernel(inline=True)
def _push(balls: Balls, laws: Laws, contacts: Contacts, c: int) -> None:
    """Let contact c's force accelerate and turn its balls."""
    stage, force = contacts.stage, contacts.forces[c, FORCE]
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    for k, answer, hold in ((a, C_FIRST_X, C_FIRST_HOLD), (b, C_SECOND_X, C_SECOND_HOLD)):
        if k < 0:
            continue
        m = int(contacts.motion[k, AT])
        ax, ay = force * stage[c, answer], force * stage[c, answer + 1]
        hold_x, hold_y = force * stage[c, hold], force * stage[c, hold + 1]
        turn = 2.5 * force / (balls.state[k].mass * balls.state[k].radius)
        stage[m, M_AX] += ax
        stage[m, M_AY] += ay
        stage[m, M_HOLD_X] += hold_x
        stage[m, M_HOLD_Y] += hold_y
        if laws.slides:
            stage[m, M_BX] += turn * stage[c, C_TURN_X]
            stage[m, M_BY] += turn * stage[c, C_TURN_X + 1]
            stage[m, M_TWIST] += turn * stage[c, C_TURN_Z]

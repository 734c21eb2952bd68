"""Takes away, by plastic impulses, the approach that is left where a contact step starts.

Plastic: the balls don't part. A ball at rest stays so, if the cloth would stop it again at once.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ANSWERING,
    FIRST,
    FORCE,
    NX,
    NY,
    RATE,
    SECOND,
    SLIDING,
    Balls,
    Contacts,
    Laws,
)
from ghostball.engine.core.tolerances import APPROACH_ROUNDING, LEAST_SPEED
from ghostball.engine.impacts.contact_solver import end_approach, gain_of, gap_rate
from ghostball.engine.impacts.laws.dispatch import nose_sine
from ghostball.engine.motion.geometry import (
    at_rest,
    capture_height,
    contact_tolerance,
    grip,
    negligible_hop,
    rolls_on,
    speed_of,
)
from ghostball.engine.motion.next_piece import loosen
from ghostball.engine.resting_contact.cloth_response import answering_mass
from ghostball.engine.resting_contact.gaps import gap_now

_RESIDUE = 2.0**-20
"""Hop, in units of a negligible one, left to the contact force: a thousandth of its speed."""


@kernel
def stop_approach(balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int) -> bool:
    """Take away what approach is left at the contacts, plastically: each is a negligible hop.

    A ball at rest stays so if the cloth would stop it again within `CAPTURE_HEIGHT`. False where
    some approach is left.
    """
    for m in range(members):
        k = contacts.member[m]
        # For now: that it moves. It may have been stopped at this very instant before.
        contacts.stopped[k] = contacts.stopped[k] or not at_rest(balls, k)
    if not _approaches(balls, laws, contacts, count):
        solved = True
    else:
        for m in range(members):
            k = contacts.member[m]
            firm = at_rest(balls, k)
            contacts.motion[k, ANSWERING] = math.inf if firm else answering_mass(balls, laws, k)
        solved = end_approach(contacts, count)
        for _ in range(members):
            if not _loosen_pushed(balls, laws, contacts, members, count, solved):
                break
            solved = end_approach(contacts, count)
        _push(balls, laws, contacts, members)
        rubbed = False
        for c in range(count):
            if contacts.ends[c, SECOND] < 0:
                rubbed = _rub_cushion(balls, laws, contacts, c) or rubbed
        if rubbed and _approaches(balls, laws, contacts, count):
            # In a corner, what one cushion rubs drives the ball into the other.
            solved = end_approach(contacts, count) and solved
            _push(balls, laws, contacts, members)
    for m in range(members):
        k = contacts.member[m]
        if abs(balls.state[k].vx) < LEAST_SPEED and abs(balls.state[k].vy) < LEAST_SPEED:
            balls.state[k].vx, balls.state[k].vy = 0.0, 0.0
        contacts.stopped[k] = contacts.stopped[k] and at_rest(balls, k)
    return solved


@kernel
def _push(balls: Balls, laws: Laws, contacts: Contacts, members: int) -> None:
    """Give every member its impulses."""
    for m in range(members):
        k = contacts.member[m]
        x, y = gain_of(contacts, k)
        if laws.slides and (x != 0.0 or y != 0.0) and not rolls_on(balls, k):
            loosen(balls, k)
        balls.state[k].vx += x
        balls.state[k].vy += y


@kernel
def _rub_cushion(balls: Balls, laws: Laws, contacts: Contacts, c: int) -> bool:
    """Give contact c, of a ball that slides with a cushion, the friction of its impulse, if any.

    By Coulomb's law, at the height where the impact law has the cushion touch it: all the bounces
    that the impulse stands for would rub.
    """
    k, cushion = contacts.ends[c, FIRST], -1 - contacts.ends[c, SECOND]
    ball = balls.state[k]
    if not laws.cushion_turns or ball.phase != SLIDING or contacts.forces[c, FORCE] == 0.0:
        return False
    nx, ny, radius = contacts.forces[c, NX], contacts.forces[c, NY], ball.radius
    sine = nose_sine(laws, int(laws.obstacles[cushion].law), radius)
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    turning = nx * ball.wx + ny * ball.wy
    along = (nx * ball.vy - ny * ball.vx) + radius * (cosine * ball.wz - sine * turning)
    down = radius * (nx * ball.wy - ny * ball.wx)
    size = speed_of(along, down)
    if size == 0.0:
        return False
    # Part of what the normal impulse does, friction does: less is left for the nose's own.
    friction = laws.cushion_friction
    part = friction / (cosine + friction * sine * (down / size))
    rubbed = min(part * (contacts.forces[c, FORCE] / ball.mass), size / 3.5)
    along, down = -rubbed * (along / size), -rubbed * (down / size)
    turn = 2.5 / radius
    ball.vx -= along * ny
    ball.vy += along * nx
    ball.wx -= turn * (nx * (along * sine) + ny * down)
    ball.wy -= turn * (ny * (along * sine) - nx * down)
    ball.wz += turn * (along * cosine)
    return True


@kernel
def _approaches(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> bool:
    """Whether any contact approaches by more than is left to its force; set normals and rates."""
    found = False
    for c in range(count):
        a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
        nx, ny, _ = gap_now(balls, laws, contacts, c)
        contacts.forces[c, NX] = nx
        contacts.forces[c, NY] = ny
        rate = gap_rate(balls, contacts, c)
        contacts.forces[c, RATE] = rate
        size = abs(balls.state[a].vx) + abs(balls.state[a].vy)
        if b >= 0:
            size += abs(balls.state[b].vx) + abs(balls.state[b].vy)
        other = b if b >= 0 else a
        height = _RESIDUE * contact_tolerance(balls, a, other)
        residue = negligible_hop(rate, max(grip(balls, a), grip(balls, other)), height)
        found = found or (rate < -APPROACH_ROUNDING * size and not residue)
    return found


@kernel
def _loosen_pushed(
    balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int, solved: bool
) -> bool:
    """Let members at rest answer to their impulses if the cloth doesn't stop them at once.

    That is, each within `CAPTURE_HEIGHT`; all of them where no impulses were found. Return whether
    there was one.
    """
    found = False
    for m in range(members):
        k = contacts.member[m]
        if not math.isinf(contacts.motion[k, ANSWERING]):
            continue
        pushed = _push_at(contacts, count, k)
        mass = answering_mass(balls, laws, k)
        height = capture_height(balls, k, k)
        if not (solved and negligible_hop(pushed / mass, balls.state[k].roll_slowing, height)):
            contacts.motion[k, ANSWERING] = mass
            found = True
    return found


@kernel
def _push_at(contacts: Contacts, count: int, k: int) -> float:
    """Return the size of the sum of ball k's impulses [N s]."""
    x, y = 0.0, 0.0
    for c in range(count):
        if k in (contacts.ends[c, FIRST], contacts.ends[c, SECOND]):
            sign = -1.0 if contacts.ends[c, FIRST] == k else 1.0
            x += sign * contacts.forces[c, FORCE] * contacts.forces[c, NX]
            y += sign * contacts.forces[c, FORCE] * contacts.forces[c, NY]
    return speed_of(x, y)

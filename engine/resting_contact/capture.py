"""The approach that is left where a contact step starts, taken away by plastic impulses."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ANSWERING,
    FIRST,
    NX,
    NY,
    PUSH_X,
    PUSH_Y,
    RATE,
    SECOND,
    SLIDING,
    Balls,
    Contacts,
    Laws,
)
from ghostball.engine.core.tolerances import APPROACH_ROUNDING
from ghostball.engine.impacts.plastic import end_approach, gained, gap_rate, sum_at
from ghostball.engine.motion.geometry import (
    at_rest,
    capture_height,
    contact_tolerance,
    grip,
    negligible_hop,
)
from ghostball.engine.motion.on_cloth import speed_of
from ghostball.engine.resting_contact.forces import gap_after

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
            contacts.motion[k, ANSWERING] = math.inf if firm else _moved_mass(balls, laws, k)
        solved = end_approach(contacts, count)
        for _ in range(members):
            if not _loosen_pushed(balls, laws, contacts, members, count, solved):
                break
            solved = end_approach(contacts, count)
        for m in range(members):
            k = contacts.member[m]
            balls.state[k].vx += gained(contacts, count, k, PUSH_X)
            balls.state[k].vy += gained(contacts, count, k, PUSH_Y)
    for m in range(members):
        k = contacts.member[m]
        contacts.stopped[k] = contacts.stopped[k] and at_rest(balls, k)
    return solved


@kernel
def _approaches(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> bool:
    """Whether any contact approaches by more than is left to its force; set normals and rates."""
    found = False
    for c in range(count):
        a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
        nx, ny, _ = gap_after(balls, laws, contacts, c, 0.0)
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
        pushed = speed_of(
            sum_at(contacts, count, k, PUSH_X, -1.0), sum_at(contacts, count, k, PUSH_Y, -1.0)
        )
        mass = _moved_mass(balls, laws, k)
        height = capture_height(balls, k, k)
        if not (solved and negligible_hop(pushed / mass, balls.state[k].roll_slowing, height)):
            contacts.motion[k, ANSWERING] = mass
            found = True
    return found


@kernel
def _moved_mass(balls: Balls, laws: Laws, k: int) -> float:
    """Mass [kg] with which member k answers to a negligible impulse.

    One that rolls, or rests, rolls on: the cloth ends so small a slip within part of
    `CAPTURE_HEIGHT`.
    """
    rolls = laws.slides and balls.state[k].phase != SLIDING and grip(balls, k) > 0.0
    mass: float = 1.4 * balls.state[k].mass if rolls else balls.state[k].mass
    return mass

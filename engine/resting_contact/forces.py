"""Compute the forces that keep an island's gaps closed over one contact step.

These are the forces between its balls and with cushions: normal forces by `impacts.contact_solver`,
and friction by `resting_contact.friction`, alternately until both are consistent.
`resting_contact.cloth_response` has the response of the cloth, `resting_contact.step` the whole
step.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.rows import REMEMBERED
from ghostball.engine.core.state import Contacts, World
from ghostball.engine.impacts.contact_solver import end_approach, take_back_gains
from ghostball.engine.motion.geometry import contact_tolerance
from ghostball.engine.resting_contact.cloth_response import accelerate, turns_little
from ghostball.engine.resting_contact.extrapolation import extrapolate, remember
from ghostball.engine.resting_contact.friction import load, rub_all
from ghostball.engine.resting_contact.gaps import (
    LARGE_OVERLAP,
    balls_of,
    compliance_of,
    excess,
    gap_now,
    gaps_are_closed,
    normal_after,
    overlap_to_end,
    stays_closed,
)

SWEEPS = 192
"""Largest number of rounds of all normal forces, then all friction; ten are usually enough.

If they aren't enough, the step is halved: in a short step, gaps hardly change, and small forces are
enough. With at most 24 rounds, balls that stick to each other between a cushion and a spinning ball
took twelve times as many steps.
"""

_LED_UNTIL = 96
"""Round from which on the forces aren't extrapolated any more.

With large friction and very different masses, there may be no forces that hold the gaps while
surfaces slip (Painlevé 1895). Each round then increases the forces, until the forces end the slips.
Extrapolating from these rounds gives forces that pull: with extrapolation, a chain of seven balls
took steps of 4e-9 s.
"""

_FROM = 7
"""Round before which the forces are first extrapolated from the last rounds, then before every
second round. Extrapolating before every round took a third more rounds."""

_PART_OF_COMPLIANCE = 0.25
"""Part of its compliance used for a member that the cloth holds, because it may give way."""


@kernel
def solve(world: World, members: int, count: int, duration: float, rubs: bool) -> bool:
    """Compute forces that close every gap at the end of a step; False if the step is too long.

    Complementarity: a force is never negative, and is 0 if the gap opens. Friction follows the
    normal forces, unless the contacts have none (`rubs` is False).
    """
    contacts = world.contacts
    for m in range(members):
        k = contacts.member[m]
        row, ball = contacts.motion[k], world.balls.state[k]
        row.load_x, row.load_y, row.new_bx, row.new_by = 0.0, 0.0, 0.0, 0.0
        row.twist_x, row.twist_y, row.twist_z = 0.0, 0.0, 0.0
        row.new_ax, row.new_ay = ball.ax, ball.ay
        accelerate(world, k, duration)
    for c in range(count):
        one = contacts.forces[c]
        one.force, one.along, one.up, one.coulomb_limit = 0.0, 0.0, 0.0, 0.0
        nx, ny = normal_after(world, c, 0.5 * duration)
        contacts.forces[c].nx, contacts.forces[c].ny = nx, ny
        _, _, contacts.forces[c].gap = gap_now(world, c)
    _, jammed = _hold(world, members, count, duration)
    # The first guess has no friction, so it isn't enough that the normal forces are steady.
    steady, still = False, 0
    for sweep in range(SWEEPS):
        contacts.turns[0] += 20 * count
        if steady and gaps_are_closed(world, count, duration, jammed):
            _mark_overlaps(world, members, count)
            return _is_short(world, members, count, duration)
        if still > 1:
            return False
        if _FROM - REMEMBERED <= sweep < _LED_UNTIL:
            remember(contacts, count, sweep - 1)
        if _FROM <= sweep < _LED_UNTIL and (sweep - _FROM) % 2 == 0:
            extrapolate(world, count, sweep - 1, duration)
        steady = not rubs or rub_all(world, count, duration)
        rests, jammed = _hold(world, members, count, duration)
        still = still + 1 if rests and _is_still(contacts, count, rubs) else 0
    return False


@kernel
def _is_still(contacts: Contacts, count: int, rubs: bool) -> bool:
    """Return whether a round changed no force at all.

    If no acceleration has changed in two rounds either, every later round gives the same forces.
    (One round isn't enough, because its friction was computed with earlier accelerations.) Mixing a
    round without changes with other rounds gives that round (`extrapolate`), except for an ulp of
    friction at its limit. No force closes the remaining gaps then. This happens in most steps that
    are tried while balls bounce on each other.
    """
    for c in range(count):
        one = contacts.forces[c]
        if one.force_change != 0.0:
            return False
        if rubs and (one.along_change != 0.0 or one.up_change != 0.0):
            return False
    return True


@kernel
def _hold(world: World, members: int, count: int, duration: float) -> tuple[bool, float]:
    """Change the normal forces so that each gap ends at its target, with the present responses.

    Return whether no member's acceleration has changed, and the overlap [m] that forces can't end
    because balls are jammed: in a row that fills the space between two cushions, the gaps have the
    same sum with any forces.
    """
    contacts = world.contacts
    forces = contacts.forces
    for m in range(members):
        k = contacts.member[m]
        # A member that the cloth holds may give way; it then has a part of its compliance.
        held = contacts.motion[k].compliance == 0.0
        compliance = (
            _PART_OF_COMPLIANCE / world.balls.state[k].mass
            if held
            else contacts.motion[k].compliance
        )
        contacts.motion[k].effective_mass = 1.0 / compliance
    for c in range(count):
        over = excess(world, c, duration)
        force = forces[c].force
        forces[c].rate = 2.0 * over / (duration * duration)
        forces[c].force_before, forces[c].kept_force = force, 0.0
        if compliance_of(contacts, c) == 0.0:
            # No force moves two balls that the cloth holds: the present force stays, or becomes 0.
            forces[c].kept_force = force if over <= 0.0 else 0.0
            forces[c].force, forces[c].rate = 0.0, math.inf
    take_back_gains(contacts, count)
    jammed = 0.0
    if not end_approach(contacts, count, 0.0):
        jammed, least = overlap_to_end(world, count, duration)
        end_approach(contacts, count, (2.0 * jammed + least) / (duration * duration))
    for c in range(count):
        forces[c].force += forces[c].kept_force
        change = forces[c].force - forces[c].force_before
        forces[c].force_change = change
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        load(contacts, a, b, change * forces[c].nx, change * forces[c].ny)
    still = True
    for m in range(members):
        row = contacts.motion[contacts.member[m]]
        ax, ay = row.new_ax, row.new_ay
        accelerate(world, contacts.member[m], duration)
        still = still and row.new_ax == ax and row.new_ay == ay
    return still, jammed


@kernel
def _is_short(world: World, members: int, count: int, duration: float) -> bool:
    """Return whether gaps stay within their tolerance in the step, and friction doesn't turn."""
    if not stays_closed(world, count, duration):
        return False
    for m in range(members):  # noqa: SIM110 - the compiler takes no generator
        if not turns_little(world, world.contacts.member[m], duration):
            return False
    return True


@kernel
def _mark_overlaps(world: World, members: int, count: int) -> None:
    contacts = world.contacts
    for m in range(members):
        contacts.motion[contacts.member[m]].overlaps = 0.0
    for c in range(count):
        a, b = balls_of(contacts, c)
        if contacts.forces[c].gap < -LARGE_OVERLAP * contact_tolerance(world.balls, a, b):
            contacts.motion[a].overlaps = 1.0
            contacts.motion[b].overlaps = 1.0

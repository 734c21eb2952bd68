"""Finds the forces that hold an island's gaps closed over one contact step.

Between its balls and with cushions: normal forces by `impacts.contact_solver`, and friction
(`resting_contact.friction`), interleaved until both fit. How the cloth responds is in
`resting_contact.cloth_response`; `resting_contact.step` has the whole.
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
"""Most rounds of all normal forces, then all friction; ten mostly do. Where they don't, the step is
halved: in a short one, gaps hardly change, and little is left to solve. With at most 24, balls that
stick to each other between a cushion and a spinning one took twelve times as many steps.
"""

_LED_UNTIL = 96
"""Round from which on the forces aren't led on any more.

Where contacts rub by much, and masses differ by much, no forces may hold the gaps while surfaces
slip (Painlevé 1895): each round then makes the forces greater, until they end the slips. What the
rounds seem to lead to are forces that pull, and a chain of seven balls that was led there took
steps of 4e-9 s.
"""

_FROM = 7
"""Round before which the forces are first led on, as the last rounds changed them: from then on
before every second. Before each round it took a third more of them."""

_PART_OF_COMPLIANCE = 0.25
"""Part of its compliance that a member counts with while the cloth holds it: it may give way."""


@kernel
def solve(world: World, members: int, count: int, duration: float, rubs: bool) -> bool:
    """Find forces that close every gap at the end of a step; False where the step is too long.

    Complementarity: a force is never negative, and is 0 where the gap opens. Friction follows it,
    unless the contacts don't rub.
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
    # No friction is in the first guess: that normal forces have settled is not enough.
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
    """Whether a round changed no force at all.

    Where no acceleration changed, either, in two rounds (in the first, friction was found with the
    accelerations before it), every round that follows does the same: mixing one that changed
    nothing with others gives that one (`extrapolate`), but for an ulp of friction that lies on its
    limit. No force closes the gaps that are left then; so it is in most steps that are tried while
    balls hop on each other.
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
    """Change the normal forces so that gaps end where the step aims at, as balls respond now.

    Return whether no member's acceleration is another than the forces before made it; and the
    overlap [m] that forces can't end, where balls are jammed: in a row that fills the place between
    two cushions, the gaps add up to the same whatever pushes.
    """
    contacts = world.contacts
    forces = contacts.forces
    for m in range(members):
        k = contacts.member[m]
        # A member that the cloth holds may give way: with a part of its compliance then.
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
            # No force moves two that the cloth holds: the one that there is stays, or goes.
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
    """Whether no gap leaves the tolerance within the step, and friction keeps its directions."""
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

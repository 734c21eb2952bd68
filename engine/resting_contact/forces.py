"""Finds the forces that hold a cluster's gaps closed over one contact step.

Between its balls and with cushions: normal forces by `impacts.contact_solver`, and friction
(`resting_contact.friction`), in turns until both fit. How the cloth answers is in
`resting_contact.cloth_response`; `resting_contact.step` has the whole.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ALONG,
    ANSWERING,
    DEEP,
    FIRST,
    FORCE,
    FORCE_BEFORE,
    GAP,
    KEPT,
    LIMIT,
    LOAD_X,
    LOAD_Y,
    MORE_FORCE,
    NEW_AX,
    NEW_AY,
    NEW_BX,
    NEW_BY,
    NX,
    NY,
    RATE,
    REMEMBERED,
    SECOND,
    TWIST_X,
    TWIST_Y,
    TWIST_Z,
    UP,
    YIELD,
    Balls,
    Contacts,
    Laws,
)
from ghostball.engine.impacts.contact_solver import end_approach, take_back_gains
from ghostball.engine.motion.geometry import contact_tolerance
from ghostball.engine.resting_contact.cloth_response import accelerate, turns_little
from ghostball.engine.resting_contact.extrapolation import extrapolate, remember
from ghostball.engine.resting_contact.friction import load, rub_all
from ghostball.engine.resting_contact.gaps import (
    DEEP_OVERLAP,
    balls_of,
    excess,
    gap_now,
    normal_after,
    settled,
    stays_closed,
    yields,
)

SWEEPS = 96
"""Most rounds of all normal forces, then all friction; ten mostly do. Where they don't, the step is
halved: in a short one, gaps hardly change, and little is left to solve. With at most 24, balls that
stick to each other between a cushion and a spinning one took twelve times as many steps.
"""

_FROM = 7
"""Round before which the forces are first led on, as the last rounds changed them: from then on
before every second. Before each round it took a third more of them."""

_SHARE = 0.25
"""Part of its answer that a member counts with while the cloth holds it, in case it gives way."""


@kernel
def solve(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    members: int,
    count: int,
    duration: float,
    rubs: bool,
) -> bool:
    """Find forces that close every gap at the end of a step; False where the step is too long.

    Complementarity: a force is never negative, and is 0 where the gap opens. Friction follows it,
    unless the contacts don't rub.
    """
    for m in range(members):
        k = contacts.member[m]
        for row in (LOAD_X, LOAD_Y, TWIST_X, TWIST_Y, TWIST_Z, NEW_BX, NEW_BY):
            contacts.motion[k, row] = 0.0
        contacts.motion[k, NEW_AX] = balls.state[k].ax
        contacts.motion[k, NEW_AY] = balls.state[k].ay
        accelerate(balls, laws, contacts, k, duration)
    for c in range(count):
        for column in (FORCE, ALONG, UP, LIMIT):
            contacts.forces[c, column] = 0.0
        nx, ny = normal_after(balls, laws, contacts, c, 0.5 * duration)
        contacts.forces[c, NX], contacts.forces[c, NY] = nx, ny
        _, _, contacts.forces[c, GAP] = gap_now(balls, laws, contacts, c)
    _hold(balls, laws, contacts, members, count, duration)
    # No friction is in the first guess: that normal forces have settled is not enough.
    steady = False
    for sweep in range(SWEEPS):
        contacts.turns[0] += 20 * count
        if steady and settled(balls, laws, contacts, count, duration):
            _mark_deep(balls, contacts, members, count)
            return _is_short(balls, laws, contacts, members, count, duration)
        if sweep >= _FROM - REMEMBERED:
            remember(contacts, count, sweep - 1)
        if sweep >= _FROM and (sweep - _FROM) % 2 == 0:
            extrapolate(balls, laws, contacts, count, sweep - 1, duration)
        steady = not rubs or rub_all(balls, laws, contacts, count, duration)
        _hold(balls, laws, contacts, members, count, duration)
    return False


@kernel
def _hold(
    balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int, duration: float
) -> None:
    """Change the normal forces so that the gaps end where the step aims at, as balls answer now."""
    forces = contacts.forces
    for m in range(members):
        k = contacts.member[m]
        # A member that the cloth holds may give way: with a part of its answer then.
        held = contacts.motion[k, YIELD] == 0.0
        answer = _SHARE / balls.state[k].mass if held else contacts.motion[k, YIELD]
        contacts.motion[k, ANSWERING] = 1.0 / answer
    for c in range(count):
        over = excess(balls, laws, contacts, c, duration)
        force = forces[c, FORCE]
        forces[c, RATE] = 2.0 * over / (duration * duration)
        forces[c, FORCE_BEFORE], forces[c, KEPT] = force, 0.0
        if yields(contacts, c) == 0.0:
            # No force moves two that the cloth holds: the one that there is stays, or goes.
            forces[c, KEPT] = force if over <= 0.0 else 0.0
            forces[c, FORCE], forces[c, RATE] = 0.0, math.inf
    take_back_gains(contacts, count)
    end_approach(contacts, count)
    for c in range(count):
        forces[c, FORCE] += forces[c, KEPT]
        change = forces[c, FORCE] - forces[c, FORCE_BEFORE]
        forces[c, MORE_FORCE] = change
        a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
        load(contacts, a, b, change * forces[c, NX], change * forces[c, NY])
    for m in range(members):
        accelerate(balls, laws, contacts, contacts.member[m], duration)


@kernel
def _is_short(
    balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int, duration: float
) -> bool:
    """Whether no gap leaves the tolerance within the step, and friction keeps its directions."""
    if not stays_closed(balls, laws, contacts, count, duration):
        return False
    for m in range(members):  # noqa: SIM110 - the compiler takes no generator
        if not turns_little(balls, contacts, contacts.member[m], duration):
            return False
    return True


@kernel
def _mark_deep(balls: Balls, contacts: Contacts, members: int, count: int) -> None:
    for m in range(members):
        contacts.motion[contacts.member[m], DEEP] = 0.0
    for c in range(count):
        a, b = balls_of(contacts, c)
        if contacts.forces[c, GAP] < -DEEP_OVERLAP * contact_tolerance(balls, a, b):
            contacts.motion[a, DEEP] = 1.0
            contacts.motion[b, DEEP] = 1.0

"""Plastic impulses: the least that end every approach of a group of contacts at once.

Those of joint impacts (`impacts.simultaneous`), and of what approach is left where a contact step
starts (`resting_contact.step`). All contacts are treated alike, and every sum over them is taken in
an order of its own terms, so that the result has the symmetry of the scene to the last bit, and
doesn't depend on the order of the balls.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ACTIVE,
    ALONE,
    ANSWERING,
    DIRECTION,
    FIRST,
    FORCE,
    LEFT_OVER,
    NX,
    NY,
    PRODUCT,
    PUSH_X,
    PUSH_Y,
    RATE,
    SCALED,
    SECOND,
    TERM,
    Balls,
    Contacts,
)
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.motion.geometry import reduced_mass

_ROUNDS = 96
"""Most choices of the contacts that have to push; two or three mostly do."""

_BLOCK_ROUNDS = 16
"""From then on only the worst contact changes sides: all at once may go round in circles."""

_STEPS_PER_CONTACT = 4
"""Most steps of conjugate gradients, in units of the contacts; one each does but for rounding."""

_RESIDUE = 64.0 * EPS
"""Approach, in units of the fastest, that rounding leaves a contact that doesn't push, at least."""

_ENDED = 8.0 * EPS
"""Approach, in the same units, at which the search for the impulses ends: its own rounding."""

_NULL = 2.0**-40
"""Curvature, in units of that of contacts which share no ball, that is rounding.

Where more contacts push than needed, as on balls between two cushions, some impulses do nothing.
Going on along those made them, and then everything, arbitrarily large.
"""

_UNSOLVED = 2.0**-30
"""Approach left, in the same units, at which impulses are no solution."""


@kernel
def end_approach(contacts: Contacts, count: int) -> bool:
    """Find the impulses [N s] after which no contact approaches, and none where one parts.

    In FORCE their sizes, in PUSH_X and PUSH_Y the vectors, on the second ball of each contact.
    Contacts that would have to pull are left out, and come back if they approach without. False
    where some approach is left; the impulses then take energy, as far as they can.

    Contract: the contacts are the first `count` of `contacts.ends`, with NX, NY and RATE set, and
    ANSWERING of each of their balls.
    """
    fastest = 0.0
    for c in range(count):
        contacts.forces[c, ACTIVE] = 1.0
        fastest = max(fastest, -contacts.forces[c, RATE])
    for turn in range(_ROUNDS):
        _end_active_approach(contacts, count, fastest)
        if _leave_out(contacts, count, turn):
            continue
        _apply(contacts, count, FORCE, PRODUCT)
        if _take_back(contacts, count, turn, fastest):
            continue
        approach = min(_worst_approach(contacts, count, 0.0), _worst_approach(contacts, count, 1.0))
        if approach >= -_UNSOLVED * fastest:
            return True
        break
    _take_energy(contacts, count)
    return False


@kernel
def _leave_out(contacts: Contacts, count: int, turn: int) -> bool:
    """Leave out contacts that would have to pull, if any: all, or later those that would most."""
    worst = 0.0
    for c in range(count):
        worst = min(worst, contacts.forces[c, FORCE])
    for c in range(count):
        force = contacts.forces[c, FORCE]
        if force < 0.0 and (turn < _BLOCK_ROUNDS or force == worst):
            contacts.forces[c, ACTIVE] = 0.0
    return worst < 0.0


@kernel
def _take_back(contacts: Contacts, count: int, turn: int, fastest: float) -> bool:
    """Take back contacts that approach, if any: all, or later those that do it fastest.

    By more than rounding, which is at least what is left of the rates that should be 0. Later by
    more than counts: to take the rest from a ball all but wedged, it would have to be stopped.
    """
    residue = _RESIDUE * fastest if turn < _BLOCK_ROUNDS else _UNSOLVED * fastest
    for c in range(count):
        if contacts.forces[c, ACTIVE] == 1.0:
            left = contacts.forces[c, RATE] + contacts.forces[c, PRODUCT]
            residue = max(residue, 4.0 * abs(left))
    worst = _worst_approach(contacts, count, 0.0)
    found = worst < -residue
    for c in range(count):
        left = contacts.forces[c, RATE] + contacts.forces[c, PRODUCT]
        enough = left < -residue if turn < _BLOCK_ROUNDS else left == worst
        if found and contacts.forces[c, ACTIVE] == 0.0 and enough:
            contacts.forces[c, ACTIVE] = 1.0
    return found


@kernel
def _worst_approach(contacts: Contacts, count: int, active: float) -> float:
    """Return the least rate of the active contacts, or of the others, after the impulses; or 0."""
    worst = 0.0
    for c in range(count):
        if contacts.forces[c, ACTIVE] == active:
            worst = min(worst, contacts.forces[c, RATE] + contacts.forces[c, PRODUCT])
    return worst


@kernel
def _take_energy(contacts: Contacts, count: int) -> None:
    """Scale impulses, none of which may pull, so that they take as much energy as they can."""
    for c in range(count):
        contacts.forces[c, FORCE] = max(0.0, contacts.forces[c, FORCE])
    _apply(contacts, count, FORCE, PRODUCT)
    work = -_dot(contacts, count, FORCE, RATE)
    curvature = _dot(contacts, count, FORCE, PRODUCT)
    scale(contacts, count, work / curvature if work > 0.0 and curvature > 0.0 else 0.0)


@kernel
def scale(contacts: Contacts, count: int, factor: float) -> None:
    """Multiply the impulses of `end_approach`."""
    for c in range(count):
        contacts.forces[c, FORCE] *= factor
        contacts.forces[c, PUSH_X] *= factor
        contacts.forces[c, PUSH_Y] *= factor


@kernel
def _end_active_approach(contacts: Contacts, count: int, fastest: float) -> None:
    """Find in FORCE the impulses that end the approach of just the active contacts.

    Conjugate gradients (Hestenes and Stiefel 1952), scaled by each contact's own mass: few steps
    whatever the masses, and the same arithmetic for every contact.
    """
    for c in range(count):
        active = contacts.forces[c, ACTIVE]
        contacts.forces[c, FORCE] = 0.0
        contacts.forces[c, LEFT_OVER] = -active * contacts.forces[c, RATE]
        scaled = _reduced_mass(contacts, c) * contacts.forces[c, LEFT_OVER]
        contacts.forces[c, SCALED] = scaled
        contacts.forces[c, DIRECTION] = scaled
    gain = _dot(contacts, count, LEFT_OVER, SCALED)
    for _ in range(_STEPS_PER_CONTACT * count):
        _apply(contacts, count, DIRECTION, PRODUCT)
        curvature = _dot(contacts, count, DIRECTION, PRODUCT)
        for c in range(count):
            mass = _reduced_mass(contacts, c)
            alone = contacts.forces[c, DIRECTION] / mass if mass > 0.0 else 0.0
            contacts.forces[c, ALONE] = alone
        if not curvature > _NULL * _dot(contacts, count, DIRECTION, ALONE):
            return
        step = gain / curvature
        worst = 0.0
        for c in range(count):
            if contacts.forces[c, ACTIVE] == 1.0:
                contacts.forces[c, FORCE] += step * contacts.forces[c, DIRECTION]
                contacts.forces[c, LEFT_OVER] -= step * contacts.forces[c, PRODUCT]
                worst = max(worst, abs(contacts.forces[c, LEFT_OVER]))
        if worst <= _ENDED * fastest:
            return
        for c in range(count):
            mass = _reduced_mass(contacts, c)
            contacts.forces[c, SCALED] = mass * contacts.forces[c, LEFT_OVER]
        previous, gain = gain, _dot(contacts, count, LEFT_OVER, SCALED)
        for c in range(count):
            onward = gain / previous * contacts.forces[c, DIRECTION]
            contacts.forces[c, DIRECTION] = contacts.forces[c, SCALED] + onward


@kernel
def _apply(contacts: Contacts, count: int, row: int, result: int) -> None:
    """Put in `result` how impulses in `row` change each contact's rate; their vectors in PUSH_*."""
    for c in range(count):
        contacts.forces[c, PUSH_X] = contacts.forces[c, row] * contacts.forces[c, NX]
        contacts.forces[c, PUSH_Y] = contacts.forces[c, row] * contacts.forces[c, NY]
    for c in range(count):
        a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
        gained_x = gained(contacts, count, b, PUSH_X)
        gained_y = gained(contacts, count, b, PUSH_Y)
        gained_x -= gained(contacts, count, a, PUSH_X)
        gained_y -= gained(contacts, count, a, PUSH_Y)
        change = contacts.forces[c, NX] * gained_x + contacts.forces[c, NY] * gained_y
        contacts.forces[c, result] = change


@kernel
def _reduced_mass(contacts: Contacts, c: int) -> float:
    """Reduced mass [kg] of what answers at contact c; 0 where nothing does."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    mass_a = contacts.motion[a, ANSWERING]
    mass_b = contacts.motion[b, ANSWERING] if b >= 0 else math.inf
    if math.isinf(mass_a):
        mass_a, mass_b = mass_b, mass_a
    if math.isinf(mass_a):
        return 0.0
    return mass_a if math.isinf(mass_b) else reduced_mass(mass_a, mass_b)


@kernel
def _dot(contacts: Contacts, count: int, row: int, other: int) -> float:
    """Sum of the products of two rows, from small to large: in no order of the contacts."""
    for c in range(count):
        term, place = contacts.forces[c, row] * contacts.forces[c, other], c
        while place > 0 and contacts.forces[place - 1, TERM] > term:
            contacts.forces[place, TERM] = contacts.forces[place - 1, TERM]
            place -= 1
        contacts.forces[place, TERM] = term
    total = 0.0
    for place in range(count):
        total += contacts.forces[place, TERM]
    return total


@kernel
def gained(contacts: Contacts, count: int, k: int, row: int) -> float:
    """Velocity [m/s] that the impulses in `row` give ball k; a cushion, k < 0, stays."""
    if k < 0:
        return 0.0
    gain: float = sum_at(contacts, count, k, row, -1.0) / contacts.motion[k, ANSWERING]
    return gain


@kernel
def gap_rate(balls: Balls, contacts: Contacts, c: int) -> float:
    """Rate of the gap of contact c [m/s]: negative where the two approach."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    vx, vy = -balls.state[a].vx, -balls.state[a].vy
    if b >= 0:
        vx, vy = balls.state[b].vx + vx, balls.state[b].vy + vy
    rate: float = contacts.forces[c, NX] * vx + contacts.forces[c, NY] * vy
    return rate


@kernel
def sum_at(contacts: Contacts, count: int, k: int, row: int, on_first: float) -> float:
    """Sum a row of `contacts.forces` over the contacts of ball k, where it is first, `on_first` x.

    The terms of each sign are added from small to large, and then both sums: that doesn't depend on
    the order of the contacts, and if all terms change sign, so does the sum.
    """
    terms = 0
    for c in range(count):
        if contacts.ends[c, FIRST] == k or contacts.ends[c, SECOND] == k:
            first = contacts.ends[c, FIRST] == k
            term = on_first * contacts.forces[c, row] if first else contacts.forces[c, row]
            place = terms
            while place > 0 and abs(contacts.forces[place - 1, TERM]) > abs(term):
                contacts.forces[place, TERM] = contacts.forces[place - 1, TERM]
                place -= 1
            contacts.forces[place, TERM] = term
            terms += 1
    positive, negative = 0.0, 0.0
    for place in range(terms):
        positive += max(contacts.forces[place, TERM], 0.0)
        negative += min(contacts.forces[place, TERM], 0.0)
    return positive + negative

"""The one solver of contacts that act together: how strongly each pushes, so that none approaches.

None pulls, and one that doesn't push may open: a linear complementarity problem. Joint impacts
(`impacts.simultaneous`) and the approach that is left where a resting contact starts
(`resting_contact.capture`) pose it for impulses, from the rates of the gaps; resting contacts
(`resting_contact.forces`) for forces, from how fast those rates change.

A choice of contacts that push is improved until it fits; the equations of each choice are solved by
conjugate gradients. All contacts are treated alike, and sums over them don't depend on their order:
so the result has the symmetry of the scene to the last bit, whatever the numbering of the balls.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ACTIVE,
    ANSWERING,
    DIRECTION,
    FIRST,
    FORCE,
    IMPULSE_X,
    IMPULSE_Y,
    LEFT_OVER,
    NX,
    NY,
    OWN_MASS,
    PRODUCT,
    PUSH_X,
    PUSH_Y,
    RATE,
    SCALED,
    SECOND,
    SMALL_X,
    SMALL_Y,
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
"""Curvature, in units of the largest of a contact alone, that is rounding.

Where more contacts push than needed, as on balls between two cushions, some impulses do nothing.
Going on along those made them, and then everything, arbitrarily large.
"""

_UNSOLVED = 2.0**-30
"""Approach left, in the same units, at which impulses are no solution."""


@kernel
def end_approach(contacts: Contacts, count: int) -> bool:
    """Find the impulses [N s] after which no contact approaches, and none where one parts.

    Or, of accelerations of gaps, the forces [N]. In FORCE is their size; `gain_of` returns
    what they give a ball. Contacts that would have to pull are left out, and come back
    if they approach without; one whose rate is inf stays out. False where some approach is left;
    the impulses then take energy, as far as they can.

    Contract: the contacts are the first `count` of `contacts.ends`, with NX, NY and RATE set, and
    ANSWERING of each of their balls.
    """
    if count == 1:
        _end_one(contacts)
        return True
    fastest = 0.0
    for c in range(count):
        contacts.forces[c, OWN_MASS] = _reduced_mass(contacts, c)
        contacts.forces[c, ACTIVE] = 1.0 if contacts.forces[c, RATE] <= 0.0 else 0.0
        fastest = max(fastest, -contacts.forces[c, RATE])
    for turn in range(_ROUNDS):
        _follow_gradients(contacts, count, fastest)
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
def _end_one(contacts: Contacts) -> None:
    """`end_approach` of a contact alone."""
    contacts.forces[0, FORCE] = max(0.0, -contacts.forces[0, RATE]) * _reduced_mass(contacts, 0)
    spread(contacts, 1, FORCE)


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
    spread(contacts, count, FORCE)


@kernel
def _follow_gradients(contacts: Contacts, count: int, fastest: float) -> None:
    """Find in FORCE the impulses that take the RATE of just the active contacts away.

    Conjugate gradients (Hestenes and Stiefel 1952), scaled by each contact's own mass: few steps
    whatever the masses.
    """
    for c in range(count):
        is_active = contacts.forces[c, ACTIVE] == 1.0
        contacts.forces[c, FORCE] = 0.0
        contacts.forces[c, LEFT_OVER] = -contacts.forces[c, RATE] if is_active else 0.0  # not 0 inf
        scaled = contacts.forces[c, OWN_MASS] * contacts.forces[c, LEFT_OVER]
        contacts.forces[c, SCALED] = scaled
        contacts.forces[c, DIRECTION] = scaled
    gain = _dot(contacts, count, LEFT_OVER, SCALED)
    for _ in range(_STEPS_PER_CONTACT * count):
        contacts.turns[0] += 8 * count
        _apply(contacts, count, DIRECTION, PRODUCT)
        curvature = _dot(contacts, count, DIRECTION, PRODUCT)
        alone = 0.0
        for c in range(count):
            mass, direction = contacts.forces[c, OWN_MASS], contacts.forces[c, DIRECTION]
            alone = max(alone, direction * direction / mass if mass > 0.0 else 0.0)
        if not curvature > _NULL * alone:
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
            mass = contacts.forces[c, OWN_MASS]
            contacts.forces[c, SCALED] = mass * contacts.forces[c, LEFT_OVER]
        previous, gain = gain, _dot(contacts, count, LEFT_OVER, SCALED)
        for c in range(count):
            onward = gain / previous * contacts.forces[c, DIRECTION]
            contacts.forces[c, DIRECTION] = contacts.forces[c, SCALED] + onward


@kernel
def _apply(contacts: Contacts, count: int, row: int, result: int) -> None:
    """Put in `result` how impulses in `row` change each contact's rate."""
    spread(contacts, count, row)
    for c in range(count):
        a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
        x, y = gain_of(contacts, a)
        x, y = -x, -y
        if b >= 0:
            more_x, more_y = gain_of(contacts, b)
            x, y = more_x + x, more_y + y
        contacts.forces[c, result] = contacts.forces[c, NX] * x + contacts.forces[c, NY] * y


@kernel
def take_back_gains(contacts: Contacts, count: int) -> None:
    """Take from each contact's RATE what the FORCE of all does to it."""
    _apply(contacts, count, FORCE, PRODUCT)
    for c in range(count):
        contacts.forces[c, RATE] -= contacts.forces[c, PRODUCT]


@kernel
def spread(contacts: Contacts, count: int, row: int) -> None:
    """Let `impulse_on` return of each ball what the impulses in `row` add up to."""
    forces = contacts.forces
    for c in range(count):
        forces[c, PUSH_X] = forces[c, row] * forces[c, NX]
        forces[c, PUSH_Y] = forces[c, row] * forces[c, NY]
    add_up(contacts, count, PUSH_X, PUSH_Y, -1.0)


@kernel
def add_up(contacts: Contacts, count: int, row_x: int, row_y: int, on_first: float) -> None:
    """Let `impulse_on` return of each ball the sums of two rows over its contacts.

    Where the ball is the first of a contact, the terms count `on_first` times. The sums don't
    depend on the order of the contacts: each term is split into two parts, both multiples of a
    number such that adding them is exact (Demmel and Nguyen 2013, Fast reproducible floating-point
    summation). What is left out is below 2^-80 of the largest term.
    """
    motion, forces = contacts.motion, contacts.forces
    most = 0.0
    for c in range(count):
        most = max(most, abs(forces[c, row_x]), abs(forces[c, row_y]))
        for end in (FIRST, SECOND):
            k = contacts.ends[c, end]
            if k >= 0:
                motion[k, IMPULSE_X], motion[k, IMPULSE_Y] = 0.0, 0.0
                motion[k, SMALL_X], motion[k, SMALL_Y] = 0.0, 0.0
    large, small = _grids(most, count)
    for c in range(count):
        x, y = forces[c, row_x], forces[c, row_y]
        large_x, large_y = _rounded(x, large), _rounded(y, large)
        small_x, small_y = _rounded(x - large_x, small), _rounded(y - large_y, small)
        a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
        motion[a, IMPULSE_X] += on_first * large_x
        motion[a, IMPULSE_Y] += on_first * large_y
        motion[a, SMALL_X] += on_first * small_x
        motion[a, SMALL_Y] += on_first * small_y
        if b >= 0:
            motion[b, IMPULSE_X] += large_x
            motion[b, IMPULSE_Y] += large_y
            motion[b, SMALL_X] += small_x
            motion[b, SMALL_Y] += small_y


@kernel(inline=True)
def impulse_on(contacts: Contacts, k: int) -> tuple[float, float]:
    """Return what impulses on ball k add up to [N s], along x and y."""
    row = contacts.motion[k]
    return row[IMPULSE_X] + row[SMALL_X], row[IMPULSE_Y] + row[SMALL_Y]


@kernel(inline=True)
def gain_of(contacts: Contacts, k: int) -> tuple[float, float]:
    """Return the velocity that these impulses give ball k [m/s], along x and y."""
    x, y = impulse_on(contacts, k)
    mass = contacts.motion[k, ANSWERING]
    return x / mass, y / mass


@kernel(inline=True)
def _grids(most: float, count: int) -> tuple[float, float]:
    """Return what makes sums of `count` terms up to `most` exact; and of what that leaves of them.

    Both for `_rounded`.
    """
    large = 4.0 * count * most
    return large, 2.0**-50 * count * large


@kernel(inline=True)
def _rounded(term: float, large: float) -> float:
    """Return the term as a multiple of the spacing of doubles at `large`; alike for both signs."""
    size = (large + abs(term)) - large
    return size if term > 0.0 else -size


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
    """Return the sum of the products of two rows, as `add_up`, but for 2^-40 of the largest.

    What stays out of one has no part in the sum, whatever the other holds.
    """
    most = 0.0
    for c in range(count):
        contacts.forces[c, TERM] = 0.0
        if contacts.forces[c, row] != 0.0:
            contacts.forces[c, TERM] = contacts.forces[c, row] * contacts.forces[c, other]
        most = max(most, abs(contacts.forces[c, TERM]))
    large, _ = _grids(most, count)
    total = 0.0
    for c in range(count):
        total += _rounded(contacts.forces[c, TERM], large)
    return total


@kernel
def gap_rate(balls: Balls, contacts: Contacts, c: int) -> float:
    """Rate of the gap of contact c [m/s]: negative where the two approach."""
    a, b = contacts.ends[c, FIRST], contacts.ends[c, SECOND]
    vx, vy = -balls.state[a].vx, -balls.state[a].vy
    if b >= 0:
        vx, vy = balls.state[b].vx + vx, balls.state[b].vy + vy
    rate: float = contacts.forces[c, NX] * vx + contacts.forces[c, NY] * vy
    return rate

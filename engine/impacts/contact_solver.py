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

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.rows import ContactRow, column_of
from ghostball.engine.core.state import Contacts, World
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.motion.geometry import reduced_mass

_FORCE, _RATE, _PRODUCT, _DIRECTION, _RESIDUAL, _SCALED = (
    column_of(ContactRow, field)
    for field in ("force", "rate", "product", "direction", "residual", "scaled")
)

PUSH_X, PUSH_Y = column_of(ContactRow, "push_x"), column_of(ContactRow, "push_y")
"""Columns for `add_up`."""

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
Continuing along those made them, and then everything, arbitrarily large.
"""

_UNSOLVED = 2.0**-30
"""Approach left, in the same units, at which impulses are no solution."""


@kernel
def end_approach(contacts: Contacts, count: int, noise: float) -> bool:
    """Find the impulses [N s] after which no contact approaches, and none where one parts.

    Or, of accelerations of gaps, the forces [N]. In FORCE is their size; `gain_of` returns
    what they give a ball. Contacts that would have to pull are left out, and come back
    if they approach without; one whose rate is inf stays out. False where some approach is left; if
    that is more than `noise`, in units of the rates, the impulses take energy, as far as they can.

    Contract: the contacts are the first `count` of `contacts.ends`, with NX, NY and RATE set, and
    EFFECTIVE_MASS of each of their balls.
    """
    if count == 1:
        _end_one(contacts)
        return True
    fastest = 0.0
    for c in range(count):
        contacts.forces[c].own_mass = _reduced_mass(contacts, c)
        contacts.forces[c].active = 1.0 if contacts.forces[c].rate <= 0.0 else 0.0
        fastest = max(fastest, -contacts.forces[c].rate)
    for turn in range(_ROUNDS):
        _solve_active(contacts, count, fastest, noise)
        if _leave_out(contacts, count, turn):
            continue
        _apply(contacts, count, _FORCE, _PRODUCT)
        if _take_back(contacts, count, turn, fastest, noise):
            continue
        approach = min(_worst_approach(contacts, count, 0.0), _worst_approach(contacts, count, 1.0))
        if approach >= -max(_UNSOLVED * fastest, noise):
            return approach >= -_UNSOLVED * fastest
        if not _leave_out_parting(contacts, count, turn, fastest):
            break
    _take_energy(contacts, count)
    return False


@kernel
def _end_one(contacts: Contacts) -> None:
    """`end_approach` of a contact alone."""
    contacts.forces[0].force = max(0.0, -contacts.forces[0].rate) * _reduced_mass(contacts, 0)
    spread(contacts, 1, _FORCE)


@kernel
def _leave_out(contacts: Contacts, count: int, turn: int) -> bool:
    """Leave out contacts that would have to pull, if any: all, or later those that would most."""
    worst = 0.0
    for c in range(count):
        worst = min(worst, contacts.forces[c].force)
    for c in range(count):
        force = contacts.forces[c].force
        if force < 0.0 and (turn < _BLOCK_ROUNDS or force == worst):
            contacts.forces[c].active = 0.0
    return worst < 0.0


@kernel
def _leave_out_parting(contacts: Contacts, count: int, turn: int, fastest: float) -> bool:
    """Leave out contacts that push and part, if any: all, or later those that part fastest.

    Where others approach on: two contacts all but parallel, as with a rail and with a jaw at its
    end, push as one (see `_NULL`), whatever each of them needs.
    """
    best = 0.0
    for c in range(count):
        if contacts.forces[c].active == 1.0:
            best = max(best, contacts.forces[c].rate + contacts.forces[c].product)
    found = best > _UNSOLVED * fastest
    for c in range(count):
        left = contacts.forces[c].rate + contacts.forces[c].product
        enough = left > _UNSOLVED * fastest if turn < _BLOCK_ROUNDS else left == best
        if found and contacts.forces[c].active == 1.0 and enough:
            contacts.forces[c].active = 0.0
    return found


@kernel
def _take_back(contacts: Contacts, count: int, turn: int, fastest: float, noise: float) -> bool:
    """Take back contacts that approach, if any: all, or later those that do it fastest.

    By more than rounding, which is at least what is left of the rates that should be 0. Later by
    more than counts: to take the rest from a ball all but wedged, it would have to be stopped.
    """
    residue = max(_RESIDUE * fastest if turn < _BLOCK_ROUNDS else _UNSOLVED * fastest, noise)
    for c in range(count):
        if contacts.forces[c].active == 1.0:
            left = contacts.forces[c].rate + contacts.forces[c].product
            residue = max(residue, 4.0 * abs(left))
    worst = _worst_approach(contacts, count, 0.0)
    found = worst < -residue
    for c in range(count):
        left = contacts.forces[c].rate + contacts.forces[c].product
        enough = left < -residue if turn < _BLOCK_ROUNDS else left == worst
        if found and contacts.forces[c].active == 0.0 and enough:
            contacts.forces[c].active = 1.0
    return found


@kernel
def _worst_approach(contacts: Contacts, count: int, active: float) -> float:
    """Return the least rate of the active contacts, or of the others, after the impulses; or 0."""
    worst = 0.0
    for c in range(count):
        if contacts.forces[c].active == active:
            worst = min(worst, contacts.forces[c].rate + contacts.forces[c].product)
    return worst


@kernel
def _take_energy(contacts: Contacts, count: int) -> None:
    """Scale impulses, none of which may pull, so that they take as much energy as they can."""
    for c in range(count):
        contacts.forces[c].force = max(0.0, contacts.forces[c].force)
    _apply(contacts, count, _FORCE, _PRODUCT)
    work = -_dot(contacts, count, _FORCE, _RATE)
    curvature = _dot(contacts, count, _FORCE, _PRODUCT)
    scale(contacts, count, work / curvature if work > 0.0 and curvature > 0.0 else 0.0)


@kernel
def scale(contacts: Contacts, count: int, factor: float) -> None:
    """Multiply the impulses of `end_approach`."""
    for c in range(count):
        contacts.forces[c].force *= factor
    spread(contacts, count, _FORCE)


@kernel
def _solve_active(contacts: Contacts, count: int, fastest: float, noise: float) -> None:
    """Find in FORCE the impulses that take the RATE of just the active contacts away.

    A part of the rates up to `noise` stays. In a row between two cushions no impulses can take the
    part that all contacts share; impulses that tried to became arbitrarily large.

    Conjugate gradients (Hestenes and Stiefel 1952), scaled by each contact's own mass: few steps
    whatever the masses.
    """
    most = 0.0
    for c in range(count):
        is_active = contacts.forces[c].active == 1.0
        contacts.forces[c].force = 0.0
        contacts.forces[c].residual = -contacts.forces[c].rate if is_active else 0.0  # not 0 inf
        scaled = contacts.forces[c].own_mass * contacts.forces[c].residual
        contacts.forces[c].scaled = scaled
        contacts.forces[c].direction = scaled
        most = max(most, abs(contacts.forces[c].residual))
    if most <= noise:
        return
    gain = _dot(contacts, count, _RESIDUAL, _SCALED)
    for _ in range(_STEPS_PER_CONTACT * count):
        contacts.turns[0] += 8 * count
        _apply(contacts, count, _DIRECTION, _PRODUCT)
        curvature = _dot(contacts, count, _DIRECTION, _PRODUCT)
        alone = 0.0
        for c in range(count):
            mass, direction = contacts.forces[c].own_mass, contacts.forces[c].direction
            alone = max(alone, direction * direction / mass if mass > 0.0 else 0.0)
        if not curvature > _NULL * alone:
            return
        step = gain / curvature
        worst = 0.0
        for c in range(count):
            if contacts.forces[c].active == 1.0:
                contacts.forces[c].force += step * contacts.forces[c].direction
                contacts.forces[c].residual -= step * contacts.forces[c].product
                worst = max(worst, abs(contacts.forces[c].residual))
        if worst <= max(_ENDED * fastest, noise):
            return
        for c in range(count):
            mass = contacts.forces[c].own_mass
            contacts.forces[c].scaled = mass * contacts.forces[c].residual
        previous, gain = gain, _dot(contacts, count, _RESIDUAL, _SCALED)
        for c in range(count):
            onward = gain / previous * contacts.forces[c].direction
            contacts.forces[c].direction = contacts.forces[c].scaled + onward


@kernel
def _apply(contacts: Contacts, count: int, column: int, result: int) -> None:
    """Put in `result` how impulses in `column` change each contact's rate."""
    spread(contacts, count, column)
    for c in range(count):
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        x, y = gain_of(contacts, a)
        x, y = -x, -y
        if b >= 0:
            more_x, more_y = gain_of(contacts, b)
            x, y = more_x + x, more_y + y
        contacts.columns[c, result] = contacts.forces[c].nx * x + contacts.forces[c].ny * y


@kernel
def take_back_gains(contacts: Contacts, count: int) -> None:
    """Take from each contact's RATE what the FORCE of all does to it."""
    _apply(contacts, count, _FORCE, _PRODUCT)
    for c in range(count):
        contacts.forces[c].rate -= contacts.forces[c].product


@kernel
def spread(contacts: Contacts, count: int, column: int) -> None:
    """Let `impulse_on` return of each ball what the impulses in `column` add up to."""
    forces = contacts.forces
    for c in range(count):
        forces[c].push_x = contacts.columns[c, column] * forces[c].nx
        forces[c].push_y = contacts.columns[c, column] * forces[c].ny
    add_up(contacts, count, PUSH_X, PUSH_Y, -1.0)


@kernel
def add_up(contacts: Contacts, count: int, column_x: int, column_y: int, on_first: float) -> None:
    """Let `impulse_on` return of each ball the sums of two columns over its contacts.

    Where the ball is the first of a contact, the terms count `on_first` times. The sums don't
    depend on the order of the contacts: each term is split into two parts, both multiples of a
    number such that adding them is exact (Demmel and Nguyen 2013, Fast reproducible floating-point
    summation). What is left out is below 2^-80 of the largest term.
    """
    motion = contacts.motion
    most = 0.0
    for c in range(count):
        most = max(most, abs(contacts.columns[c, column_x]), abs(contacts.columns[c, column_y]))
        for end in (st.FIRST, st.SECOND):
            k = contacts.ends[c, end]
            if k >= 0:
                motion[k].impulse_x, motion[k].impulse_y = 0.0, 0.0
                motion[k].small_x, motion[k].small_y = 0.0, 0.0
    large, small = _grids(most, count)
    for c in range(count):
        x, y = contacts.columns[c, column_x], contacts.columns[c, column_y]
        large_x, large_y = _rounded(x, large), _rounded(y, large)
        small_x, small_y = _rounded(x - large_x, small), _rounded(y - large_y, small)
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        motion[a].impulse_x += on_first * large_x
        motion[a].impulse_y += on_first * large_y
        motion[a].small_x += on_first * small_x
        motion[a].small_y += on_first * small_y
        if b >= 0:
            motion[b].impulse_x += large_x
            motion[b].impulse_y += large_y
            motion[b].small_x += small_x
            motion[b].small_y += small_y


@kernel(inline=True)
def impulse_on(contacts: Contacts, k: int) -> tuple[float, float]:
    """Return what impulses on ball k add up to [N s], along x and y."""
    row = contacts.motion[k]
    return row.impulse_x + row.small_x, row.impulse_y + row.small_y


@kernel(inline=True)
def gain_of(contacts: Contacts, k: int) -> tuple[float, float]:
    """Return the velocity that these impulses give ball k [m/s], along x and y."""
    x, y = impulse_on(contacts, k)
    mass = contacts.motion[k].effective_mass
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
    """Reduced mass [kg] of what responds at contact c; 0 where nothing does."""
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    mass_a = contacts.motion[a].effective_mass
    mass_b = contacts.motion[b].effective_mass if b >= 0 else math.inf
    if math.isinf(mass_a):
        mass_a, mass_b = mass_b, mass_a
    if math.isinf(mass_a):
        return 0.0
    return mass_a if math.isinf(mass_b) else reduced_mass(mass_a, mass_b)


@kernel
def _dot(contacts: Contacts, count: int, column: int, other: int) -> float:
    """Return the sum of the products of two columns, as `add_up`, but for 2^-40 of the largest.

    What stays out of one has no part in the sum, whatever the other holds.
    """
    most = 0.0
    for c in range(count):
        contacts.forces[c].term = 0.0
        if contacts.columns[c, column] != 0.0:
            contacts.forces[c].term = contacts.columns[c, column] * contacts.columns[c, other]
        most = max(most, abs(contacts.forces[c].term))
    large, _ = _grids(most, count)
    total = 0.0
    for c in range(count):
        total += _rounded(contacts.forces[c].term, large)
    return total


@kernel
def gap_rate(world: World, c: int) -> float:
    """Rate of the gap of contact c [m/s]: negative where the two approach."""
    balls, contacts = world.balls, world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    vx, vy = -balls.state[a].vx, -balls.state[a].vy
    if b >= 0:
        vx, vy = balls.state[b].vx + vx, balls.state[b].vy + vy
    rate: float = contacts.forces[c].nx * vx + contacts.forces[c].ny * vy
    return rate

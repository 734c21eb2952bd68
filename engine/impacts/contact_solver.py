"""Solver for contacts that act together: impulses or forces that end every approach.

Contacts can push but not pull, and only contacts without a push may open. This is a linear
complementarity problem. Simultaneous impacts (`impacts.simultaneous`) and the approach that is left
at the start of a resting contact (`resting_contact.capture`) use it for impulses, from the rates of
the gaps. Resting contacts (`resting_contact.forces`) use it for forces, from the second derivatives
of the gaps.

The set of pushing contacts is improved until it is consistent; the equations for each set are
solved by conjugate gradients. All contacts are treated alike, and sums over them don't depend on
their order. So the result has the symmetry of the scene to the last bit, for any numbering of the
balls.
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
"""Columns of contacts, for `add_up`."""

_ROUNDS = 96
"""Largest number of sets of pushing contacts that are tried; two or three are usually enough."""

_BLOCK_ROUNDS = 16
"""Rounds after which only the worst contact changes sides: changing all may cycle."""

_STEPS_PER_CONTACT = 4
"""Largest number of conjugate-gradient steps per contact; without rounding, one is enough."""

_RESIDUE = 64.0 * EPS
"""Largest approach, relative to the fastest, that counts as rounding, in an unpushed contact."""

_ENDED = 8.0 * EPS
"""Approach, relative to the fastest, at which the iteration for the impulses ends: its rounding."""

_NULL = 2.0**-40
"""Curvature, relative to the largest of a single contact, that counts as rounding.

If more contacts push than needed, as for balls between two cushions, some combinations of impulses
have no effect. Without this limit, steps along such combinations made all impulses arbitrarily
large.
"""

_UNSOLVED = 2.0**-30
"""Remaining approach, relative to the fastest, above which impulses aren't a solution.
"""


@kernel
def end_approach(contacts: Contacts, count: int, noise: float) -> bool:
    """Compute the impulses [N s] after which no contact approaches; parting contacts get none.

    If `rate` is the acceleration of each gap, the results are forces [N]. They are stored in
    `force`; `gain_of` returns their effect on a ball. Contacts that would have to pull are left
    out, and are included again if they approach without a force; a contact with an infinite rate
    stays out. The result is False if some approach is left; if it is more than `noise`, in the
    units of the rates, the impulses remove as much energy as they can.

    Contract: the contacts are the first `count` of `contacts.ends`, with `nx`, `ny` and `rate` set,
    and `effective_mass` of each of their balls.
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
    """Do the work of `end_approach` for a single contact."""
    contacts.forces[0].force = max(0.0, -contacts.forces[0].rate) * _reduced_mass(contacts, 0)
    spread(contacts, 1, _FORCE)


@kernel
def _leave_out(contacts: Contacts, count: int, turn: int) -> bool:
    """Leave out contacts that would have to pull: all, or later the worst only; True if any."""
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
    """Leave out contacts that push and part: all, or in later rounds the fastest; True if any.

    For the case that other contacts still approach: two nearly parallel contacts, for example with
    a rail and with a jaw at its end, act as one contact (see `_NULL`), although each of them needs
    another impulse.
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
    """Include contacts that approach again: all, or in later rounds the fastest; True if any.

    Their approach must be larger than rounding, which is estimated from the remaining rates of
    active contacts: these should be 0. In later rounds it must be larger than `_UNSOLVED`, because
    a smaller approach of a nearly wedged ball could only be removed by stopping the ball.
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
    """Return the smallest rate after the impulses, of active or of inactive contacts; at most 0."""
    worst = 0.0
    for c in range(count):
        if contacts.forces[c].active == active:
            worst = min(worst, contacts.forces[c].rate + contacts.forces[c].product)
    return worst


@kernel
def _take_energy(contacts: Contacts, count: int) -> None:
    """Set negative impulses to 0, and scale all so that they remove as much energy as they can."""
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
    """Store in `force` the impulses that cancel `rate` of the active contacts.

    A part of the rates up to `noise` stays. In a row between two cushions no impulses can cancel
    the part that all contacts have in common; attempts to cancel it made the impulses arbitrarily
    large.

    Conjugate gradients (Hestenes and Stiefel 1952), scaled with each contact's own mass, so that
    few steps are enough for any masses.
    """
    most = 0.0
    for c in range(count):
        is_active = contacts.forces[c].active == 1.0
        contacts.forces[c].force = 0.0
        contacts.forces[c].residual = -contacts.forces[c].rate if is_active else 0.0  # 0*inf: NaN
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
    """Store in `result` the change of each contact's rate that the impulses in `column` cause."""
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
    """Subtract from `rate` of each contact the effect of the forces of all contacts."""
    _apply(contacts, count, _FORCE, _PRODUCT)
    for c in range(count):
        contacts.forces[c].rate -= contacts.forces[c].product


@kernel
def spread(contacts: Contacts, count: int, column: int) -> None:
    """Add up the impulses in `column` for each ball, so that `impulse_on` returns the sum."""
    forces = contacts.forces
    for c in range(count):
        forces[c].push_x = contacts.columns[c, column] * forces[c].nx
        forces[c].push_y = contacts.columns[c, column] * forces[c].ny
    add_up(contacts, count, PUSH_X, PUSH_Y, -1.0)


@kernel
def add_up(contacts: Contacts, count: int, column_x: int, column_y: int, on_first: float) -> None:
    """Add up two columns over the contacts of each ball, so that `impulse_on` returns the sums.

    For the first ball of a contact, the terms are multiplied by `on_first`. The sums don't depend
    on the order of the contacts: each term is split into two parts, both multiples of a number with
    which adding them is exact (Demmel and Nguyen 2013, Fast reproducible floating-point summation).
    The neglected part is below 2^-80 of the largest term.
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
    """Return the sum of impulses on ball k [N s], along x and y."""
    row = contacts.motion[k]
    return row.impulse_x + row.small_x, row.impulse_y + row.small_y


@kernel(inline=True)
def gain_of(contacts: Contacts, k: int) -> tuple[float, float]:
    """Return the change of ball k's velocity by these impulses [m/s], along x and y."""
    x, y = impulse_on(contacts, k)
    mass = contacts.motion[k].effective_mass
    return x / mass, y / mass


@kernel(inline=True)
def _grids(most: float, count: int) -> tuple[float, float]:
    """Return two arguments of `_rounded` that make sums of `count` terms up to `most` exact.

    The first is for the terms, the second for their remainders.
    """
    large = 4.0 * count * most
    return large, 2.0**-50 * count * large


@kernel(inline=True)
def _rounded(term: float, large: float) -> float:
    """Return the term as a multiple of the spacing of doubles at `large`; symmetric in its sign."""
    size = (large + abs(term)) - large
    return size if term > 0.0 else -size


@kernel
def _reduced_mass(contacts: Contacts, c: int) -> float:
    """Return the reduced mass [kg] of the bodies at contact c; 0 if neither can move."""
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
    """Return the sum of the products of two columns, like `add_up`, within 2^-40 of the largest.

    A contact with 0 in the first column doesn't contribute, whatever the second contains.
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
    """Return the rate of the gap of contact c [m/s]: negative if the contact approaches."""
    balls, contacts = world.balls, world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    vx, vy = -balls.state[a].vx, -balls.state[a].vy
    if b >= 0:
        vx, vy = balls.state[b].vx + vx, balls.state[b].vy + vy
    rate: float = contacts.forces[c].nx * vx + contacts.forces[c].ny * vy
    return rate

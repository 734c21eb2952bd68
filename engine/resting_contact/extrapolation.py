"""Extrapolate the forces of a contact step to the limit of the rounds that compute them.

A round computes all friction from the present normal forces, then all normal forces. The solution
consists of forces that a round doesn't change. If balls stick to each other between two balls that
hold them, a round reduces the error by less than a thousandth. The changes in the last rounds
predict further changes: a mixture of the forces of the last few rounds is chosen so that a round
would change the mixture least, and the predicted change is added (Anderson 1965, in the form of
Walker and Ni 2011).

Extrapolating from one change alone (Irons and Tuck 1969) misled chains: eleven balls that stick to
each other, pushed into the end of a tube by a spinning ball, took seven times as many steps.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.rows import PER_ROUND, REMEMBERED
from ghostball.engine.core.state import Contacts, World
from ghostball.engine.resting_contact.friction import load, rub_more

_RIGHT = REMEMBERED
"""Column of `Contacts.matrix` with the right side of the equations, later with the weights."""

_DIAGONAL = REMEMBERED + 1
"""Column with the diagonal before elimination."""

_DEPENDENT = 1e-10
"""Fraction of the square of a difference that must be independent of the other differences.

A difference with less adds no information and is left out.
"""


@kernel
def remember(contacts: Contacts, count: int, turn: int) -> None:
    """Store the forces after the round number `turn`, and their changes in it."""
    history = _history_of(turn)
    for c in range(count):
        one, kept = contacts.forces[c], contacts.history[c, history]
        kept[0], kept[1], kept[2] = one.force, one.along, one.up
        kept[3], kept[4], kept[5] = one.force_change, one.along_change, one.up_change
    contacts.turns[0] += count


@kernel
def extrapolate(world: World, count: int, turn: int, duration: float) -> None:
    """Change every force to the extrapolation from the rounds up to number `turn`.

    It uses all stored rounds. No force becomes negative, and no friction larger than its limit.
    """
    contacts = world.contacts
    history, weights = contacts.history, contacts.matrix
    last = _history_of(turn)
    for j in range(REMEMBERED):
        other = _history_of(turn - 1 - j)
        for i in range(j + 1):
            third = _history_of(turn - 1 - i)
            product = 0.0
            for c in range(count):
                for part in range(3, PER_ROUND):
                    change = history[c, last, part] - history[c, other, part]
                    product += change * (history[c, last, part] - history[c, third, part])
            weights[j, i] = product
        right = 0.0
        for c in range(count):
            for part in range(3, PER_ROUND):
                change = history[c, last, part] - history[c, other, part]
                right += change * history[c, last, part]
        weights[j, _RIGHT] = right
        weights[j, _DIAGONAL] = weights[j, j]
    _solve(contacts)
    contacts.turns[0] += 2 * REMEMBERED * REMEMBERED * count
    for c in range(count):
        force = _mixed(contacts, c, turn, 0)
        along = _mixed(contacts, c, turn, 1)
        up = _mixed(contacts, c, turn, 2)
        one = contacts.forces[c]
        more = max(0.0, force) - one.force
        one.force += more
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        load(contacts, a, b, more * one.nx, more * one.ny)
        size, limit = math.sqrt(along * along + up * up), one.coulomb_limit
        if size > limit:
            along, up = limit * (along / size), limit * (up / size)
        more_along, more_up = along - one.along, up - one.up
        rub_more(world, c, more_along, more_up, duration)


@kernel
def _mixed(contacts: Contacts, c: int, turn: int, part: int) -> float:
    """Return a force of contact c as the weighted mixture of the rounds."""
    history, last = contacts.history, _history_of(turn)
    force: float = history[c, last, part]
    for j in range(REMEMBERED):
        change = history[c, last, part] - history[c, _history_of(turn - 1 - j), part]
        force -= contacts.matrix[j, _RIGHT] * change
    return force


@kernel
def _solve(contacts: Contacts) -> None:
    """Compute the weights of the differences by elimination, in the column of the right side.

    Only the lower half of the symmetric matrix is read.
    """
    matrix, n = contacts.matrix, REMEMBERED
    for i in range(n):
        if matrix[i, i] <= _DEPENDENT * matrix[i, _DIAGONAL]:
            matrix[i, i] = 0.0
            continue
        for j in range(i + 1, n):
            factor = matrix[j, i] / matrix[i, i]
            for k in range(i + 1, j + 1):
                matrix[j, k] -= factor * matrix[k, i]
            matrix[j, _RIGHT] -= factor * matrix[i, _RIGHT]
    for i in range(n - 1, -1, -1):
        if matrix[i, i] == 0.0:
            matrix[i, _RIGHT] = 0.0
            continue
        for j in range(i + 1, n):
            matrix[i, _RIGHT] -= matrix[j, i] * matrix[j, _RIGHT]
        matrix[i, _RIGHT] /= matrix[i, i]


@kernel(inline=True)
def _history_of(turn: int) -> int:
    """Return the index of a round in `Contacts.history`."""
    return turn % (REMEMBERED + 1)

"""A priority queue of all balls' next instants: a tournament, with the earliest at its root."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import FloatArray


@kernel(inline=True)
def enter_instant(tree: FloatArray, i: int, t: float) -> None:
    """Note that ball i's next instant is t [s], as far up the tree as it changes anything."""
    place = len(tree) // 2 + i
    tree[place] = t
    place >>= 1
    while place > 0:
        value = min(tree[2 * place], tree[2 * place + 1])
        if tree[place] == value:
            return
        tree[place] = value
        place >>= 1


@kernel(inline=True)
def least_of_others(tree: FloatArray, i: int) -> float:
    """Return the earliest instant of all balls but ball i [s]."""
    least = math.inf
    place = len(tree) // 2 + i
    while place > 1:
        least = min(least, tree[place ^ 1])
        place >>= 1
    return least


@kernel
def first_due(tree: FloatArray, t: float, start: int) -> int:
    """Return the first ball from `start` on whose next instant is t [s] or sooner, or NOWHERE."""
    leaves = len(tree) // 2
    if start >= leaves:
        return st.NOWHERE
    place = leaves + start
    if not tree[place] <= t:
        # Up, until a subtree to the right has it.
        while place & 1 or not tree[place + 1] <= t:
            place >>= 1
            if place <= 1:
                return st.NOWHERE
        place += 1
    while place < leaves:
        place = 2 * place if tree[2 * place] <= t else 2 * place + 1
    return place - leaves

"""Priority queue with the next time of every ball: a binary tree with the earliest at its root."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import FloatArray


@kernel(inline=True)
def enter_instant(tree: FloatArray, i: int, t: float) -> None:
    """Set the next time of ball i to t [s], and update the tree above it."""
    node = len(tree) // 2 + i
    tree[node] = t
    node >>= 1
    while node > 0:
        value = min(tree[2 * node], tree[2 * node + 1])
        if tree[node] == value:
            return
        tree[node] = value
        node >>= 1


@kernel(inline=True)
def least_of_others(tree: FloatArray, i: int) -> float:
    """Return the earliest next time of all balls except ball i [s]."""
    least = math.inf
    node = len(tree) // 2 + i
    while node > 1:
        least = min(least, tree[node ^ 1])
        node >>= 1
    return least


@kernel
def first_due(tree: FloatArray, t: float, start: int) -> int:
    """Return the first ball from `start` on whose next time is at most t [s], or NOWHERE."""
    leaves = len(tree) // 2
    if start >= leaves:
        return st.NOWHERE
    node = leaves + start
    if not tree[node] <= t:
        # Go up until a subtree to the right contains a due ball.
        while node & 1 or not tree[node + 1] <= t:
            node >>= 1
            if node <= 1:
                return st.NOWHERE
        node += 1
    while node < leaves:
        node = 2 * node if tree[2 * node] <= t else 2 * node + 1
    return node - leaves

"""Looks at the pairs that `_pairs` passes over: what shows that passing them over is harmless.

Nobody needs this for an answer. With it, `engine.skips` can switch single skips off, and the same
bits must come out: the bounds of a pair are a sequence that begins where the later of the two
changed its motion, each found from the one before, whoever asks and when.
"""

from __future__ import annotations

import math

from engine._jit import kernel
from engine._pairs import rescan
from engine._state import (
    ADVANCEMENTS,
    BOUNDS,
    FREE,
    NEXT,
    NOWHERE,
    OUT_OF_REACH,
    OWN_TIME,
    PARTNER,
    RECEDING,
    UNDISTURBED,
    Balls,
    BoolArray,
    Contacts,
    IntArray,
    Laws,
    Pairs,
)
from engine._touch import NOT_YET, first_bound, touch


@kernel(inline=True)
def look_again(
    balls: Balls,
    laws: Laws,
    pairs: Pairs,
    looked_at: BoolArray | None,
    contacts: Contacts | None,
    t: float,
    counters: IntArray,
) -> None:
    """Bound also the pairs that `update_pairs` left out, as `looked_at` says, at t [s].

    Contract: `update_pairs` has just been called; no allocation.
    """
    # The compiler leaves out what follows where the type of this argument is None. A run that goes
    # on where it stopped has found its next impact already, and touched nothing since.
    if looked_at is not None and balls.touched[0] > 0:
        _look_again(balls, laws, pairs, looked_at, contacts, t, counters)


@kernel
def _look_again(
    balls: Balls,
    laws: Laws,
    pairs: Pairs,
    looked_at: BoolArray,
    contacts: Contacts | None,
    t: float,
    counters: IntArray,
) -> None:
    n = len(balls.own_kind)
    for i in range(n):
        for j in range(i + 1, n):
            if not (looked_at[UNDISTURBED] or balls.changed[i] or balls.changed[j]):
                continue
            if contacts is not None and _holds(contacts, i, j):
                continue
            # A pair stands in the row of the ball that changed last.
            place = i * n + j if pairs.bound[i * n + j] < math.inf else j * n + i
            pairs.bound[place] = _bound(balls, laws, looked_at, i, j, t, counters)
    for i in range(n):
        rescan(balls, pairs, i)


@kernel
def _bound(
    balls: Balls,
    laws: Laws,
    looked_at: BoolArray,
    i: int,
    j: int,
    t: float,
    counters: IntArray,
) -> float:
    """Return the pair's bound that is due at the instant t [s] or later."""
    counters[BOUNDS] += 1
    end = min(balls.state[i, OWN_TIME], balls.state[j, OWN_TIME])
    bound = first_bound(balls, laws, i, j)
    while bound < t:
        counters[ADVANCEMENTS] += 1
        verdict, later, _ = touch(balls, i, j, bound, 0.0)
        if verdict != NOT_YET:
            # It touched at an instant that is past: a contact was missed. Found now, it changes
            # the answer, so that the comparison shows it.
            return t
        bound = later
    if bound == math.inf:
        # There is nothing to find before the motion changes: look once more then.
        return end if looked_at[RECEDING] else bound
    return bound if bound <= end or looked_at[OUT_OF_REACH] else math.inf


@kernel
def _holds(contacts: Contacts, i: int, j: int) -> bool:
    """Whether a contact step holds ball i to ball j."""
    if contacts.cluster[i] == FREE:
        return False
    row = contacts.first_held[i]
    while row != NOWHERE:
        if contacts.held[row, PARTNER] == j:
            return True
        row = contacts.held[row, NEXT]
    return False

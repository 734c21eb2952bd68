"""Looks at the pairs that `all_pairs` passes over: what shows that passing them over is harmless.

Nobody needs this for an answer. With it, `engine.running.skips` can switch single skips off, and
the same bits must come out. A pair that no event touched is bounded anew: its bounds are a sequence
that begins where the later of the two changed its motion, each found from the one before, whoever
asks and when. One that recedes, or is out of reach, is looked at until its motion changes; where it
overlaps, a contact was passed over, and finding it changes the answer.
"""

from __future__ import annotations

import math

from engine.core.kernel import kernel
from engine.core.state import (
    ADVANCEMENTS,
    BOUNDS,
    OUT_OF_REACH,
    RECEDING,
    UNDISTURBED,
    Balls,
    BoolArray,
    Contacts,
    IntArray,
    Laws,
    Pairs,
)
from engine.motion.pieces import relative_motion
from engine.scheduling.all_pairs import rescan
from engine.scheduling.contact_time import NOT_YET, first_bound, holds, touch

LOOKS = 32
"""Instants at which a pair is looked at that has no bound before its motion changes."""

DEEP = 2.0**-20
"""Overlap that rounding and contact steps don't leave, relative to the sum of the radii."""


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
            if contacts is not None and holds(contacts, i, j):
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
    if not (balls.changed[i] or balls.changed[j]):
        counters[BOUNDS] += 1
    end = min(balls.state[i].own_time, balls.state[j].own_time)
    bound = first_bound(balls, laws, i, j)
    while bound < t:
        counters[ADVANCEMENTS] += 1
        verdict, later, _ = touch(balls, i, j, bound, 0.0)
        if verdict != NOT_YET:
            # It touched at an instant that is past: a contact was missed. Found now, it changes
            # the answer, so that the comparison shows it.
            return t
        bound = later
    if bound <= end:
        return bound
    if looked_at[RECEDING if bound == math.inf else OUT_OF_REACH]:
        return overlap_until(balls, i, j, t, min(end, laws.t_max), counters)
    return math.inf


@kernel
def overlap_until(balls: Balls, i: int, j: int, t: float, end: float, counters: IntArray) -> float:
    """Return an instant between t and `end` [s] at which the pair overlaps, or inf.

    From where the balls are at `LOOKS` instants alone: no root is taken, and none is trusted.
    """
    if end == math.inf:
        return math.inf  # both rest, or nothing ends their motion but an event that isn't theirs
    reach = balls.state[i].radius + balls.state[j].radius
    for k in range(1, LOOKS + 1):
        counters[BOUNDS] += 1
        instant = t + (end - t) * (k / LOOKS)
        rx, ry, _, _, _, _ = relative_motion(balls, i, j, instant)
        if math.sqrt(rx * rx + ry * ry) < reach * (1.0 - DEEP):
            return instant
    return math.inf

"""Compare two sequences of collisions, where collisions of one instant have no order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

Collision = tuple[int, int, int]
"""`EventKind` as int, first ball, second ball or index of the cushion."""

TIE = 2.0**-40
"""Two times within this fraction of themselves are one instant (1e-12).

It is rounding, amplified by a few collisions; at 10 m/s it is 1e-11 m of path per second of motion.
"""


def matching_collisions(
    ours: Sequence[Collision], our_times: FloatArray, truth: Sequence[Collision], times: FloatArray
) -> int:
    """Count the leading collisions that two logs agree on.

    Parameters
    ----------
    ours, truth : sequence of Collision
        In order of time.
    our_times, times : (k,), (m,) float64 [s]
        Of each; an empty `times` says that no two collisions of the truth tie.

    Notes
    -----
    Order counts except within a window that neither log divides by time: collisions at one instant
    have no order, and an engine that reports one time for several says nothing of theirs. Two times
    are one instant where they differ by less than `TIE` of themselves.
    """
    matched = 0
    shorter = min(len(ours), len(truth))
    tied_ours, tied_truth = _ties(our_times), _ties(times)
    while matched < shorter:
        end = matched + 1
        while _tied(tied_ours, end) or _tied(tied_truth, end):
            end += 1
        expected = Counter(truth[matched:end])
        for collision in ours[matched:end]:
            if expected[collision] == 0:
                return matched
            expected[collision] -= 1
            matched += 1
        if matched < end:  # the log ends inside the window
            return matched
    return matched


def _ties(times: FloatArray) -> NDArray[np.bool_]:
    """Whether each time after the first is one instant with the time before it, (k - 1,)."""
    tied: NDArray[np.bool_] = np.diff(times) <= TIE * times[1:]
    return tied


def _tied(ties: NDArray[np.bool_], end: int) -> bool:
    """Whether the collisions before and after the boundary `end` tie."""
    return end - 1 < len(ties) and bool(ties[end - 1])

"""What double precision rounds: the spacing of doubles, and what given positions may be off by."""

from __future__ import annotations

from sys import float_info
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Lengths = TypeVar("Lengths", float, NDArray[np.float64])

EPS = float_info.epsilon
"""Spacing of doubles at 1 (twice the unit roundoff)."""

POSITION_ULPS = 16.0
"""Rounding errors, in units of EPS times the coordinates, that a *given* position may carry.

A rack computed from sqrt(3) and a few sums overlaps itself by up to about 4 of them; 16 leaves room
for longer sums. It decides only whether a scene is refused as overlapping; balls are never moved.
"""


def position_rounding(*lengths: Lengths) -> Lengths:
    """Largest distance [m] that rounding can put between given positions made of `lengths` [m].

    Elementwise.
    """
    total = abs(lengths[0])
    for length in lengths[1:]:
        total = total + abs(length)
    return POSITION_ULPS * EPS * total

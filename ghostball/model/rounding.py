"""What double precision rounds: the spacing of doubles, and what given positions may be off by."""

from __future__ import annotations

from sys import float_info

EPS = float_info.epsilon
"""Spacing of doubles at 1 (twice the unit roundoff)."""

POSITION_ULPS = 16.0
"""Rounding errors, in units of EPS times the coordinates, that a *given* position may carry.

A rack computed from sqrt(3) and a few sums overlaps itself by up to about 4 of them; 16 leaves room
for longer sums. It decides only whether a scene is refused as overlapping; balls are never moved.
"""


def position_rounding(*lengths: float) -> float:
    """Largest distance [m] that rounding can put between given positions made of `lengths` [m]."""
    return POSITION_ULPS * EPS * float(sum(abs(length) for length in lengths))

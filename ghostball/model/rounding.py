"""Permitted errors of given positions: rounding, and the tolerance of a resting contact."""

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
for longer sums. This number only decides whether a scene is rejected for overlaps; balls are never
moved.
"""

CONTACT_TOLERANCE = 2.0**-37
"""Opening or overlap, in diameters, of a gap that a contact force holds closed.

4e-13 m for pool balls: a thousand roundings of a coordinate on a table. Ghostball's engine keeps
the gaps of resting contacts within this tolerance (`engine.core.tolerances`). A scene may start
with such an overlap, because the rest positions of one shot are the initial positions of the next.
"""

FLIGHT_CONTACT_TOLERANCE = 2.0**-22
"""Overlap, in diameters, of an airborne ball with a ball that it lies on.

1.4e-8 m for pool balls, four times `LOWEST_BOUNCE` in `engine.core.tolerances`. No force holds such
a contact: in Ghostball's engine, the ball falls at most to this depth before it bounces.
"""


def position_rounding(*lengths: Lengths) -> Lengths:
    """Return the largest rounding error [m] of positions computed from `lengths` [m].

    The computation is elementwise.
    """
    total = abs(lengths[0])
    for length in lengths[1:]:
        total = total + abs(length)
    return POSITION_ULPS * EPS * total


def permitted_overlap(reach: Lengths, *lengths: Lengths) -> Lengths:
    """Return the largest permitted initial overlap [m] of balls on the cloth, elementwise.

    `reach` [m] is the sum of the radii of two balls, or the diameter of a ball at an obstacle.
    `lengths` [m] are the lengths from which the positions are computed.
    """
    return CONTACT_TOLERANCE * reach + position_rounding(*lengths)

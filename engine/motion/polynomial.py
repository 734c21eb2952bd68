"""How far a piece of motion goes: the only place where its polynomial is written down.

Of numbers or of arrays, in Python and, as `motion.pieces` has it, in kernels.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", float, NDArray[np.float64])


def way(velocity: Number, acceleration: Number, s: Number) -> Number:
    """Return how far a piece takes a coordinate in the time s [s] since it began [m]."""
    return s * (velocity + 0.5 * acceleration * s)


def speed(velocity: Number, acceleration: Number, s: Number) -> Number:
    """Return the velocity along a coordinate at the time s [s] after the piece began [m/s]."""
    return velocity + acceleration * s

"""How far a piece of motion goes: the only place where its polynomial is written down.

Of numbers or of arrays, in Python and, as `motion.pieces` has it, in kernels. What a piece has
beyond the square of the time are coefficients in pairs, for x and for y: those of the third power,
of the fourth, and so on, as many as there are.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", float, NDArray[np.float64])


def way(velocity: Number, acceleration: Number, s: Number) -> Number:
    """Return how far a piece takes a coordinate in the time s [s] since it began [m]."""
    return s * (velocity + 0.5 * acceleration * s)


def speed(velocity: Number, acceleration: Number, s: Number) -> Number:
    """Return the velocity along a coordinate at the time s [s] after the piece began [m/s]."""
    return velocity + acceleration * s


def tail(coefficients: Any, axis: int, s: Any, order: int) -> Any:
    """Return what the powers beyond the second add to a coordinate, or to a derivative of it.

    Parameters
    ----------
    coefficients : (2 k,) or (2 k, m) float64
        By power and axis.
    axis : int
        0 for x, 1 for y.
    s : float or (m,) float64 [s]
        Time since the piece began.
    order : int
        Which derivative, up to the third.
    """
    total = 0.0 * s
    for row in range(len(coefficients) - 2 + axis, -1, -2):
        factor = 1.0
        for lower in range(order):
            factor *= 3 + row // 2 - lower
        total = total * s + factor * coefficients[row]
    for _ in range(3 - order):
        total = total * s
    return total

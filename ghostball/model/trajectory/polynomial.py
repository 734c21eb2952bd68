"""The polynomial of the time by which a ball moves between events: the only place that has it.

Of numbers or of arrays, in Python and, as `motion.position` has it, in kernels. What a piece has
beyond the square of the time are coefficients in pairs, for x and for y: those of the third power,
of the fourth, and so on, as many as there are. What air adds to a height begins with the second.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", float, NDArray[np.float64])


def displacement(velocity: Number, acceleration: Number, s: Number) -> Number:
    """Return how far a piece takes a coordinate in the time s [s] since it began [m]."""
    return s * (velocity + 0.5 * acceleration * s)


def speed(velocity: Number, acceleration: Number, s: Number) -> Number:
    """Return the velocity along a coordinate at the time s [s] after the piece began [m/s]."""
    return velocity + acceleration * s


def tails(coefficients: Any, count: int, s: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
    """Return what powers beyond the second add to x, y, their velocities and accelerations.

    `coefficients` (2 k,) or (2 k, m) are by power and axis, of which `count` are taken, at most k;
    `s` is the time since the piece began [s], or (m,) of them.
    """
    # All as s^3 q(s): q, its derivative, and half of its second one, by Horner's scheme.
    x, y, vx, vy, ax, ay = 0.0 * s, 0.0 * s, 0.0 * s, 0.0 * s, 0.0 * s, 0.0 * s
    for power in range(count - 1, -1, -1):
        ax, ay = ax * s + vx, ay * s + vy
        vx, vy = vx * s + x, vy * s + y
        x, y = x * s + coefficients[2 * power], y * s + coefficients[2 * power + 1]
    square = s * s
    ax, ay = 6.0 * x + s * (6.0 * vx + 2.0 * s * ax), 6.0 * y + s * (6.0 * vy + 2.0 * s * ay)
    vx, vy = 3.0 * x + s * vx, 3.0 * y + s * vy
    return square * s * x, square * s * y, square * vx, square * vy, s * ax, s * ay


def rises(coefficients: Any, count: int, s: Any) -> tuple[Any, Any, Any]:
    """Return what powers from the second on add to a height, its velocity and its acceleration.

    `coefficients` (k,) or (k, m) are by power, of which `count` are taken, at most k; `s` is
    the time since the piece began [s], or (m,) of them.
    """
    # As s^2 q(s): q, its derivative, and half of its second one.
    z, vz, az = 0.0 * s, 0.0 * s, 0.0 * s
    for power in range(count - 1, -1, -1):
        az = az * s + vz
        vz = vz * s + z
        z = z * s + coefficients[power]
    return s * s * z, s * (2.0 * z + s * vz), 2.0 * z + s * (4.0 * vz + 2.0 * s * az)

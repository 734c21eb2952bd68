"""The polynomials in time that describe the motion of a ball between events.

Ghostball has no other code for these polynomials: Python calls the functions with numbers or
arrays, and kernels call them through `motion.position`. The motion of a ball slowed by air contains
further powers of the time: for each power, from the second, a piece has `PER_POWER` coefficients.
The second power of x and y is in the acceleration; the coefficients here are 0.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", float, NDArray[np.float64])

PER_POWER = 5
"""Coefficients of a power p of the time, in this order: x, y, z [m/s^p], wx, wy [rad/s^(p+1)]."""

OF_X, OF_Y, OF_Z, OF_WX, OF_WY = range(PER_POWER)


def displacement(velocity: Number, acceleration: Number, s: Number) -> Number:
    """Return the displacement of a coordinate [m] in the time s [s] since the piece began."""
    return s * (velocity + 0.5 * acceleration * s)


def speed(velocity: Number, acceleration: Number, s: Number) -> Number:
    """Return the velocity of a coordinate at the time s [s] since the start of the piece [m/s]."""
    return velocity + acceleration * s


def tails(coefficients: Any, count: int, s: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
    """Return the part of x, y, their velocities and accelerations from powers above the second.

    `coefficients`: (PER_POWER k,) or (PER_POWER k, m), by power. The first `count` powers are used,
        at most k.
    `s`: time since the start of the piece [s], a number or (m,).
    """
    # Each is s^3 q(s): this computes q, its derivative, and half of its second derivative, by
    # Horner's scheme.
    x, y, vx, vy, ax, ay = 0.0 * s, 0.0 * s, 0.0 * s, 0.0 * s, 0.0 * s, 0.0 * s
    for power in range(count - 1, 0, -1):
        ax, ay = ax * s + vx, ay * s + vy
        vx, vy = vx * s + x, vy * s + y
        x = x * s + coefficients[PER_POWER * power + OF_X]
        y = y * s + coefficients[PER_POWER * power + OF_Y]
    square = s * s
    ax, ay = 6.0 * x + s * (6.0 * vx + 2.0 * s * ax), 6.0 * y + s * (6.0 * vy + 2.0 * s * ay)
    vx, vy = 3.0 * x + s * vx, 3.0 * y + s * vy
    return square * s * x, square * s * y, square * vx, square * vy, s * ax, s * ay


def rises(coefficients: Any, count: int, s: Any) -> tuple[Any, Any, Any]:
    """Return the part of a height, its velocity and acceleration from powers of at least 2.

    Arguments as in `tails`.
    """
    # The height is s^2 q(s): this computes q, its derivative, and half of its second derivative.
    z, vz, az = 0.0 * s, 0.0 * s, 0.0 * s
    for power in range(count - 1, -1, -1):
        az = az * s + vz
        vz = vz * s + z
        z = z * s + coefficients[PER_POWER * power + OF_Z]
    return s * s * z, s * (2.0 * z + s * vz), 2.0 * z + s * (4.0 * vz + 2.0 * s * az)


def turns(coefficients: Any, count: int, s: Any) -> tuple[Any, Any]:
    """Return the part of the angular velocities wx and wy from powers of at least 2.

    Arguments as in `tails`.
    """
    wx, wy = 0.0 * s, 0.0 * s
    for power in range(count - 1, -1, -1):
        wx = wx * s + coefficients[PER_POWER * power + OF_WX]
        wy = wy * s + coefficients[PER_POWER * power + OF_WY]
    return s * s * wx, s * s * wy

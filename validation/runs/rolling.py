"""The spin of a ball that continues to roll after its velocity was changed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ghostball.model import rolling_angular_velocity


def rolling_spin(
    velocity: Sequence[float], radius: float, about_vertical: float
) -> tuple[float, float, float]:
    """Return the angular velocity [rad/s] of a rolling ball with a given spin about the vertical.

    The bits equal those of the engine: any rounding error would be slip, and the ball would slide.
    """
    x, y, _ = rolling_angular_velocity(np.array(velocity), np.array(radius)).tolist()
    return x, y, about_vertical

"""The spin of a ball that continues rolling when its velocity is changed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ghostball.model import rolling_angular_velocity


def rolling_spin(
    velocity: Sequence[float], radius: float, about_vertical: float
) -> tuple[float, float, float]:
    """Return the angular velocity [rad/s] of a ball that rolls, with its spin about the vertical.

    To the bit as the engine has it: the least rounding would be a slip, and the ball would slide.
    """
    x, y, _ = rolling_angular_velocity(np.array(velocity), np.array(radius)).tolist()
    return x, y, about_vertical

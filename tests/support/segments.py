"""The recorded motion of one ball, from closed forms: slide, roll, rest, end of the spin.

The module is independent of the engine's kernels and events.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from shots import R

from ghostball.model import ExactTrajectory

G = 9.81
ROLLING_FRICTION = 0.01
SLIDING_FRICTION = 0.2
SPIN_DECELERATION = 10.0

Segment = NDArray[np.float64]


def slide(
    t: float, position: Sequence[float], velocity: Sequence[float], spin: Sequence[float]
) -> tuple[Segment, float]:
    """Return the segment of a ball that slides from time t, and the duration of the slide [s]."""
    slip = np.array([velocity[0] - R * spin[1], velocity[1] + R * spin[0]])
    speed = float(np.hypot(*slip))
    ax, ay = -SLIDING_FRICTION * G * slip / speed
    turning = 2.5 / R
    segment = [t, *position, *velocity, ax, ay, *spin, turning * ay, -turning * ax, 0.0, 1.0]
    return np.array(segment), 2.0 * speed / (7.0 * SLIDING_FRICTION * G)


def roll(
    t: float, position: Sequence[float], velocity: Sequence[float], wz: float
) -> tuple[Segment, float]:
    """Return the segment of a ball that rolls from time t, and the duration of the roll [s].

    Unused columns are NaN, so that reading one invalidates the result.
    """
    speed = math.hypot(*velocity)
    ax, ay = (-ROLLING_FRICTION * G * v / speed for v in velocity)
    nan = math.nan
    segment = [t, *position, *velocity, ax, ay, nan, nan, wz, nan, nan, 0.0, 2.0]
    return np.array(segment), speed / (ROLLING_FRICTION * G)


def rest(t: float, position: Sequence[float], wz: float) -> Segment:
    """Return the segment of a ball whose centre rests from time t."""
    nan = math.nan
    return np.array([t, *position, 0.0, 0.0, 0.0, 0.0, nan, nan, wz, nan, nan, 0.0, 0.0])


def trajectory_of(*segments: Segment, t_end: float) -> ExactTrajectory:
    """Return the motion of one ball."""
    return ExactTrajectory(
        np.array([R]), (np.array(segments),), t_end, np.array([SPIN_DECELERATION])
    )


def whole_shot(velocity: Sequence[float], spin: Sequence[float]) -> ExactTrajectory:
    """Return the motion of a ball from the origin: slide, roll, rest, end of the spin."""
    first, slides = slide(0.0, (0.0, 0.0), velocity, spin)
    position = first[1:3] + slides * (first[3:5] + 0.5 * slides * first[5:7])
    wz = _decayed(spin[2], slides)
    second, rolls = roll(slides, position, first[3:5] + slides * first[5:7], wz)
    position = position + 0.5 * rolls * second[3:5]
    wz = _decayed(wz, rolls)
    third = rest(slides + rolls, position, wz)
    return trajectory_of(first, second, third, t_end=slides + rolls + abs(wz) / SPIN_DECELERATION)


def _decayed(wz: float, duration: float) -> float:
    return math.copysign(max(abs(wz) - SPIN_DECELERATION * duration, 0.0), wz)

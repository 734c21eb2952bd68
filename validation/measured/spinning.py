"""Simulated spin about the vertical: its deceleration, and that of a ball that rolls with it."""

from __future__ import annotations

from typing import Final

import numpy as np

from ghostball.model import Ball, Physics, Scene
from ghostball.validation.measured.simulated_ball import BallSize, OperatorError, Play

GOLF_BALL: Final = BallSize(0.02135, 0.0459)
"""The smallest radius and the largest mass that the rules of golf permit."""

_TIMES: Final = (0.05, 0.45)  # in which the ball is observed [s]
_SPIN: Final = 60.0  # at the start [rad/s]
_SPEED: Final = 0.5  # at the start, if the ball rolls [m/s]


def decelerations(play: Play, physics: Physics, *, spins: bool, rolls: bool) -> tuple[float, float]:
    """Return the deceleration of a golf ball [m/s^2], and that of its spin [rad/s^2].

    `spins`, `rolls`: whether the ball spins about the vertical, and whether it rolls, at the start.
    A motion that it doesn't have has the deceleration 0.

    Raises `OperatorError` if a motion ends before the end of the observation.
    """
    radius = GOLF_BALL.radius
    speed, spin = _SPEED * rolls, _SPIN * spins
    ball = Ball(
        id="cue",
        position=(0.0, 0.0),
        velocity=(speed, 0.0),
        angular_velocity=(0.0, speed / radius, spin),
        **GOLF_BALL._asdict(),
    )
    scene = Scene(name="golf", physics=physics, balls=[ball], t_max=_TIMES[1])
    times = np.linspace(*_TIMES, 9)
    found = play(scene).sample(times)
    speeds = np.linalg.norm(found.velocities[:, 0, :2], axis=1)
    turns = np.abs(found.angular_velocities[:, 0, 2])
    if (rolls and not speeds[-1] > 0.0) or (spins and not turns[-1] > 0.0):
        raise OperatorError(f"a golf ball stops rolling or spinning within {_TIMES[1]:g} s")
    slopes = np.polyfit(times, np.column_stack([speeds, turns]), 1)[0]
    return -float(slopes[0]), -float(slopes[1])

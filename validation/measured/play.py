"""What every operator plays with: an engine, and the balls of the measurements."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

from ghostball.model import (
    POOL_BALL_MASS,
    POOL_BALL_RADIUS,
    GhostballError,
    Physics,
    Result,
    Scene,
    Table,
)

Play = Callable[[Scene], Result]
"""What plays a scene and records its motion."""


class OperatorError(GhostballError):
    """A ball that doesn't do what was measured: it doesn't bounce, roll or come back."""


class BallSize(NamedTuple):
    """The balls of a game."""

    radius: float  # [m]
    mass: float  # [kg]


CAROM_BALL: Final = BallSize(**Table.BALLS["carom-10ft"])
POOL_BALL: Final = BallSize(POOL_BALL_RADIUS, POOL_BALL_MASS)
SNOOKER_BALL: Final = BallSize(**Table.BALLS["snooker-12ft"])


def rolling_deceleration(physics: Physics, speed: float) -> float:
    """Return how the cloth slows a ball that rolls at a speed [m/s^2]."""
    return physics.rolling_friction * physics.gravity + (
        physics.rolling_friction_quadratic * speed**2
    )

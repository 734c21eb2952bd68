"""Parts that all measurements share: the engine, the sizes of balls, and the track of one ball."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

from ghostball.model import (
    POOL_BALL_MASS,
    POOL_BALL_RADIUS,
    Ball,
    GhostballError,
    Physics,
    Result,
    Scene,
    Table,
)
from ghostball.validation.measured.tracks import Track, tracks_of

Play = Callable[[Scene], Result]
"""Simulates a scene and records its motion."""


class OperatorError(GhostballError):
    """A simulated shot without the measured motion: a ball doesn't bounce, roll or come back."""


class BallSize(NamedTuple):
    """Radius and mass of the balls of a game."""

    radius: float  # [m]
    mass: float  # [kg]


CAROM_BALL: Final = BallSize(**Physics.BALLS["carom"])
POOL_BALL: Final = BallSize(POOL_BALL_RADIUS, POOL_BALL_MASS)
SNOOKER_BALL: Final = BallSize(**Physics.BALLS["snooker"])


def rolling_deceleration(physics: Physics, speed: float) -> float:
    """Return the deceleration of a rolling ball by the cloth, at a speed [m/s^2]."""
    return physics.rolling_friction * physics.gravity + (
        physics.rolling_friction_quadratic * speed**2
    )


def track_of(
    play: Play,
    physics: Physics,
    table: Table,
    size: BallSize,
    *,
    position: tuple[float, float],
    velocity: tuple[float, float],
    lasts: float,
    angular_velocity: tuple[float, float, float] | None = None,
    rate: float = 50.0,
) -> Track:
    """Simulate one ball on a table, and return the track that a camera sees.

    `lasts` [s].
    `angular_velocity` [rad/s]: default: the ball rolls.
    `rate`: pictures per second.
    """
    ball = Ball(
        id="cue",
        position=position,
        velocity=velocity,
        angular_velocity=angular_velocity,
        **size._asdict(),
    )
    scene = Scene(name="one-ball", table=table, physics=physics, balls=[ball], t_max=lasts)
    return tracks_of(play(scene), rate)["cue"]

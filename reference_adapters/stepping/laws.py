"""The laws of a scene as numbers that engines which step are given."""

from __future__ import annotations

import math

import numpy as np

from ghostball.model import Physics, Scene, first_energy
from ghostball.model.arrays import FloatArray

LEAST_RESTITUTION = 2.0**-52
"""Restitution of balls that stands for 0, so that cushions can have another [1].

A ball then leaves at 2e-16 of its approach speed: rounding.
"""


def largest_momenta(scene: Scene) -> FloatArray:
    """Return the momentum that each ball would have with all the energy, (n,) [kg m/s].

    A spin counts: sliding can turn it into speed.
    """
    energy = first_energy(scene)
    momenta: FloatArray = np.sqrt(2.0 * energy * scene.masses)
    return momenta


def fastest(scene: Scene) -> float:
    """Return the speed of the lightest ball if it had all the energy [m/s]."""
    return float(np.max(largest_momenta(scene) / scene.masses))


def restitutions(physics: Physics) -> tuple[float, float]:
    """Return the restitution of balls and the normal one of cushions [1]."""
    return physics.ball_restitution, cushion_restitution(physics)


def cushion_restitution(physics: Physics) -> float:
    """Return the normal restitution of cushions [1]; where it falls with speed, of the slowest."""
    return 1.0 if physics.cushion == "mirror" else physics.cushion_restitution


class FallingRestitution:
    """The restitution of cushions that falls with speed, for engines that are asked each time."""

    def __init__(self, physics: Physics) -> None:
        self._slow, self._loss = cushion_restitution(physics), physics.cushion_restitution_loss

    @classmethod
    def of(cls, physics: Physics) -> FallingRestitution | None:
        """Return that of some physics; None: it is one number."""
        falls = physics.cushion_restitution_loss > 0.0 and physics.cushion != "mirror"
        return cls(physics) if falls else None

    def at(self, normal: tuple[float, float], velocity: tuple[float, float]) -> float:
        """Return it for a ball that comes with a velocity [m/s] to a cushion of that normal."""
        nx, ny = normal
        approach = max(-(nx * velocity[0] + ny * velocity[1]), 0.0)
        return self._slow / (1.0 + self._loss * math.sqrt(approach))


def ball_friction(scene: Scene) -> float:
    """Return the friction between balls [1]; 0 where one is alone, whatever the law."""
    friction = scene.physics.ball_friction if len(scene.balls) > 1 else 0.0
    assert not isinstance(friction, str)  # the engine's check refuses a law
    return friction


def multiplied_restitutions(physics: Physics) -> tuple[float, float]:
    """Return factors of balls and of cushions, for an engine that takes the product of two [1]."""
    ball, cushion = restitutions(physics)
    ball = math.sqrt(max(ball, LEAST_RESTITUTION))
    return ball, cushion / ball


def cushion_friction(physics: Physics) -> float:
    """Return the friction of cushions [1]."""
    return physics.cushion_friction if physics.cushion == "frictional" else 0.0


def tangential_restitution(physics: Physics) -> float:
    """Return what cushions leave of the velocity along them [1]."""
    return physics.cushion_tangential_restitution if physics.cushion == "restitution" else 1.0


def rubs(scene: Scene) -> bool:
    """Whether a contact of the scene has friction, so that it may turn balls."""
    between_balls = scene.physics.ball_friction != 0.0 and len(scene.balls) > 1
    return between_balls or (scene.physics.cushion == "frictional" and scene.table is not None)


def slips_of(velocities: FloatArray, spins: FloatArray, radii: FloatArray) -> FloatArray:
    """Return the velocity of each ball's lowest point over the cloth, v + w x (-R z), (n, 2) [m/s].

    `velocities` (n, 2) or (n, 3) float64 [m/s].
    `spins` (n, 3) float64 [rad/s].
    `radii` (n,) float64 [m].
    """
    slips = velocities[:, :2].copy()
    slips[:, 0] -= radii * spins[:, 1]
    slips[:, 1] += radii * spins[:, 0]
    return slips

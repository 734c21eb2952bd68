"""The laws of a scene as numbers for time-stepping engines."""

from __future__ import annotations

import math

import numpy as np

from ghostball.model import Physics, Scene, first_energy
from ghostball.model.arrays import FloatArray

LEAST_RESTITUTION = 2.0**-52
"""Restitution of balls used for 0, so that cushions can have a different restitution [1].

A ball then leaves at 2e-16 of its approach speed, which is rounding.
"""


def largest_momenta(scene: Scene) -> FloatArray:
    """Return the momentum of each ball if it had all the energy, (n,) [kg m/s].

    The energy includes that of spin, because sliding can convert spin into speed.
    """
    energy = first_energy(scene)
    momenta: FloatArray = np.sqrt(2.0 * energy * scene.masses)
    return momenta


def fastest(scene: Scene) -> float:
    """Return the speed of the lightest ball if it had all the energy [m/s]."""
    return float(np.max(largest_momenta(scene) / scene.masses))


def restitutions(physics: Physics) -> tuple[float, float]:
    """Return the restitution of balls and the normal restitution of cushions [1]."""
    return physics.ball_restitution, cushion_restitution(physics)


def cushion_restitution(physics: Physics) -> float:
    """Return the normal restitution of cushions [1], at low speed if it depends on speed."""
    return 1.0 if physics.cushion == "mirror" else physics.cushion_restitution


class SpeedDependentRestitution:
    """Restitution of cushions that decreases with speed, for engines that set it per contact."""

    def __init__(self, physics: Physics) -> None:
        self._slow, self._loss = cushion_restitution(physics), physics.cushion_restitution_loss

    @classmethod
    def of(cls, physics: Physics) -> SpeedDependentRestitution | None:
        """Return the restitution of `physics`; None if it is constant."""
        falls = physics.cushion_restitution_loss > 0.0 and physics.cushion != "mirror"
        return cls(physics) if falls else None

    def at(self, normal: tuple[float, float], velocity: tuple[float, float]) -> float:
        """Return the restitution for a ball with a velocity [m/s] at a cushion with a normal."""
        nx, ny = normal
        approach = max(-(nx * velocity[0] + ny * velocity[1]), 0.0)
        return self._slow / (1.0 + self._loss * math.sqrt(approach))


def ball_friction(scene: Scene) -> float:
    """Return the friction coefficient between balls [1]; 0 for a single ball."""
    friction = scene.physics.ball_friction if len(scene.balls) > 1 else 0.0
    assert not isinstance(friction, str)  # engines without this law reject the scene
    return friction


def multiplied_restitutions(physics: Physics) -> tuple[float, float]:
    """Return factors for balls and cushions, for an engine that multiplies two factors [1]."""
    ball, cushion = restitutions(physics)
    ball = math.sqrt(max(ball, LEAST_RESTITUTION))
    return ball, cushion / ball


def cushion_friction(physics: Physics) -> float:
    """Return the friction coefficient of cushions [1]."""
    return physics.cushion_friction if physics.cushion == "frictional" else 0.0


def tangential_restitution(physics: Physics) -> float:
    """Return the factor on the velocity along cushions [1]."""
    return physics.cushion_tangential_restitution if physics.cushion == "restitution" else 1.0


def rubs(scene: Scene) -> bool:
    """Return whether contacts of the scene have friction, which may change spins."""
    between_balls = scene.physics.ball_friction != 0.0 and len(scene.balls) > 1
    return between_balls or (scene.physics.cushion == "frictional" and scene.table is not None)


def slips_of(velocities: FloatArray, spins: FloatArray, radii: FloatArray) -> FloatArray:
    """Return the slip of each ball's lowest point on the cloth, v + w x (-R z), (n, 2) [m/s].

    `velocities`: (n, 2) or (n, 3) float64 [m/s].
    `spins`: (n, 3) float64 [rad/s].
    `radii`: (n,) float64 [m].
    """
    slips = velocities[:, :2].copy()
    slips[:, 0] -= radii * spins[:, 1]
    slips[:, 1] += radii * spins[:, 0]
    return slips

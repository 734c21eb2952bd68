"""Sampling a recorded motion at any time: positions, velocities, spin, energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.scene import Scene

FloatArray = NDArray[np.float64]


class Samples(NamedTuple):
    """States at k times: three arrays (k, n, 3) float64 [m], [m/s], [rad/s]."""

    positions: FloatArray
    velocities: FloatArray
    angular_velocities: FloatArray


class Energy(NamedTuple):
    """Energy of all balls at k times: three arrays (k,) float64 [J]."""

    translation: FloatArray
    rotation: FloatArray
    height: FloatArray

    @property
    def total(self) -> FloatArray:
        """Sum of the three [J]."""
        return self.translation + self.rotation + self.height


class Trajectory(Protocol):
    """A motion that can be sampled."""

    @property
    def t_end(self) -> float:
        """Last recorded instant [s]; the first is 0."""
        ...

    def sample(self, times: FloatArray) -> Samples:
        """Return the states at `times`, (k,) [s]."""
        ...


@dataclass(frozen=True, eq=False)
class SampledTrajectory:
    """States stored at instants, straight lines between them: what a stepping engine records.

    Attributes
    ----------
    times : (k,) float64 [s], never decreasing
        Two equal instants are the state before and after a collision; sampling there gives the
        state after.
    positions, velocities, angular_velocities : (k, n, 3) float64 [m], [m/s], [rad/s]
    """

    times: FloatArray
    positions: FloatArray
    velocities: FloatArray
    angular_velocities: FloatArray

    @property
    def t_end(self) -> float:
        """Last recorded instant [s]."""
        return float(self.times[-1])

    def sample(self, times: FloatArray) -> Samples:
        """Return the states at `times`, (k,) [s], by linear interpolation; clamped at both ends."""
        t = np.clip(times, self.times[0], self.times[-1])
        after = np.clip(np.searchsorted(self.times, t, side="right"), 1, len(self.times) - 1)
        before = after - 1
        span = self.times[after] - self.times[before]
        weight = np.where(span > 0.0, (t - self.times[before]) / np.where(span > 0, span, 1.0), 1.0)
        w = weight[:, np.newaxis, np.newaxis]
        return Samples(
            *(
                (1.0 - w) * stored[before] + w * stored[after]
                for stored in (self.positions, self.velocities, self.angular_velocities)
            )
        )


def energy_of(scene: Scene, samples: Samples) -> Energy:
    """Return the energy of the balls of `scene` in the given states.

    Notes
    -----
    I = (2/5) m R^2 for a solid ball. Height is counted from a ball that lies on the cloth, so a
    scene at rest has energy 0.
    """
    masses, radii = scene.masses, scene.radii
    inertia = 0.4 * masses * radii**2
    speed2 = np.sum(samples.velocities**2, axis=2)
    spin2 = np.sum(samples.angular_velocities**2, axis=2)
    rise = samples.positions[:, :, 2] - radii
    return Energy(
        0.5 * speed2 @ masses,
        0.5 * spin2 @ inertia,
        scene.physics.gravity * (rise @ masses),
    )

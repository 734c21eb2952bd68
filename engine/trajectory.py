"""Sampling a recorded motion at any time: positions, velocities, spin, energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from engine.scene import Scene, rolling_angular_velocity

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
class ExactTrajectory:
    """Motion between events in closed form, as our engine records it.

    Attributes
    ----------
    radii : (n,) float64 [m]
    knots : n arrays (k_i, 7) float64
        For each ball: time [s], x, y [m], vx, vy [m/s], ax, ay [m/s^2], from that time on.
    t_end : float [s]
    """

    radii: FloatArray
    knots: tuple[FloatArray, ...]
    t_end: float

    def sample(self, times: FloatArray) -> Samples:
        """Return the states at `times`, (k,) [s]; after an event where one falls on a time."""
        t = np.clip(times, 0.0, self.t_end)
        positions, velocities, spins = (np.zeros((len(t), len(self.knots), 3)) for _ in range(3))
        for i, knots in enumerate(self.knots):
            knot = knots[np.searchsorted(knots[:, 0], t, side="right") - 1]
            s = (t - knot[:, 0])[:, np.newaxis]
            r, v, a = knot[:, 1:3], knot[:, 3:5], knot[:, 5:7]
            positions[:, i, :2] = r + s * (v + 0.5 * s * a)
            velocities[:, i, :2] = v + s * a
        positions[:, :, 2] = self.radii
        spins[:] = rolling_angular_velocity(velocities, self.radii)
        return Samples(positions, velocities, spins)

    def orientation(self, times: FloatArray) -> FloatArray:
        """Return the orientation of every ball at `times`, unit quaternions (k, n, 4), w first.

        Every ball starts at (1, 0, 0, 0). A ball that rolls by a distance s turns by s / R about
        k x v, exactly, since between events it rolls straight on.

        Notes
        -----
        The paper (section 5.3) turns by |v| dt / R about r = v x k each frame: the same turn with
        the opposite sign, and only as exact as its frame is short.
        """
        t = np.clip(times, 0.0, self.t_end)
        result = np.empty((len(t), len(self.knots), 4))
        for i, knots in enumerate(self.knots):
            ends = np.append(knots[1:, 0], self.t_end)
            at_knot = np.empty((len(knots), 4))
            at_knot[0] = (1.0, 0.0, 0.0, 0.0)
            turns = _rolling_turn(knots, ends - knots[:, 0], self.radii[i])
            for k in range(1, len(knots)):
                at_knot[k] = _hamilton_product(turns[k - 1], at_knot[k - 1])
            which = np.searchsorted(knots[:, 0], t, side="right") - 1
            since = _rolling_turn(knots[which], t - knots[which, 0], self.radii[i])
            result[:, i] = _hamilton_product(since, at_knot[which])
        return result


def _rolling_turn(knots: FloatArray, duration: FloatArray, radius: float) -> FloatArray:
    """Return the turn of a ball that rolls straight on from each knot for a while, (k, 4)."""
    s = duration[:, np.newaxis]
    shift = s * (knots[:, 3:5] + 0.5 * s * knots[:, 5:7])
    distance = np.hypot(shift[:, 0], shift[:, 1])
    half_angle = 0.5 * distance / radius
    # sin(half) / distance times the shift's components, finite at distance 0.
    scale = np.sinc(half_angle / np.pi) * 0.5 / radius
    turn = np.zeros((len(knots), 4))
    turn[:, 0] = np.cos(half_angle)
    turn[:, 1] = -scale * shift[:, 1]
    turn[:, 2] = scale * shift[:, 0]
    return turn


def _hamilton_product(p: FloatArray, q: FloatArray) -> FloatArray:
    """Return p q, quaternions (..., 4) with w first: the turn q, then the turn p."""
    w1, x1, y1, z1 = np.moveaxis(p, -1, 0)
    w2, x2, y2, z2 = np.moveaxis(q, -1, 0)
    product: FloatArray = np.stack(
        (
            w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
            w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
            w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
            w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
        ),
        axis=-1,
    )
    return product


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

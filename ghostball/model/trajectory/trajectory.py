"""Sample a recorded motion at any time: positions, velocities, spin, energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.model.arrays import FloatArray
from ghostball.model.events import Events
from ghostball.model.scene.ball import rolling_angular_velocity
from ghostball.model.scene.scene import Scene
from ghostball.model.trajectory import segment
from ghostball.model.trajectory.orientation import Pieces, orientation_at, pieces_of
from ghostball.model.trajectory.polynomial import (
    PER_POWER,
    displacement,
    rises,
    speed,
    tails,
    turns,
)
from ghostball.model.trajectory.segment import Phase
from ghostball.model.trajectory.tangent_map import TangentMap

PhaseArray = NDArray[np.int8]

# Columns of a segment, for x and y.
_PLACE = slice(segment.X, segment.Y + 1)
_VELOCITY = slice(segment.VX, segment.VY + 1)
_ACCELERATION = slice(segment.AX, segment.AY + 1)
_SPIN = slice(segment.WX, segment.WY + 1)
_SPIN_RATE = slice(segment.BX, segment.BY + 1)


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
        """Sum of the three energies [J]."""
        return self.translation + self.rotation + self.height


class Trajectory(Protocol):
    """A motion that can be sampled."""

    @property
    def t_end(self) -> float:
        """Last recorded time [s]; the first is 0."""
        ...

    def sample(self, times: FloatArray) -> Samples:
        """Return the states at `times`, (k,) [s]."""
        ...


@dataclass(frozen=True, eq=False)
class ExactTrajectory:
    """Motion between events in closed form, as recorded by Ghostball's engine.

    Attributes
    ----------
    radii : (n,) float64 [m]
    segments : n arrays (k_i, 14 + 5 m) or, with `lifts`, (k_i, 17 + 5 m) float64
        One array per ball, one row from each event to the next: start time [s]; x, y [m]; vx, vy
        [m/s]; ax, ay [m/s^2]; angular velocity wx, wy, wz [rad/s]; its rate of change bx, by, and
        bz, which adds to the decay of wz [rad/s^2]; `Phase`. For a ball that rolls or rests, wx,
        wy, bx and by have no meaning: the velocity determines the angular velocity. With `lifts`,
        then: height of the lowest point above the cloth [m], velocity upwards [m/s], acceleration
        downwards by gravity [m/s^2]. If air may slow a ball, the coefficients of m powers of the
        time follow: see `model.trajectory.polynomial`.
    t_end : float [s]
    spin_decelerations : (n,) float64 [rad/s^2]
        Rate at which each ball's wz decays to 0 on the cloth; in the air, wz is constant.
    lifts : bool
        Whether balls may be in the air.
    tangents : Tangents or None
        Function that computes the growth of small changes of the motion; None if there is none.
    """

    radii: FloatArray
    segments: tuple[FloatArray, ...]
    t_end: float
    spin_decelerations: FloatArray
    lifts: bool = False
    tangents: Tangents | None = None

    def powers(self, segments: FloatArray) -> FloatArray:
        """Return the coefficients of m further powers of the time in k segments, (5 m, k)."""
        return segments[:, segment.COLUMNS + 3 * self.lifts :].T

    def sample(self, times: FloatArray) -> Samples:
        """Return the states at `times`, (k,) [s]; at an event, the state after the event."""
        t = np.clip(times, 0.0, self.t_end)
        states = Samples(*(np.zeros((len(t), len(self.segments), 3)) for _ in range(3)))
        for i, segments in enumerate(self.segments):
            now, one = segments[_at_or_before(segments, t)], slice(i, i + 1)
            positions, *moves = (array[:, i] for array in states)
            self._fill(positions, moves, now, t, self.radii[one], self.spin_decelerations[one])
        return states

    def positions_at(self, times: FloatArray) -> FloatArray:
        """Return the positions that `sample` returns, (k, n, 3) [m], without any velocities."""
        t = np.clip(times, 0.0, self.t_end)
        positions = np.zeros((len(t), len(self.segments), 3))
        for i, segments in enumerate(self.segments):
            now, one = segments[_at_or_before(segments, t)], slice(i, i + 1)
            self._fill(positions[:, i], None, now, t, self.radii[one], self.spin_decelerations[one])
        return positions

    def positions_apart(self, times: Sequence[FloatArray]) -> list[FloatArray]:
        """Return the positions of each ball at its own times: (k_i,) [s] and (k_i, 3) for ball i.

        They equal those of `sample`, bit for bit. For many balls and few times this is faster,
        because it computes all positions together instead of ball by ball.
        """
        counts = [len(own) for own in times]
        t = np.clip(np.concatenate(times), 0.0, self.t_end)
        ends = np.cumsum(counts)[:-1]
        now = [
            segments[_at_or_before(segments, own)]
            for segments, own in zip(self.segments, np.split(t, ends), strict=True)
        ]
        positions = np.zeros((len(t), 3))
        radii, decays = np.repeat(self.radii, counts), np.repeat(self.spin_decelerations, counts)
        self._fill(positions, None, np.concatenate(now), t, radii, decays)
        return np.split(positions, ends)

    def _fill(
        self,
        positions: FloatArray,
        moves: Sequence[FloatArray] | None,
        now: FloatArray,
        t: FloatArray,
        radius: FloatArray,
        decay: FloatArray,
    ) -> None:
        """Compute states at the times `t` (k,) [s] and store them in arrays (k, 3) of zeros.

        `moves`: the arrays of velocities and angular velocities; None: they aren't needed.
        `now` (k, columns): the segment of each time. `radius` [m], `decay` [rad/s^2]: of the ball
        (1,), or of the ball of each time (k,).
        """
        s = t - now[:, segment.EPOCH]
        across = s[:, np.newaxis]
        r, v, a = now[:, _PLACE], now[:, _VELOCITY], now[:, _ACCELERATION]
        positions[:, :2] = r + displacement(v, a, across)
        positions[:, 2] = radius
        powers = self.powers(now)
        count = _powers_in_use(powers)
        if count > 0:
            x, y, vx, vy, _, _ = tails(powers, count, s)
            positions[:, :2] += np.column_stack((x, y))
        if self.lifts:
            rise, up, fall = now[:, segment.COLUMNS : segment.COLUMNS + 3].T
            positions[:, 2] += rise + displacement(up, -fall, s)
            if count > 0:
                more, faster, _ = rises(powers, count, s)
                positions[:, 2] += more
        if moves is None:
            return
        velocities, spins = moves
        velocities[:, :2] = speed(v, a, across)
        if count > 0:
            velocities[:, :2] += np.column_stack((vx, vy))
        spins[:] = rolling_angular_velocity(velocities, radius)
        if self.lifts:
            velocities[:, 2] = speed(up, -fall, s)
            if count > 0:
                velocities[:, 2] += faster
        flies = now[:, segment.PHASE] == Phase.FLYING
        slides = np.isin(now[:, segment.PHASE], (Phase.SLIDING, Phase.COMPRESSED)) | flies
        w, b = now[slides, _SPIN], now[slides, _SPIN_RATE]
        spins[slides, :2] = w + across[slides] * b
        if count > 0:
            further = turns(powers[:, slides], count, s[slides])
            spins[slides, :2] += np.column_stack(further)
        vertical = now[:, segment.WZ]
        left = np.maximum(np.abs(vertical) - s * np.where(flies, 0.0, decay), 0.0)
        spins[:, 2] = np.sign(vertical) * left + s * now[:, segment.BZ]

    def phases(self, times: FloatArray) -> PhaseArray:
        """Return each ball's `Phase` at `times`, (k, n) int8; at an event, the phase after it."""
        t = np.clip(times, 0.0, self.t_end)
        result = np.empty((len(t), len(self.segments)), dtype=np.int8)
        for i, segments in enumerate(self.segments):
            result[:, i] = segments[_at_or_before(segments, t), segment.PHASE]
        return result

    def bend_times(self, deviation: float, limit: int) -> FloatArray:
        """Return increasing times, (k,) [s], between which slides stay close to their chords.

        Straight lines between the states at these times draw a curved path as a smooth curve.
        Rolling balls move along straight lines and need no such times. `deviation` [m] is the
        largest distance of a path from its chord, `limit` the largest number of chords per slide.
        """
        times = [np.empty(0)]
        for segments in self.segments:
            ends = np.append(segments[1:, segment.EPOCH], self.t_end)
            for row in np.flatnonzero(segments[:, segment.PHASE] == Phase.SLIDING):
                start, end = segments[row, segment.EPOCH], ends[row]
                # A parabola of duration s deviates from its chord by at most a s^2 / 8.
                longest = math.hypot(*segments[row, _ACCELERATION]) * (end - start) ** 2 / 8.0
                if not math.isfinite(longest):
                    continue  # the run failed here
                chords = min(max(math.ceil(math.sqrt(longest / deviation)), 1), limit)
                times.append(np.linspace(start, end, chords + 1))
        return np.unique(np.concatenate(times))

    def orientation(self, times: FloatArray) -> FloatArray:
        """Return the orientation of every ball at `times`, unit quaternions (k, n, 4), w first.

        Every ball starts at (1, 0, 0, 0). A ball that rolls by a distance s without vertical spin
        turns by s / R about k x v. This is exact, because a rolling ball moves along a straight
        line between events.

        If the ball slides, or rolls with vertical spin, the axis moves, and the turn is a power
        series, exact to rounding; see `model.trajectory.orientation`. The paper's rule (section
        5.3) is in `reference_adapters.paper.rotation`. Raises `GhostballError` if a ball turns too
        far for the power series.
        """
        t = np.clip(times, 0.0, self.t_end)
        result = np.empty((len(t), len(self.segments), 4))
        for i, segments in enumerate(self.segments):
            decay = float(self.spin_decelerations[i])
            powers = self.powers(segments)
            pieces = pieces_of(segments, powers, float(self.radii[i]), decay, self.t_end)
            result[:, i] = orientation_at(t, pieces)
        return result


Tangents = Callable[[Scene, ExactTrajectory, Events, ArrayLike | None], TangentMap]
"""Function that returns the effect of small changes on a shot: (scene, motion, events, changes).

The changes, (m, n, 7) float64, are changes of every ball's position x, y [m], velocity x, y [m/s]
and angular velocity x, y, z [rad/s]. None asks for the effect of rounding the state at the start
and at each event, divided by 2^-53. The function must be at the top level of a module, so that the
trajectory can be pickled.
"""


def _at_or_before(segments: FloatArray, t: FloatArray) -> NDArray[np.intp]:
    """Return the row of the segment that is valid at each time, (k,)."""
    return np.searchsorted(segments[:, segment.EPOCH], t, side="right") - 1


@dataclass(frozen=True, eq=False)
class SampledTrajectory:
    """States stored at given times, interpolated linearly, as recorded by a time-stepping engine.

    Attributes
    ----------
    times : (k,) float64 [s], never decreasing
        Two equal times are the states before and after a collision; sampling there gives the
        state after it.
    positions, velocities, angular_velocities : (k, n, 3) float64 [m], [m/s], [rad/s]
    """

    times: FloatArray
    positions: FloatArray
    velocities: FloatArray
    angular_velocities: FloatArray

    @property
    def t_end(self) -> float:
        """Last recorded time [s]."""
        return float(self.times[-1])

    def orientation(self, times: FloatArray) -> FloatArray:
        """Return the orientation of every ball at `times`, as `ExactTrajectory.orientation`.

        The angular velocity is interpolated linearly between frames and then integrated.
        """
        t = np.clip(times, self.times[0], self.times[-1])
        duration = np.append(np.diff(self.times), 0.0)
        spin = np.zeros((len(duration), 2, 3))
        result = np.empty((len(t), self.positions.shape[1], 4))
        for i in range(result.shape[1]):
            spin[:, 0] = self.angular_velocities[:, i]
            change = np.diff(spin[:, 0], axis=0, append=spin[-1:, 0])
            over = duration[:, np.newaxis]
            np.divide(change, over, out=spin[:, 1], where=over > 0.0)
            result[:, i] = orientation_at(t, Pieces(self.times, duration, spin))
        return result

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

    I = (2/5) m R^2 for a solid ball. The height is that above a ball on the cloth, so a scene at
    rest has energy 0.
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


def _powers_in_use(powers: FloatArray) -> int:
    """Return the number of powers (5 m, k) up to the last with a coefficient other than 0.

    At least 1 if there are any. Most motion of a scene with flights or air needs none.
    """
    used = np.flatnonzero(np.any(powers, axis=1))
    return int(used[-1]) // PER_POWER + 1 if len(used) else min(len(powers), 1)

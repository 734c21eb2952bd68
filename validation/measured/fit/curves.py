"""Polynomial fits to the samples of a window, as linear operators that are computed only once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.tracks import Track


@dataclass(frozen=True)
class Curve:
    """A least-squares polynomial through samples.

    `times` (n,) [s]: of the samples; `middle` [s]: their mean.
    `operator` (d + 1, n): maps positions (n, 2) to coefficients, from the lowest power of t -
        middle.
    """

    times: FloatArray
    middle: float
    operator: FloatArray

    @classmethod
    def through(cls, times: FloatArray, degree: int) -> Self:
        """Return the operator for samples at `times`, with more than `degree` different times."""
        middle = float(np.mean(times))
        powers = np.vander(times - middle, degree + 1, increasing=True)
        return cls(times, middle, np.asarray(np.linalg.pinv(powers), dtype=np.float64))

    def of(self, positions: FloatArray) -> FloatArray:
        """Return the coefficients (d + 1, 2) for positions (n, 2)."""
        return self.operator @ positions

    @property
    def covariance(self) -> FloatArray:
        """The covariance (d + 1, d + 1) of the coefficients, for samples of variance 1."""
        return self.operator @ self.operator.T

    def off(self, positions: FloatArray) -> float:
        """Return the rms distance of positions from the curve, per coordinate [m]."""
        powers = np.vander(self.times - self.middle, len(self.operator), increasing=True)
        return float(np.sqrt(np.mean((positions - powers @ self.of(positions)) ** 2)))


def without_stale(track: Track) -> Track:
    """Return a track without samples that repeat the one before while the ball moves.

    A late tracker repeats the last position.
    """
    times, places = track.times, track.positions
    if len(times) < 3:
        return track
    repeats = np.concatenate([[False], np.all(places[1:] == places[:-1], axis=1)])
    fresh = np.flatnonzero(~repeats)
    after = np.minimum(np.searchsorted(fresh, np.arange(len(times)), side="right"), len(fresh) - 1)
    before = np.maximum(after - 1, 0)
    step = np.linalg.norm(places[fresh[after]] - places[fresh[before]], axis=1)
    span = times[fresh[after]] - times[fresh[before]]
    moves = step > _MOVING_SPEED * np.where(span > 0.0, span, np.inf)
    kept = ~(repeats & moves)
    return Track(times[kept], places[kept])


def noise_of(tracks: list[Track]) -> float:
    """Return the standard deviation of a coordinate of a sample [m], from moving balls.

    Without noise, three consecutive samples are on a line, apart from the small deceleration.
    """
    off = [np.empty(0)]
    for track in tracks:
        t, x = track.times, track.positions
        if len(t) < 3:
            continue
        share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
        between = (1.0 - share) * x[:-2] + share * x[2:]
        spread = np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)
        speed = np.linalg.norm(x[2:] - x[:-2], axis=1) / (t[2:] - t[:-2])
        moves = (speed > _MOVING_SPEED) & (t[2:] - t[:-2] < _NEIGHBOURS)
        off.append(((x[1:-1] - between) / spread)[moves].ravel())
    every = np.concatenate(off)
    return float(_MEDIAN_TO_DEVIATION * np.median(np.abs(every))) if len(every) else 0.0


_MOVING_SPEED = 0.05
"""Speed above which a ball counts as moving [m/s]."""
_NEIGHBOURS = 0.2
"""Longest time between the first and the last of three consecutive samples [s]."""
_MEDIAN_TO_DEVIATION = 1.4826
"""The standard deviation of normal numbers, in medians of their absolute values."""

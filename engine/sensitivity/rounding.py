"""Small changes of a shot by rounding, at the start and at each event."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.sensitivity.motion import (
    PARTS,
    VX,
    VY,
    WX,
    WY,
    WZ,
    FloatArray,
    Rows,
    SegmentedMotion,
    X,
    Y,
)

LANES = 8
"""Number of random signs from one hash for each number of a change."""


class Rounding:
    """Changes by rounding, in several independent samples, each with its random signs.

    The signs depend on the rank of the ball's initial position, and on the number of its segments
    so far. No two roundings share signs, because their errors would then cancel or add up.
    """

    def __init__(self, motion: SegmentedMotion, runs: int) -> None:
        self._motion, self._runs = motion, runs
        n = len(motion.state)
        self._rank = np.empty(n, dtype=np.uint64)
        places = motion.state[:, st.Y], motion.state[:, st.X]
        self._rank[np.lexsort(places)] = np.arange(n)

    @property
    def lanes(self) -> int:
        """Number of independent samples."""
        return LANES * self._runs

    def at_starts(self, rows: Rows, times: FloatArray, before: FloatArray) -> FloatArray:
        """Return changes by rounding of the state at the starts of segments, (m, PARTS, lanes).

        Each number is changed, with a random sign in each lane, by the largest size that the number
        or its terms have at the event. A number that is exactly 0 doesn't change, and a ball's
        position along an axis changes only if the ball moves along it: motion that is symmetric
        about an axis is exactly symmetric in this engine. The uncertainty of a position includes
        that of the gaps, which are compared with radii, and the distance that the ball moves within
        the rounding of the clock.

        `before` (m, PARTS): sizes of velocity and angular velocity before the event, the largest of
            all its balls; 0 at the start of the shot.
        """
        motion = self._motion
        of, radius = motion.segments[rows], motion.of_balls(st.RADIUS)[rows]
        slides = motion.slides[rows]
        size = np.abs(before)
        for part, column in ((X, st.X), (Y, st.Y)):
            speed = np.abs(of[:, st.VX + part])
            size[:, VX + part] = np.maximum(size[:, VX + part], speed)
            place = np.abs(of[:, column]) + radius + times * speed
            size[:, part] = np.where(size[:, VX + part] > 0.0, place, 0.0)
        stops = np.equal(of[:, st.PHASE], st.RESTING) & (
            motion.of_balls(st.ROLL_SLOWING)[rows] > 0.0
        )
        gone = np.equal(of[:, st.PHASE], st.GONE)
        size[stops | gone, VX : VY + 1] = 0.0
        for part, column in ((WX, st.WX), (WY, st.WY)):
            turning = np.maximum(size[:, part], np.abs(of[:, column]))
            size[:, part] = np.where(slides, turning, 0.0)
        size[:, WZ] = np.where(gone, 0.0, np.maximum(size[:, WZ], np.abs(of[:, st.WZ])))
        if not motion.laws.slides:
            size[:, WX:] = 0.0
        return size[:, :, np.newaxis] * self._signs(rows)

    def _signs(self, rows: Rows) -> FloatArray:
        """Return signs, 1 or -1, for each number of a change in each lane, (m, PARTS, lanes)."""
        ball = self._motion.ball[rows]
        had = (rows - self._motion.first[ball]).astype(np.uint64)
        number = (self._rank[ball] << np.uint64(32)) + had
        run = np.arange(self._runs, dtype=np.uint64) << np.uint64(56)
        bits = _mixed(number[:, np.newaxis] + run)
        place = np.arange(PARTS * LANES, dtype=np.uint64)
        set_ = (bits[:, :, np.newaxis] >> place) & np.uint64(1)
        signs: FloatArray = 1.0 - 2.0 * set_.astype(np.float64)
        by_run = signs.reshape(len(rows), self._runs, PARTS, LANES)
        return by_run.transpose(0, 2, 1, 3).reshape(len(rows), PARTS, self.lanes)


def _mixed(number: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return 64 pseudorandom bits for each number, which has at most 63 bits.

    As in Steele, Lea and Flood (2014), "Fast splittable pseudorandom number generators", except
    that 63 bits of the first product are kept.
    """
    bits = (number * np.uint64(0x1E3779B97F4A7C15)) & np.uint64(0x7FFFFFFFFFFFFFFF)
    bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0x3F58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x14D049BB133111EB)
    return bits ^ (bits >> np.uint64(31))

"""A recorded motion as arrays, and the propagation of a small change of a ball between two events.

A change of a ball consists of the first-order changes of position, velocity and angular velocity at
a time: PARTS numbers. The segments of all balls are in one array, ball by ball.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.core.state import Laws
from ghostball.engine.running.from_scene import SceneLayout

FloatArray = NDArray[np.float64]
Rows = NDArray[np.intp]

# Indices of the numbers in a change of a ball.
X, Y, VX, VY, WX, WY, WZ = range(7)
PARTS = 7

SPIN_OVER_RADIUS = 2.5
"""Change of the spin by an impulse at a ball's surface, relative to the impulse over m R."""


@dataclass(frozen=True, eq=False)
class SegmentedMotion:
    """The recorded motion of n balls, in k segments.

    `layout`: that of the scene.
    `laws`: the laws of the scene; its obstacles are rows that Python can read.
    `segments` (k, SEGMENT_COLUMNS) float64.
    `first` (n + 1,): the index of each ball's first segment, then k.
    """

    layout: SceneLayout
    laws: Laws
    segments: FloatArray
    first: Rows

    @cached_property
    def state(self) -> FloatArray:
        """The balls at the start of the shot, (n, STATE_COLUMNS); see `core.rows.BallRow`."""
        return self.layout.state

    @cached_property
    def ball(self) -> Rows:
        """The ball of each segment, (k,)."""
        return np.repeat(np.arange(len(self.state)), np.diff(self.first))

    def of_balls(self, column: int) -> FloatArray:
        """Return for each segment a number of its ball, (k,)."""
        found: FloatArray = self.state[self.ball, column]
        return found

    @cached_property
    def slides(self) -> NDArray[np.bool_]:
        """Whether the ball slides, (k,)."""
        return np.equal(self.segments[:, st.PHASE], st.SLIDING)

    @cached_property
    def slip(self) -> FloatArray:
        """The slip at the start of a slide, otherwise the velocity, (k, 2) [m/s]."""
        lever = np.where(self.slides, self.of_balls(st.RADIUS), 0.0)
        vx, vy, wx, wy = self.segments[:, [st.VX, st.VY, st.WX, st.WY]].T
        turning = np.where(self.slides, wx, 0.0), np.where(self.slides, wy, 0.0)
        return np.column_stack((vx - lever * turning[1], vy + lever * turning[0]))

    @cached_property
    def pull(self) -> FloatArray:
        """Derivative of the acceleration by the slip or, for a rolling ball, by the velocity.

        (k, 2, 2) [1/s]: -(c / |d|) (1 - d^ d^T), where d is the slip or the velocity and c its
        deceleration.
        """
        slows = np.where(
            self.slides, self.of_balls(st.SLIDE_SLOWING), self.of_balls(st.ROLL_SLOWING)
        )
        dx, dy = self.slip.T
        square = dx * dx + dy * dy
        over = np.zeros(len(square))
        np.divide(-slows, square * np.sqrt(square), out=over, where=square > 0.0)
        across = -over * dx * dy
        return np.array([[over * dy * dy, across], [across, over * dx * dx]]).transpose(2, 0, 1)

    def rows_at(self, times: FloatArray) -> Rows:
        """Return the segment of each ball at some times, (len(times), n).

        At the time of an event, this is the segment after the event.
        """
        rows = np.empty((len(times), len(self.state)), dtype=np.intp)
        for i, (start, end) in enumerate(zip(self.first[:-1], self.first[1:], strict=True)):
            epochs = self.segments[start + 1 : end, st.EPOCH]
            rows[:, i] = start + np.searchsorted(epochs, times, side="right")
        return rows

    def flows(self, rows: Rows, s: FloatArray) -> FloatArray:
        """Return the propagation of changes over a time s [s] from the start of a segment.

        (m, PARTS, PARTS), for m segments. A change of the velocity also changes the acceleration a:
        dv += s da, dx += s dv + s^2 da / 2. The spin of a sliding ball follows the friction, that
        of a rolling ball its velocity.
        """
        flow = np.zeros((len(rows), PARTS, PARTS))
        flow[:, range(PARTS), range(PARTS)] = 1.0
        slides, radius = self.slides[rows], self.of_balls(st.RADIUS)[rows]
        bent = np.zeros((len(rows), 2, PARTS))
        bent[:, :, VX : VY + 1] = self.pull[rows]
        lever = np.where(slides, radius, 0.0)[:, np.newaxis]
        bent[:, :, WX] = lever * bent[:, :, VY]
        bent[:, :, WY] = -lever * bent[:, :, VX]
        along = s[:, np.newaxis]
        flow[:, X, VX] = flow[:, Y, VY] = s
        flow[:, X : Y + 1] += (0.5 * along * along)[:, :, np.newaxis] * bent
        flow[:, VX : VY + 1] += along[:, :, np.newaxis] * bent
        turn = (SPIN_OVER_RADIUS * s / radius)[:, np.newaxis]
        flow[:, WX] = np.where(slides[:, np.newaxis], flow[:, WX] + turn * bent[:, 1], 0.0)
        flow[:, WY] = np.where(slides[:, np.newaxis], flow[:, WY] - turn * bent[:, 0], 0.0)
        over = np.where(slides, 0.0, 1.0 / radius)[:, np.newaxis]
        flow[:, WX] -= over * flow[:, VY]
        flow[:, WY] += over * flow[:, VX]
        flow[self._spin_has_ended(rows, s), WZ] = 0.0
        return flow

    def displacements(self, rows: Rows, s: FloatArray, start: FloatArray) -> FloatArray:
        """Return the first two rows of `flows` times the changes `start`, (2, m, lanes) [m].

        `rows` (m,), `s` (m,) [s], `start` (k, PARTS, lanes).
        """
        of = start[rows]
        lever = np.where(self.slides[rows], self.of_balls(st.RADIUS)[rows], 0.0)[:, np.newaxis]
        ux, uy = of[:, VX] - lever * of[:, WY], of[:, VY] + lever * of[:, WX]
        s = s[:, np.newaxis]
        half = 0.5 * s
        (pxx, pxy), (_, pyy) = self.pull[rows].transpose(1, 2, 0)[..., np.newaxis]
        x = of[:, X] + s * (of[:, VX] + half * (pxx * ux + pxy * uy))
        y = of[:, Y] + s * (of[:, VY] + half * (pxy * ux + pyy * uy))
        return np.array([x, y])

    def _spin_has_ended(self, rows: Rows, s: FloatArray) -> NDArray[np.bool_]:
        rate = self.of_balls(st.SPIN_SLOWING)[rows]
        ended: NDArray[np.bool_] = np.abs(self.segments[rows, st.WZ]) <= s * rate
        ended &= (rate > 0.0) & self.laws.slides
        return ended

    def arrivals(self, rows: Rows, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the motion of balls just before events at some times, in their segments `rows`.

        These are the states, (m, PARTS), and their rates of change f-, (m, PARTS) [1/s].
        """
        of, radius = self.segments[rows], self.of_balls(st.RADIUS)[rows]
        s, slides = times - of[:, st.EPOCH], self.slides[rows]
        state, rate = np.zeros((2, len(rows), PARTS))
        rate[:, VX : VY + 1] = of[:, st.AX : st.AY + 1]
        velocity = of[:, st.VX : st.VY + 1] + s[:, np.newaxis] * rate[:, VX : VY + 1]
        state[:, VX : VY + 1] = rate[:, X : Y + 1] = velocity
        for w, v, sign, start, turning in (
            (WX, VY, -1.0, st.WX, st.BX),
            (WY, VX, 1.0, st.WY, st.BY),
        ):
            rate[:, w] = np.where(slides, of[:, turning], sign * rate[:, v] / radius)
            slid = of[:, start] + s * of[:, turning]
            state[:, w] = np.where(slides, slid, sign * state[:, v] / radius)
        slowing = self.of_balls(st.SPIN_SLOWING)[rows]
        left = np.maximum(np.abs(of[:, st.WZ]) - s * slowing, 0.0)
        state[:, WZ] = np.copysign(left, of[:, st.WZ])
        rate[:, WZ] = of[:, st.BZ] - np.copysign(slowing * (left > 0.0), of[:, st.WZ])
        if not self.laws.slides:
            rate[:, WX:] = 0.0
        return state, rate

    def departures(self, rows: Rows) -> FloatArray:
        """Return the rates of change f+ of the states at the starts of segments, (m, PARTS)."""
        of = self.segments[rows]
        rate = np.zeros((len(rows), PARTS))
        rate[:, X : Y + 1] = of[:, st.VX : st.VY + 1]
        rate[:, VX : VY + 1] = of[:, st.AX : st.AY + 1]
        if self.laws.slides:
            slides = self.slides[rows, np.newaxis]
            rate[:, WX : WY + 1] = np.where(slides, of[:, st.BX : st.BY + 1], 0.0)
            slowing = self.of_balls(st.SPIN_SLOWING)[rows]
            rate[:, WZ] = -np.sign(of[:, st.WZ]) * slowing
        return rate

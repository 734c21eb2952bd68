"""One ball of a proved motion between events: its state, and the derivative of where it goes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.trajectory import Phase

FloatArray = NDArray[np.float64]

PARTS = 7
"""Numbers that a ball's state has here: x, y, vx, vy, slip ux, uy, and the vertical spin wz."""

PLACE, VELOCITY, SLIP, SPIN = slice(0, 2), slice(2, 4), slice(4, 6), 6

_SLIDING, _RESTING = float(Phase.SLIDING), float(Phase.RESTING)

_DRIFT = np.eye(PARTS)
"""What a ball without forces keeps of its changes; its place gains s times that of its velocity."""


@dataclass(frozen=True, eq=False)
class ProvedBall:
    """The proved motion of one ball: its knots, and what the cloth does to it."""

    knots: FloatArray  # as in `ExactTrajectory`
    radius: float
    slides_by: float  # [m/s^2]
    rolls_by: float
    spins_by: float  # [rad/s^2]

    @cached_property
    def _rows(self) -> list[list[float]]:
        """The knots as plain numbers: one at a time they are quicker to calculate with."""
        rows: list[list[float]] = self.knots.tolist()
        return rows

    def slides(self, k: int) -> bool:
        """Whether the ball slides from a knot on."""
        return self._rows[k][13] == _SLIDING

    def pull(self, k: int) -> tuple[float, float]:
        """Return the acceleration from a knot on [m/s^2]."""
        _, _, _, _, _, ax, ay, *_ = self._rows[k]
        return ax, ay

    def _slip(self, k: int) -> tuple[float, float]:
        """Return the slip at a knot [m/s]."""
        if not self.slides(k):
            return 0.0, 0.0
        _, _, _, vx, vy, _, _, wx, wy, *_ = self._rows[k]
        return vx - self.radius * wy, vy + self.radius * wx

    def rates(self, k: int, s: float) -> tuple[FloatArray, FloatArray]:
        """Return the state a time s [s] after a knot, and its rate of change there, (7,) each."""
        _, x, y, vx, vy, ax, ay, _, _, spin, *_ = self._rows[k]
        slip_x, slip_y = self._slip(k)
        grip = 3.5 if self.slides(k) else 0.0
        left = max(abs(spin) - s * self.spins_by, 0.0)
        slowing = -math.copysign(self.spins_by, spin) if left > 0.0 else 0.0
        now_x, now_y = vx + s * ax, vy + s * ay
        now = (
            x + s * (vx + 0.5 * s * ax),
            y + s * (vy + 0.5 * s * ay),
            now_x,
            now_y,
            slip_x + s * (grip * ax),
            slip_y + s * (grip * ay),
            math.copysign(left, spin),
        )
        return np.array(now), np.array((now_x, now_y, ax, ay, grip * ax, grip * ay, slowing))

    def flow(self, k: int, s: float) -> FloatArray:
        """Return the derivative of the state a time s [s] after a knot by that at it, (7, 7)."""
        flow = _DRIFT.copy()
        flow[0, 2] = flow[1, 3] = s
        of, turn, slips = self._turn(k)
        if turn is not None:
            flow[PLACE, of] += 0.5 * s * s * turn
            flow[VELOCITY, of] += s * turn
            flow[SLIP, of] += 3.5 * slips * s * turn
        if self.spins_by > 0.0 and abs(self._rows[k][9]) <= s * self.spins_by:
            flow[SPIN, SPIN] = 0.0
        return flow

    def _turn(self, k: int) -> tuple[slice, FloatArray | None, bool]:
        """Return what the acceleration depends on, and how: -(c / |d|) (1 - d^ d^T); None: not."""
        slips = self.slides(k)
        of, slowing = (SLIP, self.slides_by) if slips else (VELOCITY, self.rolls_by)
        x, y = self._slip(k) if slips else (self._rows[k][3], self._rows[k][4])
        size = math.hypot(x, y)
        # A ball that is so slow that the quotient overflows has stopped before it can turn.
        if slowing == 0.0 or size == 0.0 or math.isinf(slowing / size):
            return of, None, slips
        x, y = x / size, y / size
        return of, -(slowing / size) * np.array([[y * y, -x * y], [-x * y, x * x]]), slips

    def displacement(self, times: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
        """Return the knot that holds at each instant, and the derivative of the place there."""
        rows = np.searchsorted(self.knots[:, 0], times, side="right") - 1
        s = (times - self.knots[rows, 0])[:, np.newaxis, np.newaxis]
        turns = np.zeros((len(self.knots), 2, PARTS))
        for k in np.unique(rows).tolist():
            of, turn, _ = self._turn(k)
            if turn is not None:
                turns[k][:, of] = turn
        flow = np.zeros((len(times), 2, PARTS))
        flow[:, :, PLACE] = np.eye(2)
        flow[:, :, VELOCITY] = s * np.eye(2)
        return rows, flow + 0.5 * s * s * turns[rows]

    def hold(self, k: int, change: FloatArray) -> None:
        """Take from changes, (7, m), what the ball's phase at a knot ends at once.

        A ball without slip rolls at once; a changed one slides first, for a time as small as the
        change, in which the cloth takes 2/7 of the slip. One that rests stops again at once, where
        the cloth slows it.
        """
        if not self.slides(k):
            change[VELOCITY] -= change[SLIP] * (2.0 / 7.0)
            change[SLIP] = 0.0
        if self._stands(k):
            change[VELOCITY] = 0.0

    def _stands(self, k: int) -> bool:
        """Whether the ball rests from a knot on, and the cloth would stop it again."""
        return self._rows[k][13] == _RESTING and self.rolls_by > 0.0

    def changed(self, directions: FloatArray) -> FloatArray:
        """Return changes of the first state, (7, m), given with the angular velocity in them."""
        change = directions.copy()
        change[SLIP] = change[VELOCITY]
        change[4] -= self.radius * directions[5]
        change[5] += self.radius * directions[4]
        if not self.slides(0):
            change[SLIP] = 0.0  # it begins by rolling, or rests
        self.hold(0, change)
        return change

    def noise(self, k: int, others: tuple[FloatArray, ...]) -> FloatArray:
        """Return the covariance of rounding the state at a knot once, over 2^-53 squared, (7, 7).

        Each number is rounded at the largest size that it, or what it is made of, has at the event:
        `others` are the states before it, (7,). A number that is exactly 0 stays so, and a place
        changes along an axis only where the ball moves along it: what is symmetric about an axis
        is so to the last bit in an exact engine. A place is as uncertain as its gaps, which are
        compared with radii, and as what the ball covers while the clock rounds.
        """
        t, *place, vx, vy, _, _, wx, wy, spin = self._rows[k][:10]
        slides, radius = self.slides(k), self.radius
        speeds, turns, spin = [abs(vx), abs(vy)], [0.0, 0.0], abs(spin)
        if slides:
            turns = [abs(wx), abs(wy)]
        places = [abs(x) + radius + t * speed for x, speed in zip(place, speeds, strict=True)]
        for other in others:
            _, _, vx, vy, slip_x, slip_y, wz = other.tolist()
            speeds = [max(speeds[0], abs(vx)), max(speeds[1], abs(vy))]
            turns = [
                max(turns[0], abs(vy - slip_y) / radius),
                max(turns[1], abs(vx - slip_x) / radius),
            ]
            spin = max(spin, abs(wz))
        noise = np.zeros((PARTS, PARTS))
        for x, (size, speed) in enumerate(zip(places, speeds, strict=True)):
            noise[x, x] = size * size if speed > 0.0 else 0.0
            v, slip = 2 + x, 4 + x
            of_speed = 0.0 if self._stands(k) else speed * speed
            noise[v, v] = of_speed
            if slides:  # slip is velocity less, or more, what the ball turns by
                noise[v, slip] = noise[slip, v] = of_speed
                noise[slip, slip] = of_speed + (radius * turns[1 - x]) ** 2
        noise[SPIN, SPIN] = spin * spin
        return noise

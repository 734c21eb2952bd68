"""One ball of a proved motion between events: its state, and the derivative of where it goes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.trajectory import Phase

FloatArray = NDArray[np.float64]

PARTS = 7
"""Numbers that a ball's state has here: x, y, vx, vy, slip ux, uy, and the vertical spin wz."""

PLACE, VELOCITY, SLIP, SPIN = slice(0, 2), slice(2, 4), slice(4, 6), 6


@dataclass(frozen=True, eq=False)
class ProvedBall:
    """The proved motion of one ball: its knots, and what the cloth does to it."""

    knots: FloatArray  # as in `ExactTrajectory`
    radius: float
    slides_by: float  # [m/s^2]
    rolls_by: float
    spins_by: float  # [rad/s^2]

    def state(self, k: int) -> FloatArray:
        """Return the state at a knot, (7,)."""
        knot = self.knots[k]
        state = np.array([*knot[1:5], 0.0, 0.0, knot[9]])
        if knot[13] == Phase.SLIDING:
            state[SLIP] = knot[3] - self.radius * knot[8], knot[4] + self.radius * knot[7]
        return state

    def rates(self, k: int, s: float) -> tuple[FloatArray, FloatArray]:
        """Return the state a time s [s] after a knot, and its rate of change there, (7,) each."""
        knot, state = self.knots[k], self.state(k)
        pull = knot[5:7]
        slip_pull = 3.5 * pull if knot[13] == Phase.SLIDING else np.zeros(2)
        spin, loss = state[SPIN], s * self.spins_by
        left = max(abs(spin) - loss, 0.0)
        velocity = state[VELOCITY] + s * pull
        now = np.array(
            [
                *(state[PLACE] + s * (state[VELOCITY] + 0.5 * s * pull)),
                *velocity,
                *(state[SLIP] + s * slip_pull),
                math.copysign(left, spin),
            ]
        )
        slowing = -math.copysign(self.spins_by, spin) if left > 0.0 else 0.0
        return now, np.array([*velocity, *pull, *slip_pull, slowing])

    def flow(self, k: int, s: float) -> FloatArray:
        """Return the derivative of the state a time s [s] after a knot by that at it, (7, 7)."""
        flow = np.eye(PARTS)
        flow[PLACE, VELOCITY] += s * np.eye(2)
        of, turn, slips = self._turn(k)
        flow[PLACE, of] += 0.5 * s * s * turn
        flow[VELOCITY, of] += s * turn
        flow[SLIP, of] += 3.5 * slips * s * turn
        if self.spins_by > 0.0 and abs(self.knots[k, 9]) <= s * self.spins_by:
            flow[SPIN, SPIN] = 0.0
        return flow

    def _turn(self, k: int) -> tuple[slice, FloatArray, bool]:
        """Return what the acceleration depends on, and how: -(c / |d|) (1 - d^ d^T)."""
        state, slips = self.state(k), bool(self.knots[k, 13] == Phase.SLIDING)
        of, slowing = (SLIP, self.slides_by) if slips else (VELOCITY, self.rolls_by)
        x, y = state[of]
        size = math.hypot(x, y)
        # A ball that is so slow that the quotient overflows has stopped before it can turn.
        if size == 0.0 or math.isinf(slowing / size):
            return of, np.zeros((2, 2)), slips
        x, y = x / size, y / size
        return of, -(slowing / size) * np.array([[y * y, -x * y], [-x * y, x * x]]), slips

    def displacement(self, times: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
        """Return the knot that holds at each instant, and the derivative of the place there."""
        rows = np.searchsorted(self.knots[:, 0], times, side="right") - 1
        s = (times - self.knots[rows, 0])[:, np.newaxis, np.newaxis]
        turns = np.zeros((len(self.knots), 2, PARTS))
        for k in np.unique(rows).tolist():
            of, turn, _ = self._turn(k)
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
        phase = self.knots[k, 13]
        if phase != Phase.SLIDING:
            change[VELOCITY] -= change[SLIP] * (2.0 / 7.0)
            change[SLIP] = 0.0
        if phase == Phase.RESTING and self.rolls_by > 0.0:
            change[VELOCITY] = 0.0

    def changed(self, directions: FloatArray) -> FloatArray:
        """Return changes of the first state, (7, m), given with the angular velocity in them."""
        change = directions.copy()
        change[SLIP] = change[VELOCITY]
        change[4] -= self.radius * directions[5]
        change[5] += self.radius * directions[4]
        if self.knots[0, 13] != Phase.SLIDING:
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
        knot, phase = self.knots[k], self.knots[k, 13]
        speed = np.abs(knot[3:5])
        place = np.abs(knot[1:3]) + self.radius + knot[0] * speed
        turn = np.abs(knot[7:9]) if phase == Phase.SLIDING else np.zeros(2)
        spin = abs(knot[9])
        for other in others:
            speed = np.maximum(speed, np.abs(other[VELOCITY]))
            surface = np.abs(other[VELOCITY] - other[SLIP])[::-1] / self.radius
            turn = np.maximum(turn, surface)
            spin = max(spin, abs(other[SPIN]))
        place = np.where(speed > 0.0, place, 0.0)
        if phase == Phase.RESTING and self.rolls_by > 0.0:
            speed = np.zeros(2)
        noise = np.zeros((PARTS, PARTS))
        noise[PLACE, PLACE] = np.diag(place**2)
        noise[VELOCITY, VELOCITY] = np.diag(speed**2)
        noise[SPIN, SPIN] = spin**2
        if phase == Phase.SLIDING:  # slip is velocity less, or more, what the ball turns by
            noise[VELOCITY, SLIP] = noise[SLIP, VELOCITY] = noise[VELOCITY, VELOCITY]
            noise[SLIP, SLIP] = np.diag(speed**2 + (self.radius * turn[::-1]) ** 2)
        return noise

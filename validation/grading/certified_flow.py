"""One ball of a certified motion between events: its state, and the derivative of its motion."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.model import Phase
from ghostball.model.arrays import FloatArray
from ghostball.model.trajectory.polynomial import OF_WX, OF_WY, OF_X, OF_Y, PER_POWER
from ghostball.model.trajectory.segment import COLUMNS
from ghostball.validation.grading.certified_air import (
    SLIP_RATE,
    Slide,
    SlideSeries,
    straight,
    straight_flow,
)

PARTS = 7
"""Number of values in a ball's state: x, y, vx, vy, slip ux, uy, and the vertical spin wz."""

PLACE, VELOCITY, SLIP, SPIN = slice(0, 2), slice(2, 4), slice(4, 6), 6

_SLIDING, _RESTING, _GONE = (float(phase) for phase in (Phase.SLIDING, Phase.RESTING, Phase.GONE))

_Form = Literal["parabola", "line", "slide"]

_Vector = tuple[float, float]

_Moved = tuple[_Vector, _Vector, _Vector, _Vector, _Vector]
"""Displacement, velocity, slip, and the rates of change of velocity and slip."""

_SURE_SHARE = 2.0**-10
"""Share of its initial size that a slip must have, so that its series gives its direction.

Only the last piece of a slide reduces the slip further.
"""

_DRIFT = np.eye(PARTS)
"""Derivative of the state of a ball without forces; the position also gains s times the velocity.
"""


def rows_of(balls: tuple[int, ...]) -> NDArray[np.intp]:
    """Return the rows of some balls in a state with `PARTS` numbers for each ball."""
    return np.concatenate([np.arange(PARTS * i, PARTS * (i + 1)) for i in balls])


@dataclass(frozen=True, eq=False)
class CertifiedBall:
    """The certified motion of one ball: its segments, and its decelerations.

    `segments` (k, 14 + 5 m) float64: as in `ExactTrajectory`.
    `starts`: rows at which the ball's motion starts or an event changes it; see
        `Certificate.starts`.
    `radius` [m].
    `slides_by`, `rolls_by` [m/s^2]: deceleration by the cloth during a slide, and during a roll.
    `spins_by` [rad/s^2]: deceleration of the vertical spin.
    `quadratic`, `drag` [1/m]: coefficient b of the deceleration b v^2 during a roll, and
        coefficient k of k v^2 during a slide.
    `flies`: whether it may be in the air; then no derivative is known.
    """

    segments: FloatArray
    starts: tuple[int, ...]
    radius: float
    slides_by: float
    rolls_by: float
    spins_by: float
    quadratic: float = 0.0
    drag: float = 0.0
    flies: bool = False

    @cached_property
    def _rows(self) -> list[list[float]]:
        """The segments as Python numbers, which are faster for single values."""
        rows: list[list[float]] = self.segments[:, :COLUMNS].tolist()
        return rows

    @cached_property
    def _flows(self) -> dict[int, FloatArray]:
        """The derivatives over whole pieces computed so far, by row."""
        return {}

    def slides(self, k: int) -> bool:
        """Return True if the ball slides during a segment."""
        return self._rows[k][13] == _SLIDING

    def _slip(self, k: int) -> tuple[float, float]:
        """Return the slip at the start of a segment [m/s]."""
        if not self.slides(k):
            return 0.0, 0.0
        _, _, _, vx, vy, _, _, wx, wy, *_ = self._rows[k]
        return vx - self.radius * wy, vy + self.radius * wx

    def _form(self, k: int) -> _Form:
        """Return the kind of motion in a segment."""
        phase, slides = self._rows[k][13], self.slides(k)
        _, _, _, vx, vy, *_ = self._rows[k]
        drag = self.drag if slides else self.quadratic
        if drag == 0.0 or phase == _RESTING:
            return "parabola"
        if slides and self.slides_by > 0.0:
            return "slide"
        # If the ball is so slow that the quotient overflows, it stops before this matters.
        speed, slowing = math.hypot(vx, vy), 0.0 if slides else self.rolls_by
        moves = speed > 0.0 and math.isfinite(slowing / speed) and math.isfinite(1.0 / speed)
        return "line" if moves else "parabola"

    def _series(self, k: int) -> SlideSeries:
        """Return velocity and slip of a sliding segment as power series of the time."""
        _, _, _, vx, vy, ax, ay, *_, bx, by, _, _ = self._rows[k]
        powers = self.segments[k, COLUMNS:].reshape(-1, PER_POWER)  # from the second power on
        further, turning = powers[1:, [OF_X, OF_Y]], powers[:-1, [OF_WX, OF_WY]]
        degrees = np.arange(3, 3 + len(further))[:, np.newaxis]
        velocity = np.vstack([[[vx, vy], [ax, ay]], degrees * further])
        spin = np.vstack([[[bx, by]], turning])  # from the first power on
        slip = velocity.copy()
        slip[0] = self._slip(k)
        slip[1:] += self.radius * spin[:, ::-1] * (-1.0, 1.0)
        return SlideSeries(velocity, slip)

    def _slips_to(self, k: int) -> FloatArray:
        """Return the direction of the slip at the start of a sliding segment.

        It is computed from the acceleration, because a small slip may consist of rounding errors
        only.
        """
        _, _, _, vx, vy, ax, ay, *_ = self._rows[k]
        drag = self.drag * math.hypot(vx, vy)
        x, y = -(ax + drag * vx), -(ay + drag * vy)
        size = math.hypot(x, y)
        return np.array([x / size, y / size])

    def _slide(self, k: int) -> Slide:
        return Slide(self._series(k), self._slips_to(k), self.slides_by, self.drag)

    def _piece(self, k: int, s: float) -> tuple[int, float]:
        """Return the row at a time s [s] after a start, and the time since that row."""
        t = self._rows[k][0] + s
        row, end = k, self._next_start(k)
        while row + 1 < end and self._rows[row + 1][0] <= t:
            row += 1
        return row, s if row == k else t - self._rows[row][0]

    def _next_start(self, k: int) -> int:
        following = bisect_right(self.starts, k)
        return self.starts[following] if following < len(self.starts) else len(self._rows)

    def along(self, k: int) -> Iterator[tuple[int, FloatArray]]:
        """Yield the rows after a start that continue its motion, with the flow to each."""
        for row in range(k + 1, self._next_start(k)):
            yield row, self._over(row - 1)

    def _over(self, row: int) -> FloatArray:
        """Return the flow over a whole piece, (7, 7)."""
        if row not in self._flows:
            lasts = self._rows[row + 1][0] - self._rows[row][0]
            self._flows[row] = self._flow_in(row, lasts)
        return self._flows[row]

    def rates(self, k: int, s: float) -> tuple[FloatArray, FloatArray]:
        """Return the state at a time s [s] after a start, and its rate of change, (7,) each."""
        row, s = self._piece(k, s)
        _, x, y, _, _, _, _, _, _, spin, *_ = self._rows[row]
        left = max(abs(spin) - s * self.spins_by, 0.0)
        slowing = -math.copysign(self.spins_by, spin) if left > 0.0 else 0.0
        moves = {"parabola": self._parabola, "line": self._line, "slide": self._sliding}
        place, velocity, slip, pull, slip_pull = moves[self._form(row)](row, s)
        now = (x + place[0], y + place[1], *velocity, *slip, math.copysign(left, spin))
        return np.array(now), np.array((*velocity, *pull, *slip_pull, slowing))

    def _parabola(self, row: int, s: float) -> _Moved:
        _, _, _, vx, vy, ax, ay, *_ = self._rows[row]
        slip_x, slip_y = self._slip(row)
        rate = SLIP_RATE if self.slides(row) else 0.0
        return (
            (s * (vx + 0.5 * s * ax), s * (vy + 0.5 * s * ay)),
            (vx + s * ax, vy + s * ay),
            (slip_x + s * (rate * ax), slip_y + s * (rate * ay)),
            (ax, ay),
            (rate * ax, rate * ay),
        )

    def _line(self, row: int, s: float) -> _Moved:
        _, _, _, vx, vy, *_ = self._rows[row]
        speed, a, b = math.hypot(vx, vy), self._slowed_by(row), self._squared(row)
        after = straight(speed, a, b, s)
        x, y = vx / speed, vy / speed
        velocity = (after.speed * x, after.speed * y)
        slowed = a + b * after.speed**2
        pull = (-slowed * x, -slowed * y)
        place = (after.displacement * x, after.displacement * y)
        if not self.slides(row):
            return place, velocity, (0.0, 0.0), pull, (0.0, 0.0)
        # Without friction of the cloth the spin is constant, so the slip changes like the velocity.
        slip_x, slip_y = self._slip(row)
        return place, velocity, (slip_x + velocity[0] - vx, slip_y + velocity[1] - vy), pull, pull

    def _sliding(self, row: int, s: float) -> _Moved:
        series = self._series(row)
        ((vx, vy),), (slip,) = (part.tolist() for part in series.at(np.array([s])))
        powers = np.arange(1, len(series.velocity) + 1)
        place = (s**powers / powers) @ series.velocity
        size = math.hypot(*slip)
        sure = size > _SURE_SHARE * math.hypot(*self._slip(row))
        x, y = (slip[0] / size, slip[1] / size) if sure else self._slips_to(row).tolist()
        drag, rate = self.drag * math.hypot(vx, vy), self.slides_by
        pull = (-rate * x - drag * vx, -rate * y - drag * vy)
        slip_pull = (pull[0] - 2.5 * rate * x, pull[1] - 2.5 * rate * y)
        return (float(place[0]), float(place[1])), (vx, vy), (slip[0], slip[1]), pull, slip_pull

    def _slowed_by(self, row: int) -> float:
        """Return the deceleration in straight motion that doesn't depend on the speed [m/s^2]."""
        return 0.0 if self.slides(row) else self.rolls_by

    def _squared(self, row: int) -> float:
        """Return the coefficient of the deceleration proportional to the squared speed [1/m]."""
        return self.drag if self.slides(row) else self.quadratic

    def flow(self, k: int, s: float) -> FloatArray:
        """Return the derivative of the state a time s [s] after a start, by that start, (7, 7)."""
        last, s = self._piece(k, s)
        flow = self._flow_in(last, s)
        for row in reversed(range(k, last)):
            flow = flow @ self._over(row)
        return flow

    def _flow_in(self, k: int, s: float) -> FloatArray:
        """Return the derivative of `flow` within one segment, (7, 7)."""
        flow = _DRIFT.copy()
        flow[0, 2] = flow[1, 3] = s
        form = self._form(k)
        if form == "line":
            _, _, _, vx, vy, *_ = self._rows[k]
            place, velocity = straight_flow(vx, vy, self._slowed_by(k), self._squared(k), s)
            flow[PLACE, VELOCITY], flow[VELOCITY, VELOCITY] = place, velocity
            if self.slides(k):
                flow[SLIP, VELOCITY] = velocity - np.eye(2)
        elif form == "slide":
            flow[:6, 2:6] = self._slide(k).flow(s)
        else:
            of, turn, slips = self._turn(k)
            if turn is not None:
                flow[PLACE, of] += 0.5 * s * s * turn
                flow[VELOCITY, of] += s * turn
                flow[SLIP, of] += SLIP_RATE * slips * s * turn
        if self.spins_by > 0.0 and abs(self._rows[k][9]) <= s * self.spins_by:
            flow[SPIN, SPIN] = 0.0
        return flow

    def _turn(self, k: int) -> tuple[slice, FloatArray | None, bool]:
        """Return the part d that the acceleration depends on, a derivative, and if the ball slides.

        d is the slip of a sliding ball, otherwise the velocity. The derivative of the acceleration
        by d is -(c / |d|) (1 - d^ d^T) with d^ = d / |d|; None if the acceleration is constant.
        """
        slips = self.slides(k)
        of, slowing = (SLIP, self.slides_by) if slips else (VELOCITY, self.rolls_by)
        x, y = self._slip(k) if slips else (self._rows[k][3], self._rows[k][4])
        size = math.hypot(x, y)
        # If the ball is so slow that the quotient overflows, it stops before it can turn.
        if slowing == 0.0 or size == 0.0 or math.isinf(slowing / size):
            return of, None, slips
        x, y = x / size, y / size
        return of, -(slowing / size) * np.array([[y * y, -x * y], [-x * y, x * x]]), slips

    def end_of_phase(self, k: int, s: float) -> tuple[FloatArray, FloatArray]:
        """Return the flow to the end of a phase, and the derivative of the end time.

        The phase ends after a time s [s]. Both derivatives, (7, 7) and (7,), are by the state at
        the start. A roll ends after |v| / (mu_r g), a slide after |u| / (7/2 mu_s g); for air see
        `Slide.end`.
        """
        later = np.zeros(PARTS)
        last, in_piece = self._piece(k, s)
        if self._form(last) == "slide":
            flow = self._flow_in(last, in_piece)
            flow[:6, 2:6], later[2:6] = self._slide(last).end(in_piece)
            for row in reversed(range(k, last)):
                flow, later = flow @ self._over(row), later @ self._over(row)
            return flow, later
        slides = self.slides(last)
        of, slowing = (SLIP, SLIP_RATE * self.slides_by) if slides else (VELOCITY, self.rolls_by)
        # Opposite to the acceleration, because a small slip may consist of rounding errors only.
        pull = np.array(self._rows[last][5:7])
        later[of] = -pull / (slowing * np.hypot(*pull))
        flow = self.flow(k, s)
        # Only changes along the direction shift the end; without air, they stay constant until
        # then.
        return flow, later if self._form(last) == "parabola" else later @ flow

    def end_shifted(self, k: int, changes: FloatArray) -> FloatArray:
        """Return bounds on the shift of a phase's end by changes of its start (..., m) [s].

        `changes` (..., 7, m) float64: of the state at the start.

        A slide with slip u ends after |u| / (7/2 mu_s g), and |u + du| differs from |u| by at most
        |du|, even if |u| is smaller. The same holds for the speed of a rolling ball, which air only
        stops sooner.
        """
        slides = self.slides(k)
        part, slowing = (SLIP, SLIP_RATE * self.slides_by) if slides else (VELOCITY, self.rolls_by)
        shifted: FloatArray = np.linalg.norm(changes[..., part, :], axis=-2) / slowing
        return shifted

    def displacement(self, times: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
        """Return the segment at each time, and the derivative of the position there.

        NaN if no derivative is known.
        """
        rows = np.searchsorted(self.segments[:, 0], times, side="right") - 1
        if self.flies:
            return rows, np.full((len(times), 2, PARTS), np.nan)
        s = (times - self.segments[rows, 0])[:, np.newaxis, np.newaxis]
        turns = np.zeros((len(self.segments), 2, PARTS))
        curved = np.zeros(len(times), dtype=bool)
        for k in np.unique(rows).tolist():
            if self._form(k) != "parabola":
                curved |= rows == k
                continue
            of, turn, _ = self._turn(k)
            if turn is not None:
                turns[k][:, of] = turn
        flow = np.zeros((len(times), 2, PARTS))
        flow[:, :, PLACE] = np.eye(2)
        flow[:, :, VELOCITY] = s * np.eye(2)
        flow += 0.5 * s * s * turns[rows]
        for i in np.flatnonzero(curved).tolist():
            flow[i] = self._flow_in(int(rows[i]), float(s[i, 0, 0]))[PLACE]
        return rows, flow

    def hold(self, k: int, change: FloatArray) -> None:
        """Remove from changes, (7, m), the parts that the phase of a segment ends at once.

        A ball without slip rolls at once. A changed ball first slides, for a time proportional to
        the change, and loses 2/7 of the slip in velocity. A changed ball at rest stops again at
        once, if the cloth has friction.
        """
        if not self.slides(k):
            change[VELOCITY] -= change[SLIP] * (2.0 / 7.0)
            change[SLIP] = 0.0
        if self._stands(k):
            change[VELOCITY] = 0.0

    def _stands(self, k: int) -> bool:
        """Return True if the ball is pocketed, or at rest on a cloth that would stop it again."""
        phase = self._rows[k][13]
        return phase == _GONE or (phase == _RESTING and self.rolls_by > 0.0)

    def noise(self, k: int, others: tuple[FloatArray, ...]) -> FloatArray:
        """Return the covariance of one rounding of a segment's state, over 2^-53 squared, (7, 7).

        Each number is rounded at the largest size that it, or a term of it, has at the event;
        `others` are the states before it, (7,). A number that is exactly 0 stays 0, and a
        coordinate changes only if the ball moves along its axis, because an exact engine preserves
        symmetries about an axis to the last bit. The uncertainty of a position includes the
        rounding of gaps, which are compared with radii, and the distance that the ball moves in a
        rounding of the time.
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
            if slides:  # slip is the velocity minus, or plus, the surface velocity
                noise[v, slip] = noise[slip, v] = of_speed
                noise[slip, slip] = of_speed + (radius * turns[1 - x]) ** 2
        noise[SPIN, SPIN] = spin * spin
        return noise

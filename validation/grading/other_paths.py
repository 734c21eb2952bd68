"""The delays in the detection of events after which a shot has a different path.

    >>> growth = growth_of_certificate(scene, certificate)
    >>> margins = margins_along(scene, motion, growth.balls, growth.events)
    >>> margins.moved @ delays >= margins.widths     # where another path begins

Detecting an event late displaces its balls, and all balls that these meet. The shot has a different
path if this closes the gap by which a ball passes another ball, an obstacle or the edge of a hole;
or if it makes a ball miss its target, stop before it, or hit something else first. The displacement
is computed with the tangent map of the certified motion, to first order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ghostball.model import ExactTrajectory, Scene
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.validation.grading.certified_events import EventChange
from ghostball.validation.grading.certified_flow import (
    PARTS,
    PLACE,
    VELOCITY,
    CertifiedBall,
    rows_of,
)
from ghostball.validation.grading.near_misses import Gaps, NearMiss, pairs_of, sampling_times

MOST_EVENTS = 600
"""Largest number of events for which the effect of each late event on later ones is computed.

Time and memory grow with its square; this number takes 0.2 s and 30 MB.
"""


@dataclass(frozen=True, eq=False)
class Margins:
    """The times at which a shot may change its path, and the displacement needed for this.

    `times` (m,) float64 [s]: increasing.
    `widths` (m,) float64 [m]: displacement above which the path is different.
    `moved` (m, events) float64 [m/s]: displacement per second of delay of each event.
    `turns` (m,) bool: whether the width is the displacement by which a ball would miss a round
        body. Smaller displacements are then amplified by more than the derivative.
    `slows` (m,) bool: whether the width is the displacement by which a decelerating ball would stop
        before its target. The amplification then exceeds the derivative, too.
    `balls`: the displaced balls, one or two.
    `since` (m,) float64 [s]: time at which the bodies came near, so that the different path may
        begin.
    `pasts`: the events before the different path that led to it, one bit each.
    `until` [s]: time up to which the shot was examined; inf: to its end.
    """

    times: FloatArray
    widths: FloatArray
    moved: FloatArray
    turns: BoolArray
    slows: BoolArray
    balls: tuple[tuple[int, ...], ...]
    since: FloatArray
    pasts: tuple[int, ...]
    until: float

    def amplified(self, delays: FloatArray, n: int, drift: float = 0.0) -> FloatArray | None:
        """Return the factor on each ball's first-order displacement at the end, (n,).

        None if the shot may have a different path before its end.

        `delays` (events,) float64 [s]: largest delay of each event.
        `n`: number of balls in the scene.
        `drift` [m]: additional displacement of balls.

        For a miss distance b, the angle of the line of centres is asin(b / rho). Because this
        function is convex, a finite displacement d is amplified by at most 1 + d / depth times the
        derivative, from a full hit to a graze, where depth = rho - b. A contact that is detected
        late has a smaller rho, which turns the line as much as a larger b.

        A ball that would stop at s = v^2 / 2 a beyond its target, and is x s behind, arrives with v
        sqrt(1 - x). The change of its speed, to first order -v x / 2, is 2 / (1 + sqrt(1 - x))
        times as large; that of the time at most 2 / (1 - x / 2 + sqrt(1 - x)) times, if all of x is
        caused by a lower speed. Both factors are at most 1 / sqrt(1 - x).
        """
        if math.isfinite(self.until):
            return None
        factors, within_reach, _ = self.followed(delays, n, drift)
        return None if within_reach else factors

    def followed(
        self, delays: FloatArray, n: int, drift: float = 0.0
    ) -> tuple[FloatArray, list[int], FloatArray]:
        """Return the factors at the end, the rows within reach, and the largest factor so far.

        The largest factor is given for each row, (m,). For the arguments see `amplified`.
        """
        factors = np.ones(n)
        within_reach: list[int] = []
        largest = np.ones(len(self.times))
        with np.errstate(invalid="ignore", over="ignore"):
            moved = self.moved @ delays
        for k, (width, balls) in enumerate(zip(self.widths.tolist(), self.balls, strict=True)):
            rows = list(balls)
            factor = float(np.max(factors[rows]))
            by = factor * float(moved[k]) + drift
            if by > 0.0 and not by < width:
                within_reach.append(k)
            if self.turns[k]:
                factors[rows] = factor * (1.0 + by / width) if width > 0.0 else math.inf
            elif self.slows[k]:
                left = 1.0 - by / width if width > 0.0 else 0.0
                factors[rows] = factor / math.sqrt(left) if left > 0.0 else math.inf
            largest[k] = np.max(factors)
        return factors, within_reach, largest


def margins_along(
    scene: Scene,
    motion: ExactTrajectory,
    balls: tuple[CertifiedBall, ...],
    events: tuple[EventChange, ...],
) -> Margins | None:
    """Return where a certified shot may change its path; None if it is too long to examine.

    `motion`: the certified motion; `balls`, `events`: its derivatives (`CertifiedGrowth`).
    """
    known = next((k for k, one in enumerate(events) if one.matrix is None), len(events))
    known = min(known, MOST_EVENTS)
    until = events[known].t if known < len(events) else math.inf
    events = events[:known]
    pairs = pairs_of(scene)
    times = sampling_times(scene, motion, events, len(pairs), min(until, motion.t_end))
    if times is None:
        return None
    lateness, rows = _Late(balls, len(events)), _Rows(scene, motion)
    places = Gaps(scene, motion, events, pairs, times)
    near = places.near_misses()
    last = 0
    for e, event in enumerate(events):
        while last < len(near) and near[last].t <= event.t:
            rows.pass_by(near[last], lateness)
            last += 1
        for one in places.beside(event, e):
            rows.pass_by(one, lateness, e)
        rows.meet(event, e, lateness)
        rows.go_on(event, e)
        lateness.apply(event, e)
    for one in near[last:]:
        rows.pass_by(one, lateness)
    return rows.margins(len(events), until)


class _Late:
    """Change of the balls by late detection of events so far: (7 n, events) per second."""

    def __init__(self, balls: tuple[CertifiedBall, ...], events: int) -> None:
        self._balls = balls
        self._starts = [ball.starts[0] for ball in balls]
        self._changes = np.zeros((PARTS * len(balls), events))

    def part(self, ball: int, t: float, part: slice) -> FloatArray:
        """Return the change of a part of a ball's state at a time, (2, events)."""
        one, k = self._balls[ball], self._starts[ball]
        flow = one.flow(k, max(t - float(one.segments[k, 0]), 0.0))[part]
        changed: FloatArray = flow @ self._changes[PARTS * ball : PARTS * (ball + 1)]
        return changed

    def between(self, ball: int, other: int | None, t: float, part: slice = PLACE) -> FloatArray:
        """Return the change of the vector, or relative velocity, from a ball to a body."""
        own = self.part(ball, t, part)
        return -own if other is None else self.part(other, t, part) - own

    def apply(self, event: EventChange, e: int) -> None:
        """Apply an event, which may itself be detected late."""
        # `margins_along` stops at the first event without a matrix
        assert event.matrix is not None
        rows = rows_of(event.balls)
        with np.errstate(over="ignore", invalid="ignore"):
            self._changes[rows] = event.matrix @ self._changes[rows]
        self._changes[rows, e] = event.late
        for ball, k in zip(event.balls, event.segments, strict=True):
            self._starts[ball] = k


class _Rows:
    """Collects `Margins`."""

    def __init__(self, scene: Scene, motion: ExactTrajectory) -> None:
        t_end, first = motion.t_end, motion.sample(np.array([0.0]))
        self._reach = float(np.min(scene.radii))
        self._stopped_at = t_end if scene.t_max is not None and t_end >= scene.t_max else None
        self._moves = [
            0.0 if np.any(v) or np.any(w) else math.inf
            for v, w in zip(first.velocities[0], first.angular_velocities[0], strict=True)
        ]
        self._pasts = [0] * len(scene.balls)
        self._found: list[
            tuple[float, float, FloatArray, bool, bool, tuple[int, ...], float, int]
        ] = []

    def pass_by(self, near: NearMiss, late: _Late, e: int | None = None) -> None:
        """Add a near miss; `e`: an event of the ball at that time, which ends its old motion."""
        balls = (near.ball,) if near.other is None else (near.ball, near.other)
        moves = min(self._moves[i] for i in balls)
        if math.isinf(moves):
            return  # a ball at rest isn't displaced
        moved = np.abs(near.normal @ late.between(near.ball, near.other, near.t))
        if e is not None:
            moved[e] += max(near.closing, 0.0)
        since = min(max(near.since, moves), near.t)
        row = (near.t, max(near.gap, 0.0), moved, False, False, balls, since, self._past(balls))
        self._found.append(row)

    def meet(self, event: EventChange, e: int, late: _Late) -> None:
        """Add the displacements by which an event would be missed."""
        meets = event.meets
        if meets is None:
            return
        other = event.balls[1] if len(event.balls) == 2 else None
        between = late.between(event.balls[0], other, event.t)
        along = meets.normal @ between
        found = [(self._reach, np.hypot(*between), False, False)]
        if math.isfinite(meets.stops):
            # v^2 / 2 a changes by v / a = 2 s / v times the change of the approach speed.
            parting = meets.normal @ late.between(event.balls[0], other, event.t, VELOCITY)
            shorter = np.abs(along + (2.0 * meets.stops / event.approach) * parting)
            found.append((meets.stops, shorter, False, True))
        if self._stopped_at is not None:
            later = np.abs(along)
            later[e] += event.approach
            found.append((event.approach * (self._stopped_at - event.t), later, False, False))
        # This row must be the last of its event, because it changes the amplification of later
        # rows.
        across = np.array([-meets.parting[1], meets.parting[0]]) / np.hypot(*meets.parting)
        moved = np.abs(across @ between)
        moved[e] += event.approach
        found.append((meets.depth, moved, math.isfinite(meets.depth), False))
        past = self._past(event.balls)
        self._found += [(event.t, *one, event.balls, event.t, past) for one in found]

    def go_on(self, event: EventChange, e: int) -> None:
        """Apply an event: it is in the past of its balls, which may move from then on."""
        past = self._past(event.balls) | 1 << e
        for i in event.balls:
            self._pasts[i] = past
            self._moves[i] = min(self._moves[i], event.t)

    def _past(self, balls: tuple[int, ...]) -> int:
        past = 0
        for i in balls:
            past |= self._pasts[i]
        return past

    def margins(self, events: int, until: float) -> Margins:
        """Return the margins found up to a time [s]."""
        columns = zip(*self._found, strict=True) if self._found else ((),) * 8
        times, widths, moved, turns, slows, balls, since, pasts = columns
        return Margins(
            np.array(times, dtype=np.float64),
            np.array(widths, dtype=np.float64),
            np.array(moved, dtype=np.float64).reshape(len(times), events),
            np.array(turns, dtype=np.bool_),
            np.array(slows, dtype=np.bool_),
            balls,
            np.array(since, dtype=np.float64),
            pasts,
            until,
        )

"""How much later the events of a shot may be seen before the shot takes another path.

    >>> growth = growth_of_proof(scene, proof)
    >>> margins = margins_along(scene, motion, growth.balls, growth.events)
    >>> margins.moved @ delays >= margins.widths     # where another path begins

Whoever sees an event late moves the balls that it concerns, and all that they meet. The shot takes
another path where that closes the gap by which a ball passes another one, an obstacle or the edge
of a hole; or where it makes a ball miss what it meets, stop short of it, or meet something else
first. The displacement is that of the tangent map of the proved motion, to first order.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ghostball.model import EventKind, ExactTrajectory, Hole, Scene
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.model.scene.obstacles import Obstacle, facing, gap_to
from ghostball.model.scene.sides import Side
from ghostball.validation.grading.certified_events import EventChange
from ghostball.validation.grading.certified_flow import PARTS, PLACE, VELOCITY, ProvedBall, rows_of
from ghostball.validation.grading.tolerances import EPS

MOST_EVENTS = 600
"""Largest number of events for which the effect of each late event on later ones is computed.

It takes time and memory that grow with the square of them: 0.2 s, 30 MB.
"""

_PART = 0.25
"""Longest path of a ball between two checks of the gaps, in units of the smallest radius."""

_MOST_NUMBERS = 30_000_000
"""Most numbers that are held for one shot, 240 MB. A shot that needs more is not examined.

Nine for the state of each ball, and one for each gap, at each look: 40 000 looks of 16 balls on a
table with pockets.
"""

_TOUCHES = 2.0**-25
"""Gap below which a ball touches the obstacle of an event, in units of the smallest radius."""

_ALONG = 1e-9
"""Two normals count as equal up to this; the value is half the square of their angle."""

_LEVEL = 256.0
"""Change of a gap between two checks that rounding explains, in roundings of a coordinate."""

_Other = int | Side | Obstacle
"""Anything that a ball may hit: a ball (by index), a side of the table, or an obstacle."""


@dataclass(frozen=True, eq=False)
class Margins:
    """The instants at which a shot may take another path, and the displacement needed for it.

    `times` (m,) float64 [s]: increasing.
    `widths` (m,) float64 [m]: displacement from which on there is another path.
    `moved` (m, events) float64 [m/s]: displacement by each second that an event is seen late.
    `turns` (m,) bool: whether the width is by how much a ball would have to miss what is round.
        There a smaller displacement is amplified by more than the derivative says.
    `slows` (m,) bool: whether it is by how much a ball that is slowed down would have to go less
        far to stop short. There, too, more is passed on than the derivative says.
    `balls`: which are moved, one or two.
    `since` (m,) float64 [s]: when what is near came near, at which the other path may begin.
    `pasts`: the events that led to it, one bit each: they come before the other path begins.
    `until` [s]: up to when the shot was looked at; inf: to its end.
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

        None if the shot may have taken another path by then.

        `delays` (events,) float64 [s]: by which each event is seen late, at most.
        `n`: balls of the scene.
        `drift` [m]: by which balls are displaced besides.

        The line of centres turns by d (asin b / rho) for a miss distance b; its convexity bounds
        what a finite displacement d does by 1 + d / depth times the derivative, from a full hit to
        a graze, where depth = rho - b. A contact that is seen late is met at a smaller rho, which
        turns the line as much as a larger b.

        A ball that would stop s = v^2 / 2 a after what it meets, and goes x s less far, comes there
        with v sqrt(1 - x). The change of its speed, to first order -v x / 2, is 2 / (1 + sqrt(1 -
        x)) times as large; that of the instant at most 2 / (1 - x / 2 + sqrt(1 - x)) times, where
        all of x is speed that it lacks. Neither is more than 1 / sqrt(1 - x).
        """
        if math.isfinite(self.until):
            return None
        factors, within_reach, _ = self.followed(delays, n, drift)
        return None if within_reach else factors

    def followed(
        self, delays: FloatArray, n: int, drift: float = 0.0
    ) -> tuple[FloatArray, list[int], FloatArray]:
        """Return the factors at the end, which rows are within reach, and the largest so far.

        The largest factor is that at each row, (m,). Arguments as of `amplified`.
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
    balls: tuple[ProvedBall, ...],
    events: tuple[EventChange, ...],
) -> Margins | None:
    """Return where a proved shot may take another path; None if it is too long to look at.

    `motion`: as it is proved; `balls`, `events`: what changes do along it (`CertifiedGrowth`).
    """
    known = next((k for k, one in enumerate(events) if one.matrix is None), len(events))
    known = min(known, MOST_EVENTS)
    until = events[known].t if known < len(events) else math.inf
    events = events[:known]
    pairs = _pairs_of(scene)
    times = _looks(scene, motion, events, len(pairs), min(until, motion.t_end))
    if times is None:
        return None
    lateness, rows = _Late(balls, len(events)), _Rows(scene, motion)
    places = _Gaps(scene, motion, events, pairs, times)
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


@dataclass(frozen=True)
class _Near:
    """A ball beside something that it doesn't meet there; `normal` points from the ball to it."""

    t: float
    gap: float
    normal: FloatArray
    ball: int
    other: int | None  # the ball that it is, else None
    closing: float = 0.0  # [m/s] at which the gap closes just before
    since: float = 0.0  # [s] when it came near


class _Late:
    """What seeing events late has changed of the balls until now: (7 n, events) per second."""

    def __init__(self, balls: tuple[ProvedBall, ...], events: int) -> None:
        self._balls = balls
        self._starts = [ball.starts[0] for ball in balls]
        self._changes = np.zeros((PARTS * len(balls), events))

    def part(self, ball: int, t: float, part: slice) -> FloatArray:
        """Return how much a part of a ball's state is changed at an instant, (2, events)."""
        one, k = self._balls[ball], self._starts[ball]
        flow = one.flow(k, max(t - float(one.segments[k, 0]), 0.0))[part]
        changed: FloatArray = flow @ self._changes[PARTS * ball : PARTS * (ball + 1)]
        return changed

    def between(self, ball: int, other: int | None, t: float, part: slice = PLACE) -> FloatArray:
        """Return how much a ball's way, or velocity, to another one or what stands is changed."""
        own = self.part(ball, t, part)
        return -own if other is None else self.part(other, t, part) - own

    def apply(self, event: EventChange, e: int) -> None:
        """Pass an event, which may itself be seen late."""
        assert event.matrix is not None  # `margins_along` stops at the first event without
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

    def pass_by(self, near: _Near, late: _Late, e: int | None = None) -> None:
        """Add what a ball passes; `e`: as it has an event, until which it goes on as before."""
        balls = (near.ball,) if near.other is None else (near.ball, near.other)
        moves = min(self._moves[i] for i in balls)
        if math.isinf(moves):
            return  # what rests is not displaced
        moved = np.abs(near.normal @ late.between(near.ball, near.other, near.t))
        if e is not None:
            moved[e] += max(near.closing, 0.0)
        since = min(max(near.since, moves), near.t)
        row = (near.t, max(near.gap, 0.0), moved, False, False, balls, since, self._past(balls))
        self._found.append(row)

    def meet(self, event: EventChange, e: int, late: _Late) -> None:
        """Add what an event would be missed by."""
        meets = event.meets
        if meets is None:
            return
        other = event.balls[1] if len(event.balls) == 2 else None
        between = late.between(event.balls[0], other, event.t)
        along = meets.normal @ between
        found = [(self._reach, np.hypot(*between), False, False)]
        if math.isfinite(meets.stops):
            # v^2 / 2 a changes by v / a = 2 s / v times what the approach gains.
            parting = meets.normal @ late.between(event.balls[0], other, event.t, VELOCITY)
            shorter = np.abs(along + (2.0 * meets.stops / event.approach) * parting)
            found.append((meets.stops, shorter, False, True))
        if self._stopped_at is not None:
            later = np.abs(along)
            later[e] += event.approach
            found.append((event.approach * (self._stopped_at - event.t), later, False, False))
        # The last one of an event: it changes what is amplified from here on.
        across = np.array([-meets.parting[1], meets.parting[0]]) / np.hypot(*meets.parting)
        moved = np.abs(across @ between)
        moved[e] += event.approach
        found.append((meets.depth, moved, math.isfinite(meets.depth), False))
        past = self._past(event.balls)
        self._found += [(event.t, *one, event.balls, event.t, past) for one in found]

    def go_on(self, event: EventChange, e: int) -> None:
        """Pass an event: it is in the past of its balls, which may move from then on."""
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
        """Return what was found until an instant [s]."""
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


def _pairs_of(scene: Scene) -> list[tuple[int, _Other]]:
    """Return all pairs of balls, and all pairs of a ball and an obstacle on the table."""
    n, table = len(scene.balls), scene.table
    things: list[_Other] = [] if table is None else [*table.sides, *table.obstacles]
    pairs: list[tuple[int, _Other]] = [(i, j) for i in range(n) for j in range(i + 1, n)]
    return pairs + [(i, thing) for i in range(n) for thing in things]


def _looks(
    scene: Scene,
    motion: ExactTrajectory,
    events: tuple[EventChange, ...],
    pairs: int,
    until: float,
) -> FloatArray | None:
    """Return the events and as many instants between them as balls go fast, (k,) [s].

    None where their gaps would be more than `_MOST_NUMBERS`: looks that are farther apart would
    miss some. Between two events the speed of a ball has no maximum: it is largest at one of them.
    """
    marks = np.unique([0.0, *(one.t for one in events), until])
    speeds = [
        np.max(np.linalg.norm(motion.sample(times).velocities[:, :, :2], axis=2), axis=1)
        for times in (marks[:-1], np.nextafter(marks[1:], 0.0))
    ]
    farthest = np.diff(marks) * np.maximum(*speeds)
    counts = np.ceil(farthest / (_PART * float(np.min(scene.radii)))) + 4.0
    if float(np.sum(counts)) * (9 * len(scene.balls) + pairs) > _MOST_NUMBERS:
        return None
    inner = [
        np.linspace(start, stop, int(count), endpoint=False)
        for start, stop, count in zip(marks[:-1], marks[1:], counts, strict=True)
    ]
    return np.unique(np.concatenate([*inner, marks]))


class _Gaps:
    """Gaps along a proved motion, of each two balls, and of each ball to each thing that stands."""

    def __init__(
        self,
        scene: Scene,
        motion: ExactTrajectory,
        events: tuple[EventChange, ...],
        pairs: list[tuple[int, _Other]],
        times: FloatArray,
    ) -> None:
        self._scene, self._motion = scene, motion
        self._pairs, self._times = pairs, times
        self._smallest = float(np.min(scene.radii))
        centres = motion.sample(times).positions[:, :, :2]
        self._level = _LEVEL * EPS * float(np.max(np.abs(centres)) + np.max(scene.radii))
        self._touches = _TOUCHES * self._smallest + self._level
        self._gaps = np.zeros((len(pairs), len(times)))
        for p, pair in enumerate(pairs):
            self._gaps[p] = self._gaps_of(*pair, centres)
        for event in events:
            if event.kind is EventKind.POCKETED:
                gone = np.array([event.balls[0] in pair for pair in self._pairs], dtype=bool)
                self._gaps[np.ix_(gone, self._times > event.t)] = math.nan
        # What is met, by pair: the looks at which it is.
        self._met: dict[int, list[int]] = {}
        self._partners_of = [self._partners(event) for event in events]
        for event, partners in zip(events, self._partners_of, strict=True):
            for p in partners:
                self._met.setdefault(p, []).append(self._look(event.t))

    def near_misses(self) -> list[_Near]:
        """Return where gaps are smallest between two events, and those left at the end."""
        found = []
        before, here, after = self._gaps[:, :-2], self._gaps[:, 1:-1], self._gaps[:, 2:]
        lowest = (here < before - self._level) & (here <= after) & (here < self._smallest)
        for p, look in zip(*np.nonzero(lowest), strict=True):
            if look + 1 not in self._met.get(int(p), ()):
                found.append(self._closest(int(p), int(look) + 1))
        last = len(self._times) - 1
        for p in np.flatnonzero(self._gaps[:, last] < self._smallest).tolist():
            if math.isfinite(self._gaps[p, last]) and not self._leaves(p, last):
                found.append(self._near(p, float(self._times[last]), last))
        return sorted(found, key=lambda one: one.t)

    def beside(self, event: EventChange, e: int) -> Iterator[_Near]:
        """Yield what the balls of a collision, or a fall, are beside without meeting it there.

        `e`: the index of the event.
        """
        if event.meets is None:
            return
        look = self._look(event.t)
        for p in np.flatnonzero(self._gaps[:, look] < self._smallest).tolist():
            ball, other = self._pairs[p]
            concerned = ball in event.balls or other in event.balls
            there = math.isfinite(self._gaps[p, look])
            if concerned and there and p not in self._partners_of[e] and not self._leaves(p, look):
                yield self._near(p, event.t, look)

    def _look(self, t: float) -> int:
        return int(np.searchsorted(self._times, t))

    def _gaps_of(self, ball: int, other: _Other, centres: FloatArray) -> FloatArray:
        """Return a ball's gap to something, for centres (k, n, 2): (k,) [m]."""
        x, y = centres[:, ball].T
        radius = float(self._scene.radii[ball])
        if isinstance(other, int):
            away: FloatArray = np.hypot(*(centres[:, other] - centres[:, ball]).T)
            return away - radius - float(self._scene.radii[other])
        if isinstance(other, Side):
            inside: FloatArray = other.distance(x, y)
            return inside - radius
        return gap_to(other, x, y) - (0.0 if isinstance(other, Hole) else radius)

    def _partners(self, event: EventChange) -> list[int]:
        """Return the pairs that an event is of: of a corner both sides, whose point is met."""
        if event.meets is None:
            return []
        if event.kind is EventKind.BALL_BALL:
            pair = (min(event.balls), max(event.balls))
            return [self._pairs.index(pair)]
        found, look = [], self._look(event.t)
        for p, (ball, other) in enumerate(self._pairs):
            if ball != event.balls[0] or isinstance(other, int):
                continue
            if isinstance(other, Hole) != (event.kind is EventKind.POCKETED):
                continue
            if abs(self._gaps[p, look]) < self._touches:
                normal = self._near(p, event.t, look).normal
                if float(normal @ event.meets.normal) > 1.0 - _ALONG:
                    found.append(p)
        return found

    def _leaves(self, p: int, look: int) -> bool:
        """Whether a pair has only separated since it last met."""
        met = [one for one in self._met.get(p, ()) if one <= look]
        if not met:
            return False
        return bool(np.all(np.diff(self._gaps[p, met[-1] : look + 1]) >= -self._level))

    def _closest(self, p: int, look: int) -> _Near:
        """Return where a gap is smallest near a check."""
        low, high = float(self._times[look - 1]), float(self._times[look + 1])
        for _ in range(2):
            times = np.linspace(low, high, 17)
            gaps = self._gaps_of(*self._pairs[p], self._motion.sample(times).positions[:, :, :2])
            row = int(np.argmin(gaps))
            low, high = float(times[max(row - 1, 0)]), float(times[min(row + 1, 16)])
        return self._near(p, float(times[row]), look)

    def _since(self, p: int, look: int) -> float:
        """Return when a pair came near that is near at a look [s]: 0 where it is from the start."""
        far = np.flatnonzero(self._gaps[p, :look] >= self._smallest)
        met = [one for one in self._met.get(p, ()) if one < look]
        last = max([*met, *far[-1:].tolist()], default=0)
        return float(self._times[last])

    def _near(self, p: int, t: float, look: int) -> _Near:
        """Return how a pair is at an instant, of a look; velocities are those just before."""
        since = self._since(p, look)
        ball, other = self._pairs[p]
        centres = self._motion.sample(np.array([t])).positions[0, :, :2]
        before = self._motion.sample(np.array([np.nextafter(t, 0.0)])).velocities[0, :, :2]
        gap = float(self._gaps_of(ball, other, centres[np.newaxis])[0])
        if isinstance(other, int):
            way = centres[other] - centres[ball]
            normal = way / np.hypot(*way)
            closing = -float(normal @ (before[other] - before[ball]))
            return _Near(t, gap, normal, ball, other, closing, since)
        inward = other.normal if isinstance(other, Side) else facing(other, *centres[ball])[0]
        normal = -np.array(inward)
        return _Near(t, gap, normal, ball, None, float(normal @ before[ball]), since)

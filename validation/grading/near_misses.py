"""Near misses: places where a ball of a certified shot passes a body without touching it.

    >>> times = sampling_times(scene, motion, events, len(pairs), until)
    >>> Gaps(scene, motion, events, pairs, times).near_misses()

Gaps are sampled often enough to find each pass, and more densely around a minimum.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ghostball.model import EventKind, ExactTrajectory, Hole, Scene
from ghostball.model.arrays import FloatArray
from ghostball.model.scene.obstacles import Obstacle, facing, gap_to
from ghostball.model.scene.sides import Side
from ghostball.validation.grading.certified_events import EventChange
from ghostball.validation.grading.tolerances import EPS

_LONGEST_PATH = 0.25
"""Longest path of a ball between two checks of the gaps, in units of the smallest radius."""

_MOST_NUMBERS = 30_000_000
"""Largest number of values that are stored for one shot, 240 MB. Longer shots aren't examined.

A sample has nine values for the state of each ball, and one for each gap. The limit allows 40 000
samples of 16 balls on a table with pockets.
"""

_TOUCHING_GAP = 2.0**-25
"""Gap below which a ball touches the obstacle of an event, in units of the smallest radius."""

_SAME_NORMAL = 1e-9
"""Half the square of the largest angle between two normals that count as equal."""

_GAP_ROUNDINGS = 256.0
"""Change of a gap between two samples that rounding explains, in roundings of a coordinate."""

Thing = int | Side | Obstacle
"""A body that a ball may hit: a ball (by index), a side of the table, or an obstacle."""


@dataclass(frozen=True)
class NearMiss:
    """A ball near a body that it doesn't touch; `normal` points from the ball to the body."""

    t: float
    gap: float
    normal: FloatArray
    ball: int
    other: int | None  # index if the body is a ball
    closing: float = 0.0  # [m/s] approach speed just before
    since: float = 0.0  # [s] time at which it came near


def things_of(scene: Scene) -> list[Side | Obstacle]:
    """Return all sides and obstacles of the table."""
    return [] if scene.table is None else [*scene.table.sides, *scene.table.obstacles]


def pairs_of(scene: Scene) -> list[tuple[int, Thing]]:
    """Return all pairs of balls, and all pairs of a ball and an obstacle on the table."""
    n, things = len(scene.balls), things_of(scene)
    pairs: list[tuple[int, Thing]] = [(i, j) for i in range(n) for j in range(i + 1, n)]
    return pairs + [(i, thing) for i in range(n) for thing in things]


def gaps_of(scene: Scene, ball: int, other: Thing, centres: FloatArray) -> FloatArray:
    """Return a ball's gap to a body in the plane, for centres (k, n, 2 or 3): (k,) [m]."""
    x, y = centres[:, ball, :2].T
    radius = float(scene.radii[ball])
    if isinstance(other, int):
        away: FloatArray = np.hypot(*(centres[:, other] - centres[:, ball])[:, :2].T)
        return away - radius - float(scene.radii[other])
    if isinstance(other, Side):
        inside: FloatArray = other.distance(x, y)
        return inside - radius
    return gap_to(other, x, y) - (0.0 if isinstance(other, Hole) else radius)


def sampling_times(
    scene: Scene, motion: ExactTrajectory, events: tuple[EventChange, ...], pairs: int, until: float
) -> FloatArray | None:
    """Return the times of events and sampling times between them, (k,) [s].

    None if there would be more than `_MOST_NUMBERS` values, because fewer samples could miss a
    pass. Between two events, the speed of a ball is largest at one of them.
    """
    marks = np.unique([0.0, *(one.t for one in events), until])
    speeds = [
        np.max(np.linalg.norm(motion.sample(times).velocities[:, :, :2], axis=2), axis=1)
        for times in (marks[:-1], np.nextafter(marks[1:], 0.0))
    ]
    farthest = np.diff(marks) * np.maximum(*speeds)
    counts = np.ceil(farthest / (_LONGEST_PATH * float(np.min(scene.radii)))) + 4.0
    if float(np.sum(counts)) * (9 * len(scene.balls) + pairs) > _MOST_NUMBERS:
        return None
    inner = [
        np.linspace(start, stop, int(count), endpoint=False)
        for start, stop, count in zip(marks[:-1], marks[1:], counts, strict=True)
    ]
    return np.unique(np.concatenate([*inner, marks]))


class Gaps:
    """Gaps along a certified motion: of each pair of balls, and each ball and other body."""

    def __init__(
        self,
        scene: Scene,
        motion: ExactTrajectory,
        events: tuple[EventChange, ...],
        pairs: list[tuple[int, Thing]],
        times: FloatArray,
    ) -> None:
        self._scene, self._motion = scene, motion
        self._pairs, self._times = pairs, times
        self._smallest = float(np.min(scene.radii))
        centres = motion.sample(times).positions[:, :, :2]
        self._level = _GAP_ROUNDINGS * EPS * float(np.max(np.abs(centres)) + np.max(scene.radii))
        self._touches = _TOUCHING_GAP * self._smallest + self._level
        self._gaps = np.zeros((len(pairs), len(times)))
        for p, pair in enumerate(pairs):
            self._gaps[p] = gaps_of(scene, *pair, centres)
        for event in events:
            if event.kind is EventKind.POCKETED:
                gone = np.array([event.balls[0] in pair for pair in self._pairs], dtype=bool)
                self._gaps[np.ix_(gone, self._times > event.t)] = math.nan
        # For each pair that touches, the samples at which the pair touches.
        self._met: dict[int, list[int]] = {}
        self._partners_of = [self._partners(event) for event in events]
        for event, partners in zip(events, self._partners_of, strict=True):
            for p in partners:
                self._met.setdefault(p, []).append(self._look(event.t))

    def near_misses(self) -> list[NearMiss]:
        """Return the smallest gaps between two events, and the small gaps at the end."""
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

    def beside(self, event: EventChange, e: int) -> Iterator[NearMiss]:
        """Yield the bodies that are near the balls of a collision or a fall, but don't touch them.

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

    def _partners(self, event: EventChange) -> list[int]:
        """Return the pairs of an event; at a corner, both of its sides."""
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
                if float(normal @ event.meets.normal) > 1.0 - _SAME_NORMAL:
                    found.append(p)
        return found

    def _leaves(self, p: int, look: int) -> bool:
        """Return True if a pair has only separated since it last touched."""
        met = [one for one in self._met.get(p, ()) if one <= look]
        if not met:
            return False
        return bool(np.all(np.diff(self._gaps[p, met[-1] : look + 1]) >= -self._level))

    def _closest(self, p: int, look: int) -> NearMiss:
        """Return the smallest gap near a sample."""
        low, high = float(self._times[look - 1]), float(self._times[look + 1])
        for _ in range(2):
            times = np.linspace(low, high, 17)
            gaps = gaps_of(self._scene, *self._pairs[p], self._motion.sample(times).positions)
            row = int(np.argmin(gaps))
            low, high = float(times[max(row - 1, 0)]), float(times[min(row + 1, 16)])
        return self._near(p, float(times[row]), look)

    def _since(self, p: int, look: int) -> float:
        """Return the time from which a pair has been near [s]; 0: from the start."""
        far = np.flatnonzero(self._gaps[p, :look] >= self._smallest)
        met = [one for one in self._met.get(p, ()) if one < look]
        last = max([*met, *far[-1:].tolist()], default=0)
        return float(self._times[last])

    def _near(self, p: int, t: float, look: int) -> NearMiss:
        """Return the state of a pair at a time near a sample; velocities are those just before."""
        since = self._since(p, look)
        ball, other = self._pairs[p]
        centres = self._motion.sample(np.array([t])).positions[0, :, :2]
        before = self._motion.sample(np.array([np.nextafter(t, 0.0)])).velocities[0, :, :2]
        gap = float(gaps_of(self._scene, ball, other, centres[np.newaxis])[0])
        if isinstance(other, int):
            way = centres[other] - centres[ball]
            normal = way / np.hypot(*way)
            closing = -float(normal @ (before[other] - before[ball]))
            return NearMiss(t, gap, normal, ball, other, closing, since)
        inward = other.normal if isinstance(other, Side) else facing(other, *centres[ball])[0]
        normal = -np.array(inward)
        return NearMiss(t, gap, normal, ball, None, float(normal @ before[ball]), since)

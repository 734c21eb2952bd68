"""Where balls of a shot all but touch: two of them pass, or one turns back short of a cushion."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import CUSHIONS, EventKind, ExactTrajectory, Result, Scene
from ghostball.validation.runs.sampling import events_of

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_HALVINGS = 60
"""Of an interval of time: to the last bit."""

_MOST_INTERVALS = 100_000
"""Of two balls between their events that are searched at once: 30 MB."""


def ball_passings(result: Result) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Return where the gap of two balls has a minimum between events: times, balls, gaps."""
    motion, meetings = result._exact("motion"), meetings_of(result)
    parts = [
        _passings_in(intervals, motion.radii, meetings)
        for intervals in _intervals(motion, np.any(result.scene.velocities != 0.0, axis=1))
    ]
    if not parts:
        none = np.empty(0)
        return none, np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), none
    times, a, b, gaps = (np.concatenate(column) for column in zip(*parts, strict=True))
    return times, a, b, gaps


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Intervals of time in which neither of two balls has an event, of many pairs of balls.

    Attributes
    ----------
    low, high : (k,) float64 [s]
    pairs : (k, 2) int64
        The two balls.
    within, after : (k, 2) int64
        The row of `knots` that says how each of the two moves, and the one that does at `high`.
    knots : (m, 14) float64
        Of all balls, as in `ExactTrajectory`.
    """

    low: FloatArray
    high: FloatArray
    pairs: IntArray
    within: IntArray
    after: IntArray
    knots: FloatArray

    def only(self, kept: IntArray) -> _Intervals:
        """Return some of the intervals."""
        return _Intervals(
            self.low[kept],
            self.high[kept],
            self.pairs[kept],
            self.within[kept],
            self.after[kept],
            self.knots,
        )

    def relative(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return place and velocity of the second ball relative to the first at an instant of each.

        As `ExactTrajectory.sample` has them, to the bit.
        """
        rows = np.where((times < self.high)[:, np.newaxis], self.within, self.after)
        states = []
        for row in rows.T:
            knot = self.knots[row]
            s = (times - knot[:, 0])[:, np.newaxis]
            r, v, a = knot[:, 1:3], knot[:, 3:5], knot[:, 5:7]
            states.append((r + s * (v + 0.5 * s * a), v + s * a))
        (place_a, velocity_a), (place_b, velocity_b) = states
        return place_b - place_a, velocity_b - velocity_a

    def closing(self, times: FloatArray) -> FloatArray:
        """Return half the rate of change of the squared distance at an instant of each [m^2/s]."""
        r, v = self.relative(times)
        rate: FloatArray = np.sum(r * v, axis=1)
        return rate


def _intervals(motion: ExactTrajectory, moving: NDArray[np.bool_]) -> Iterator[_Intervals]:
    """Yield the intervals of all pairs of which one ever moves, many at once."""
    starts = [knots[:, 0] for knots in motion.knots]
    first = np.cumsum([0, *(len(one) for one in starts)])
    knots = np.concatenate(motion.knots)
    pending: list[_Intervals] = []
    count = 0
    for i in range(len(starts)):
        for j in range(i):
            if len(starts[i]) == len(starts[j]) == 1 and not np.any(moving[[i, j]]):
                continue
            edges = np.unique(np.concatenate([starts[i], starts[j], [motion.t_end]]))
            rows = np.stack(
                [
                    first[ball]
                    + np.maximum(np.searchsorted(starts[ball], edges, side="right") - 1, 0)
                    for ball in (i, j)
                ],
                axis=1,
            )
            pairs = np.tile(np.array([i, j]), (len(edges) - 1, 1))
            pending.append(_Intervals(edges[:-1], edges[1:], pairs, rows[:-1], rows[1:], knots))
            count += len(edges) - 1
            if count > _MOST_INTERVALS:
                yield _joined(pending)
                pending, count = [], 0
    if pending:
        yield _joined(pending)


def _joined(parts: Sequence[_Intervals]) -> _Intervals:
    return _Intervals(
        np.concatenate([part.low for part in parts]),
        np.concatenate([part.high for part in parts]),
        np.concatenate([part.pairs for part in parts]),
        np.concatenate([part.within for part in parts]),
        np.concatenate([part.after for part in parts]),
        parts[0].knots,
    )


def _passings_in(
    every: _Intervals, radii: FloatArray, meetings: Mapping[tuple[int, int], set[float]]
) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Return what `ball_passings` does, of some intervals."""
    before = every.closing(np.nextafter(every.high, 0.0))
    turns = np.flatnonzero((every.closing(every.low) < 0.0) & (before > 0.0))
    # One also stops, or turns, at an event of its own: but not where the two meet.
    ending = np.flatnonzero((before < 0.0) & (every.closing(every.high) >= 0.0))
    stops = np.array(
        [
            k
            for k in ending.tolist()
            if every.high[k] not in meetings.get((every.pairs[k, 0], every.pairs[k, 1]), ())
        ],
        dtype=np.int64,
    )
    turning = every.only(turns)
    low, high = turning.low, turning.high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        falling = turning.closing(middle) < 0.0
        low, high = np.where(falling, middle, low), np.where(falling, high, middle)
    which = np.concatenate([turns, stops])
    times = np.concatenate([high, every.high[stops]])
    # By pairs; of each, first where one turns.
    pair_of = every.pairs[which, 0] * len(radii) + every.pairs[which, 1]
    order = np.lexsort((np.arange(len(which)), pair_of))
    which, times = which[order], times[order]
    a, b = every.pairs[which].T
    gaps = np.linalg.norm(every.only(which).relative(times)[0], axis=1) - (radii[a] + radii[b])
    return times, a, b, np.maximum(gaps, 0.0)


def meetings_of(result: Result) -> dict[tuple[int, int], set[float]]:
    """Return when each two balls collide [s], by the higher number and the lower."""
    meetings: dict[tuple[int, int], set[float]] = defaultdict(set)
    for t, kind, a, b in events_of(result).tolist():
        if kind == EventKind.BALL_BALL:
            meetings[max(a, b), min(a, b)].add(t)
    return meetings


class Cushion(NamedTuple):
    """A side of the table: its number in `CUSHIONS`, and gap = `inward` . place - `offset` - R."""

    number: int
    inward: FloatArray
    offset: float


def cushions_of(scene: Scene) -> tuple[Cushion, ...]:
    """Return the cushions that a scene's table has."""
    table = scene.table
    if table is None:
        return ()
    sides = {
        "left": ((1.0, 0.0), 0.0),
        "right": ((-1.0, 0.0), -table.length),
        "bottom": ((0.0, 1.0), 0.0),
        "top": ((0.0, -1.0), -table.width),
    }
    return tuple(
        Cushion(k, np.array(sides[name][0]), sides[name][1])
        for k, name in enumerate(CUSHIONS)
        if name in table.cushions
    )


def cushion_passings(result: Result) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Return where a ball turns back, or stops, short of a cushion: times, balls, cushions, gaps.

    At the vertex of its path, which is a parabola between two events of the ball; or at an event
    that sends it away, such as another ball that it meets.
    """
    motion, events = result._exact("motion"), events_of(result)
    bounces = events[events["kind"] == EventKind.BALL_CUSHION]
    met = set(zip(bounces["t"].tolist(), bounces["a"].tolist(), bounces["b"].tolist(), strict=True))
    found: list[tuple[float, int, int, float]] = []
    for cushion in cushions_of(result.scene):
        for ball, knots in enumerate(motion.knots):
            start = knots[:, 0]
            lasts = np.diff(np.append(start, max(motion.t_end, start[-1])))
            gap = knots[:, 1:3] @ cushion.inward - cushion.offset - motion.radii[ball]
            speed, pull = knots[:, 3:5] @ cushion.inward, knots[:, 5:7] @ cushion.inward
            ends = speed + pull * lasts
            after = np.append(speed[1:], ends[-1:])
            turns = (speed < 0.0) & (ends > 0.0)
            stops = ~turns & (speed < 0.0) & (after >= 0.0)
            with np.errstate(divide="ignore", invalid="ignore"):
                s = np.where(turns, -speed / pull, lasts)
            times = start + s
            gaps = gap + s * (speed + 0.5 * s * pull)
            for k in np.flatnonzero(turns | stops).tolist():
                t = float(start[k + 1]) if stops[k] and k + 1 < len(start) else float(times[k])
                if (t, ball, cushion.number) not in met:
                    found.append((t, ball, cushion.number, max(float(gaps[k]), 0.0)))
    rows = np.array(found, dtype=np.float64).reshape(-1, 4)
    return rows[:, 0], rows[:, 1].astype(np.int64), rows[:, 2].astype(np.int64), rows[:, 3]

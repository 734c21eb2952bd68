"""How little would change the course of a shot: other balls would meet, or in another order.

    >>> nearest = nearest_of(bifurcations_of(simulate(scene, record="trajectory")))[0]
    >>> nearest.relative         # relative change of the first state
    >>> nearest.describe(scene)  # 'ball "3" catches ball "5" by 0.12 mm at t = 1.234 s'

Each is a margin, in metres, over what a relative change of the first state of size 1 makes of it,
by the tangent map of the shot itself. To first order, so that it is the surer the smaller it is.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import CUSHIONS, EventKind, ExactTrajectory, Result, Scene
from ghostball.engine.sensitivity import LANES, PARTS
from ghostball.validation.runs.sampling import events_of

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

BifurcationKind = Literal["tie", "graze", "near miss", "order"]
"""Two collisions of a ball at one instant; a hit that all but misses; a miss that all but hits; a
collision that comes all but first."""

_LOCAL = 0.1
"""Of the sum of two radii: how near a competitor must be for its rate to tell when it touches."""

_HALVINGS = 60
"""Of an interval of time: to the last bit."""

_SEED = 59
"""Of the directions in which the first state is changed: the same for every shot."""

_MOST_NUMBERS = 4_000_000
"""Of perturbations that are held at once: 32 MB."""

_MOST_INTERVALS = 100_000
"""Of two balls between their events that are searched at once: 30 MB."""


@dataclass(frozen=True)
class Bifurcation:
    """Where a shot might have taken another course.

    Attributes
    ----------
    kind : "tie", "graze", "near miss" or "order"
    t : float [s]
    a, b : int
        The balls; b is -1 minus the index of a cushion, where it is one.
    margin : float [m]
        By how much a hit overlaps sideways, a miss is apart, or the ball that would have been first
        still has to go when the other collision comes; 0 for a tie.
    relative : float
        The relative change of the first state that uses up the margin, see `bifurcations_of`.
    """

    kind: BifurcationKind
    t: float
    a: int
    b: int
    margin: float
    relative: float

    def describe(self, scene: Scene) -> str:
        """Return the bifurcation in words."""
        first = f'ball "{scene.balls[self.a].id}"'
        second = (
            f'ball "{scene.balls[self.b].id}"'
            if self.b >= 0
            else f"cushion {CUSHIONS[-1 - self.b]}"
        )
        size, at = f"{1e3 * self.margin:.3g} mm", f"t = {self.t:.6g} s"
        if self.kind == "tie":
            return f"{first} has several collisions at {at}, one with {second}"
        if self.kind == "graze":
            return f"{first} catches {second} by {size} at {at}"
        if self.kind == "near miss":
            return f"{first} passes {second} {size} away at {at}"
        return f"{first} is {size} from {second} when another collision comes at {at}"


class Changes(Protocol):
    """What becomes of m small changes of a shot's first state."""

    @property
    def event_shifts(self) -> FloatArray:
        """How much later each event comes [s], (events, m)."""
        ...

    def sample(self, times: FloatArray) -> FloatArray:
        """Return the changes at `times`, (k, m, n, 2 or more), places first [m]."""
        ...


def bifurcations_of(result: Result, tangent: Changes | None = None) -> tuple[Bifurcation, ...]:
    """Return all bifurcations that a shot passes, in order of time.

    Parameters
    ----------
    result : Result
        Recorded with `record="trajectory"` by an engine of exact motion.
    tangent : Changes, optional
        What becomes of `directions_of` its scene; left out, by its own tangent map.

    Raises
    ------
    GhostballError
        Where it isn't.

    Notes
    -----
    The first state is changed in random directions: every ball's position by the extent of the
    scene, and the velocity and spin of every ball that moves, whatever their direction, by its
    speed; `relative` is in these units, and the root mean square over the directions. Unlike
    rounding in our engine, such changes respect no symmetry.

    Of cushions only ties count: no near miss of one, and none as a competitor. Between two events
    of two balls the least of their gaps counts where they part again, or one stops.

    Left out is what lies where no derivative exists, past ties and sustained contact; the first tie
    itself counts as one with margin 0.
    """
    if tangent is None:
        tangent = result.tangent(directions_of(result.scene))
    found = [*_ties(result), *_grazes(result, tangent), *_orders(result, tangent)]
    return tuple(sorted([*found, *_near_misses(result, tangent)], key=lambda one: one.t))


def nearest_of(bifurcations: Iterable[Bifurcation]) -> tuple[Bifurcation, ...]:
    """Return the nearest bifurcation of each kind, the nearest first."""
    nearest: dict[BifurcationKind, Bifurcation] = {}
    for one in bifurcations:
        if one.kind not in nearest or one.relative < nearest[one.kind].relative:
            nearest[one.kind] = one
    return tuple(sorted(nearest.values(), key=lambda one: one.relative))


def extent_of(scene: Scene) -> float:
    """Return the largest coordinate of a scene, of its table or of a ball [m]."""
    extent = float(np.max(np.abs(scene.positions[:, :2])) + np.max(scene.radii))
    return extent if scene.table is None else max(extent, scene.table.length, scene.table.width)


def directions_of(scene: Scene) -> FloatArray:
    """Return changes of the first state, (LANES, n, 7), of relative size 1."""
    signs = (
        np.random.default_rng(_SEED).integers(0, 2, (LANES, len(scene.balls), PARTS)) * 2.0 - 1.0
    )
    sizes = np.empty((len(scene.balls), PARTS))
    sizes[:, :2] = extent_of(scene)
    sizes[:, 2:4] = np.linalg.norm(scene.velocities, axis=1)[:, np.newaxis]
    sizes[:, 4:] = np.linalg.norm(scene.angular_velocities, axis=1)[:, np.newaxis]
    changes: FloatArray = signs * sizes
    return changes


def _ties(result: Result) -> Iterator[Bifurcation]:
    """Yield the first instant at which a ball has two collisions."""
    at: dict[int, float] = {}
    for t, kind, a, b in events_of(result).tolist():
        if kind not in (EventKind.BALL_BALL, EventKind.BALL_CUSHION):
            continue
        balls = (a, b) if kind == EventKind.BALL_BALL else (a,)
        other = b if kind == EventKind.BALL_BALL else -1 - b
        if any(at.get(ball) == t for ball in balls):
            yield Bifurcation("tie", t, a, other, 0.0, 0.0)
            return
        at |= dict.fromkeys(balls, t)


def _grazes(result: Result, tangent: Changes) -> Iterator[Bifurcation]:
    """Yield for each hit of two balls by how much they might miss, sideways."""
    events = events_of(result)
    hits = np.flatnonzero(events["kind"] == EventKind.BALL_BALL)
    radii = result.scene.radii
    for rows in _chunks(hits, len(radii)):
        t, a, b = (events[name][rows] for name in ("t", "a", "b"))
        before = np.nextafter(t, 0.0)
        state = result.sample(before)
        at = np.arange(len(rows))
        r = (state.positions[at, b] - state.positions[at, a])[:, :2]
        v = (state.velocities[at, a] - state.velocities[at, b])[:, :2]
        speed = np.linalg.norm(v, axis=1)
        with np.errstate(invalid="ignore"):  # of a tie, which is noted as such
            across = np.stack([-v[:, 1], v[:, 0]], axis=1) / speed[:, np.newaxis]
        margin = radii[a] + radii[b] - np.abs(np.sum(across * r, axis=1))
        change = _changes(tangent, before, a, b)
        spread = _spread(np.einsum("kx,kmx->km", across, change))
        yield from _bifurcations("graze", t, a, b, np.maximum(margin, 0.0), spread)


def _orders(result: Result, tangent: Changes) -> Iterator[Bifurcation]:
    """Yield for each collision of a ball how near another of the same ball was."""
    events, scene = events_of(result), result.scene
    collisions = np.flatnonzero(events["kind"] <= EventKind.BALL_CUSHION)
    n = len(scene.balls)
    for rows in _chunks(collisions, n):
        t, kind = events["t"][rows], events["kind"][rows]
        before = np.nextafter(t, 0.0)
        state = result.sample(before)
        for name in ("a", "b"):
            chosen = rows if name == "a" else rows[kind == EventKind.BALL_BALL]
            at = np.flatnonzero(np.isin(rows, chosen))
            if not len(at):
                continue
            mover = events[name][rows[at]].astype(np.int64)
            taken = np.where(
                kind[at] == EventKind.BALL_BALL, events["b" if name == "a" else "a"][rows[at]], -1
            )
            for other in range(n):
                free = (mover != other) & (taken != other)
                if np.any(free):
                    yield from _competing(
                        result,
                        tangent,
                        rows[at[free]],
                        before[at[free]],
                        mover[free],
                        other,
                        state.positions[at[free]],
                        state.velocities[at[free]],
                    )


def _competing(
    result: Result,
    tangent: Changes,
    rows: IntArray,
    before: FloatArray,
    mover: IntArray,
    other: int,
    positions: FloatArray,
    velocities: FloatArray,
) -> Iterator[Bifurcation]:
    """Yield how near `other` was to being met by each mover, when its event of `rows` came."""
    radii, k = result.scene.radii, np.arange(len(rows))
    r = (positions[:, other] - positions[k, mover])[:, :2]
    distance = np.linalg.norm(r, axis=1)
    reach = radii[mover] + radii[other]
    normal = r / distance[:, np.newaxis]
    approach = np.sum(normal * (velocities[k, mover] - velocities[:, other])[:, :2], axis=1)
    gap = np.maximum(distance - reach, 0.0)
    close = np.flatnonzero((approach > 0.0) & (gap < _LOCAL * reach))
    if not len(close):
        return
    b = np.full(len(close), other)
    change = _changes(tangent, before[close], mover[close], b)
    later = np.einsum("kx,kmx->km", normal[close], change) / approach[close, np.newaxis]
    relative = approach[close, np.newaxis] * (later - tangent.event_shifts[rows[close]])
    t = events_of(result)["t"][rows[close]]
    yield from _bifurcations("order", t, mover[close], b, gap[close], _spread(relative))


def _near_misses(result: Result, tangent: Changes) -> Iterator[Bifurcation]:
    """Yield how closely two balls pass without touching."""
    times, a, b, gaps = _passings(result)
    for rows in _chunks(np.argsort(times, kind="stable"), len(result.scene.balls)):
        at = np.arange(len(rows))
        places = result.sample(times[rows]).positions[..., :2]
        r = places[at, b[rows]] - places[at, a[rows]]
        normal = r / np.linalg.norm(r, axis=1)[:, np.newaxis]
        change = _changes(tangent, times[rows], a[rows], b[rows])
        spread = _spread(np.einsum("kx,kmx->km", normal, change))
        yield from _bifurcations("near miss", times[rows], a[rows], b[rows], gaps[rows], spread)


def _passings(result: Result) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Return where the gap of two balls has a minimum between events: times, balls, gaps."""
    motion, meetings = result._exact("motion"), _meetings(result)
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
    """Return what `_passings` does, of some intervals."""
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


def _meetings(result: Result) -> dict[tuple[int, int], set[float]]:
    """Return when each two balls collide [s], by the higher number and the lower."""
    meetings: dict[tuple[int, int], set[float]] = defaultdict(set)
    for t, kind, a, b in events_of(result).tolist():
        if kind == EventKind.BALL_BALL:
            meetings[max(a, b), min(a, b)].add(t)
    return meetings


def _changes(tangent: Changes, times: FloatArray, a: IntArray, b: IntArray) -> FloatArray:
    """Return the perturbations of the position of b relative to a at times, (k, m, 2) [m]."""
    places = tangent.sample(times)[..., :2]
    at = np.arange(len(times))
    change: FloatArray = places[at, :, b] - places[at, :, a]
    return change


def _spread(values: FloatArray) -> FloatArray:
    """Return the root mean square over perturbations, (k,)."""
    with np.errstate(over="ignore", invalid="ignore"):
        spread: FloatArray = np.sqrt(np.mean(values**2, axis=-1))
    return spread


def _bifurcations(
    kind: BifurcationKind,
    t: FloatArray,
    a: IntArray,
    b: IntArray,
    margin: FloatArray,
    spread: FloatArray,
) -> Iterator[Bifurcation]:
    for one in zip(t, a, b, margin, spread, strict=True):
        size, change = float(one[3]), float(one[4])
        # A margin that nothing changes is none to speak of; no derivative, no margin.
        if np.isfinite(change) and change > 0.0:
            yield Bifurcation(kind, float(one[0]), int(one[1]), int(one[2]), size, size / change)


def _chunks(rows: IntArray, n: int) -> Iterator[IntArray]:
    size = max(_MOST_NUMBERS // (56 * n), 1)
    for start in range(0, len(rows), size):
        yield rows[start : start + size]

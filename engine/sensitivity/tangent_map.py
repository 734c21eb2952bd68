"""How a shot answers to small changes: the tangent map, and until when it can be predicted.

    >>> result = simulate(scene, record="trajectory")
    >>> result.sensitivity(result.rest_time)     # what rounding does to each ball, over 2^-53 [m]
    >>> result.horizon(tolerance=1e-3)           # until when our engine tells where balls are [s]
    >>> result.tangent(directions).sample(times) # what becomes of given changes of the first state

The derivative is that of the engine's own trajectory, and exact for its laws: each event also comes
sooner or later. None exists past an instant at which one ball has several collisions, for any
change decides their order, and past sustained contact: there it is infinite. Where air slows balls,
or they may leave the cloth, none is known, and it is infinite from the start.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.core.rows import OBSTACLE, ObstacleRow, rows_of
from ghostball.engine.library.entry import Needed
from ghostball.engine.running.from_scene import laws_of, layout_of
from ghostball.engine.running.skips import has_drag
from ghostball.engine.running.variants import Variant, still_scene
from ghostball.engine.sensitivity import state as ts
from ghostball.engine.sensitivity.propagate import run_tangent, sample_growth, sample_tangent
from ghostball.model import ExactTrajectory, Scene
from ghostball.model.errors import GhostballError
from ghostball.model.events import EVENT_DTYPE, OBSTACLE_KINDS, EventKind, Events

FloatArray = NDArray[np.float64]

LANES, PARTS = ts.LANES, ts.PARTS
"""Changes that cost as much as one; numbers that a change of a ball has."""

ROUNDING = 2.0**-53
"""Half the spacing of doubles at 1: the largest relative error of one rounding."""

QUALITY = 32.0
"""How many times the error of one rounding of the state at each event our engine stays within."""

_RUNS, _MOST_SEGMENTS = 4, 20_000
"""How often LANES random signs are carried at most, and along how many segments in all: memory."""

_BETWEEN = 4
"""Parts that a segment is cut into where growth is looked for."""

_CHUNK = 16_384
"""Instants at which growth is computed at once: it grows, so most of a long run is never needed."""


@dataclass(frozen=True, eq=False)
class TangentMap:
    """What becomes of m small changes of a shot's first state, to first order.

    `count`: m.
    `t_end` [s]: last instant of the motion.
    `balls`, `events`: how many the shot has.
    """

    count: int
    t_end: float
    balls: int
    events: int
    _runs: tuple[ts.Tangents, ...]  # none where no derivative is known

    def sample(self, times: ArrayLike) -> FloatArray:
        """Return the changes at `times`, (k, m, n, 7) float64.

        `times` (k,) float64 [s], in any order; past the end, as at the end.

        Returns (k, m, n, 7) float64: for each ball the change of its position x, y [m], velocity x,
        y [m/s] and angular velocity x, y, z [rad/s] at the same instant; not finite where no
        derivative exists.
        """
        t, order = _increasing(times, self.t_end)
        if not self._runs:
            return np.full((len(t), self.count, self.balls, ts.PARTS), math.inf)
        parts = []
        for run in self._runs:
            out = np.empty((len(t), len(run.at), ts.ROW_LENGTH))
            with _growing():
                sample_tangent(run, t, out)
            parts.append(out.reshape(len(t), len(run.at), ts.PARTS, ts.LANES))
        lanes = np.concatenate(parts, axis=3)[..., : self.count]
        result = np.empty_like(lanes)
        result[order] = lanes
        return result.transpose(0, 3, 1, 2)

    @property
    def event_shifts(self) -> FloatArray:
        """How much later each event comes [s], (events, m); NaN where no derivative exists."""
        if not self._runs:
            return np.full((self.events, self.count), math.nan)
        shifts: FloatArray = np.concatenate(
            [run.shift.reshape(-1, ts.LANES) for run in self._runs], axis=1
        )
        return shifts[:, : self.count]

    def growth(self, times: ArrayLike) -> FloatArray:
        """Return how far each ball is displaced, (k, n) [m]: root mean square over the changes.

        Over all LANES of them, unless there are fewer. Infinite where no derivative exists.
        """
        t, order = _increasing(times, self.t_end)
        total = np.zeros((len(t), self.balls))
        if not self._runs:
            return np.full_like(total, math.inf)
        for run in self._runs:
            out = np.empty_like(total)
            with _growing():
                sample_growth(run, t, out)
            total = np.hypot(total, out)  # a square may overflow
        result = np.empty_like(total)
        result[order] = total * math.sqrt(ts.LANES / self.count)
        return result

    def horizon(self, instants: FloatArray, tolerance: float, error: float | None) -> float:
        """Return the first instant at which error times `growth` exceeds a tolerance [s].

        inf: none does.

        `instants` (k,) float64 [s], increasing: of the events; between two of them growth is looked
            for at a few instants only.
        `tolerance` [m].
        `error`: None: that within which our engine stays, `QUALITY` times the error of a rounding.
        """
        limit = tolerance / (QUALITY * ROUNDING if error is None else error)
        for times in _chunks(instants, self.t_end):
            beyond = ~(np.max(self.growth(times), axis=1) <= limit)
            if np.any(beyond):
                first = int(np.argmax(beyond))
                if first == 0:
                    return float(times[0])
                return _first_beyond(self, float(times[first - 1]), float(times[first]), limit)
        return float("inf")


def tangent_of(
    scene: Scene, trajectory: ExactTrajectory, events: Events, directions: ArrayLike
) -> TangentMap:
    """Return what becomes of small changes of the first state of a shot.

    `trajectory`, `events`: of its run, as our engine records them; `Result.tangent` passes its own.
    `directions` (m, n, 7) float64: each a change of every ball's position x, y [m], velocity x, y
        [m/s] and angular velocity x, y, z [rad/s]. The angular velocity of a ball that begins by
        rolling follows its velocity; one that rests stops again at once where the cloth slows it,
        and stays.

    Raises `GhostballError` where `directions` has another shape, or isn't finite; where the
    trajectory or the events name balls or obstacles that the scene doesn't have, or can't be of its
    physics; or where our engine doesn't simulate the scene.
    """
    n = len(scene.balls)
    given = np.asarray(directions, dtype=np.float64)
    if given.ndim != 3 or given.shape[1:] != (n, ts.PARTS) or not len(given):
        raise GhostballError(
            f"`directions` must be of shape (m, {n}, {ts.PARTS}) with m at least 1, got "
            f'{given.shape} (scene "{scene.name}" has {n} balls)'
        )
    if not np.all(np.isfinite(given)):
        raise GhostballError("`directions` must be finite, got NaN or infinity")
    runs = []
    _check_recorded(scene, trajectory, events)
    for start in range(0, len(given), ts.LANES) if has_derivative(scene) else ():
        lanes = np.zeros((n, ts.PARTS, ts.LANES))
        some = given[start : start + ts.LANES]
        lanes[:, :, : len(some)] = some.transpose(1, 2, 0)
        runs.append(_run(scene, trajectory, events, lanes))
    return TangentMap(len(given), trajectory.t_end, n, len(events), tuple(runs))


def rounding_of(scene: Scene, trajectory: ExactTrajectory, events: Events) -> TangentMap:
    """Return what becomes of rounding the state at the start and at each event, over 2^-53.

    Each number that an event sets is changed by its size with a random sign, in 32 independent ways
    (fewer where the balls have more than 5000 segments, 8 beyond 10 000). So it is a sample: its
    standard error is some 12 % of the root mean square over all signs (25 % of 8).
    The signs depend on where the balls began and on nothing else: the same shot has the same
    result, however its balls are numbered. Where balls move at less than some 1e-100 m/s, products
    of their speeds leave the range of doubles, and no derivative is found: infinite.
    """
    n = len(scene.balls)
    _check_recorded(scene, trajectory, events)
    count = max(1, min(_RUNS, _MOST_SEGMENTS // sum(len(one) for one in trajectory.segments)))
    runs = []
    for number in range(count) if has_derivative(scene) else ():
        start = np.zeros((n, ts.PARTS, ts.LANES))
        runs.append(_run(scene, trajectory, events, start, 1.0, number))
    return TangentMap(ts.LANES * count, trajectory.t_end, n, len(events), tuple(runs))


def has_derivative(scene: Scene) -> bool:
    """Whether anything is known of how shots of a scene answer to small changes.

    Nothing is where air slows balls or they may leave the cloth.
    """
    return not (has_drag(scene) or scene.physics.airborne)


def _chunks(segments: FloatArray, t_end: float) -> Iterator[FloatArray]:
    """Yield instants at the segments' starts and between; each chunk begins where one ended."""
    ends = np.append(segments, t_end) if segments[-1] < t_end else segments
    step = _CHUNK // _BETWEEN
    for start in range(0, max(len(ends) - 1, 1), step):
        some = ends[start : start + step + 1]
        fractions = np.arange(_BETWEEN) / _BETWEEN
        inner = some[:-1, np.newaxis] + np.diff(some)[:, np.newaxis] * fractions
        yield np.append(inner.ravel(), some[-1])


def _first_beyond(rounding: TangentMap, low: float, high: float, limit: float) -> float:
    """Return where the growth passes `limit` between two instants, to the last bit."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return high
        if float(np.max(rounding.growth([middle]))) <= limit:
            low = middle
        else:
            high = middle


def _run(
    scene: Scene,
    trajectory: ExactTrajectory,
    events: Events,
    start: FloatArray,
    rounding: float = 0.0,
    signs: int = 0,
) -> ts.Tangents:
    """Carry perturbations (n, PARTS, LANES) at the start along a motion, and roundings of it."""
    warm_up()
    run = _arrays(scene, trajectory, events, rounding, signs)
    # A ball that rests stops again at once, where the cloth slows it.
    rests = (run.segments[run.first[:-1], st.PHASE] == st.RESTING) & (
        run.state[:, st.ROLL_SLOWING] > 0.0
    )
    start[rests, ts.DVX // ts.LANES : ts.DVY // ts.LANES + 1] = 0.0
    run.tangent.reshape(-1, ts.ROW_LENGTH)[run.first[:-1]] = start.reshape(-1, ts.ROW_LENGTH)
    with _growing():
        run_tangent(run)
    return run


def _arrays(
    scene: Scene, trajectory: ExactTrajectory, events: Events, rounding: float, signs: int = 0
) -> ts.Tangents:
    n, m, layout = len(scene.balls), len(events), layout_of(scene)
    laws = laws_of(scene)
    lines = laws.obstacles
    rows = lines.view(OBSTACLE)[:, 0] if COMPILED else rows_of(lines, ObstacleRow)
    first = np.zeros(n + 1, dtype=np.int64)
    np.cumsum([len(segments) for segments in trajectory.segments], out=first[1:])
    rank = np.empty(n, dtype=np.int64)
    rank[np.lexsort((layout.state[:, st.Y], layout.state[:, st.X]))] = np.arange(n)
    what = np.empty((m, 3), dtype=np.int64)
    what[:, 0], what[:, 1], what[:, 2] = events["kind"], events["a"], events["b"]
    return ts.Tangents(
        lanes=ts.LANES,
        state=layout.state,
        laws=laws._replace(obstacles=rows),
        segments=np.concatenate(trajectory.segments),
        first=first,
        rank=rank,
        time=np.ascontiguousarray(events["t"]),
        what=what,
        rounding=rounding,
        signs=signs,
        tangent=np.empty(int(first[-1]) * ts.ROW_LENGTH),
        shift=np.empty(m * ts.LANES),
        at=np.zeros(n, dtype=np.int64),
        due=np.zeros(n, dtype=np.int64),
        motion=np.zeros((2, ts.PRE_COLUMNS)),
        work=np.zeros(ts.WORK),
        law=np.zeros((ts.LAW_OUT, ts.LAW_IN)),
    )


def _check_recorded(scene: Scene, trajectory: ExactTrajectory, events: Events) -> None:
    """Refuse what can't be of the scene: the kernels would read beyond their arrays."""
    obstacles = layout_of(scene).obstacles  # checks the scene
    n = len(scene.balls)
    pairs = events["kind"] == EventKind.BALL_BALL
    named = np.concatenate((events["a"], events["b"][pairs]))
    if len(trajectory.segments) != n or np.any((named < 0) | (named >= n)):
        raise GhostballError(
            f"`trajectory` and `events` must be those of the scene, of {n} balls, got the "
            f"trajectories of {len(trajectory.segments)} and events of balls "
            f"{sorted(set(named.tolist()))}"
        )
    met = {int(b) for b in events["b"][np.isin(events["kind"], OBSTACLE_KINDS)]}
    there = {int(index) for index in obstacles.view(OBSTACLE)["index"].flat}
    if not met <= there:
        raise GhostballError(
            f'`events` must be those of scene "{scene.name}", whose obstacles are '
            f"{sorted(there)}, got events at obstacles {sorted(met - there)}. Give the scene, "
            "trajectory and events of one result"
        )
    shapes = {segments.shape for segments in trajectory.segments}
    if any(
        rows == 0 or (has_derivative(scene) and columns != st.SEGMENT_COLUMNS)
        for rows, columns in shapes
    ):
        raise GhostballError(
            f'`trajectory` must be that of scene "{scene.name}", with {st.SEGMENT_COLUMNS} numbers '
            f"for each segment of each ball, got arrays of shapes {sorted(shapes)}. "
            "Give the scene, trajectory and events of one result"
        )


def _growing() -> AbstractContextManager[None]:
    """Let numbers that outgrow doubles become infinite, and NaN, without a warning.

    A long chaotic motion does that to a derivative. Compiled kernels never warn; others would.
    """
    return np.errstate(over="ignore", invalid="ignore")


def warm_up() -> None:
    """Compile the kernels that tangent maps need, or load them; say so if compiled."""
    for one in needed():
        one.load()


@cache
def needed() -> tuple[Needed, ...]:
    """Return the kernels of tangent maps, to be compiled or loaded."""
    name = "sensitivity"
    scene = still_scene(Variant(cells=False))
    segments = (np.zeros((1, st.SEGMENT_COLUMNS)),) * len(scene.balls)
    trajectory = ExactTrajectory(scene.radii, segments, 1.0, np.zeros(len(scene.balls)))
    run = _arrays(scene, trajectory, np.empty(0, dtype=EVENT_DTYPE), 1.0)
    samples, growth = np.empty((1, 1, ts.ROW_LENGTH)), np.empty((1, 1))
    return (
        Needed(run_tangent, (run,), name),
        Needed(sample_tangent, (run, np.zeros(1), samples), f"{name}, samples"),
        Needed(sample_growth, (run, np.zeros(1), growth), f"{name}, growth"),
    )


def _increasing(times: ArrayLike, t_end: float) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return instants in order, none past the end, and where each was."""
    t = np.minimum(np.atleast_1d(np.asarray(times, dtype=np.float64)), t_end)
    order = np.argsort(t, kind="stable")
    return t[order], order

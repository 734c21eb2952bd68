"""How a shot answers to small changes: the tangent map, and until when it can be predicted.

    >>> result = simulate(scene, record="trajectory")
    >>> result.sensitivity(result.rest_time)     # what rounding does to each ball, over 2^-53 [m]
    >>> result.horizon(tolerance=1e-3)           # until when our engine tells where balls are [s]
    >>> result.tangent(directions).sample(times) # what becomes of given changes of the first state

The derivative is that of the engine's own trajectory: each event also comes sooner or later. On the
cloth it is exact for the laws (`sensitivity.carried`), to 1e-9 of the largest change; in air and in
flight it is half the difference of two runs begun a little aside (`sensitivity.replayed`), to some
1e-7, and 1e-3 where all balls are slower than 1e-4 m/s. None exists past an instant at which one
ball has several collisions, for any change decides their order, and past sustained contact: there
it is infinite.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ghostball.engine.core import state as st
from ghostball.engine.core.rows import OBSTACLE
from ghostball.engine.running.from_scene import layout_of
from ghostball.engine.running.skips import is_lean
from ghostball.engine.sensitivity.carried import Carried
from ghostball.engine.sensitivity.motion import PARTS, FloatArray
from ghostball.engine.sensitivity.replayed import Replayed
from ghostball.engine.sensitivity.rounding import LANES
from ghostball.model import ExactTrajectory, Scene
from ghostball.model.errors import GhostballError
from ghostball.model.events import OBSTACLE_KINDS, EventKind, Events

ROUNDING = 2.0**-53
"""Half the spacing of doubles at 1: the largest relative error of one rounding."""

QUALITY = 32.0
"""How many times the error of one rounding of the state at each event our engine stays within."""

_RUNS, _MOST_SEGMENTS = 4, 20_000
"""How often random signs are carried at most, and along how many segments in all: memory."""

_RUNS_PLAYED = 2
"""The same where changes are played on, which takes longer."""

_BETWEEN = 4
"""Parts that a segment is cut into where growth is looked for."""

_CHUNK = 1024
"""Instants at which growth is computed at once: it grows, so most of a long run is never needed."""


class Changes(Protocol):
    """What becomes of m changes of the first state of n balls; NaN where no derivative exists."""

    @property
    def event_shifts(self) -> FloatArray:
        """How much later each event comes [s], (events, m)."""

    def known(self, times: FloatArray) -> FloatArray:
        """Return the changes at some instants, (k, n, 7, m)."""

    def moved(self, times: FloatArray) -> Iterable[FloatArray]:
        """Return changes of places, (2 or 3, k, n, m) [m], some instants after the others."""


@dataclass(frozen=True, eq=False)
class TangentMap:
    """What becomes of m small changes of a shot's first state, to first order.

    `count`: m.
    `t_end` [s]: last instant of the motion.
    """

    count: int
    t_end: float
    _changes: Changes

    def sample(self, times: ArrayLike) -> FloatArray:
        """Return the changes at `times`, (k, m, n, 7) float64.

        `times` (k,) float64 [s], in any order; past the end, as at the end.

        Returns (k, m, n, 7) float64: for each ball the change of its position x, y [m], velocity x,
        y [m/s] and angular velocity x, y, z [rad/s] at the same instant; not finite where no
        derivative exists.
        """
        with _growing():
            return self._changes.known(self._within(times)).transpose(0, 3, 1, 2)

    @property
    def event_shifts(self) -> FloatArray:
        """How much later each event comes [s], (events, m); NaN where no derivative exists."""
        return self._changes.event_shifts

    def growth(self, times: ArrayLike) -> FloatArray:
        """Return how far each ball is displaced, (k, n) [m]: root mean square over the changes.

        Infinite where no derivative exists.
        """
        with _growing():
            moved = self._changes.moved(self._within(times))
            return np.concatenate([_root_mean_square(some) for some in moved])

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

    def _within(self, times: ArrayLike) -> FloatArray:
        return np.minimum(np.atleast_1d(np.asarray(times, dtype=np.float64)), self.t_end)


def _root_mean_square(moved: FloatArray) -> FloatArray:
    """Return the root mean square length of displacements (d, k, n, m) over m, (k, n) [m].

    inf for a NaN. Scaled by the largest, for a square may overflow.
    """
    largest = np.max(np.abs(moved), axis=(0, 3))
    finite = np.isfinite(largest)
    scale = np.where(finite & (largest > 0.0), largest, 1.0)
    parts = moved / scale[..., np.newaxis]
    sizes = largest * np.sqrt(np.sum(parts * parts, axis=(0, 3)) / moved.shape[3])
    found: FloatArray = np.where(finite, sizes, np.inf)
    return found


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
    if given.ndim != 3 or given.shape[1:] != (n, PARTS) or not len(given):
        raise GhostballError(
            f"`directions` must be of shape (m, {n}, {PARTS}) with m at least 1, got "
            f'{given.shape} (scene "{scene.name}" has {n} balls)'
        )
    if not np.all(np.isfinite(given)):
        raise GhostballError("`directions` must be finite, got NaN or infinity")
    _check_recorded(scene, trajectory, events)
    given = given.transpose(1, 2, 0)
    changes = (Carried if is_lean(scene) else Replayed)(scene, trajectory, events, given)
    return TangentMap(given.shape[2], trajectory.t_end, changes)


def rounding_of(scene: Scene, trajectory: ExactTrajectory, events: Events) -> TangentMap:
    """Return what becomes of rounding the state at the start and at each event, over 2^-53.

    Each number that an event sets is changed by its size with a random sign, in 32 independent ways
    (fewer where the balls have more than 5000 segments, 8 beyond 10 000; 16 in air and in flight).
    So it is a sample: its standard error is some 12 % of the root mean square over all signs (18 %
    of 16, 25 % of 8).
    The signs depend on where the balls began and on nothing else: the same shot has the same
    result, however its balls are numbered. Where balls move at less than some 1e-100 m/s, products
    of their speeds leave the range of doubles, and no derivative is found: infinite.
    """
    _check_recorded(scene, trajectory, events)
    segments = sum(len(one) for one in trajectory.segments)
    lean = is_lean(scene)
    runs = max(1, min(_RUNS if lean else _RUNS_PLAYED, _MOST_SEGMENTS // segments))
    changes = (Carried if lean else Replayed)(scene, trajectory, events, None, runs)
    return TangentMap(LANES * runs, trajectory.t_end, changes)


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


def _check_recorded(scene: Scene, trajectory: ExactTrajectory, events: Events) -> None:
    """Refuse what can't be of the scene."""
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
    lean = is_lean(scene)
    if any(rows == 0 or (lean and columns != st.SEGMENT_COLUMNS) for rows, columns in shapes):
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

"""Response of a shot to small changes: its tangent map, and its horizon of predictability.

    >>> result = simulate(scene, record="trajectory")
    >>> result.sensitivity(result.rest_time)     # effect of rounding on each ball, over 2^-53 [m]
    >>> result.horizon(tolerance=1e-3)           # until when the engine knows the positions [s]
    >>> result.tangent(directions).sample(times) # effect of given changes of the first state

The tangent map is the derivative of the engine's own trajectory, including the times of events. On
the cloth it is exact for the laws (`sensitivity.carried`), with an error of 1e-9 of the largest
change. In air and in flight it is half the difference of two runs with slightly changed states
(`sensitivity.replayed`), with an error of about 1e-7, or 1e-3 if all balls are slower than 1e-4
m/s. No derivative exists after several collisions of a ball at one time, because any change decides
their order, and none after a resting contact. The map is infinite there.
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
"""Bound on this engine's errors, in units of the error of one rounding of the state per event."""

_RUNS, _MOST_SEGMENTS = 4, 20_000
"""Largest number of groups of random signs, and of segments in all groups, to limit memory."""

_RUNS_PLAYED = 2
"""Largest number of groups for simulated changes, which take longer."""

_PARTS_PER_SEGMENT = 4
"""Number of parts of a segment at whose ends growth is computed."""

_CHUNK = 1024
"""Number of times at which growth is computed at once; most of a long run is never needed."""


class Changes(Protocol):
    """The effects of m changes of the first state of n balls; NaN if no derivative exists."""

    @property
    def event_shifts(self) -> FloatArray:
        """Delay of each event [s], (events, m)."""

    def known(self, times: FloatArray) -> FloatArray:
        """Return the changes at k times, (k, n, 7, m)."""

    def moved(self, times: FloatArray) -> Iterable[FloatArray]:
        """Return changes of positions, (2 or 3, k, n, m) [m], for successive groups of times."""


@dataclass(frozen=True, eq=False)
class EngineTangentMap:
    """The effects of m small changes of a shot's first state, to first order.

    `count`: m.
    `t_end` [s]: last time of the motion.
    """

    count: int
    t_end: float
    _changes: Changes

    def sample(self, times: ArrayLike) -> FloatArray:
        """Return the changes at `times`, (k, m, n, 7) float64.

        `times` (k,) float64 [s], in any order; later times count as the end.

        Returns (k, m, n, 7) float64: for each ball the change of its position x, y [m], velocity x,
        y [m/s] and angular velocity x, y, z [rad/s] at the same time; not finite if no derivative
        exists.
        """
        with _growing():
            return self._changes.known(self._within(times)).transpose(0, 3, 1, 2)

    @property
    def event_shifts(self) -> FloatArray:
        """Delay of each event [s], (events, m); NaN if no derivative exists."""
        return self._changes.event_shifts

    def growth(self, times: ArrayLike) -> FloatArray:
        """Return the displacement of each ball, (k, n) [m]: root mean square over the changes.

        Infinite if no derivative exists.
        """
        with _growing():
            moved = self._changes.moved(self._within(times))
            return np.concatenate([_root_mean_square(some) for some in moved])

    def horizon(self, instants: FloatArray, tolerance: float, error: float | None) -> float:
        """Return the first time at which `error` times `growth` exceeds a tolerance [s].

        inf if there is none.

        `instants` (k,) float64 [s], increasing: the times of the events; between two of them growth
            is computed at a few times only.
        `tolerance` [m].
        `error`: None: the bound on this engine's errors, `QUALITY` times the error of a rounding.
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

    inf for a NaN. Scaled by the largest displacement, because a square may overflow.
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
) -> EngineTangentMap:
    """Return the effects of small changes of the first state of a shot.

    `trajectory`, `events`: as this engine records them; `Result.tangent` passes those it has.
    `directions` (m, n, 7) float64: each a change of every ball's position x, y [m], velocity x, y
        [m/s] and angular velocity x, y, z [rad/s]. The angular velocity of a ball that is rolling
        at the start follows its velocity. A ball at rest stops again immediately if the cloth slows
        it.

    Raises `GhostballError` if `directions` has another shape, or isn't finite; if the trajectory or
    the events have balls or obstacles that the scene doesn't have, or can't belong to its physics;
    or if this engine doesn't simulate the scene.
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
    return EngineTangentMap(given.shape[2], trajectory.t_end, changes)


def rounding_of(scene: Scene, trajectory: ExactTrajectory, events: Events) -> EngineTangentMap:
    """Return the effects of rounding the state at the start and at each event, over 2^-53.

    Each number that an event sets is changed by its size with a random sign, in 32 independent
    samples (fewer if the balls have more than 5000 segments, 8 beyond 10 000; 16 in air and in
    flight). The standard error of the root mean square is therefore about 12 % (18 % with 16
    samples, 25 % with 8).

    The signs depend on the initial positions of the balls only: the same shot has the same result
    for any numbering of the balls. If balls move at less than about 1e-100 m/s, products of their
    speeds are outside the range of doubles, and the result is infinite.
    """
    _check_recorded(scene, trajectory, events)
    segments = sum(len(one) for one in trajectory.segments)
    lean = is_lean(scene)
    runs = max(1, min(_RUNS if lean else _RUNS_PLAYED, _MOST_SEGMENTS // segments))
    changes = (Carried if lean else Replayed)(scene, trajectory, events, None, runs)
    return EngineTangentMap(LANES * runs, trajectory.t_end, changes)


def _chunks(segments: FloatArray, t_end: float) -> Iterator[FloatArray]:
    """Yield times at and between the starts of segments; each chunk starts where the last ended."""
    ends = np.append(segments, t_end) if segments[-1] < t_end else segments
    step = _CHUNK // _PARTS_PER_SEGMENT
    for start in range(0, max(len(ends) - 1, 1), step):
        some = ends[start : start + step + 1]
        fractions = np.arange(_PARTS_PER_SEGMENT) / _PARTS_PER_SEGMENT
        inner = some[:-1, np.newaxis] + np.diff(some)[:, np.newaxis] * fractions
        yield np.append(inner.ravel(), some[-1])


def _first_beyond(rounding: EngineTangentMap, low: float, high: float, limit: float) -> float:
    """Return the time at which the growth exceeds `limit` between two times, to the last bit."""
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return high
        if float(np.max(rounding.growth([middle]))) <= limit:
            low = middle
        else:
            high = middle


def _check_recorded(scene: Scene, trajectory: ExactTrajectory, events: Events) -> None:
    """Refuse a trajectory or events that can't belong to the scene."""
    obstacles = layout_of(scene).obstacles  # checks the scene
    n = len(scene.balls)
    pairs = events["kind"] == EventKind.BALL_BALL
    named = np.concatenate((events["a"], events["b"][pairs]))
    if len(trajectory.segments) != n or np.any((named < 0) | (named >= n)):
        raise GhostballError(
            f"`trajectory` and `events` must be those of the scene, which has {n} balls, got the "
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

    The derivatives of a long chaotic motion outgrow doubles. Compiled kernels never warn; numpy
    would.
    """
    return np.errstate(over="ignore", invalid="ignore")

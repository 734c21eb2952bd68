"""When to sample a result, and its energy and overlaps there.

A stepping engine's frames are joined by straight lines, so between two frames its velocity is a
blend, and the energy of a blend of two velocities is less than either's. Its energy is therefore
taken at the frames alone and interpolated; our own engine's motion is exact at any time.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ghostball.model import (
    Energy,
    Events,
    ExactTrajectory,
    GhostballError,
    Hole,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    energy_of,
)
from ghostball.model.arrays import FloatArray
from ghostball.model.events import LEAVING_KINDS
from ghostball.model.scene.obstacles import gap_to
from ghostball.validation.results.records import Motion

UNIFORM_TIMES = 401
"""Times of the stored motion's uniform grid: more than a figure's width resolves."""

MAX_TIMES = 4_000
"""Times of the stored motion at most, events included: 3 MB for 16 balls before compression."""

PATH_DEVIATION = 2e-4
"""How far a stored path may run beside a curved one [m]: a tenth of a pixel in a figure."""

DENSE_TIMES = 20_001
"""Times at which an exact motion is searched for overlaps: 1 mm of path at 2 m/s for 10 s."""

_CHUNK = 1_000
"""Times handled at once when searching for overlaps: 2 MB for 16 balls."""


def union_times(
    t_end: float, event_times: FloatArray, *, uniform: int, limit: int, before: bool = False
) -> FloatArray:
    """Return a uniform grid on [0, t_end] united with event times, (k,) float64 [s], increasing.

    Where there are more than `limit`, events are left out evenly, never the grid. With `before`,
    each event that is kept also brings the last instant before it.
    """
    grid = np.linspace(0.0, t_end, uniform)
    events = np.unique(event_times[(event_times >= 0.0) & (event_times <= t_end)])
    events = _thinned(events, (limit - uniform) // (2 if before else 1))
    parts = [grid, events, np.nextafter(events, 0.0)] if before else [grid, events]
    return np.unique(np.concatenate(parts))


def motion_of(result: Result) -> Motion:
    """Return the motion of a result recorded with `record="trajectory"`, as it is stored.

    It holds the states on both sides of an event: balls that an engine lets overlap, and then pulls
    apart, overlap at the instant before. Where an exact motion bends, it holds enough states to
    draw the curve.
    """
    events = events_of(result)
    times = union_times(
        result.rest_time, events["t"], uniform=UNIFORM_TIMES, limit=MAX_TIMES, before=True
    )
    phases = None
    if isinstance(result.trajectory, ExactTrajectory):
        bends = result.trajectory.bend_times(PATH_DEVIATION, UNIFORM_TIMES)
        times = np.union1d(times, _thinned(bends, MAX_TIMES - len(times)))
        phases = result.phases(times)
    return Motion(events, times, *result.sample(times), *energy_at(result, times), phases)


def energy_at(result: Result, times: FloatArray) -> Energy:
    """Return the energy of a result at `times`, (k,) [J]; see the module's note."""
    frames = _frames(result)
    if frames is None:
        return result.energy(times)
    at_frames = _energy_at_frames(result.scene, frames)
    return Energy(*(np.interp(times, frames.times, part) for part in at_frames))


@lru_cache(maxsize=1)  # by identity: the class of a run and its limits both ask
def energy_series(result: Result) -> FloatArray:
    """Return the total energy over a whole run, (k,) [J], at every recorded frame.

    Where the motion is exact: on a uniform grid, at each event, and the last instant before it.
    """
    frames = _frames(result)
    if frames is not None:
        return _energy_at_frames(result.scene, frames).total
    times = energy_times(result)
    return np.concatenate(
        [result.energy(times[start : start + _CHUNK]).total for start in _starts(times)]
    )


def energy_times(result: Result) -> FloatArray:
    """Return the instants of an exact motion's `energy_series`, (k,) float64 [s], increasing."""
    events = events_of(result)["t"]
    limit = UNIFORM_TIMES + 2 * len(events)
    return union_times(result.rest_time, events, uniform=UNIFORM_TIMES, limit=limit, before=True)


def largest_overlap(result: Result) -> float:
    """Return the largest overlap of any two balls in the recorded motion [m]; 0 if never.

    Searched at every frame of a stepping engine, at `DENSE_TIMES` and all events of an exact one.
    """
    return _largest_overlaps(result)[0]


def largest_cushion_overlap(result: Result) -> float:
    """Return the largest overlap of a ball with a cushion, a jaw or a post [m]; 0 if never.

    Searched at the same instants as `largest_overlap`.
    """
    return _largest_overlaps(result)[1]


@lru_cache(maxsize=1)  # by identity: the class of a run and its limits both ask
def _largest_overlaps(result: Result) -> tuple[float, float]:
    """Return the largest overlap of two balls, and of a ball and a cushion [m]; 0 if never."""
    scene, frames = result.scene, _frames(result)
    if frames is None:
        times = union_times(
            result.rest_time,
            events_of(result)["t"],
            uniform=DENSE_TIMES,
            limit=2 * DENSE_TIMES,
        )
    else:
        times = frames.times
    here = times[:, np.newaxis] < times_gone(result) if _may_go(scene) else None
    of_balls = at_cushions = 0.0
    for start in _starts(times):
        rows = slice(start, start + _CHUNK)
        places = result.sample(times[rows]).positions if frames is None else frames.positions[rows]
        there = None if here is None else here[rows]
        if len(scene.balls) > 1:
            deepest = overlaps_of_balls(scene, places, there)
            of_balls = max(of_balls, float(np.max(deepest, initial=0.0)))
        if scene.table is not None:
            deepest = overlaps_at_cushions(scene, places, there)
            at_cushions = max(at_cushions, float(np.max(deepest, initial=0.0)))
    return of_balls, at_cushions


def momentum_series(result: Result) -> FloatArray:
    """Return each ball's momentum in the plane over a whole run, (k, n, 2) [kg m/s].

    At the instants of `energy_series`.
    """
    frames = _frames(result)
    if frames is None:
        velocities = result.sample(energy_times(result)).velocities
    else:
        velocities = frames.velocities
    momenta: FloatArray = result.scene.masses[:, np.newaxis] * velocities[:, :, :2]
    return momenta


def times_gone(result: Result) -> FloatArray:
    """Return when each ball left the table, into a pocket or over a cushion, (n,) [s]; else inf.

    From then on it stays where it was, and nothing meets it.
    """
    gone = np.full(len(result.scene.balls), np.inf)
    events = events_of(result)
    leaves = np.isin(events["kind"], LEAVING_KINDS)
    np.minimum.at(gone, events["a"][leaves], events["t"][leaves])
    return gone


def _may_go(scene: Scene) -> bool:
    return scene.physics.airborne or (scene.table is not None and bool(scene.table.holes))


def first_not_finite(result: Result) -> str:
    """Return the first number of the recorded motion that isn't finite, and where; "" if all are.

    Of an exact motion, what is sampled of it is looked at.
    """
    frames = result.trajectory
    if not isinstance(frames, SampledTrajectory):
        times = np.linspace(0.0, result.rest_time, UNIFORM_TIMES)
        frames = SampledTrajectory(times, *result.sample(times))
    arrays = {
        "position": frames.positions,
        "velocity": frames.velocities,
        "angular velocity": frames.angular_velocities,
    }
    for what, values in arrays.items():
        where = np.argwhere(~np.isfinite(values))
        if len(where):
            k, ball, axis = where[0]
            return (
                f"{values[k, ball, axis]} for the {what} of ball {ball} at {frames.times[k]:.6g} s"
            )
    return ""


def events_of(result: Result) -> Events:
    """Return the event log of a result.

    Raises `GhostballError` where the engine kept none, though it was asked to.
    """
    if result.events is None:
        raise GhostballError(
            f"engine `{result.engine}` returned no `events` though it ran with "
            'record="trajectory". Fix that engine'
        )
    return result.events


def _thinned(times: FloatArray, room: int) -> FloatArray:
    """Return at most `room` of `times`, evenly chosen."""
    if len(times) <= room:
        return times
    return times[np.linspace(0, len(times) - 1, max(room, 0)).astype(np.intp)]


def _frames(result: Result) -> SampledTrajectory | None:
    return result.trajectory if isinstance(result.trajectory, SampledTrajectory) else None


def _energy_at_frames(scene: Scene, frames: SampledTrajectory) -> Energy:
    states = Samples(frames.positions, frames.velocities, frames.angular_velocities)
    return energy_of(scene, states)


def _starts(rows: FloatArray) -> range:
    return range(0, len(rows), _CHUNK)


def overlaps_of_balls(
    scene: Scene, positions: FloatArray, here: NDArray[np.bool_] | None = None
) -> FloatArray:
    """Return the deepest overlap of two balls at each instant, (k,) [m]; negative where none touch.

    `positions` (k, n, 3) float64 [m].
    `here` (k, n): whether each ball is on the table, which one in a pocket isn't; None: all are.
    """
    # On the cloth balls touch in the plane of their centres; see "Geometry" in engine/__init__.py.
    columns = range(3 if scene.physics.airborne else 2)
    axes = [np.ascontiguousarray(positions[:, :, axis].T) for axis in columns]
    radii, present = scene.radii, None if here is None else here.T
    deepest = np.full(len(positions), -np.inf)
    # One ball against all that follow: the pairs of 100 balls at once would fill the memory.
    for ball in range(len(radii) - 1):
        squares = sum(np.square(axis[ball + 1 :] - axis[ball]) for axis in axes)
        overlaps = (radii[ball] + radii[ball + 1 :])[:, np.newaxis] - np.sqrt(squares)
        if present is not None:
            overlaps[~(present[ball + 1 :] & present[ball])] = -np.inf
        np.maximum(deepest, np.max(overlaps, axis=0), out=deepest)
    return deepest


def overlaps_at_cushions(
    scene: Scene, positions: FloatArray, here: NDArray[np.bool_] | None = None
) -> FloatArray:
    """Return the deepest overlap with a cushion at each instant, (k,) [m]; negative for none.

    Jaws and posts count, holes don't. `positions` and `here` are those of `overlaps_of_balls`.
    """
    table = scene.table
    deepest = np.full(len(positions), -np.inf)
    if table is None:
        return deepest
    x, y = positions[:, :, 0], positions[:, :, 1]
    gaps = [side.distance(x, y) for side in table.sides]
    gaps += [gap_to(one, x, y) for one in table.obstacles if not isinstance(one, Hole)]
    for gap in gaps:
        overlaps = scene.radii - gap
        if here is not None:
            overlaps[~here] = -np.inf
        np.maximum(deepest, np.max(overlaps, axis=1), out=deepest)
    return deepest

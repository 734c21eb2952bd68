"""Sample a result: the times, and the energy and overlaps at these times.

Linear interpolation joins the frames of a time-stepping engine. Between two frames the velocity is
therefore an average, and its energy is less than that of either frame. The energy is therefore
computed at the frames only, and interpolated. The motion of Ghostball's engine is exact at any
time.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ghostball.model import (
    Energy,
    Events,
    ExactTrajectory,
    GhostballError,
    Hole,
    Phase,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    energy_of,
    first_energy,
)
from ghostball.model.arrays import FloatArray
from ghostball.model.events import LEAVING_KINDS
from ghostball.model.scene.obstacles import gap_to
from ghostball.validation.results.records import Motion

UNIFORM_TIMES = 401
"""Number of times in the uniform grid of a stored motion: more than the width of a figure resolves.
"""

MAX_TIMES = 4_000
"""Largest number of times in a stored motion, events included: 3 MB for 16 balls, uncompressed."""

PATH_DEVIATION = 2e-4
"""Largest deviation of a stored path from a curved one [m]: a tenth of a pixel in a figure."""

DENSE_TIMES = 20_001
"""Number of times at which an exact motion is searched for overlaps: 1 mm of path at 2 m/s for 10
s.
"""

_TOUCHES = 1e-9
"""Gap of two balls, in sums of their radii, below which they may be in an impact that lasts."""

_CHUNK = 1_000
"""Number of times handled together in the search for overlaps: 2 MB for 16 balls."""


def union_times(
    t_end: float, event_times: FloatArray, *, uniform: int, limit: int, before: bool = False
) -> FloatArray:
    """Return the union of a uniform grid on [0, t_end] and event times, (k,) float64 [s], sorted.

    With more than `limit` times, events are left out evenly, but never grid points. With `before`,
    each event also adds the last floating-point number before it.
    """
    grid = np.linspace(0.0, t_end, uniform)
    events = np.unique(event_times[(event_times >= 0.0) & (event_times <= t_end)])
    events = _thinned(events, (limit - uniform) // (2 if before else 1))
    parts = [grid, events, np.nextafter(events, 0.0)] if before else [grid, events]
    return np.unique(np.concatenate(parts))


def motion_of(result: Result) -> Motion:
    """Return the motion of a result recorded with `record="trajectory"`, as it is stored.

    It holds the states before and after each event, because an engine may let balls overlap and
    then separate them: the overlap exists just before the event. For an exact motion with curved
    paths it holds enough states to draw the curves.
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
    """Return the energy of a result at `times`, (k,) [J]; see the note of the module."""
    frames = frames_of(result)
    if frames is None:
        return result.energy(times)
    at_frames = _energy_at_frames(result.scene, frames)
    return Energy(*(np.interp(times, frames.times, part) for part in at_frames))


# keyed by identity; the accuracy class and the limits of a run both need it
@lru_cache(maxsize=1)
def energy_series(result: Result) -> FloatArray:
    """Return the total energy over a whole run, (k,) [J], at every recorded frame.

    For an exact motion: on a uniform grid, at each event, and just before each event.

    Times at which balls push each other in impacts that last are left out: contacts have energy.
    """
    frames = free_frames(result)
    if frames is not None:
        return _energy_at_frames(result.scene, frames).total
    times = energy_times(result)
    return np.concatenate(
        [result.energy(times[start : start + _CHUNK]).total for start in _starts(times)]
    )


def energy_times(result: Result) -> FloatArray:
    """Return the times of `energy_series` for an exact motion, (k,) float64 [s], increasing."""
    events = events_of(result)["t"]
    limit = UNIFORM_TIMES + 2 * len(events)
    times = union_times(result.rest_time, events, uniform=UNIFORM_TIMES, limit=limit, before=True)
    return _uncompressed(result, times)


def _uncompressed(result: Result, times: FloatArray) -> FloatArray:
    """Return the times at which no balls are in a compliant impact, (k,) [s].

    During such an impact, the balls are compressed, so they overlap and their contact has energy.
    """
    if result.work.get("compliant_impacts", 0) == 0:
        return times
    free: FloatArray = times[~np.any(result.phases(times) == Phase.COMPRESSED, axis=1)]
    return free


def free_frames(result: Result) -> SampledTrajectory | None:
    """Return the frames in which no balls push each other in impacts that last; None: no frames.

    Balls push each other while they touch or overlap, and move relative to each other.
    """
    frames, scene = frames_of(result), result.scene
    if frames is None or scene.physics.impacts != "compliant":
        return frames
    pushing = np.zeros(len(frames.times), dtype=np.bool_)
    for ball in range(len(scene.balls) - 1):
        apart = frames.positions[:, ball + 1 :, :2] - frames.positions[:, ball : ball + 1, :2]
        moves = frames.velocities[:, ball + 1 :, :2] - frames.velocities[:, ball : ball + 1, :2]
        reach = scene.radii[ball + 1 :] + scene.radii[ball]
        near = np.linalg.norm(apart, axis=2) < (1.0 + _TOUCHES) * reach
        pushing |= np.any(near & np.any(moves != 0.0, axis=2), axis=1)
    free = ~pushing
    return SampledTrajectory(
        frames.times[free],
        frames.positions[free],
        frames.velocities[free],
        frames.angular_velocities[free],
    )


def deepest_contact(scene: Scene) -> float:
    """Return the largest overlap that impacts that last allow [m]; 0 for rigid impacts.

    The energy of a contact with the overlap d is 2/5 K d^2.5 (Hertz, see `engine.impacts.hertz`).
    It can't exceed the initial energy of the scene. K is that of the two smallest balls.
    """
    physics = scene.physics
    if physics.impacts != "compliant":
        return 0.0
    modulus = physics.ball_youngs_modulus / (2.0 * (1.0 - physics.ball_poissons_ratio**2))
    smallest = float(np.min(scene.radii))
    stiffness = 4.0 / 3.0 * modulus * math.sqrt(0.5 * smallest)
    return float((2.5 * first_energy(scene) / stiffness) ** 0.4)


def largest_overlap(result: Result) -> float:
    """Return the largest overlap of any two balls in the recorded motion [m]; 0 if there is none.

    The search covers every frame of a time-stepping engine; for an exact motion, `DENSE_TIMES`
    times and all events.
    """
    return _largest_overlaps(result)[0]


def largest_cushion_overlap(result: Result) -> float:
    """Return the largest overlap of a ball with a cushion, a jaw or a post [m]; 0 if there is none.

    The search covers the same times as `largest_overlap`.
    """
    return _largest_overlaps(result)[1]


# keyed by identity; the accuracy class and the limits of a run both need it
@lru_cache(maxsize=1)
def _largest_overlaps(result: Result) -> tuple[float, float]:
    """Return the largest overlap of two balls, and of a ball with a cushion [m]; 0 for none."""
    scene, frames = result.scene, frames_of(result)
    if frames is None:
        times = union_times(
            result.rest_time,
            events_of(result)["t"],
            uniform=DENSE_TIMES,
            limit=2 * DENSE_TIMES,
        )
        times = _uncompressed(result, times)
    else:
        times = frames.times
    here = times[:, np.newaxis] < times_gone(result) if _may_go(scene) else None
    of_balls = at_cushions = 0.0
    for start in _starts(times):
        rows = slice(start, start + _CHUNK)
        places = _positions(result, times[rows]) if frames is None else frames.positions[rows]
        there = None if here is None else here[rows]
        if len(scene.balls) > 1:
            deepest = overlaps_of_balls(scene, places, there)
            of_balls = max(of_balls, float(np.max(deepest, initial=0.0)))
        if scene.table is not None:
            deepest = overlaps_at_cushions(scene, places, there)
            at_cushions = max(at_cushions, float(np.max(deepest, initial=0.0)))
    return of_balls, at_cushions


def _positions(result: Result, times: FloatArray) -> FloatArray:
    """Return the positions of `result.sample`, (k, n, 3) [m]; of an exact motion, without the rest.

    The search for overlaps would need more time for the spins than for the positions.
    """
    if isinstance(result.trajectory, ExactTrajectory):
        return result.trajectory.positions_at(times)
    return result.sample(times).positions


def momentum_series(result: Result) -> FloatArray:
    """Return the horizontal momentum of each ball over a whole run, (k, n, 2) [kg m/s].

    The times are those of `energy_series`.
    """
    frames = free_frames(result)
    if frames is None:
        velocities = result.sample(energy_times(result)).velocities
    else:
        velocities = frames.velocities
    momenta: FloatArray = result.scene.masses[:, np.newaxis] * velocities[:, :, :2]
    return momenta


def times_gone(result: Result) -> FloatArray:
    """Return when each ball left the table, into a pocket or over a cushion, (n,) [s]; inf: never.

    After that time its position is constant, and it has no contacts.
    """
    gone = np.full(len(result.scene.balls), np.inf)
    events = events_of(result)
    leaves = np.isin(events["kind"], LEAVING_KINDS)
    np.minimum.at(gone, events["a"][leaves], events["t"][leaves])
    return gone


def _may_go(scene: Scene) -> bool:
    return scene.physics.airborne or (scene.table is not None and bool(scene.table.holes))


def first_not_finite(result: Result) -> str:
    """Return the first number of the recorded motion that isn't finite, with its place; or "".

    For an exact motion, samples are checked.
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
    """Return the events of a result.

    Raises `GhostballError` if the engine recorded none although it was asked to.
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


def frames_of(result: Result) -> SampledTrajectory | None:
    """Return the recorded frames of a time-stepping engine; None for an exact motion."""
    return result.trajectory if isinstance(result.trajectory, SampledTrajectory) else None


def _energy_at_frames(scene: Scene, frames: SampledTrajectory) -> Energy:
    states = Samples(frames.positions, frames.velocities, frames.angular_velocities)
    return energy_of(scene, states)


def _starts(rows: FloatArray) -> range:
    return range(0, len(rows), _CHUNK)


def overlaps_of_balls(
    scene: Scene, positions: FloatArray, here: NDArray[np.bool_] | None = None
) -> FloatArray:
    """Return the largest overlap of two balls at each time, (k,) [m]; negative if no balls touch.

    `positions` (k, n, 3) float64 [m].
    `here` (k, n): whether each ball is on the table, not in a pocket; None: all are.
    """
    # On the cloth, balls touch in the plane of their centres; see "Coordinates" in engine/__init__.
    columns = range(3 if scene.physics.airborne else 2)
    axes = [np.ascontiguousarray(positions[:, :, axis].T) for axis in columns]
    radii, present = scene.radii, None if here is None else here.T
    deepest = np.full(len(positions), -np.inf)
    # One ball against all later balls: all pairs of 100 balls together would need too much memory.
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
    """Return the largest overlap with a cushion at each time, (k,) [m]; negative if there is none.

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

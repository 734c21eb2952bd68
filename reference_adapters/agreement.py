"""Check that the end of a result agrees with its motion, in position and time.

If the two contradict each other, neither can be judged: only the engine knows which one is wrong.
`returned` calls this module, and compares the collision counts with the events itself.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ghostball.model import Result, SampledTrajectory, Scene, Status
from ghostball.model.arrays import FloatArray

_RELATIVE_TOLERANCE = 2.0**-23
"""Largest relative difference between two values of the same position or time.

This is the spacing of single-precision numbers, in which an engine may store one of the values.
"""


def disagreement(result: Result, scene: Scene) -> str:
    """Return a sentence about how the end of a run contradicts its motion, or "".

    `result`: result of a run that reached its end; `returned` has checked each field.
    """
    if result.status is Status.T_MAX and scene.t_max is None:
        return (
            'a run of a scene without `t_max` must not end with "t-max": return the status "rest" '
            "when all balls are at rest, or another status with the reason for the stop"
        )
    motion = result.trajectory
    if motion is None or not result.status.complete:
        return ""
    with np.errstate(invalid="ignore", over="ignore"):
        if isinstance(motion, SampledTrajectory) and (problem := _length_problem(result, motion)):
            return problem
        if problem := _place_problem(result, scene):
            return problem
        if problem := _status_problem(result, scene):
            return problem
        if isinstance(motion, SampledTrajectory):
            return _rest_time_problem(result, motion)
    if abs(motion.t_end - result.rest_time) > _RELATIVE_TOLERANCE * abs(motion.t_end):
        return _late_rest(result, motion.t_end)
    return ""


def _length_problem(result: Result, frames: SampledTrajectory) -> str:
    """Check that the samples continue to the end of the run, while a ball on the table moves.

    The last sample may be missing, because an engine may record at intervals.
    """
    times, here = frames.times, ~result.gone
    missing = result.rest_time * (1.0 - _RELATIVE_TOLERANCE) - frames.t_end
    if not frames.velocities[-1, here].any() or missing <= np.max(np.diff(times), initial=0.0):
        return ""
    return (
        f"`trajectory.times` must continue to the end of the run at {float(result.rest_time)!r} s "
        f"(`rest_time`), got a last sample at {float(frames.t_end)!r} s with moving balls. "
        "Record the motion to its end"
    )


def _place_problem(result: Result, scene: Scene) -> str:
    """Check that each ball on the table rests where its motion ends, in the plane."""
    motion = result.trajectory
    ends = [float(result.rest_time)]
    if result.status is Status.REST and isinstance(motion, SampledTrajectory):
        ends.append(max(float(motion.t_end), *ends))
    on_table = ~result.gone
    for t in ends:
        shown = result.sample([t]).positions[0]
        off = np.linalg.norm((result.rest_positions - shown)[:, :2], axis=1)
        size = np.linalg.norm(shown, axis=1) + scene.radii
        beyond = np.flatnonzero(
            on_table & (off > _RELATIVE_TOLERANCE * size + _distance_between_samples(result, t))
        )
        if len(beyond):
            ball = int(beyond[0])
            how = _mistake(result, shown)
            return (
                f"`rest_positions[{ball}]` must be the position of ball "
                f'"{scene.balls[ball].id}" in the motion at t = {t!r} s, {shown[ball].tolist()}, '
                f"got {result.rest_positions[ball].tolist()}, {off[ball]:.3g} m away{how}"
            )
    return ""


def _status_problem(result: Result, scene: Scene) -> str:
    """Check that a run with moving balls at `t_max` doesn't end with "rest"."""
    motion = result.trajectory
    if result.status is not Status.REST or scene.t_max is None or motion is None:
        return ""
    if result.rest_time < scene.t_max * (1.0 - _RELATIVE_TOLERANCE):
        return ""
    end = motion.sample(np.array([motion.t_end]))
    moving = np.flatnonzero(end.velocities[0].any(axis=1) & ~result.gone)
    if not len(moving):
        return ""
    return (
        f'a run must end with "t-max" if balls move at `t_max` = {scene.t_max!r} s, got "rest", '
        f'but ball "{scene.balls[moving[0]].id}" moves'
    )


def _mistake(result: Result, shown: FloatArray) -> str:
    """Return the common mistake that turns the positions `shown` into the rest positions, or ""."""
    scene, rest = result.scene, result.rest_positions[:, :2]
    places = shown[:, :2]
    near = 1e-3 * float(np.min(scene.radii))
    among = np.linalg.norm(rest[:, np.newaxis] - places, axis=2)
    order = np.argmin(among, axis=1)
    moved = np.flatnonzero(order != np.arange(len(rest)))
    if len(moved) and np.all(np.min(among, axis=1) < near) and len(set(order)) == len(rest):
        one, other = (f'"{scene.balls[ball].id}"' for ball in (moved[0], order[moved[0]]))
        if len(moved) == 2:
            return f": {one} and {other} are swapped"
        return f": the balls are in a wrong order, {one} is where {other} must be"
    for what, mirrored in _mirrored(scene, places):
        if np.all(np.abs(rest - mirrored) < near):
            return f": `rest_positions` is mirrored: {what}"
    return ""


def _mirrored(scene: Scene, places: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Yield mirror images of positions (n, 2) [m], each with a description."""
    x, y = places.T
    yield "x has the wrong sign", np.column_stack([-x, y])
    yield "y has the wrong sign", np.column_stack([x, -y])
    yield "x and y are swapped", np.column_stack([y, x])
    if scene.table is not None and scene.table.length is not None:
        length, width = float(scene.table.length), float(scene.table.width)
        yield "x is measured from the right cushion", np.column_stack([length - x, y])
        yield "y is measured from the top cushion", np.column_stack([x, width - y])


def _distance_between_samples(result: Result, t: float) -> FloatArray:
    """Return the distance that each ball moves between the samples around a time, (n,) [m].

    After the last sample, this is the distance at the last velocity.
    """
    frames = result.trajectory
    if not isinstance(frames, SampledTrajectory):
        return np.zeros(len(result.scene.balls))
    k = int(np.searchsorted(frames.times, t, side="right"))
    if k < len(frames.times):
        moved = frames.positions[k] - frames.positions[max(k - 1, 0)]
    else:
        moved = frames.velocities[-1] * (t - frames.t_end)
    distance: FloatArray = np.linalg.norm(moved, axis=1)
    return distance


def _rest_time_problem(result: Result, frames: SampledTrajectory) -> str:
    """Check that `rest_time` is at most one sample after the first samples in which all balls rest.

    One extra sample is allowed, because an engine may check twice that its balls are at rest. A
    ball with any speed above 0 counts as moving.
    """
    if result.status is not Status.REST:
        return ""
    here = ~result.gone
    speeds = np.linalg.norm(frames.velocities[:, here], axis=2)
    turns = np.linalg.norm(frames.angular_velocities[:, here], axis=2) * result.scene.radii[here]
    fastest = np.max(speeds + turns, axis=1, initial=0.0)
    moving = np.flatnonzero(fastest > 0.0)
    if not len(moving) or moving[-1] + 2 >= len(frames.times):
        return ""  # no ball moves, or the samples end when the balls come to rest
    rests = float(frames.times[moving[-1] + 2])
    return (
        _late_rest(result, rests) if result.rest_time > rests * (1.0 + _RELATIVE_TOLERANCE) else ""
    )


def _late_rest(result: Result, rests: float) -> str:
    """Return how `rest_time` contradicts a motion in which balls rest from `rests` [s] on."""
    return (
        "`rest_time` must be the time at which the last ball comes to rest in the motion, or the "
        f"run ends, {float(rests)!r} s, got {float(result.rest_time)!r} s"
    )

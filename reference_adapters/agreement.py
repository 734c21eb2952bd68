"""Check that the end of a result agrees with its motion, in position and time.

Numbers that contradict each other can't both be judged, and only the engine knows which of them is
wrong. `returned` calls this module; it compares the counts with the events itself.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ghostball.model import Result, SampledTrajectory, Scene, Status
from ghostball.model.arrays import FloatArray

_SAME = 2.0**-23
"""Largest relative difference between two values of the same position or time.

The spacing of single precision, in which an engine may keep one of the two.
"""


def disagreement(result: Result, scene: Scene) -> str:
    """Return how the end of a run contradicts its motion, in a sentence; "" where it doesn't.

    `result`: of a run that reached its end. Each field alone has passed the checks of `returned`.
    """
    if result.status is Status.T_MAX and scene.t_max is None:
        return (
            'a run of a scene without `t_max` must not end by "t-max": give the status "rest" when '
            "all balls rest, or stop with the reason why the run goes no further"
        )
    motion = result.trajectory
    if motion is None or not result.status.complete:
        return ""
    with np.errstate(invalid="ignore", over="ignore"):
        if isinstance(motion, SampledTrajectory) and (problem := _of_length(result, motion)):
            return problem
        if problem := _of_places(result, scene):
            return problem
        if problem := _of_status(result, scene):
            return problem
        if isinstance(motion, SampledTrajectory):
            return _of_rest(result, motion)
    if abs(motion.t_end - result.rest_time) > _SAME * abs(motion.t_end):
        return _late(result, motion.t_end)
    return ""


def _of_length(result: Result, frames: SampledTrajectory) -> str:
    """Check that the samples continue until the run ends, while a ball on the table moves.

    The last one may be missing: an engine that records now and then may end between two samples.
    """
    times, here = frames.times, ~result.gone
    missing = result.rest_time * (1.0 - _SAME) - frames.t_end
    if not frames.velocities[-1, here].any() or missing <= np.max(np.diff(times), initial=0.0):
        return ""
    return (
        f"`trajectory.times` must go on until the run ends, at {float(result.rest_time)!r} s "
        f"(`rest_time`), got a last sample at {float(frames.t_end)!r} s, in which balls move. "
        "Record the motion to its end"
    )


def _of_places(result: Result, scene: Scene) -> str:
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
        beyond = np.flatnonzero(on_table & (off > _SAME * size + _between(result, t)))
        if len(beyond):
            ball = int(beyond[0])
            how = _mistake(result, shown)
            return (
                f"`rest_positions[{ball}]` must be where the motion has ball "
                f'"{scene.balls[ball].id}" at t = {t!r} s, {shown[ball].tolist()}, got '
                f"{result.rest_positions[ball].tolist()}, {off[ball]:.3g} m from there{how}"
            )
    return ""


def _of_status(result: Result, scene: Scene) -> str:
    """Check that a run whose balls still move at `t_max` doesn't end by "rest"."""
    motion = result.trajectory
    if result.status is not Status.REST or scene.t_max is None or motion is None:
        return ""
    if result.rest_time < scene.t_max * (1.0 - _SAME):
        return ""
    end = motion.sample(np.array([motion.t_end]))
    moving = np.flatnonzero(end.velocities[0].any(axis=1) & ~result.gone)
    if not len(moving):
        return ""
    return (
        f'a run must end by "t-max" where the scene ends it, at `t_max` = {scene.t_max!r} s, got '
        f'"rest" although ball "{scene.balls[moving[0]].id}" moves then'
    )


def _mistake(result: Result, shown: FloatArray) -> str:
    """Return which common mistake turns the places `shown` into the rest positions, if any."""
    scene, rest = result.scene, result.rest_positions[:, :2]
    places = shown[:, :2]
    near = 1e-3 * float(np.min(scene.radii))
    among = np.linalg.norm(rest[:, np.newaxis] - places, axis=2)
    order = np.argmin(among, axis=1)
    moved = np.flatnonzero(order != np.arange(len(rest)))
    if len(moved) and np.all(np.min(among, axis=1) < near) and len(set(order)) == len(rest):
        one, other = (f'"{scene.balls[ball].id}"' for ball in (moved[0], order[moved[0]]))
        if len(moved) == 2:
            return f": {one} and {other} are in each other's place"
        return f": balls are in another order, {one} is where {other} must be"
    for what, mirrored in _mirrored(scene, places):
        if np.all(np.abs(rest - mirrored) < near):
            return f": `rest_positions` is mirrored, {what}"
    return ""


def _mirrored(scene: Scene, places: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    """Yield mirror images of places (n, 2) [m], each with how it is made."""
    x, y = places.T
    yield "x has the other sign", np.column_stack([-x, y])
    yield "y has the other sign", np.column_stack([x, -y])
    yield "x and y are exchanged", np.column_stack([y, x])
    if scene.table is not None and scene.table.length is not None:
        length, width = float(scene.table.length), float(scene.table.width)
        yield "x is counted from the right cushion", np.column_stack([length - x, y])
        yield "y is counted from the top cushion", np.column_stack([x, width - y])


def _between(result: Result, t: float) -> FloatArray:
    """Return how far each ball moves between the samples around a time, (n,) [m].

    After the last sample: how far it would move at its last velocity.
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


def _of_rest(result: Result, frames: SampledTrajectory) -> str:
    """Check that `rest_time` is at most one sample after the samples show that all balls rest.

    An engine may check twice that its balls rest. A ball of any speed above 0 moves.
    """
    if result.status is not Status.REST:
        return ""
    here = ~result.gone
    speeds = np.linalg.norm(frames.velocities[:, here], axis=2)
    turns = np.linalg.norm(frames.angular_velocities[:, here], axis=2) * result.scene.radii[here]
    fastest = np.max(speeds + turns, axis=1, initial=0.0)
    moving = np.flatnonzero(fastest > 0.0)
    if not len(moving) or moving[-1] + 2 >= len(frames.times):
        return ""  # nothing moves, or the samples end as the balls come to rest
    rests = float(frames.times[moving[-1] + 2])
    return _late(result, rests) if result.rest_time > rests * (1.0 + _SAME) else ""


def _late(result: Result, rests: float) -> str:
    """Return how `rest_time` contradicts a motion whose balls rest at `rests` [s]."""
    return (
        "`rest_time` must be when the last ball comes to rest, or the run ends, as the motion has "
        f"it, {float(rests)!r} s, got {float(result.rest_time)!r} s"
    )

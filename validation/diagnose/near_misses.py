"""By how much a collision happens, or doesn't: overlaps, gaps and speeds of approach in a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ghostball.model import Ball, EventKind, Result, SampledTrajectory, Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.validation.grading.event_logs import Event
from ghostball.validation.runs.playing import run_ours

Centres = Callable[[FloatArray], FloatArray]
"""Times (k,) [s] -> centres (k, balls, 2) [m]."""

TIMES = 2_001
"""Instants at which a gap is looked at; around the smallest, as many again, twice."""


def state_before(result: Result, t: float) -> tuple[float, Samples]:
    """Return the last known state before an instant [s], and when it is; arrays (1, n, 3).

    An exact motion is known just before. Of frames it is the last one: between it and the next the
    velocities on both sides of a collision would be mixed.
    """
    frames = result.trajectory
    if isinstance(frames, SampledTrajectory):
        row = max(int(np.searchsorted(frames.times, t, side="left")) - 1, 0)
        states = (frames.positions, frames.velocities, frames.angular_velocities)
        return float(frames.times[row]), Samples(*(one[row : row + 1] for one in states))
    before = max(float(np.nextafter(t, 0.0)), 0.0)
    return before, result.sample([before])


def overlap_of(result: Result, collision: Event) -> float | None:
    """Return the overlap of a collision of a run [m]: by how much it would have to be missed.

    Two balls that continued as they were would come to overlap by this much at most, or a ball to
    reach so far into the cushion, before the cloth stops them. None where the last known state
    doesn't lead to the collision: an engine had several in one step.
    """
    _, state = state_before(result, collision.t)
    coasts = [_coast(result.scene, state, ball) for ball in collision.balls]
    end = max(coast.rest_time for coast in coasts)
    if end == 0.0:
        return None

    def centres(times: FloatArray) -> FloatArray:
        return np.concatenate([coast.sample(times).positions[:, :, :2] for coast in coasts], axis=1)

    overlap = -_smallest(result.scene, collision, centres, 0.0, end)[0]
    return overlap if overlap > 0.0 else None


def nearest_approach(
    result: Result, collision: Event, start: float, end: float
) -> tuple[float, float]:
    """Return the smallest gap of what would meet in a collision [m], and when [s], from `start`."""

    def centres(times: FloatArray) -> FloatArray:
        chosen: FloatArray = result.sample(times).positions[:, list(collision.balls), :2]
        return chosen

    return _smallest(result.scene, collision, centres, start, max(end, start))


def approach_speed(result: Result, collision: Event) -> float:
    """Return the speed at which what collides closes its gap just before [m/s]."""
    _, state = state_before(result, collision.t)
    positions, velocities = state.positions[0, :, :2], state.velocities[0, :, :2]
    a, b = collision.a, collision.b
    if collision.kind is EventKind.BALL_CUSHION:
        assert result.scene.table is not None
        inward, _ = result.scene.table.facing(b, *positions[a].tolist())
        return float(-(velocities[a] @ np.array(inward)))
    between = positions[b] - positions[a]
    normal = between / np.hypot(*between)
    return float((velocities[a] - velocities[b]) @ normal)


def gaps(scene: Scene, collision: Event, centres: FloatArray) -> FloatArray:
    """Return the gap of what would collide for centres (k, balls of it, 2): (k,) [m]."""
    radii = scene.radii[list(collision.balls)]
    if collision.kind is EventKind.BALL_BALL:
        gap: FloatArray = np.hypot(*(centres[:, 1] - centres[:, 0]).T) - radii.sum()
        return gap
    assert scene.table is not None
    facing = scene.table.facing
    distances = [facing(collision.b, *place)[1] for place in centres[:, 0].tolist()]
    gap_to_cushion: FloatArray = np.array(distances) - radii[0]
    return gap_to_cushion


def _coast(scene: Scene, state: Samples, ball: int) -> Result:
    """Let a ball continue alone from a state, on a cloth without end."""
    old = scene.balls[ball].without_strike()
    rolling = scene.physics.motion == "rolling"
    alone = Ball(
        **{
            **dict(old),
            "position": tuple(state.positions[0, ball, :2].tolist()),
            "velocity": tuple(state.velocities[0, ball, :2].tolist()),
            "angular_velocity": None
            if rolling
            else tuple(state.angular_velocities[0, ball].tolist()),
        }
    )
    # Nothing slows a ball on a cloth without resistance: until it has gone far beyond all others.
    speed = float(np.linalg.norm(state.velocities[0, ball, :2]))
    extent = float(np.max(np.abs(state.positions[0, :, :2])) + np.max(scene.radii))
    endless = scene.rolling_frictions[ball] == 0.0 or not scene.sliding_frictions[ball] > 0.0
    t_max = 4.0 * extent / speed if endless and speed > 0.0 else None
    t_max = 1.0 if endless and t_max is None else t_max
    free = Scene(name="coast", physics=scene.physics, balls=[alone], t_max=t_max)
    return run_ours(free)


def _smallest(
    scene: Scene, collision: Event, centres: Centres, start: float, end: float
) -> tuple[float, float]:
    """Return the smallest gap between two instants [m], and when it is [s]."""
    low, high = start, end
    gap, when = np.inf, start
    for _ in range(3):
        times = np.linspace(low, high, TIMES)
        found = gaps(scene, collision, centres(times))
        row = int(np.argmin(found))
        gap, when = float(found[row]), float(times[row])
        low, high = float(times[max(row - 1, 0)]), float(times[min(row + 1, TIMES - 1)])
    return gap, when


def in_ulps(length: float, positions: Sequence[FloatArray]) -> float:
    """Return a length over the spacing of doubles at the largest coordinate of `positions`."""
    largest = max(float(np.abs(one).max()) for one in positions)
    return length / float(np.spacing(largest))

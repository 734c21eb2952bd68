"""Shots with resting contact that once revealed bugs, and a measure of their overlaps."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from shots import ball, kept_scene, scene_of

from ghostball.engine import simulate
from ghostball.model import Result, Scene, Status


def kept_shot(name: str) -> Result:
    """Simulate a scene of the folder `scenes` until all balls rest."""
    result = simulate(kept_scene(name), record="events", max_events=100_000)
    assert result.status is Status.REST, result.reason
    return result


def pushing_pair(
    radii: Sequence[float], masses: Sequence[float], *, air_drag: float = 0.0
) -> Scene:
    """Return a ball that pushes another ball for 40 ms; both slide and spin all the time."""
    places = ((0.0, 0.0), (sum(radii), 0.0))
    velocities = ((0.3, 0.1), (0.3, -0.02))
    spins = ((4.0, 60.0, 8.0), (-30.0, -20.0, -5.0))
    balls = [
        ball(place, velocity, angular_velocity=spin, radius=radius, mass=mass)
        for place, velocity, spin, radius, mass in zip(
            places, velocities, spins, radii, masses, strict=True
        )
    ]
    return scene_of(
        *balls, t_max=0.04, motion="sliding", sliding_friction=0.2, spinning_friction_rate=10.0,
        ball_friction=0.06, ball_restitution=0.5, air_drag=air_drag,
    )  # fmt: skip


def largest_overlap(result: Result) -> float:
    """Return the largest overlap of balls, or of ball and cushion [m], at and between events."""
    assert result.trajectory is not None
    starts = np.unique(np.concatenate([k[:, 0] for k in result.trajectory.segments]))
    times = np.union1d(starts, 0.5 * (starts[1:] + starts[:-1]))
    places, radii = result.sample(times).positions[:, :, :2], result.scene.radii
    gaps = [
        np.min(np.hypot(*(places[:, i] - places[:, j]).T) - radii[i] - radii[j])
        for i, j in itertools.combinations(range(len(radii)), 2)
    ]
    table = result.scene.table
    if table is not None:
        far = np.array([table.length, table.width])
        room = np.minimum(places, far - places) - radii[:, np.newaxis]
        gaps.append(np.min(room))
    return -min(gaps)

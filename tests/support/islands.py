"""Shots of balls in resting contact that once showed what was wrong, and how far they overlap."""

from __future__ import annotations

import itertools

import numpy as np
from shots import kept_scene

from ghostball.engine import simulate
from ghostball.model import Result, Status


def kept_shot(name: str) -> Result:
    """Play a kept scene until all balls rest."""
    result = simulate(kept_scene(name), record="events", max_events=100_000)
    assert result.status is Status.REST, result.reason
    return result


def largest_overlap(result: Result) -> float:
    """Return how far [m] a ball goes into another or beyond a cushion, at and between events."""
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

"""The independent program for tracks simulates the same physics as the engine."""

from __future__ import annotations

import numpy as np

from benchmarks.stepped_tracks import Camera, SteppedTable, start_of, stepped_tracks
from benchmarks.synthetic_tracks import POOL
from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table

SHARED = {
    "rolling_friction": 0.009,
    "sliding_friction": 0.19,
    "ball_restitution": 0.93,
    "ball_friction": 0.06,
    "cushion_restitution": 0.88,
    "cushion_friction": 0.17,
}
"""Coefficients with the same names in the program and in the engine."""
NOSE_HEIGHT = 0.0363
SIDE = 0.25
TABLE = SteppedTable(**SHARED, nose_height=NOSE_HEIGHT)
PHYSICS = Physics(preset="pool", **SHARED, cushion_height=NOSE_HEIGHT)


def test_shots_are_those_of_the_engine_but_for_the_step():
    """Half of the shots agree to 0.3 mm in the first second, 90 % to 2 mm.

    Collisions amplify what steps of 0.1 ms err by.
    """
    camera = Camera(rate=50.0, noise=0.0, drift=0.0, pixel=1e-9, stale=0.0)
    shots = stepped_tracks(TABLE, POOL, 20, 3, camera, side=SIDE)
    off = []
    for number, tracks in shots.items():
        scene = started(int(number))
        motion = simulate(scene, record="trajectory")
        times = next(iter(tracks.values())).times[:50]  # the first second
        places = np.stack([track.positions[:50] for track in tracks.values()], axis=1)
        off.append(np.max(np.abs(motion.sample(times).positions[..., :2] - places)))
    assert len(off) == 20
    assert np.median(off) < 3e-4
    assert np.quantile(off, 0.9) < 2e-3


def started(shot: int) -> Scene:
    """Return the initial scene of a shot."""
    balls = [
        Ball(
            id=name,
            position=tuple(row[:2]),
            velocity=tuple(row[2:4]),
            angular_velocity=tuple(row[4:]),
            radius=POOL.radius,
        )
        for name, row in zip(
            ("cue", "red", "yellow"), start_of(shot, POOL, 3, side=SIDE), strict=True
        )
    ]
    table = Table(length=POOL.length, width=POOL.width)
    return Scene(name="shot", table=table, physics=PHYSICS, balls=balls)

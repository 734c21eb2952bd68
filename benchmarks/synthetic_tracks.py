"""Simulate camera tracks of shots with known physics, with Ghostball's engine."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.tracks import Shots, Surface, Track, tracks_of

POOL = Surface(2.54, 1.27, 0.028575)
"""A nine-foot table."""

_SMALLEST_DISTANCE = 0.1  # [m]: between balls, and from balls to cushions
_AIM_ERROR = 0.04  # [m]: standard deviation of the distance at which an aimed shot passes a ball


def synthetic_tracks(
    physics: Physics,
    shots: int,
    seed: int,
    *,
    rate: float = 50.0,
    noise: float = 1e-3,
    stale: float = 0.04,
    side: float = 0.0,
    resting: bool = True,
) -> Shots:
    """Return tracks of random shots of three balls; half of the shots are aimed at a ball.

    `rate` [1/s]: pictures per second.
    `noise` [m]: standard deviation of a coordinate.
    `stale`: share of samples that repeat the position of the sample before.
    `side`: standard deviation of the side spin of the struck ball, R w_z / v.
    `resting`: whether samples of resting balls are included; each ball's first sample always is.
    """
    random = np.random.default_rng(seed)
    found: Shots = {}
    for shot in range(1, shots + 1):
        scene = _shot(random, physics, side)
        tracks = tracks_of(simulate(scene, record="trajectory"), rate)
        found[str(shot)] = {
            ball: _seen(random, track, noise, stale, resting=resting)
            for ball, track in tracks.items()
        }
    return found


def _shot(random: np.random.Generator, physics: Physics, side: float) -> Scene:
    places: list[FloatArray] = []
    extent = np.array([POOL.length, POOL.width])
    while len(places) < 3:
        place = random.uniform(_SMALLEST_DISTANCE, extent - _SMALLEST_DISTANCE)
        if all(np.linalg.norm(place - other) > _SMALLEST_DISTANCE for other in places):
            places.append(place)
    way = places[1] - places[0]
    angle = random.uniform(0.0, 2.0 * math.pi)
    if random.random() < 0.5:
        error = random.normal() * _AIM_ERROR / float(np.linalg.norm(way))
        angle = math.atan2(way[1], way[0]) + error
    speed, roll = random.uniform(0.5, 3.0), random.uniform(0.0, 1.0)
    vx, vy = speed * math.cos(angle), speed * math.sin(angle)
    spin = np.array([-roll * vy, roll * vx, side * random.normal() * speed]) / POOL.radius
    struck = Ball(
        id="cue",
        position=tuple(places[0]),
        velocity=(vx, vy),
        angular_velocity=tuple(spin),
        radius=POOL.radius,
    )
    others = [
        Ball(id=name, position=tuple(place), radius=POOL.radius)
        for name, place in zip(("red", "yellow"), places[1:], strict=True)
    ]
    table = Table(length=POOL.length, width=POOL.width)
    return Scene(name="shot", table=table, physics=physics, balls=[struck, *others])


def _seen(
    random: np.random.Generator, track: Track, noise: float, stale: float, *, resting: bool
) -> Track:
    places = track.positions + random.normal(0.0, noise, track.positions.shape)
    for k in np.flatnonzero(random.random(len(places)) < stale):
        if k > 0:
            places[k] = places[k - 1]
    kept = np.ones(len(places), dtype=bool)
    if not resting:
        kept[1:] = np.any(track.positions[1:] != track.positions[:-1], axis=1)
    return Track(track.times[kept], places[kept])


def write_tracks(path: Path, shots: Shots, heading: str) -> None:
    """Write tracks as a CSV file for `ghostball fit`, rounded to 0.1 mm."""
    lines = [f"# {heading}", "shot,ball,t,x,y"]
    for shot, balls in shots.items():
        for ball, track in balls.items():
            for t, (x, y) in zip(track.times, track.positions, strict=True):
                lines.append(f"{shot},{ball},{t:.2f},{x:.4f},{y:.4f}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


EXAMPLE = Path(__file__).resolve().parents[1] / "docs" / "examples" / "tracks.csv"
"""File of the tracks that the documentation fits."""

EXAMPLE_PHYSICS = Physics(
    preset="pool",
    rolling_friction=0.009,
    rolling_friction_quadratic=0.01,
    sliding_friction=0.19,
    ball_restitution=0.93,
    cushion_restitution=0.88,
    cushion_restitution_loss=0.06,
    cushion_friction=0.17,
)
"""Physics of the tracks that the documentation fits."""


def write_example(path: Path = EXAMPLE) -> None:
    """Write the tracks that the documentation fits."""
    shots = synthetic_tracks(EXAMPLE_PHYSICS, 80, 12, rate=25.0, side=0.3, resting=False)
    heading = "Synthetic tracks: 80 shots of known physics, 25 pictures a second, 1 mm of noise."
    write_tracks(path, shots, heading)

"""Tracks as a camera would bring them of tables whose physics is known."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.tracks import Shots, Surface, Track, tracks_of

POOL = Surface(2.54, 1.27, 0.028575)
"""A table of nine feet."""

_APART = 0.1  # [m]: balls from each other and from cushions
_AIMED = 0.04  # [m]: how far a shot that is aimed at a ball passes its centre, typically


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
    """Return tracks of random shots among three balls, half of them aimed at one.

    `rate` [1/s] of the camera; `noise` [m], of each coordinate; `stale`: part of the samples that
    show the place of the one before; `side` of the struck ball, typically. Where `resting` is
    false, balls are left out while they rest, but for how they begin.
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
        place = random.uniform(_APART, extent - _APART)
        if all(np.linalg.norm(place - other) > _APART for other in places):
            places.append(place)
    way = places[1] - places[0]
    angle = random.uniform(0.0, 2.0 * math.pi)
    if random.random() < 0.5:
        angle = math.atan2(way[1], way[0]) + random.normal() * _AIMED / float(np.linalg.norm(way))
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
    """Write tracks as a CSV file that `ghostball fit` reads, to a tenth of a millimetre."""
    lines = [f"# {heading}", "shot,ball,t,x,y"]
    for shot, balls in shots.items():
        for ball, track in balls.items():
            for t, (x, y) in zip(track.times, track.positions, strict=True):
                lines.append(f"{shot},{ball},{t:.2f},{x:.4f},{y:.4f}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


EXAMPLE = Path(__file__).resolve().parents[1] / "docs" / "examples" / "tracks.csv"
"""The tracks that the documentation fits."""

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
"""The table that they are of."""


def write_example(path: Path = EXAMPLE) -> None:
    """Write the tracks that the documentation fits."""
    shots = synthetic_tracks(EXAMPLE_PHYSICS, 80, 12, rate=25.0, side=0.3, resting=False)
    heading = "Synthetic tracks: 80 shots of known physics, 25 pictures a second, 1 mm of noise."
    write_tracks(path, shots, heading)

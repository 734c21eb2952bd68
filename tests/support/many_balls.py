"""Scenes with many balls, and shots simulated with both schedulers."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from shots import R

from ghostball.engine import simulate
from ghostball.engine.running import skips
from ghostball.model import Ball, Physics, Result, Scene, Table


def many_balls(count, filled=0.4, seed=1, speed=1.0, t_max=None, spread=1.0, **physics) -> Scene:
    """Return balls on a randomly perturbed lattice; `spread` is the largest ratio of radii."""
    chance = random.Random(seed)
    length = math.sqrt(count * math.pi * R * R / filled)
    lines = math.ceil(math.sqrt(count))
    step = length / lines
    room = 0.5 * step - 1.01 * R
    balls = []
    for k in range(count):
        turn = chance.uniform(0.0, 2.0 * math.pi)
        place = [(m + 0.5) * step + chance.uniform(-room, room) for m in (k % lines, k // lines)]
        velocity = (speed * math.cos(turn), speed * math.sin(turn))
        radius = R / chance.uniform(1.0, spread)
        balls.append(Ball(id=f"{k}", position=place, velocity=velocity, radius=radius))
    table = Table(length=length, width=length)
    return Scene(name="many", balls=balls, table=table, physics=Physics(**physics), t_max=t_max)


def alike(velocities, spins=None, **physics) -> Scene:
    """Return balls far apart; balls with equal motions have simultaneous events."""
    places = (np.stack(np.divmod(np.arange(len(velocities)), 64), axis=1) + 1.0) * (20.0, 0.2)
    return Scene.from_arrays(places, velocities, spins, name="alike", physics=Physics(**physics))


def by_both(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> list[Result]:
    """Simulate a scene with both schedulers: all pairs, and grid."""
    results = []
    for most in (10**6, 0):
        monkeypatch.setattr(skips, "MOST_PAIRED", most)
        results.append(simulate(scene.model_copy(), record="events"))
    return results

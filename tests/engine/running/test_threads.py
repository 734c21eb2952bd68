"""Tests of threads that share shots: each shot has the same result as alone."""

from threading import Event

import numpy as np
import pytest
from batches import assert_same
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import simulate, simulate_many, simulate_sweep
from ghostball.engine.running import calls, threads
from ghostball.model import Scene
from ghostball.model.sines import cosines_and_sines
from ghostball.validation.scenes.random_scenes import random_scene


@pytest.mark.compiled
@pytest.mark.parametrize("workers", [1, 2])
def test_every_part_of_a_long_sweep_agrees_with_single_shots(workers):
    """Threads take a share of the shots at a time; the test compares some shots of each share."""
    speeds, angles = np.linspace(0.4, 3.0, 300), np.linspace(0.0, 1.5, 300)
    scene = scene_of(ball((0.6, 0.6), (1.0, 0.0)), table=POOL_TABLE)
    batch = simulate_sweep(scene, speeds, angles, threads=workers)
    cosines, sines = cosines_and_sines(angles)
    for k in (*range(0, 300, 17), *range(70, 80), *range(290, 300)):
        velocity = (speeds[k] * cosines[k], speeds[k] * sines[k])
        assert_same(batch, k, simulate(scene_of(ball((0.6, 0.6), velocity), table=POOL_TABLE)))


@pytest.mark.compiled
@pytest.mark.parametrize(("first", "second"), [(223, 153), (153, 223)])
def test_scenes_with_equally_many_balls_keep_their_own_results(first, second):
    """A thread simulates both in one room; the first shot ends during a resting contact."""
    scenes = [random_scene(number, **RUBBING) for number in (first, second)]
    stop = 0.02 * simulate(scenes[0]).rest_time
    scenes[0] = Scene.model_validate(dict(scenes[0]) | {"t_max": stop})
    batch = simulate_many(8 * scenes, threads=1)
    for k, scene in enumerate(8 * scenes):
        assert_same(batch, k, simulate(scene))


RUBBING = {
    "count": "few",
    "air": "no",
    "flight": "no",
    "ball_law": "frictional",
    "cushion": ("none", "mirror", "restitution", "frictional"),
    "quadratic": "no",
}
"""Options for scenes 153 and 223: four balls that come to push each other."""


def test_an_error_in_a_thread_is_raised_and_ends_the_others(monkeypatch):
    played, stops = [], []

    class Noted(Event):
        def __init__(self):
            super().__init__()
            stops.append(self)

    def fail(layout, memory, shots, which, *_, **__):
        played.append(int(which[0]))
        if len(played) == 1:
            raise MemoryError("no room")
        assert stops[0].wait(60.0)

    monkeypatch.setattr(threads, "Event", Noted)
    monkeypatch.setattr(calls, "play_some", fail)
    with pytest.raises(MemoryError, match="no room"):
        simulate_many([scene_of(ball((0.6, 0.6), (1.0, 0.0)))] * 400, threads=1)
    assert len(played) <= 2

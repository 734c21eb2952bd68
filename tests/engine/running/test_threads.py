"""Threads that share shots: every part of a sweep, and each scene of many, is as by itself."""

import numpy as np
import pytest
from batches import assert_same
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import simulate, simulate_many, simulate_sweep
from ghostball.model import Scene
from ghostball.model.sines import cosines_and_sines
from ghostball.validation.scenes.library import FOLDER


@pytest.mark.compiled
@pytest.mark.parametrize("threads", [1, 2])
def test_every_part_of_a_long_sweep_is_as_shot_by_shot(threads):
    """Threads take a share of the shots at a time: some of each share are looked at one by one."""
    speeds, angles = np.linspace(0.4, 3.0, 300), np.linspace(0.0, 1.5, 300)
    scene = scene_of(ball((0.6, 0.6), (1.0, 0.0)), table=POOL_TABLE)
    batch = simulate_sweep(scene, speeds, angles, threads=threads)
    cosines, sines = cosines_and_sines(angles)
    for k in (*range(0, 300, 17), *range(70, 80), *range(290, 300)):
        velocity = (speeds[k] * cosines[k], speeds[k] * sines[k])
        assert_same(batch, k, simulate(scene_of(ball((0.6, 0.6), velocity), table=POOL_TABLE)))


@pytest.mark.compiled
@pytest.mark.parametrize("threads", [1, 2])
def test_scenes_with_as_many_balls_are_each_played_as_their_own(threads):
    """A thread plays them all in one room; some need contacts at once, some later, some never."""
    names = ("half-ball-cut", "push-line", "thin-cut", "break-7", "follow-shot")
    scenes = 3 * [Scene.load(FOLDER / f"{name}.toml") for name in names]
    batch = simulate_many(scenes, threads=threads)
    for k, scene in enumerate(scenes):
        assert_same(batch, k, simulate(scene))

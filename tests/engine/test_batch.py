"""Tests of batches: each shot is bit-identical to `simulate`, in any thread."""

import os
import signal
import threading
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from batches import assert_same, two_ball_shot
from shots import POOL_TABLE, ball, crowded_table, random_break, scene_of

from ghostball.engine import simulate, simulate_many, simulate_starts, simulate_sweep
from ghostball.model import GhostballError, UnsupportedSceneError


def test_no_scenes_give_an_empty_batch():
    batch = simulate_many([])
    assert batch.rest_positions.shape == (0, 0, 3)
    assert len(batch.complete) == 0


def test_many_scenes_are_as_one_by_one():
    scenes = [scene_of(ball((0.0, 0.0), (1.0, 0.0))), two_ball_shot()]
    batch = simulate_many(scenes, threads=2)
    for k, scene in enumerate(scenes):
        assert_same(batch, k, simulate(scene))


@pytest.mark.parametrize("wrong", [0, -2, 1.5, True])
def test_a_wrong_number_of_threads_is_refused(wrong):
    with pytest.raises(GhostballError, match="threads"):
        simulate_many([two_ball_shot()], threads=wrong)


@pytest.mark.compiled
@pytest.mark.parametrize("way", ["sweep", "many", "starts"])
def test_endless_shots_are_interrupted(way):
    # Reaching the event limit would take days.
    rolls_on = scene_of(
        ball((0.5, 0.5), (1.0, 0.3)), table=POOL_TABLE, rolling_friction=0.0, t_max=1e50
    )
    interrupt = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    simulate_sweep(rolls_on, 1.0, 0.3, max_events=2)  # compiled before the clock runs
    simulate_many([rolls_on], max_events=2)
    endless: Callable[[], object] = partial(
        simulate_sweep, rolls_on, np.linspace(1.0, 2.0, 600), 0.3, max_events=10**12
    )
    if way == "starts":
        slower = np.linspace(0.5, 1.0, 600)[:, None, None] * rolls_on.velocities
        endless = partial(simulate_starts, rolls_on, velocities=slower, max_events=10**12)
    if way == "many":
        endless = partial(simulate_many, [rolls_on] * 50, threads=2, max_events=10**12)
    interrupt.start()
    with pytest.raises(KeyboardInterrupt):
        endless()


def test_a_scene_beyond_the_engine_is_refused_before_any_run():
    with pytest.raises(UnsupportedSceneError):
        simulate_many([random_break(1), scene_of(ball((0.2, 0.1)), table=crowded_table())])

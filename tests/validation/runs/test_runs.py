from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ghostball.model import Ball, Physics, Scene
from ghostball.validation.runs.interleave import Task, interleave
from ghostball.validation.runs.rolling import rolling_spin

# The timer samples the tasks in turn, and prepares each task once


def task_of(name, log, most=None):
    def sample():
        log.append(name)
        return {"seconds": float(len(log))}

    def prepare():
        log.append(f"prepare {name}")
        return sample

    return Task(name, prepare, most)


def test_tasks_are_interleaved_prepared_once_and_all_values_kept():
    log, seen = [], []
    found = interleave([task_of("a", log), task_of("b", log)], 2, lambda *done: seen.append(done))
    assert log == ["prepare a", "a", "prepare b", "b", "a", "b"]
    assert found == {"a": {"seconds": [2.0, 5.0]}, "b": {"seconds": [4.0, 6.0]}}
    assert seen == [(1, 4, "a"), (2, 4, "b"), (3, 4, "a"), (4, 4, "b")]


@pytest.mark.parametrize(
    ("most", "rounds", "due"),
    [(None, 3, [0, 1, 2]), (1, 4, [3]), (2, 4, [1, 3]), (3, 7, [2, 4, 6]), (9, 2, [0, 1])],
)
def test_a_slow_task_is_sampled_less_often_and_over_all_rounds(most, rounds, due):
    task = Task("slow", lambda: lambda: {}, most)
    assert [turn for turn in range(rounds) if task.due(turn, rounds)] == due


# A ball with a changed velocity still rolls, without any rounded slip


SPEED = st.floats(-10.0, 10.0)


@given(SPEED, SPEED, st.floats(0.01, 0.1), SPEED)
def test_its_spin_is_that_of_a_ball_which_rolls_to_the_bit(x, y, radius, about_vertical):
    spin = rolling_spin((x, y, 0.0), radius, about_vertical)
    place = {"id": "cue", "position": (0.0, 0.0), "velocity": (x, y), "radius": radius}
    ball = Ball(**place, angular_velocity=spin)
    scene = Scene(name="rolls", physics=Physics(motion="sliding"), balls=[ball])
    assert spin[2] == about_vertical
    assert np.all(scene.rolls)

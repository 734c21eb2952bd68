"""Examples of docs/ that no page runs: the environment for Gymnasium."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from ghostball import Ball, Scene, Strike, simulate

pytestmark = pytest.mark.compiled  # hundreds of shots

EXAMPLES = Path(__file__).parents[1] / "docs/examples"


@pytest.fixture
def example(monkeypatch):
    """Return the environment for Gymnasium as a module."""
    monkeypatch.syspath_prepend(EXAMPLES)
    monkeypatch.delitem(sys.modules, "gym_env", raising=False)
    return import_module("gym_env")


def scene_of(example, observation: np.ndarray, stroke: np.ndarray) -> Scene:
    """Return the scene of one table, of which the observation has the positions."""
    speed, direction, left, up = map(float, stroke)
    strike = Strike(speed=speed, direction=direction, offset_left=left, offset_up=up)
    (x, y), other = observation.reshape(2, 2).tolist()
    balls = [Ball(id="cue", position=(x, y), strike=strike), Ball(id="object", position=other)]
    return Scene(**{**dict(example.SCENE), "balls": balls})


def test_a_step_plays_the_stroke_at_each_table(example):
    env = example.PocketEnv(300)
    before, _ = env.reset(seed=3)
    env._places = before.reshape(-1, 2, 2).astype(np.float64)  # observations are rounded
    env.action_space.seed(1)
    actions = env.action_space.sample()
    after, rewards, ended, stopped, _ = env.step(actions)
    assert env.observation_space.contains(after)
    for i, action in enumerate(actions):
        result = simulate(scene_of(example, before[i], action), record="events")
        cue_gone, object_gone = result.gone
        assert rewards[i] == (-1.0 if cue_gone else float(object_gone))
        assert ended[i] == (cue_gone or object_gone)
        if not ended[i]:
            np.testing.assert_array_equal(
                after[i], result.rest_positions[:, :2].ravel().astype(np.float32)
            )
    assert {-1.0, 0.0, 1.0} == set(rewards.tolist())
    assert not stopped.any()


def test_an_episode_ends_and_the_next_step_starts_another(example):
    env = example.PocketEnv(200, shots=2)
    env.reset(seed=4)
    env.action_space.seed(2)
    _, _, first_ended, _, _ = env.step(env.action_space.sample())
    _, rewards, ended, stopped, _ = env.step(env.action_space.sample())
    assert first_ended.any()
    assert not rewards[first_ended].any()  # the action was ignored
    assert not (ended | stopped)[first_ended].any()
    assert np.all((ended | stopped)[~first_ended])
    again, _, ended, stopped, _ = env.step(env.action_space.sample())
    places = again[~first_ended].reshape(-1, 2, 2)
    assert np.all((places[:, 0, 0] <= 1.1) & (places[:, 1, 0] >= 1.4))  # put on the table again


def test_the_same_seed_gives_the_same_steps(example):
    found = []
    for _ in range(2):
        env = example.PocketEnv(20, noise={"direction": 0.01, "speed": 0.1})
        env.reset(seed=5)
        env.action_space.seed(3)
        found.append([env.step(env.action_space.sample())[0] for _ in range(5)])
    assert np.array_equal(found[0], found[1])


def test_the_example_measures_its_throughput(example, capsys):
    example.main(num_envs=16, steps=3)
    assert "16 tables: " in capsys.readouterr().out

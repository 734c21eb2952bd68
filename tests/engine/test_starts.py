"""Tests of many starts of one scene: each is bit-identical to `simulate` with the changed scene."""

import numpy as np
import pytest
from batches import assert_same, two_ball_shot
from shots import POOL_TABLE, R, ball, rack, scene_of

from ghostball.engine import simulate, simulate_starts
from ghostball.model import Ball, GhostballError, Scene, SceneError


def begun(scene: Scene, **columns) -> Scene:
    """Return the scene with other fields of its balls."""
    balls = [
        Ball(**{**dict(one), **{name: tuple(values[i]) for name, values in columns.items()}})
        for i, one in enumerate(scene.balls)
    ]
    return Scene(**{**dict(scene), "balls": balls})


def test_breaks_of_different_racks_agree_with_single_shots():
    chance = np.random.default_rng(3)
    scene = scene_of(
        ball((0.6, 0.6)), *rack(6, (1.9, 0.635), gap=1e-3), table=POOL_TABLE, preset="pool"
    )
    positions = scene.positions[:, :2] + chance.uniform(-1e-4, 1e-4, (5, 7, 2))
    velocities = np.zeros((5, 7, 2))
    velocities[:, 0, 0] = chance.uniform(1.0, 5.0, 5)
    batch = simulate_starts(scene, positions, velocities, threads=2)
    for k in range(5):
        one = begun(scene, position=positions[k], velocity=velocities[k])
        assert_same(batch, k, simulate(one))


def test_values_that_are_not_given_are_those_of_the_scene():
    scene = two_ball_shot(angular_velocity=(3.0, -20.0, 40.0))
    there = scene.positions + np.array([[[0.0, 0.0, 0.0]], [[0.0, 0.02, 0.0]]])
    batch = simulate_starts(scene, there)
    assert_same(batch, 0, simulate(scene))
    assert_same(batch, 1, simulate(begun(scene, position=there[1])))
    assert_same(simulate_starts(scene), 0, simulate(scene))
    strike = {"speed": 2.0, "direction": 0.05, "offset_left": 0.2, "elevation": 0.1}
    struck = Scene(
        **{
            **dict(scene),
            "balls": [Ball(id="cue", position=(0.6, 0.6), strike=strike), scene.balls[1]],
        }
    )
    assert_same(simulate_starts(struck), 0, simulate(struck))


def test_balls_whose_velocities_are_given_without_spins_roll():
    spun = two_ball_shot(angular_velocity=(3.0, -20.0, 40.0))
    batch = simulate_starts(spun, velocities=0.5 * spun.velocities)
    assert_same(batch, 0, simulate(two_ball_shot((1.0, 0.0))))


def test_spins_and_heights_are_those_that_are_given():
    scene = scene_of(
        ball((0.0, 0.0)), ball((0.5, 0.001)), motion="sliding", airborne=True, t_max=1.0
    )
    positions = [[[0.0, 0.0, R + 0.05], [0.5, 0.001, R]], [[0.0, 0.0, R], [0.5, 0.001, R]]]
    velocities = [[[1.0, 0.0, -0.1], [0.0, 0.0, 0.0]], [[1.0, 0.0, 1.0], [0.0, 0.0, 0.0]]]
    spins = [[[9.0, -5.0, 20.0], [0.0, 0.0, 7.0]], [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]]
    batch = simulate_starts(scene, positions, velocities, spins, threads=1)
    for k in range(2):
        one = begun(scene, position=positions[k], velocity=velocities[k], angular_velocity=spins[k])
        assert_same(batch, k, simulate(one))


def test_no_starts_give_an_empty_batch():
    assert len(simulate_starts(two_ball_shot(), np.empty((0, 2, 2))).status) == 0


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"positions": [[0.0, 0.0]]}, r"`positions` must have the shape \(shots, 2, 2 or 3\)"),
        ({"positions": "here"}, "`positions` must be an array of numbers"),
        ({"angular_velocities": np.zeros((2, 2))}, r"`angular_velocities` must .* \(2, 3\) for"),
        (
            {"positions": np.zeros((3, 2, 2)), "velocities": np.zeros((4, 2, 2))},
            "must be of equally many shots, got 3 and 4",
        ),
    ],
)
def test_arrays_that_do_not_fit_are_refused(arrays, message):
    with pytest.raises(GhostballError, match=message):
        simulate_starts(two_ball_shot(), **arrays)


@pytest.mark.parametrize(
    ("field", "at", "value", "message"),
    [
        ("positions", (1, 0, 0), np.nan, r"`balls\[0\].position` in shot 1 must be finite .* nan"),
        ("velocities", (2, 1, 1), 1e60, r"`balls\[1\].velocity` in shot 2 must .* got 1e\+60"),
        ("velocities", (2, 1, 1), 1e308, r"`balls\[1\].velocity` in shot 2 must .* got 1e\+308"),
        ("positions", (2, 1, 0), 0.61, r"`balls\[0\]` .* `balls\[1\]` in shot 2 .* overlap by"),
        ("positions", (1, 1, 1), 5.0, r"`balls\[1\].position` in shot 1 must be inside the table"),
        ("positions", (0, 1, 2), 0.5, r"`balls\[1\].position` in shot 0 z must be the radius"),
        ("velocities", (0, 1, 2), 0.5, r"`balls\[1\].velocity` in shot 0 z must be 0"),
        ("velocities", (2, 0, 0), 1e49, "`t_max` must be given if"),
    ],
)
def test_a_start_is_refused_that_a_scene_would_be_refused_for(field, at, value, message):
    scene = scene_of(ball((0.6, 0.6)), ball((1.6, 0.635)), table=POOL_TABLE, rolling_friction=1e-30)
    arrays = {
        "positions": np.tile(scene.positions, (3, 1, 1)),
        "velocities": np.zeros((3, 2, 3)),
    }
    arrays[field][at] = value
    with pytest.raises(SceneError, match=message):
        simulate_starts(scene, **arrays)


@pytest.mark.compiled
def test_more_starts_than_one_chunk_are_simulated(monkeypatch):
    monkeypatch.setattr("ghostball.engine.starts._BALLS_PER_CHUNK", 6)
    scene = two_ball_shot()
    velocities = np.linspace(0.2, 3.0, 10)[:, None, None] * [[[1.0, 0.1], [0.0, 0.0]]]
    batch = simulate_starts(scene, velocities=velocities)
    for k in range(10):
        assert_same(batch, k, simulate(begun(scene, velocity=velocities[k])))

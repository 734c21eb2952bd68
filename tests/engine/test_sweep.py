"""Tests of sweeps: each shot is bit-identical to `simulate`."""

import math

import numpy as np
import pytest
from batches import assert_same, two_ball_shot
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.engine import STATUSES, simulate, simulate_sweep
from ghostball.model import GhostballError, Scene, SceneError, Status
from ghostball.model.sines import cosines_and_sines


def test_a_sweep_of_frozen_balls_agrees_with_single_shots_in_any_order():
    """Each shot ends during resting contacts, which must not affect the next shot in the room."""
    scene = scene_of(
        ball((0.6, 0.6), (1.0, 0.0)),
        ball((0.7, 0.603)),
        ball((0.7 + 2 * R, 0.603)),
        # These two balls stay in contact from the start.
        ball((1.2, 0.3), (0.3, 0.1), angular_velocity=(4.0, 60.0, 8.0)),
        ball((1.2 + 2 * R, 0.3), (0.3, -0.02), angular_velocity=(-30.0, -20.0, -5.0)),
        table=POOL_TABLE,
        preset="pool",
        t_max=0.06,
    )
    speeds, angles = np.array([1.0, 2.2, 0.1]), np.array([0.0, 0.02, 0.0])
    ends = []
    for v, cosine, sine in zip(speeds, *cosines_and_sines(angles), strict=True):
        velocity = (v * cosine, v * sine, 0.0)
        cue = scene.balls[0].model_copy(update={"velocity": velocity})
        ends.append(simulate(scene.model_copy(update={"balls": (cue, *scene.balls[1:])})))
    assert all(result.work["contact_steps"] > 0 for result in ends)
    for order in ([0, 1, 2], [2, 1, 1, 0]):
        batch = simulate_sweep(scene, speeds[order], angles[order], threads=1)
        for k, shot_number in enumerate(order):
            assert_same(batch, k, ends[shot_number])


def test_a_sweep_reports_shots_that_did_not_end():
    batch = simulate_sweep(two_ball_shot(), [1.0, 5.0], 0.0, max_events=2)
    assert [STATUSES[code] for code in batch.status] == [Status.EVENT_LIMIT, Status.EVENT_LIMIT]
    assert not batch.complete.any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0, 2.0], [0.0, 0.1, 0.2]), "same length"),
        (([0.0], [0.0]), "more than 0 m/s, got 0.0"),
        (([math.nan], [0.0]), "`speeds` must be finite, got nan"),
        (([1.0], ["left"]), "`angles` must be numbers"),
        (([[1.0]], [0.0]), "one-dimensional"),
    ],
)
def test_wrong_arrays_are_refused(arguments, message):
    with pytest.raises(GhostballError, match=message):
        simulate_sweep(two_ball_shot(), *arguments)


@pytest.mark.parametrize("wrong", [-1, 2, True, 0.0, "cue"])
def test_a_ball_that_is_not_there_is_refused(wrong):
    with pytest.raises(GhostballError, match="index of a ball, 0 to 1"):
        simulate_sweep(two_ball_shot(), 1.0, 0.0, ball=wrong)


def one_ball(**fields) -> Scene:
    return scene_of(ball((0.5, 0.5), (1.0, 0.0)), **fields)


@pytest.mark.parametrize(
    ("scene", "speeds", "rule"),
    [
        (scene_of(ball((0, 0)), rolling_friction=0.0), [1.0, 2.0], r"`t_max` must be given if"),
        (
            one_ball(),
            [1.0, 1e60],
            r"`balls\[0\].velocity` in shot 1 must be finite and at most 1e\+50 in size",
        ),
        (one_ball(), [1.0, 1e308], "must be finite and at most"),
        (one_ball(rolling_friction=1e-40), [1.0, 1e20], "`t_max` must be given .* 1e\\+20 m/s"),
        (
            one_ball(air_drag=1.0),
            [1.0, 1e11],
            r"`physics.air_drag` .* at most 1e\+10 .* 1e\+11 m/s of `balls\[0\]` in shot 1",
        ),
        (
            one_ball(table=POOL_TABLE),
            [1.0, 1e8],
            r"cushions more than 1e\+12 times .* `balls\[0\]` in shot 1 starts at 1e\+08 m/s",
        ),
        (
            scene_of(
                ball((0, 0), (1e-10, 0.0), angular_velocity=(0.0, 0.0, 1e5)),
                motion="sliding",
                t_max=1.0,
            ),
            [1.0, 1e38],
            r"`balls\[0\].angular_velocity` in shot 1 must be finite and at most 1e\+50 in size",
        ),
        (
            scene_of(
                ball((0, 0), (1e-9, 0.0), angular_velocity=(0.0, 0.0, 9.0)),
                motion="sliding",
                spinning_friction_rate=1e-5,
            ),
            [1.0, 1e36],
            "`t_max` must be given if a ball might spin",
        ),
        (
            scene_of(
                ball((0, 0), (1.0, 0.0), angular_velocity=(0.0, 0.0, 9e3), radius=10.0),
                motion="sliding",
                t_max=1.0,
            ),
            [1.0, 1e46],
            r"`balls\[0\].angular_velocity` in shot 1 must give a surface speed",
        ),
    ],
    ids=["endless", "fast", "overflow", "long", "drag", "impacts", "spin", "spin-ends", "surface"],
)
def test_a_shot_is_refused_that_a_scene_would_be_refused_for(scene, speeds, rule):
    with pytest.raises(SceneError, match=rule):
        simulate_sweep(scene, speeds, 0.0)
    # The rules are those of the scene itself.
    cue, v = scene.balls[0], scene.balls[0].velocity[0]
    spin = cue.angular_velocity and tuple(speeds[1] / v * w for w in cue.angular_velocity)
    shot = {**cue.model_dump(), "velocity": (speeds[1], 0.0), "angular_velocity": spin}
    with pytest.raises(SceneError):
        Scene(**{**dict(scene), "balls": [shot]})


def test_no_shots_give_an_empty_batch():
    assert len(simulate_sweep(one_ball(), [], []).status) == 0


def test_a_ball_that_is_struck_is_struck_harder_in_another_direction():
    # The result of a stroke turns with the cue and is proportional to its speed, and so is a
    # bounce.
    def struck(speed, direction):
        strike = {"elevation": 0.4, "offset_left": 0.2, "offset_up": -0.2}
        cue = {"position": (0.5, 0.5), "strike": {"speed": speed, "direction": direction, **strike}}
        other = ball((0.9, 0.55))
        return scene_of(cue, other, motion="sliding", airborne=True, table_restitution=0.5)

    scene, other = struck(1.0, 0.2), struck(1.6, 0.3)
    (vx, vy, _), (wx, wy, _) = scene.velocities[0], other.velocities[0]
    batch = simulate_sweep(
        scene,
        [math.hypot(vx, vy), math.hypot(wx, wy)],
        [math.atan2(vy, vx), math.atan2(wy, wx)],
    )
    for k, one in enumerate((scene, other)):
        assert batch.rest_positions[k] == pytest.approx(simulate(one).rest_positions, abs=1e-9)


def test_a_ball_that_only_spins_gives_no_direction():
    with pytest.raises(GhostballError, match="spins but doesn't move"):
        simulate_sweep(two_ball_shot((0.0, 0.0), angular_velocity=(0.0, 0.0, 9.0)), 1.0, 0.0)

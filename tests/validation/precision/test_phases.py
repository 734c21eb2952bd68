"""The same shot from an earlier start."""

import numpy as np
import pytest
from toy_engines import cut, roll

from ghostball.engine import simulate
from ghostball.model import Ball, Scene, Table
from ghostball.validation import find_scene
from ghostball.validation.precision.phases import start_of, started_earlier


@pytest.mark.parametrize("name", ["half-ball-cut", "sliding-swerve", "masse", "throw-by-spin"])
def test_an_earlier_start_passes_through_the_scene_and_has_the_same_end(name):
    scene, dt = find_scene(name), 3e-3
    earlier = started_earlier(scene, dt)
    there = simulate(earlier.model_copy(update={"t_max": dt})).final_state
    np.testing.assert_allclose(there.positions[0], scene.positions, atol=1e-14)
    np.testing.assert_allclose(there.velocities[0], scene.velocities, atol=1e-14)
    np.testing.assert_allclose(there.angular_velocities[0], scene.angular_velocities, atol=1e-11)
    now, then = simulate(scene), simulate(earlier)
    np.testing.assert_allclose(then.rest_positions, now.rest_positions, atol=1e-12)
    assert then.rest_time == pytest.approx(now.rest_time + dt, abs=1e-12)


def test_an_earlier_start_makes_t_max_later():
    assert started_earlier(roll(t_max=2.0), 0.25).t_max == 2.25


def test_a_start_that_is_0_s_earlier_is_the_scene_itself():
    scene = cut()
    assert started_earlier(scene, 0.0) is scene


def test_each_turn_begins_the_shot_a_part_of_a_step_earlier():
    scene = roll()
    assert start_of(scene, 0.02, 0) is scene
    assert start_of(scene, 0.02, 2) == started_earlier(scene, 0.005)
    assert start_of(scene, None, 3) is scene


def test_a_ball_that_just_left_a_cushion_or_a_ball_has_no_earlier_start():
    leaving = Scene(
        name="leaving",
        table=Table(length=2.0, width=1.0),
        balls=[Ball(id="cue", position=(0.03, 0.5), velocity=(1.0, 0.0))],
    )
    assert started_earlier(leaving, 0.01) is None
    parting = Scene(
        name="parting",
        balls=[
            Ball(id="a", position=(0.0, 0.0), velocity=(-1.0, 0.0)),
            Ball(id="b", position=(0.06, 0.0)),
        ],
    )
    assert started_earlier(parting, 0.01) is None
    assert started_earlier(parting, 0.001) is not None
    assert start_of(parting, 0.02, 1) is parting

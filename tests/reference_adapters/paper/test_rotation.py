"""The paper's rule for rotating balls (5.3), compared with the exact rotation."""

import math

import numpy as np
import pytest
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.reference_adapters.paper.rotation import turned_by_frames

RADII = np.array([R])


def angle_between(p, q):
    return 2.0 * min(np.linalg.norm(p - q), np.linalg.norm(p + q))


def backwards(q):
    """Return the orientation after the opposite rotations."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def frames_of(result, dt):
    """Return the frames until rest: times, and velocities in the paper's algorithm."""
    times = dt * np.arange(1, math.floor(result.rest_time / dt) + 1)
    return times, result.sample(times).velocities


def test_at_a_steady_speed_it_turns_exactly_as_far_as_the_ball_rolls_but_backwards():
    """The axis must stay as printed, because the rule documents the paper."""
    steady = scene_of(ball((0, 0), (0.6, -0.8)), rolling_friction=0.0, t_max=1.0)
    exact = simulate(steady, record="trajectory").orientation([1.0])[0, 0]
    velocities = np.tile([0.6, -0.8, 0.0], (50, 1, 1))
    printed = turned_by_frames(velocities, RADII, 0.02)[-1, 0]
    assert angle_between(printed, backwards(exact)) < 1e-12
    assert angle_between(printed, exact) > 0.1


@pytest.mark.parametrize("dt", [0.02, 0.01, 0.005])
def test_of_a_ball_that_slows_it_misses_half_of_what_each_frame_takes_from_the_speed(dt):
    """The error is v0 dt / 2 over a whole roll: 1 rad for 20 ms and 3 m/s."""
    v = 3.0
    result = simulate(scene_of(ball((0, 0), (v, 0))), record="trajectory")
    times, velocities = frames_of(result, dt)
    printed = turned_by_frames(velocities, RADII, dt)[-1, 0]
    exact = result.orientation(times[-1:])[0, 0]
    missed = angle_between(printed, backwards(exact))
    assert missed == pytest.approx(v * dt / 2 / R, rel=0.02)


def test_of_a_ball_that_slides_or_spins_it_knows_nothing():
    """The rule is wrong for a stunned ball, and for a ball that spins in place."""
    slides = scene_of(
        ball((0, 0), (2, 0), angular_velocity=(0, 0, 0)), motion="sliding", t_max=0.01
    )
    exact = simulate(slides, record="trajectory").orientation([0.01])[0, 0]
    assert angle_between(exact, [1, 0, 0, 0]) < 0.02
    printed = turned_by_frames(np.array([[[2.0, 0.0, 0.0]]]), RADII, 0.01)[0, 0]
    assert angle_between(printed, [1, 0, 0, 0]) == pytest.approx(0.7, rel=0.01)

    spins = scene_of(ball((0, 0), (0, 0), angular_velocity=(0, 0, 30)), motion="sliding")
    result = simulate(spins, record="trajectory")
    assert angle_between(result.orientation([0.1])[0, 0], [1, 0, 0, 0]) > 1.0
    printed = turned_by_frames(np.zeros((5, 1, 3)), RADII, 0.02)
    assert np.array_equal(printed, np.tile([1.0, 0.0, 0.0, 0.0], (5, 1, 1)))

"""Sampling between what was stored, and the energy of a state."""

from __future__ import annotations

import numpy as np
import pytest
from shots import R, ball, scene_of

from engine import SampledTrajectory, Samples
from engine.result import initial_state
from engine.trajectory import energy_of


def line(times, xs, vxs) -> SampledTrajectory:
    """One ball on the x axis."""
    k = len(times)
    positions, velocities = np.zeros((k, 1, 3)), np.zeros((k, 1, 3))
    positions[:, 0, 0], velocities[:, 0, 0] = xs, vxs
    return SampledTrajectory(np.array(times, dtype=float), positions, velocities, velocities / R)


def sampled_x(trajectory, *times) -> list[float]:
    return trajectory.sample(np.array(times)).positions[:, 0, 0].tolist()


def test_straight_lines_between_frames_and_stored_values_at_frames():
    trajectory = line([0.0, 1.0, 3.0], [0.0, 2.0, 1.0], [2.0, 2.0, -0.5])
    assert trajectory.t_end == 3.0
    assert sampled_x(trajectory, 0.0, 0.25, 1.0, 2.0, 3.0) == [0.0, 0.5, 2.0, 1.5, 1.0]


def test_before_the_start_and_after_the_end_the_balls_stay():
    trajectory = line([0.0, 1.0], [0.0, 2.0], [2.0, 2.0])
    assert sampled_x(trajectory, -1.0, 5.0) == [0.0, 2.0]


def test_at_a_collision_the_state_after_it_counts():
    trajectory = line([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0], [1.0, 1.0, -1.0, -1.0])
    velocities = trajectory.sample(np.array([np.nextafter(1.0, 0.0), 1.0])).velocities[:, 0, 0]
    assert velocities[1] == -1.0
    assert velocities[0] == pytest.approx(1.0)


def test_a_collision_in_the_last_frame():
    trajectory = line([0.0, 1.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, -1.0])
    assert trajectory.sample(np.array([1.0])).velocities[0, 0, 0] == -1.0


def test_a_single_frame_is_a_trajectory():
    assert sampled_x(line([0.0], [0.5], [0.0]), -1.0, 0.0, 1.0) == [0.5, 0.5, 0.5]


def test_no_times_give_empty_arrays():
    trajectory = line([0.0, 1.0], [0.0, 2.0], [2.0, 2.0])
    assert trajectory.sample(np.array([])).positions.shape == (0, 1, 3)


def test_a_rolling_ball_has_seven_tenths_m_v_squared_whatever_its_radius():
    scene = scene_of(ball((0, 0), (3, 4), mass=2.0), ball((9, 9), (0, 1), mass=3.0, radius=0.5))
    energy = energy_of(scene, initial_state(scene))
    assert energy.translation[0] == pytest.approx(25.0 + 1.5, rel=1e-15)
    assert energy.rotation[0] == pytest.approx(0.4 * (25.0 + 1.5), rel=1e-15)
    assert energy.height[0] == 0.0
    assert energy.total[0] == pytest.approx(1.4 * 26.5, rel=1e-15)


def test_height_is_counted_from_lying_on_the_cloth():
    scene = scene_of(ball((0, 0, R + 0.5), mass=2.0), airborne=True, gravity=10.0)
    energy = energy_of(scene, initial_state(scene))
    assert energy.height[0] == pytest.approx(10.0, rel=1e-15)
    assert energy.total[0] == energy.height[0]


def test_energy_of_several_instants_at_once():
    scene = scene_of(ball((0, 0), (1, 0), mass=1.0))
    one = initial_state(scene)
    both = Samples(*(np.concatenate([array, 2.0 * array]) for array in one))
    assert energy_of(scene, both).translation.tolist() == [0.5, 2.0]

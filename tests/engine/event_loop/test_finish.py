"""Tests of the end of a run at `t_max`: balls are at the positions of their closed forms."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from recorded import EPS
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Status


def test_without_friction_it_rolls_on_to_t_max():
    scene = scene_of(ball((0.5, 0.25), (0.75, -0.5)), rolling_friction=0.0, t_max=8.0)
    result = simulate(scene)
    assert (result.status, result.rest_time) == (Status.T_MAX, 8.0)
    assert result.rest_positions[0].tolist() == [6.5, -3.75, R]
    assert result.final_state.velocities[0, 0].tolist() == [0.75, -0.5, 0.0]


def test_t_max_cuts_a_roll_where_the_closed_form_is():
    scene = scene_of(ball((0, 0), (1, 0)), t_max=2.5)
    result = simulate(scene, record="events")
    a, t = Fraction(scene.physics.rolling_friction) * Fraction(scene.physics.gravity), Fraction(2.5)
    assert (result.status, result.rest_time, len(result.events)) == (Status.T_MAX, 2.5, 0)
    place, speed = result.rest_positions[0, 0], result.final_state.velocities[0, 0, 0]
    for value, exact in ((place, t - a * t**2 / 2), (speed, 1 - a * t)):
        assert abs(Fraction(float(value)) - exact) <= 4 * EPS * exact


def test_t_max_cuts_the_spin_of_a_ball_that_has_stopped():
    scene = scene_of(
        ball((0, 0), (0, 0), angular_velocity=(0, 0, 30.0)),
        motion="sliding",
        spinning_friction_rate=10.0,
        t_max=1.0,
    )
    result = simulate(scene)
    assert (result.status, result.rest_time) == (Status.T_MAX, 1.0)
    assert result.final_state.angular_velocities[0, 0].tolist() == [0.0, 0.0, 20.0]


def test_t_max_cuts_an_impact_that_lasts():
    """The contact of three balls in a row lasts some 200 us and begins at once."""
    scene = scene_of(
        ball((0, 0), (1.0, 0), angular_velocity=(0, 0, 5.0)),
        ball((2.0 * R, 0)),
        ball((4.0 * R, 0)),
        motion="sliding",
        impacts="compliant",
        ball_friction=0.1,
        t_max=1e-4,
    )
    result = simulate(scene)
    assert (result.status, result.rest_time) == (Status.T_MAX, 1e-4)
    speeds, spins = result.final_state.velocities[0], result.final_state.angular_velocities[0]
    assert np.all(speeds[:, 0] > 1e-3)
    assert np.sum(speeds[:, 0]) == pytest.approx(1.0, abs=1e-3)  # the cloth takes a little
    assert 0.0 < spins[0, 2] < 5.0
    assert np.all(np.diff(result.rest_positions[:, 0]) < 2.0 * R)

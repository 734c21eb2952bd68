"""Tests of the end of a run at `t_max`: balls are at the positions of their closed forms."""

from __future__ import annotations

from fractions import Fraction

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

"""Tests of one impact of two balls, or of a ball and a cushion, against closed forms.

The tolerance is a few ulps times the condition number of the shot. The exact numbers are computed
with mpmath from the doubles of the scene, so only the rounding of the engine remains.
"""

from __future__ import annotations

import math

import pytest
from digits import assert_close, deceleration, forty_digits  # noqa: F401 - for all tests
from mpmath import mp, mpf
from recorded import EPS, collisions
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Status, Table

BALL_BALL, CUSHION = EventKind.BALL_BALL, EventKind.BALL_CUSHION


def time_to_roll(distance, speed, a):
    """Time in which a ball rolls a distance: the stable root of s = v t - a t^2 / 2."""
    return 2 * distance / (speed + mp.sqrt(speed**2 - 2 * a * distance))


@pytest.mark.parametrize("distance", [0.06, 0.5, 2.0])
def test_a_full_elastic_collision_hands_the_motion_over(distance):
    scene = scene_of(ball((0, 0), (1, 0)), ball((distance, 0)))
    result = simulate(scene, record="events")
    a, path = deceleration(scene), mpf(distance) - 2 * mpf(R)
    assert collisions(result) == [(BALL_BALL, 0, 1)]
    # Here the condition number of the time is v / (v - a t) <= 3.
    assert_close(result.events["t"][0], time_to_roll(path, mpf(1), a), 32)
    # The sum of their distances is the distance of a single ball.
    assert_close(result.rest_positions[1, 0], 1 / (2 * a) + 2 * mpf(R), 16)
    assert_close(result.rest_positions[0, 0], path, 32)


@pytest.mark.parametrize(
    ("masses", "e"), [((1.0, 3.0), 0.5), ((5.0, 1.0), 1.0), ((1.0, 1.0), 0.0), ((1e-6, 1), 1.0)]
)
def test_masses_and_restitution_of_a_full_collision(masses, e):
    scene = scene_of(
        ball((0, 0), (1, 0), mass=masses[0]),
        ball((1, 0), (-0.5, 0), mass=masses[1]),
        rolling_friction=0.0,
        ball_restitution=e,
        t_max=2.0,
    )
    result = simulate(scene, record="events")
    m1, m2 = map(mpf, masses)
    centre = (m1 - m2 / 2) / (m1 + m2)
    relative = mpf(1.5)
    exact = (
        centre - mpf(e) * relative * m2 / (m1 + m2),
        centre + mpf(e) * relative * m1 / (m1 + m2),
    )
    assert collisions(result) == [(BALL_BALL, 0, 1)]
    for i in range(2):
        error = abs(mpf(float(result.final_state.velocities[0, i, 0])) - exact[i])
        assert error <= 8 * EPS * 1.5


def test_a_half_ball_collision_leaves_at_30_and_60_degrees():
    scene = scene_of(ball((0, 0), (1, 0)), ball((0.6, R)), rolling_friction=0.0, t_max=1.0)
    velocities = simulate(scene).final_state.velocities[0]
    # The line of centres is computed from positions: its error is eps times 0.6 m over 2 R cos 30.
    tolerance = 32 * EPS * 0.6 / (2 * R)
    cos, sin = math.sqrt(3) / 2, 0.5
    assert velocities[1, :2] == pytest.approx([cos * cos, cos * sin], abs=tolerance)
    assert velocities[0, :2] == pytest.approx([sin * sin, -cos * sin], abs=tolerance)


def test_unequal_radii_touch_at_the_sum_of_the_radii_in_the_plane():
    scene = scene_of(
        ball((0, 0), (1, 0), radius=0.25),
        ball((2, 0), radius=0.5),
        rolling_friction=0.0,
        t_max=2.0,
    )
    assert simulate(scene, record="events").events["t"].tolist() == [1.25]


def test_a_ball_that_stops_short_does_not_hit():
    a = float(deceleration(scene_of(ball((0, 0)))))
    reach = 1.0 / (2.0 * a) + 2 * R
    short = scene_of(ball((0, 0), (1, 0)), ball((reach + 1e-9, 0)))
    far_enough = scene_of(ball((0, 0), (1, 0)), ball((reach - 1e-9, 0)))
    assert collisions(simulate(short, record="events")) == []
    assert collisions(simulate(far_enough, record="events")) == [(BALL_BALL, 0, 1)]


@pytest.mark.parametrize(
    ("velocity", "cushion"), [((-1, 0), 0), ((1, 0), 1), ((0, -1), 2), ((0, 1), 3)]
)
def test_each_cushion_is_where_it_is_and_has_its_index(velocity, cushion):
    scene = scene_of(
        ball((1, 1), velocity, radius=0.25),
        table=Table(length=2.0, width=2.0),
        rolling_friction=0.0,
        t_max=1.0,
    )
    result = simulate(scene, record="events")
    assert result.events.tolist() == [(0.75, CUSHION, 0, cushion)]
    assert result.rest_positions[0, :2].tolist() == [1 + v / 2 for v in velocity]
    assert result.collision_counts == {"ball-ball": 0, "ball-cushion": 1}


def test_restitution_scales_both_components():
    scene = scene_of(
        ball((1, 1), (1, 0.5), radius=0.25),
        table=Table(length=2.0, width=9.0),
        cushion="restitution",
        cushion_restitution=0.5,
        cushion_tangential_restitution=0.25,
        rolling_friction=0.0,
        t_max=1.75,
    )
    result = simulate(scene)
    assert result.final_state.velocities[0, 0].tolist() == [-0.5, 0.125, 0.0]
    assert result.rest_positions[0].tolist() == [1.25, 1.5, 0.25]


def test_an_inelastic_cushion_keeps_the_ball_at_the_nose_without_a_storm():
    scene = scene_of(
        ball((1, 1), (1, 0.5)),
        table=POOL_TABLE,
        cushion="restitution",
        cushion_restitution=0.0,
    )
    result = simulate(scene, record="events", max_events=1000)
    assert result.status is Status.REST
    assert result.collision_counts["ball-cushion"] <= 2
    assert result.rest_positions[0, 0] == pytest.approx(2.54 - R, abs=4 * EPS * 2.54)


@pytest.mark.parametrize("e", [0.5, 0.75])
def test_a_ball_that_just_fits_between_two_cushions_bounces_until_rounding_is_left(e):
    radius = 2.0**-5
    scene = scene_of(
        ball((0.5, radius), (0.0, 1.0), radius=radius),
        table=Table(length=1.0, width=2.0 * radius),
        cushion="restitution",
        cushion_restitution=e,
    )
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    # e to this power is `APPROACH_ROUNDING`: the ball once bounced until its speed underflowed.
    bounces = math.log(8.0 * EPS) / math.log(e)
    assert result.collision_counts["ball-cushion"] == pytest.approx(bounces, abs=2.0)
    assert tuple(result.rest_positions[0, :2]) == (0.5, radius)

"""Shots that have a solution in closed form, to a few ulp times the shot's conditioning.

The exact numbers come from mpmath, from the scene's own doubles, so that only the engine's rounding
is left to see.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from invariants import collisions
from mpmath import mp, mpf, workdps
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.engine import (
    EVENT_DTYPE,
    EventKind,
    GhostballError,
    Scene,
    Status,
    Table,
    UnsupportedSceneError,
    simulate,
)

EPS = 2.0**-52
HIT, CUSHION, REST = EventKind.BALL_BALL, EventKind.BALL_CUSHION, EventKind.ROLL_TO_REST


@pytest.fixture(autouse=True)
def _forty_digits():
    with workdps(40):
        yield


def deceleration(scene: Scene):
    return mpf(scene.physics.rolling_friction) * mpf(scene.physics.gravity)


def time_to_roll(distance, speed, a):
    """Time in which a ball of this speed rolls so far: the stable root of s = v t - a t^2 / 2."""
    return 2 * distance / (speed + mp.sqrt(speed**2 - 2 * a * distance))


def assert_close(value: float, exact, ulps: float) -> None:
    error = abs(mpf(float(value)) - exact)
    assert error <= ulps * EPS * abs(exact), f"{float(error / abs(exact)) / EPS:.1f} ulp"


class TestOneBall:
    @pytest.mark.parametrize("speed", [1e-9, 1e-3, 0.1, 1.0, 3.0, 10.0, 1e4])
    @pytest.mark.parametrize("friction", [0.005, 0.02, 1.0])
    def test_it_stops_where_and_when_it_must(self, speed, friction):
        scene = scene_of(ball((0, 0), (speed, 0)), rolling_friction=friction)
        result = simulate(scene, record="events")
        a = deceleration(scene)
        assert result.status is Status.REST
        assert_close(result.rest_time, mpf(speed) / a, 3)
        assert_close(result.rest_positions[0, 0], mpf(speed) ** 2 / (2 * a), 4)
        assert result.rest_positions[0, 1:].tolist() == [0.0, R]
        assert result.events["kind"].tolist() == [REST]

    def test_a_resting_scene_has_no_events_and_no_time(self):
        result = simulate(scene_of(ball((0.3, 0.1)), ball((0.9, 0.2))), record="events")
        assert result.status is Status.REST
        assert result.rest_time == 0.0
        assert len(result.events) == 0
        assert np.array_equal(result.rest_positions, result.scene.positions)

    def test_without_friction_it_rolls_on_to_t_max(self):
        scene = scene_of(ball((0.5, 0.25), (0.75, -0.5)), rolling_friction=0.0, t_max=8.0)
        result = simulate(scene)
        assert result.status is Status.T_MAX
        assert result.rest_time == 8.0
        assert result.rest_positions[0].tolist() == [6.5, -3.75, R]
        assert result.final_state.velocities[0, 0].tolist() == [0.75, -0.5, 0.0]

    def test_t_max_cuts_a_roll_where_the_closed_form_is(self):
        scene = scene_of(ball((0, 0), (1, 0)), t_max=2.5)
        result = simulate(scene, record="events")
        a = deceleration(scene)
        assert (result.status, result.rest_time, len(result.events)) == (Status.T_MAX, 2.5, 0)
        assert_close(result.rest_positions[0, 0], 2.5 - a * mpf(2.5) ** 2 / 2, 4)
        assert_close(result.final_state.velocities[0, 0, 0], 1 - a * mpf(2.5), 4)

    def test_the_recorded_motion_is_the_closed_form(self):
        scene = scene_of(ball((0, 0), (1, 0)))
        result = simulate(scene, record="trajectory")
        a = deceleration(scene)
        times = np.linspace(0.0, result.rest_time, 23)[:-1]
        samples = result.sample(times)
        for k, t in enumerate(times):
            exact = mpf(float(t)) - a * mpf(float(t)) ** 2 / 2
            assert abs(samples.positions[k, 0, 0] - exact) <= 4 * EPS * 2.6
            assert abs(samples.velocities[k, 0, 0] - (1 - a * mpf(float(t)))) <= 4 * EPS
        assert np.allclose(
            samples.angular_velocities[:, 0, 1], samples.velocities[:, 0, 0] / R, rtol=4 * EPS
        )


class TestTwoBalls:
    @pytest.mark.parametrize("distance", [0.06, 0.5, 2.0])
    def test_a_full_elastic_hit_hands_the_motion_over(self, distance):
        scene = scene_of(ball((0, 0), (1, 0)), ball((distance, 0)))
        result = simulate(scene, record="events")
        a, path = deceleration(scene), mpf(distance) - 2 * mpf(R)
        assert collisions(result) == [(HIT, 0, 1)]
        # The time has the condition number v / (v - a t) <= 3 here.
        assert_close(result.events["t"][0], time_to_roll(path, mpf(1), a), 32)
        # Together they roll as far as one would have alone.
        assert_close(result.rest_positions[1, 0], 1 / (2 * a) + 2 * mpf(R), 16)
        assert_close(result.rest_positions[0, 0], path, 32)

    @pytest.mark.parametrize(
        ("masses", "e"), [((1.0, 3.0), 0.5), ((5.0, 1.0), 1.0), ((1.0, 1.0), 0.0), ((1e-6, 1), 1.0)]
    )
    def test_masses_and_restitution_of_a_full_hit(self, masses, e):
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
        assert collisions(result) == [(HIT, 0, 1)]
        for i in range(2):
            error = abs(mpf(float(result.final_state.velocities[0, i, 0])) - exact[i])
            assert error <= 8 * EPS * 1.5

    def test_a_half_ball_hit_leaves_at_30_and_60_degrees(self):
        scene = scene_of(ball((0, 0), (1, 0)), ball((0.6, R)), rolling_friction=0.0, t_max=1.0)
        velocities = simulate(scene).final_state.velocities[0]
        # The line of centres is found from positions: eps of 0.6 m over 2 R cos 30.
        tolerance = 32 * EPS * 0.6 / (2 * R)
        cos, sin = math.sqrt(3) / 2, 0.5
        assert velocities[1, :2] == pytest.approx([cos * cos, cos * sin], abs=tolerance)
        assert velocities[0, :2] == pytest.approx([sin * sin, -cos * sin], abs=tolerance)

    def test_unequal_radii_touch_at_the_sum_of_the_radii_in_the_plane(self):
        scene = scene_of(
            ball((0, 0), (1, 0), radius=0.25),
            ball((2, 0), radius=0.5),
            rolling_friction=0.0,
            t_max=2.0,
        )
        assert simulate(scene, record="events").events["t"].tolist() == [1.25]

    def test_a_ball_that_stops_short_does_not_hit(self):
        a = float(deceleration(scene_of(ball((0, 0)))))
        reach = 1.0 / (2.0 * a) + 2 * R
        short = scene_of(ball((0, 0), (1, 0)), ball((reach + 1e-9, 0)))
        far_enough = scene_of(ball((0, 0), (1, 0)), ball((reach - 1e-9, 0)))
        assert collisions(simulate(short, record="events")) == []
        assert collisions(simulate(far_enough, record="events")) == [(HIT, 0, 1)]


class TestTouching:
    @pytest.mark.parametrize("moving", [0, 1])
    def test_a_frozen_pair_struck_along_its_line_passes_the_motion_on_at_once(self, moving):
        # The moving one of two touching balls runs into the other: a collision at t = 0.
        velocities = [(0.0, 0.0), (0.0, 0.0)]
        velocities[moving] = (1.0, 0.0) if moving == 0 else (-1.0, 0.0)
        scene = scene_of(ball((0, 0), velocities[0]), ball((2 * R, 0), velocities[1]))
        result = simulate(scene, record="events")
        assert collisions(result) == [(HIT, 0, 1)]
        assert result.events["t"][0] == 0.0
        assert np.array_equal(result.rest_positions[moving], scene.positions[moving])

    @pytest.mark.parametrize("n", [2, 3, 5, 8])
    def test_a_frozen_line_passes_an_elastic_hit_to_its_last_ball(self, n):
        # pooltool 0.6.0 makes 11 219 events of 8 balls. Sequential impulses: n collisions.
        line = [ball((0.5 + 2 * R * k, 0)) for k in range(n)]
        scene = scene_of(ball((0, 0), (1, 0)), *line)
        result = simulate(scene, record="events", max_events=1000)
        assert result.status is Status.REST
        assert [pair[1:] for pair in collisions(result)] == [(k, k + 1) for k in range(n)]
        alone = 1 / (2 * deceleration(scene))
        passed = mpf(float(scene.positions[n, 0])) - mpf(0.5) + 2 * mpf(R)
        assert_close(result.rest_positions[n, 0], alone + passed, 16)


class TestCushions:
    def test_a_bounce_mirrors_the_path(self):
        start = ball((1.9, 0.5), (0.75, 0.1))
        result = simulate(scene_of(start, table=POOL_TABLE), record="events")
        assert collisions(result) == [(CUSHION, 0, 1)]
        free = simulate(scene_of(start)).rest_positions[0]
        unfolded = [2 * (2.54 - R) - free[0], free[1], R]
        assert result.rest_positions[0] == pytest.approx(unfolded, abs=32 * EPS * 2.54)

    @pytest.mark.parametrize(
        ("velocity", "cushion"), [((-1, 0), 0), ((1, 0), 1), ((0, -1), 2), ((0, 1), 3)]
    )
    def test_each_cushion_is_where_it_is_and_has_its_index(self, velocity, cushion):
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

    @pytest.mark.parametrize("corner", [(0, 2), (0, 3), (1, 2), (1, 3)])
    def test_a_corner_hit_along_the_diagonal_comes_straight_back(self, corner):
        table = Table(length=2.0, width=2.0)
        velocity = (1.0 if corner[0] == 1 else -1.0, 1.0 if corner[1] == 3 else -1.0)
        scene = scene_of(
            ball((1, 1), velocity, radius=0.25), table=table, rolling_friction=0.0, t_max=1.5
        )
        result = simulate(scene, record="events")
        assert sorted(result.events.tolist()) == [(0.75, CUSHION, 0, c) for c in corner]
        assert result.rest_positions[0, :2].tolist() == [1.0, 1.0]
        assert result.final_state.velocities[0, 0, :2].tolist() == [-v for v in velocity]

    def test_restitution_scales_both_components(self):
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

    def test_an_inelastic_cushion_keeps_the_ball_at_the_nose_without_a_storm(self):
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


def galperin(digits: int) -> Scene:
    """Masses 1 : 100^k, a cushion behind the light ball: the collisions spell pi."""
    return scene_of(
        ball((1.0, 0.5), mass=1.0),
        ball((2.0, 0.5), (-1.0, 0.0), mass=100.0 ** (digits - 1)),
        table=Table(length=9.0, width=1.0, cushions=("left",)),
        rolling_friction=0.0,
        t_max=1e9,
    )


@pytest.mark.parametrize(
    ("digits", "count"),
    [
        (1, 3),
        (2, 31),
        (3, 314),
        (4, 3141),
        pytest.param(5, 31415, marks=pytest.mark.compiled),
    ],
)
def test_galperin_counts_pi(digits, count):
    result = simulate(galperin(digits))
    assert sum(result.collision_counts.values()) == count
    assert result.status is Status.T_MAX


class TestFrontDoor:
    def test_an_unknown_record_is_refused(self):
        with pytest.raises(GhostballError, match=r"`record` must be .*got 'all'"):
            simulate(scene_of(ball((0, 0))), record="all")

    @pytest.mark.parametrize("limit", [0, -5, 2.5, math.inf, True, "a", None])
    def test_an_event_limit_below_1_is_refused(self, limit):
        with pytest.raises(
            GhostballError, match=f"`max_events` must be a whole number from 1 to .*, got {limit!r}"
        ):
            simulate(scene_of(ball((0, 0))), max_events=limit)

    def test_unsupported_physics_is_refused_by_name(self):
        scene = scene_of(ball((0, 0), (1, 0)), motion="sliding", airborne=True, air_drag=0.004)
        with pytest.raises(UnsupportedSceneError, match="no air drag of balls that leave the cl"):
            simulate(scene)

    def test_the_event_limit_stops_and_says_when(self):
        scene = scene_of(
            ball((1, 0.5), (1, 0)), table=POOL_TABLE, rolling_friction=0.0, t_max=1000.0
        )
        result = simulate(scene, record="events", max_events=5)
        assert result.status is Status.EVENT_LIMIT
        assert len(result.events) == 5
        assert "5 events" in result.reason
        assert result.rest_time == result.events["t"][-1]

    def test_events_have_the_dtype_of_the_contract_and_counts_agree(self):
        scene = scene_of(ball((0.5, 0.5), (2, 0.3)), ball((1.5, 0.6)), table=POOL_TABLE)
        result = simulate(scene, record="events")
        assert result.events.dtype == EVENT_DTYPE
        kinds = result.events["kind"].tolist()
        assert result.collision_counts == {
            "ball-ball": kinds.count(HIT),
            "ball-cushion": kinds.count(CUSHION),
        }
        assert kinds.count(HIT) > 0
        assert kinds.count(CUSHION) > 0
        assert result.work["events"] == len(result.events)
        assert set(result.events["b"][result.events["kind"] == REST].tolist()) == {-1}
        assert result.wall_time >= 0.0

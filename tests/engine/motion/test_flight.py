"""Balls in flight: when they land, how their bounces end, when they meet others."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shots import FLIES, JUST_ABOVE, R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core.tolerances import EPS
from ghostball.model import EventKind, Phase, Status, Table

G = 9.81


def landings(result):
    return result.events["t"][result.events["kind"] == EventKind.BALL_CLOTH]


def test_a_ball_flies_along_a_parabola_and_lands():
    spin = (3.0, -40.0, 70.0)
    scene = scene_of(ball((0, 0), (2, 0.5, 1.5), angular_velocity=spin), **FLIES)
    result = simulate(scene, record="trajectory")
    first = landings(result)[0]
    assert first == pytest.approx(2 * 1.5 / G, rel=2 * EPS)
    t = np.linspace(0, first * (1 - 1e-12), 7)
    states = result.sample(t)
    assert states.positions[:, 0, 2] == pytest.approx(R + 1.5 * t - G * t**2 / 2, abs=1e-15)
    assert states.positions[:, 0, :2] == pytest.approx(np.outer(t, [2, 0.5]), abs=1e-15)
    assert np.all(states.angular_velocities[:, 0] == spin)  # no cloth slows any of it
    assert np.all(result.phases(t) == Phase.FLYING)
    energy = result.energy(t)
    assert energy.total == pytest.approx(energy.total[0], rel=4 * EPS)
    assert energy.height[3] > 0.0


# --- the end of bouncing, in closed form


def test_a_dropped_ball_comes_to_rest_after_its_series():
    """Ends sqrt(2 h / g)(1 + e)/(1 - e) after it is let go: no bounce is cut short."""
    h, e = 0.1, 0.6
    scene = scene_of(ball((0, 0, R + h)), **(FLIES | {"table_restitution": e}))
    result = simulate(scene, record="trajectory")
    times = landings(result)
    assert times[0] == pytest.approx(0.14278431229270645, rel=4 * EPS)
    assert times[-1] == pytest.approx(0.57113724917082579, rel=8 * EPS)
    assert result.rest_time == pytest.approx(0.57113724917082579, rel=8 * EPS)
    ratios = np.diff(times)[1:-1] / np.diff(times)[:-2]
    assert ratios == pytest.approx(e, abs=1e-9)
    assert len(times) == 18
    assert result.rest_positions.tolist() == [[0.0, 0.0, R]]


@pytest.mark.parametrize("e", [0.0, 0.3, 0.9, 0.99])
def test_however_it_bounces_it_rolls_at_the_same_speed(e):
    """v0 - (2/7) u0: neither the table nor the number of bounces matter."""
    scene = scene_of(
        ball((0, 0, JUST_ABOVE), (2, 1, -0.7), angular_velocity=(10, -60, 5)),
        **(FLIES | {"table_restitution": e}),
    )
    result = simulate(scene, record="trajectory")
    assert result.status is Status.REST
    rolls = result.events["t"][result.events["kind"] == EventKind.SLIDE_TO_ROLL]
    t = max([*rolls, landings(result)[-1]])
    assert result.phases([t])[0, 0] == Phase.ROLLING
    rolling = np.array([2, 1]) - 2 / 7 * np.array([2 + R * 60, 1 + R * 10])
    assert result.sample([t]).velocities[0, 0, :2] == pytest.approx(rolling, abs=1e-12)


def test_a_table_that_returns_all_lets_a_ball_bounce_for_ever():
    scene = scene_of(ball((0, 0, R + 0.05)), t_max=20.0, **(FLIES | {"table_restitution": 1.0}))
    result = simulate(scene, record="trajectory")
    assert result.status is Status.T_MAX
    period = 2 * math.sqrt(2 * 0.05 / G)
    times = landings(result)
    assert times == pytest.approx(period * (np.arange(len(times)) + 0.5), rel=1e-13)
    energy = result.energy(np.linspace(0, 20, 50)).total
    assert energy == pytest.approx(energy[0], rel=1e-13)


# --- in space


def test_a_ball_dropped_on_another_bounces_off_and_both_come_to_rest():
    scene = scene_of(
        ball((0.001, 0.0005, 0.2)), ball((0, 0)), ball_restitution=0.9, ball_friction=0.05, **FLIES
    )
    result = simulate(scene, record="trajectory")
    assert result.status is Status.REST
    collisions = result.events[result.events["kind"] == EventKind.BALL_BALL]
    assert len(collisions) > 2
    assert np.all(result.rest_positions[:, 2] == R)
    times = np.linspace(0, result.rest_time, 3000)
    places = result.sample(times).positions
    assert np.min(np.linalg.norm(places[:, 0] - places[:, 1], axis=1)) > 2 * R * (1 - 1e-12)
    energy = result.energy(np.sort([*times, *result.events["t"]])).total
    assert np.all(np.diff(energy) <= 1e-13 * energy[0])


def test_a_ball_dropped_exactly_on_another_falls_off():
    """Nothing decides to which side; without a rule of its own it would bounce there for ever."""
    scene = scene_of(ball((0, 0, 0.1)), ball((0, 0)), ball_restitution=0.5, **FLIES)
    result = simulate(scene, record="events", max_events=50_000)
    assert result.status is Status.REST
    assert np.all(result.rest_positions[:, 2] == R)
    assert result.rest_positions[0, 1] == 0.0


def test_a_ball_over_an_open_side_comes_down_on_the_cloth_that_continues():
    table = Table(length=2.0, width=1.0, cushions=("left", "bottom", "top"))
    scene = scene_of(ball((1.8, 0.5), (3, 0, 1.5)), table=table, **FLIES)
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    assert EventKind.LEAVES_TABLE not in result.events["kind"]
    assert result.rest_positions[0, 0] > 2.0

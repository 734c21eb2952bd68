"""Tests of published numbers for billiards without losses, and for three balls in line.

Each test names the formula and its source. The shots are far longer than their horizon, so the
numbers are means and counts, which rounding doesn't change.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpmath import mpf, workdps
from numpy.typing import NDArray
from shots import ball, scene_of

from ghostball.engine import simulate, simulate_starts
from ghostball.model import POOL_BALL_RADIUS as R, Scene, Table
from ghostball.model.scene.obstacles import FIRST_POST

SIGMAS = 4.0
"""Permitted error of a mean, in standard errors."""

POINT = 1e-3
"""Radius of the ball in Sinai's billiard [m]; the point of the billiard is the centre of the ball.
"""


def sinai(radius: float, t_max: float, place=(0.1, 0.1), velocity=(1.0, 0.0)) -> Scene:
    """Return a ball whose centre moves in a unit square around a disc with a radius [m]."""
    middle = 0.5 + POINT
    table = Table(
        length=2.0 * middle,
        width=2.0 * middle,
        posts=[{"centre": (middle, middle), "radius": radius - POINT}],
    )
    place = tuple(x + POINT for x in place)
    balls = [ball(place, velocity, radius=POINT)]
    return scene_of(*balls, table=table, rolling_friction=0.0, t_max=t_max)


@pytest.mark.compiled
@pytest.mark.parametrize("radius", [0.05, 0.2, 0.4])
def test_the_mean_free_path_of_sinai_s_billiard(radius):
    """pi A / P, for area A and perimeter P: Chernov 1997, after Santalo.

    The initial states have the invariant measure: uniform in position and direction. The mean
    number of collisions in a time is then the path length over the mean free path.
    """
    t_max, shots = 20.0, 4000
    chance = np.random.default_rng(1)
    places = chance.uniform(0.0, 1.0, (3 * shots, 2))
    places = places[np.hypot(*(places - 0.5).T) > radius][:shots]
    angles = chance.uniform(0.0, 2.0 * math.pi, shots)
    velocities = np.column_stack([np.cos(angles), np.sin(angles)])
    found = simulate_starts(
        sinai(radius, t_max), places[:, None] + POINT, velocities[:, None], threads=1
    ).ball_cushion
    area, perimeter = 1.0 - math.pi * radius**2, 4.0 + 2.0 * math.pi * radius
    expected = t_max * perimeter / (math.pi * area)
    error = float(np.std(found, ddof=1)) / math.sqrt(shots)
    assert error < 0.002 * expected
    assert abs(float(np.mean(found)) - expected) < SIGMAS * error


def stretches(scene: Scene) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the time of each collision with the disc, and ln(1 + k t) of the path after it.

    k is the curvature of the wave front after the collision, t the time to the next one. A mirror
    adds 2 / (r cos(angle)) to k; a path divides k by 1 + k t (Sinai 1970).
    """
    result = simulate(scene, record="trajectory")
    (post,) = scene.table.posts
    times = result.events["t"][result.events["b"] == FIRST_POST]
    states = result.sample(times)  # after the collision
    out = (states.positions[:, 0, :2] - post.centre) / (post.radius + POINT)
    cosines = np.sum(out * states.velocities[:, 0, :2], axis=1)
    bends = 2.0 / ((post.radius + POINT) * cosines)
    curvature, found = bends[0], []
    for bend, path in zip(bends[1:], np.diff(times), strict=True):
        found.append(math.log1p(curvature * path))
        curvature = bend + curvature / (1.0 + curvature * path)
    return times, np.array(found)


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize(("radius", "collisions"), [(0.01, 5000), (0.05, 20_000)])
def test_the_lyapunov_exponent_of_sinai_s_billiard(radius, collisions):
    """-2 ln r + 1 - 4 ln 2 + 27 zeta(3) / (2 pi^2) + O(r ln^2 r) per collision with the disc.

    Dahlqvist 1997, who doesn't give the factor of the last term; here the term may be a quarter of
    r ln^2 r.
    """
    path = (1.0 - math.pi * radius**2) / (2.0 * radius)
    shot = sinai(radius, collisions * path, (0.123, 0.217), (math.cos(0.7), math.sin(0.7)))
    _, found = stretches(shot)
    assert len(found) > 0.9 * collisions
    zeta = 1.2020569031595942
    expected = -2.0 * math.log(radius) + 1.0 - 4.0 * math.log(2.0)
    expected += 27.0 * zeta / (2.0 * math.pi**2)
    blocks = [float(np.mean(part)) for part in np.array_split(found, 20)]
    error = float(np.std(blocks, ddof=1)) / math.sqrt(len(blocks))
    assert error < 0.025
    rest = 0.25 * radius * math.log(radius) ** 2
    assert abs(float(np.mean(found)) - expected) < SIGMAS * error + rest


def test_the_tangent_map_stretches_as_sinai_s_formula():
    """The derivative of a shot grows by the product of 1 + k t."""
    scene = sinai(0.2, 30.0, (0.123, 0.217), (math.cos(0.7), math.sin(0.7)))
    result = simulate(scene, record="trajectory")
    times, found = stretches(scene)
    assert len(found) > 8
    changes = np.zeros((1, 1, 7))
    changes[0, 0, 2:4] = (-math.sin(0.7), math.cos(0.7))
    # The front that starts here has another curvature; its effect vanishes after a few collisions.
    ends = result.tangent(changes).sample(times[[4, -1]])[:, 0, 0, :2]
    grown = math.log(np.hypot(*ends[1]) / np.hypot(*ends[0]))
    assert grown == pytest.approx(float(np.sum(found[4:])), rel=1e-9)


def test_fagnano_s_orbit_closes():
    """The feet of the altitudes of an acute triangle form a closed orbit.

    Its length is 8 A^2 / (a b c), where A is the area and a, b, c are the sides of the triangle in
    which the centre moves (Fagnano 1775).
    """
    corners = np.array([[0.0, 0.0], [2.2, 0.0], [0.9, 1.7]])
    sides = np.roll(corners, -1, axis=0) - corners
    inward = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.hypot(*sides.T)[:, None]
    # Corners of the triangle of the centre, which stays one radius away from each side.
    inner = np.array(
        [
            corner + np.linalg.solve([inward[k - 1], inward[k]], [R, R])
            for k, corner in enumerate(corners)
        ]
    )
    feet = np.array(
        [
            inner[k] + inward[(k + 1) % 3] * np.dot(inner[k - 1] - inner[k], inward[(k + 1) % 3])
            for k in range(3)
        ]
    )
    a, b, c = (math.dist(inner[k], inner[k - 1]) for k in range(3))
    half = 0.5 * (a + b + c)
    way = 8.0 * half * (half - a) * (half - b) * (half - c) / (a * b * c)
    start, along = 0.5 * (feet[0] + feet[1]), feet[1] - feet[0]
    shot = scene_of(
        ball(tuple(start), tuple(along / np.hypot(*along))),
        table=Table(vertices=corners.tolist()), rolling_friction=0.0, t_max=100.0 * way,
    )  # fmt: skip
    result = simulate(shot, record="trajectory")
    times = result.events["t"]
    assert len(times) == 300
    assert np.diff(times[::3]) == pytest.approx(way, rel=1e-12)
    places = result.sample(times).positions[:, 0, :2]
    assert places == pytest.approx(np.tile(feet[[1, 2, 0]], (100, 1)), abs=1e-12)


@pytest.mark.compiled
def test_three_equal_discs_collide_at_most_four_times():
    """Without cushions and losses: Murphy and Cohen 1993. Some of the shots have four collisions.

    The discs are near each other at one time. Their past is the future with opposite velocities.
    """
    shots, chance = 50_000, np.random.default_rng(2)
    angle = chance.uniform(0.0, 2.0 * math.pi, shots)
    places = np.zeros((shots, 3, 2))
    for k, turned in ((0, angle), (2, angle + math.pi * chance.uniform(1.0 / 3.0, 1.0, shots))):
        gap = chance.uniform(0.0, 1.0, shots) * 10.0 ** chance.uniform(-3.0, 0.0, shots)
        away = 2.0 * R * (1.0 + gap)
        places[:, k] = np.column_stack([away * np.cos(turned), away * np.sin(turned)])
    places = places[np.hypot(*(places[:, 0] - places[:, 2]).T) > 2.0001 * R]
    velocities = chance.normal(0.0, 0.3, places.shape)
    balls = [ball(place) for place in places[0]]
    scene = scene_of(*balls, rolling_friction=0.0, t_max=1e4)
    future, past = (
        simulate_starts(scene, places, sign * velocities, threads=1).ball_ball for sign in (1, -1)
    )
    counts = np.bincount(future + past)
    assert len(counts) == 5
    assert counts[4] > 50


def in_line(restitution: float, approach: float) -> Scene:
    """Return three equal balls in line: one moves at 1 m/s, the last the other way."""
    places, speeds = (0.0, 2.0 * R + 0.01, 4.0 * R + 0.02), (1.0, 0.0, -approach)
    balls = [ball((x, 0.0), (v, 0.0)) for x, v in zip(places, speeds, strict=True)]
    return scene_of(*balls, rolling_friction=0.0, ball_restitution=restitution, t_max=1.0)


def collisions_in_line(restitution: float, approach: float, most: int = 200) -> int:
    """Return the number of collisions of `in_line`, to 50 digits; `most` if there are more."""
    with workdps(50):
        e, speeds, gaps = mpf(restitution), [mpf(1), mpf(approach)], [mpf("0.01")] * 2
        for count in range(most):
            due = [gap / v if v > 0 else mpf("inf") for gap, v in zip(gaps, speeds, strict=True)]
            k = 0 if due[0] < due[1] else 1
            if due[k] == mpf("inf"):
                return count
            gaps = [gap - v * due[k] for gap, v in zip(gaps, speeds, strict=True)]
            gaps[k] = mpf(0)
            speeds[1 - k] += (1 + e) / 2 * speeds[k]
            speeds[k] *= -e
    return most


@pytest.mark.parametrize("approach", [0.0, 0.1, 0.3])
def test_three_balls_in_line_collapse_below_7_minus_4_root_3(approach):
    """McNamara and Young 1992: below this restitution, the collisions never end.

    Each approach speed is the larger root x of x^2 - (1 + e) / 2 x + e = 0 times the one before.
    Just above the critical restitution, double precision can't distinguish the end from a collapse:
    the speeds fall below their rounding.
    """
    critical = 7.0 - 4.0 * math.sqrt(3.0)
    assert collisions_in_line(critical - 1e-4, approach) == 200
    assert 60 < collisions_in_line(critical + 2e-4, approach) < 200
    for restitution in (0.073, 0.08, 0.1, 0.2, 0.5):
        result = simulate(in_line(restitution, approach), record="events")
        expected = collisions_in_line(restitution, approach)
        assert result.collision_counts["ball-ball"] == expected
    result = simulate(in_line(0.05, approach), record="trajectory")
    times = result.events["t"]
    assert times[-1] < 0.05
    between = 0.5 * (times[:16] + times[1:17])  # later times round to the same double
    speeds = np.abs(np.diff(result.sample(between).velocities[:, :, 0], axis=1)).max(axis=1)
    assert speeds[9:] / speeds[8:-1] == pytest.approx(0.4, rel=1e-3)
    assert np.ptp(result.final_state.velocities[0, :, 0]) < 1e-14
    assert np.diff(result.rest_positions[:, 0]) == pytest.approx(2.0 * R, abs=4e-13)

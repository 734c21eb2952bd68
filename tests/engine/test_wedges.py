"""Tests of corners, funnels and gates narrower than a ball: the ball returns, or jams and rests.

They fail for endless bounces at one time, for a ball that passes, and for contact steps that become
ever shorter: each shot has a limit of work.
"""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from shots import R

from ghostball.engine import simulate
from ghostball.model import Result, Scene, Status
from ghostball.validation.stress.pockets import wedge

MOST_WORK = 5 * 10**6
"""Limit of work for a shot, in units of about 6 ns."""

OVERLAP = 2.0**-37 * 2.0 * R + 1e-14
"""Permitted overlap of a resting contact, plus rounding [m]."""

LAWS = ("mirror", "restitution", "frictional", "han2005", "mathavan2010", "stronge2000")

Shot = dict[str, object]


def shot(
    physics: Shot,
    table: Shot,
    position: tuple[float, float],
    velocity: tuple[float, float],
    *spin: float,
) -> Scene:
    """Return a scene of one ball."""
    moves: Shot = {"id": "a", "position": position, "velocity": velocity}
    if spin:
        moves["angular_velocity"] = spin
    content = {"schema": 1, "name": "wedge", "physics": physics, "table": table, "balls": [moves]}
    return Scene.model_validate(content)


def corner(degrees: float) -> Shot:
    """Return a triangular table with an angle of `degrees` at (2, 0)."""
    return {"vertices": [[0, 0], [2, 0], [0, 2.0 * math.tan(math.radians(degrees))]]}


FUNNEL: Shot = {"vertices": [[0, 0], [2, 0], [2, 0.04715], [0, 0.08715]]}


def gate(lacking: float, radius: float = 0.02) -> Shot:
    """Return a table with a post at x = 1, nearer to a cushion than the diameter of a ball [m]."""
    post = {"centre": [1.0, 2.0 * R - lacking + radius], "radius": radius}
    return {"length": 2, "width": 1, "posts": [post]}


def pool(restitution: float, cushion: str = "han2005") -> Shot:
    return {"preset": "pool", "cushion": cushion, "cushion_restitution": restitution}


PAPER: Shot = {"preset": "paper", "cushion": "restitution", "cushion_restitution": 0.3}
SPIN = (-2.0, -20.0, 61.0)


def check(scene: Scene) -> Result:
    """Simulate a shot; it must rest, take little work, and overlap nothing beyond tolerance."""
    result = simulate(scene, record="events", max_work=MOST_WORK)
    assert result.status is Status.REST, result.reason
    assert result.work["unsolved_contact_steps"] == 0
    times = np.append(np.linspace(0.0, result.rest_time, 200), result.events["t"])
    positions = result.sample(np.unique(times)).positions[:, 0, :2]
    assert least_gap(scene, positions) > -OVERLAP
    return result


def least_gap(scene: Scene, positions: np.ndarray) -> float:
    """Return the smallest gap between the ball and the obstacles on its table [m]."""
    table, x, y = scene.table, positions[:, 0], positions[:, 1]
    gaps = []
    if table.vertices:
        corners = np.array(table.vertices)
        for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            side = math.hypot(x1 - x0, y1 - y0)
            gaps.append(((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / side - R)
    else:
        gaps += [x - R, y - R, table.length - R - x, table.width - R - y]
        gaps += [
            np.hypot(x - post.centre[0], y - post.centre[1]) - post.radius - R
            for post in table.posts
        ]
    return float(np.min(gaps))


@pytest.mark.parametrize(
    ("physics", "degrees", "position", "velocity"),
    [
        (pool(0.5), 20.0, (1.745, 0.045), (1.23, 0.15)),
        (pool(0.3), 30.0, (1.832, 0.045), (1.24, 0.04)),
        (pool(0.3, "frictional"), 20.0, (1.745, 0.045), (1.23, 0.15)),
        (pool(0.1), 45.0, (1.832, 0.045), (1.24, 0.04)),
    ],
)
def test_a_ball_rests_in_a_corner_that_is_too_sharp_for_its_cushions(
    physics, degrees, position, velocity
):
    check(shot(physics, corner(degrees), position, velocity, *SPIN))


@pytest.mark.parametrize("law", [*LAWS[:4], pytest.param(LAWS[4], marks=pytest.mark.compiled)])
@pytest.mark.parametrize("restitution", [0.3, 0.85])
def test_a_ball_jams_in_a_funnel_or_comes_back(law, restitution):
    preset = "paper" if law in ("mirror", "restitution") else "pool"
    physics: Shot = {"preset": preset, "cushion": law}
    if law != "mirror":
        physics["cushion_restitution"] = restitution
    result = check(shot(physics, FUNNEL, (0.1, 0.038575), (1.0, 0.05)))
    if law == "mirror":
        assert result.rest_positions[0, 0] < 0.5
    else:
        # The place at which the funnel is as wide as the ball, across its bisector.
        slope = 0.04 / 2.0
        at = (0.08715 - R * (1.0 + math.hypot(1.0, slope))) / slope
        assert result.rest_positions[0, 0] == pytest.approx(at, abs=1e-8)


@pytest.mark.parametrize(
    "lacking", [0.0, 1e-12, 1e-11, 1e-10, 4e-10, 5e-10, 1e-9, 1e-8, 1e-6, 1e-5]
)
@pytest.mark.parametrize("physics", [pool(0.85), PAPER, pool(0.85, "restitution")], ids=str)
def test_a_ball_stays_on_its_side_of_a_gate(physics, lacking):
    result = check(shot(physics, gate(lacking), (0.5, 0.029575), (0.7, -0.001)))
    assert result.rest_positions[0, 0] < 1.0 + 1e-6


def test_a_ball_between_parallel_noses_that_just_fit_it_goes_on_along_them():
    table: Shot = {"vertices": [[0, 0], [2, 0], [2, 2.0 * R], [0, 2.0 * R]]}
    result = check(shot(PAPER, table, (0.5, R), (0.5, 0.05)))
    assert result.rest_positions[0, 0] > 0.6


def random_shot(seed: int) -> Scene:
    """Return a shot of a ball into a corner, a funnel, a gate, or between two posts."""
    rng = random.Random(seed)
    law = rng.choice(LAWS[:4])
    slides = law in ("frictional", "han2005") or rng.random() < 0.4
    physics: Shot = {"preset": "pool" if slides else "paper", "cushion": law}
    if law != "mirror":
        physics["cushion_restitution"] = rng.uniform(0.1, 0.9)
    speed, kind = rng.uniform(0.3, 3.0), rng.randrange(4)
    spin = [rng.uniform(-60.0, 60.0) for _ in range(3)] if slides and rng.random() < 0.7 else []
    if kind == 0:
        angle = math.radians(rng.uniform(10.0, 60.0))
        far, way = R / math.sin(angle / 2.0) * rng.uniform(1.05, 2.0), -angle / 2.0
        place = 2.0 - far * math.cos(angle / 2.0), far * math.sin(angle / 2.0)
        way += rng.uniform(-angle, angle) / 3.0
        velocity = speed * math.cos(way), speed * math.sin(way)
        return shot(physics, corner(math.degrees(angle)), place, velocity, *spin)
    if kind == 1:
        wide, narrow = rng.uniform(0.065, 0.1), rng.uniform(0.03, 0.056)
        table: Shot = {"vertices": [[0, 0], [2, 0], [2, narrow], [0, wide]]}
        return shot(
            physics, table, (0.1, wide / 2.0 - 0.002), (speed, rng.uniform(-0.1, 0.1)), *spin
        )
    lacking, radius = 10.0 ** rng.uniform(-12.0, -4.5), rng.uniform(0.01, 0.05)
    if kind == 2:
        place = 0.6, R + rng.choice([0.0, 0.0005, 0.001])
        return shot(physics, gate(lacking, radius), place, (speed, rng.uniform(-0.001, 0.0)), *spin)
    away = R - lacking / 2.0 + radius
    posts = [{"centre": [1.0, 0.5 + side * away], "radius": radius} for side in (1.0, -1.0)]
    table = {"length": 2, "width": 1, "posts": posts}
    place = 0.8, 0.5 + rng.choice([0.0, 0.001])
    return shot(physics, table, place, (speed, rng.uniform(-0.003, 0.003)), *spin)


@pytest.mark.parametrize("seed", range(60))
def test_no_random_wedge_holds_up_a_run_or_lets_a_ball_through(seed):
    check(random_shot(seed))


@pytest.mark.compiled
@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 1000, 100))
def test_no_random_wedge_of_many_holds_up_a_run(first):
    for seed in range(1000 + first, 1100 + first):
        check(random_shot(seed))


@pytest.mark.compiled
@pytest.mark.parametrize("lacking", [1e-12, 1e-9, 1e-7, 1e-5])
def test_a_ball_whose_bounces_are_integrated_stays_on_its_side_of_a_gate(lacking):
    scene = shot(pool(0.85, "mathavan2010"), gate(lacking), (0.5, 0.029575), (0.7, -0.001))
    assert check(scene).rest_positions[0, 0] < 1.0


def test_bounces_between_slanting_cushions_keep_the_energy():
    """Fails if the rounded normal of a cushion changes the energy the same way at each bounce."""
    scene, bounces = wedge(math.radians(0.1))
    result = simulate(scene, record="events")
    assert result.collision_counts["ball-cushion"] == bounces == 1800
    before, after = result.energy([0.0, scene.t_max]).total
    assert abs(after / before - 1.0) < 1e-14

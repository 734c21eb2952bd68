"""Simultaneous impacts: certified if exactly simultaneous, or if their order doesn't matter."""

from __future__ import annotations

import math

import numpy as np
import pytest
from proofs import after, engine_keys, keys, proved
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Scene, Table
from ghostball.reference_adapters.certified import certify
from ghostball.validation.scenes.library import find_scene

R = 2.0**-5
"""Radius [m] with which bodies touch exactly along an axis."""

BOX = Table(length=1.0, width=1.0)

FRICTION = {
    "motion": "sliding",
    "ball_restitution": 0.95,
    "ball_friction": 0.06,
    "cushion": "frictional",
    "cushion_restitution": 0.85,
}


def small(place, velocity=(0.0, 0.0), **fields):
    return ball(place, velocity, radius=R, **fields)


def pair_of_two(**physics) -> Scene:
    """Return a ball that moves between two resting balls, which are mirror images."""
    balls = [small((0.0, 0.0), (2.0, 0.0)), small((0.5, 0.04)), small((0.5, -0.04))]
    return scene_of(*balls, t_max=0.6, **physics)


def triangle(**physics) -> Scene:
    """Return a head-on break of three balls that touch to within rounding."""
    x = 0.5 + R * math.sqrt(3.0)
    balls = [small((0.5, 0.0)), small((x, R)), small((x, -R))]
    return scene_of(small((0.3, 0.0), (2.0, 0.0)), *balls, t_max=0.3, **physics)


def cornered(velocity=(-1.0, -1.0), start=0.0, **physics) -> Scene:
    """Return a ball that moves into a corner: along the bisector, or obliquely while touching."""
    return scene_of(small((R + start, R + start), velocity), table=BOX, t_max=0.5, **physics)


def column(**physics) -> Scene:
    """Return a ball that is pushed, from the start, against a ball that touches a cushion."""
    balls = [small((5.0 * R, 0.5), (-1.0, 0.0)), small((3.0 * R, 0.5)), small((R, 0.5))]
    return scene_of(*balls, table=BOX, t_max=0.2, **physics)


def square(**physics) -> Scene:
    """Return a ball that touches two balls at right angles, and moves between them."""
    balls = [small((0.0, 0.0), (1.0, 0.5)), small((2.0 * R, 0.0)), small((0.0, 2.0 * R))]
    return scene_of(*balls, t_max=0.2, **physics)


ROLLING = {"rolling_friction": 0.02, "ball_restitution": 0.9}

AT_ONCE = {
    "two balls": pair_of_two(**ROLLING),
    "two balls, with friction": pair_of_two(**FRICTION),
    "two balls, friction by the slip": pair_of_two(**{**FRICTION, "ball_friction": "alciatore"}),
    "two balls at a right angle, elastic": square(),
    "triangle": triangle(**ROLLING),
    "triangle, with friction": triangle(**FRICTION),
    "corner": cornered(start=0.25, **ROLLING),
    "corner, slanting, with friction": cornered((-0.8, -0.6), **FRICTION),
    "cushion before balls": column(**ROLLING),
}


@pytest.mark.parametrize("name", AT_ONCE)
def test_impacts_at_once_end_as_our_engine_says(name):
    """Two programs without common code must have the same law."""
    scene = AT_ONCE[name]
    proof, run = proved(scene), simulate(scene)
    assert keys(proof) == engine_keys(scene)
    assert any(event.tie for event in proof.events)
    places = np.array([[float(x) for x in place] for place in proof.positions])
    np.testing.assert_allclose(run.rest_positions[:, :2], places, rtol=0.0, atol=1e-14)


def test_a_ball_that_hits_two_that_touch_comes_back_with_a_fifth_of_its_speed():
    proof = after(find_scene("three-ball-symmetric"), 2)
    (cue, cue_y), left, right = ([float(v) for v in ball] for ball in proof.velocities)
    # From momentum and energy, with lines of centres at 30 degrees.
    assert left[0] == pytest.approx(-3.0 * cue, rel=1e-12)
    assert left[1] == pytest.approx(-math.sqrt(3.0) * cue, rel=1e-12)
    assert right == pytest.approx([left[0], -left[1]], rel=1e-12)
    assert cue_y == 0.0
    assert proof.velocities[0][1].width == 0.0


@pytest.mark.parametrize("start", [0.0, 0.25])
def test_a_ball_comes_back_out_of_a_corner_as_it_went_in(start):
    proof = proved(cornered(start=start, rolling_friction=0.0))
    assert keys(proof) == [(1, 0, 0), (1, 0, 2)]
    assert [float(v) for v in proof.velocities[0]] == [1.0, 1.0]
    assert [float(x) for x in proof.positions[0]] == [R + 0.5 - start, R + 0.5 - start]


@pytest.mark.parametrize(
    ("place", "velocity", "physics", "ending"),
    [
        ((R, R + 1e-15), (-0.8, -0.6), {}, "proved"),
        ((R + 1e-15, R), (-0.8, -0.6), {"cushion": "restitution"}, "proved"),
        ((R, R + 1e-15), (-0.8, -0.6), FRICTION, "ambiguous"),
        (
            (R, R + 1e-15),
            (-0.8, -0.6),
            {
                "cushion": "restitution",
                "cushion_restitution_loss": 0.1,
                "cushion_tangential_restitution": 0.9,
            },
            "ambiguous",
        ),
    ],
)
def test_the_order_of_two_sides_matters_only_where_the_first_changes_what_the_second_does(
    place, velocity, physics, ending
):
    scene = scene_of(small(place, velocity), table=BOX, t_max=0.1, **physics)
    assert certify(scene, cached=False).ending == ending


@pytest.mark.parametrize(
    "scene",
    [
        # No engine in doubles can decide which impact comes first.
        scene_of(
            small((0.0, 1e-18), (2.0, 0.0)), small((0.5, 0.04)), small((0.5, -0.04)), t_max=0.6
        ),
        # The scene requires an order of the impacts, but doesn't determine it.
        pair_of_two(impacts="sequential"),
        cornered(impacts="sequential"),
    ],
    ids=["another instant", "two balls in an order", "two sides in an order"],
)
def test_impacts_that_are_not_simultaneous_are_ambiguous(scene):
    proof = certify(scene, cached=False)
    assert proof.ending == "ambiguous"
    assert proof.reason.startswith("can't determine what comes first")
    assert proof.events == ()

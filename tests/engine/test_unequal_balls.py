"""Tests of balls with different radii and masses: same result renumbered, mirrored or with cells.

A kernel that uses the radius or the mass of the wrong ball is right for equal balls, but changes
with their order. Radii and positions are sums of powers of two, so mirroring rounds nothing.
"""

from __future__ import annotations

import numpy as np
import pytest
from islands import pushing_pair
from same import differences
from same.images import MAPS, image, is_promised, shuffled
from shots import ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Scene, Table

R, S = 2.0**-5, 0.75 * 2.0**-5
"""Radii of a large and a small ball [m]."""

SLIDES = {
    "motion": "sliding",
    "rolling_friction": 0.01,
    "sliding_friction": 0.2,
    "spinning_friction_rate": 10.0,
    "ball_restitution": 0.9,
    "ball_friction": 0.06,
}
BOUNDED = Table(length=1.0, width=0.75)
SPINS = (20.0, -30.0, 60.0)

CUE = ball((0.25, 0.25), (2.0, 0.25), radius=R, mass=0.3, angular_velocity=SPINS)
SMALL = ball((0.5, 0.3125), radius=S, mass=0.05)
MOVING = SMALL | {
    "position": (0.375, 0.28125),
    "velocity": (-0.5, 0.0),
    "angular_velocity": (-50.0, 10.0, -25.0),
}
PAIR = (
    ball((0.5, 0.25 + R), radius=R, mass=0.1),
    ball((0.5, 0.25 - R), radius=R, mass=0.3),
)
"""Two touching balls; a third ball of their radius, moving along x, hits both simultaneously."""

AT_BOTH = ball((0.25, 0.25), (2.0, 0.0), radius=R, mass=0.2, angular_velocity=(0.0, 0.0, 60.0))
ALOFT = ball(
    (0.5, 0.5, 0.125), (1.0, 0.125, 0.5), radius=R, mass=0.3, angular_velocity=(5.0, 20.0, 40.0)
)
UNDER = ball((0.75, 0.53125), radius=S, mass=0.1)


def on(*balls, table=None, **physics) -> Scene:
    return scene_of(*balls, table=table, **(SLIDES | physics))


SCENES = {
    "points that roll": scene_of(
        CUE | {"angular_velocity": None}, SMALL, motion="rolling", ball_restitution=0.9
    ),
    "a cut": on(CUE, SMALL),
    "a cut of a ball that moves and spins": on(CUE, MOVING),
    "friction by the speed": on(CUE, MOVING, ball_friction="alciatore"),
    "friction that ends the slip": on(CUE, MOVING, ball_friction=0.9),
    "a cloth of its own for each": on(
        CUE | {"sliding_friction": 0.3, "rolling_friction": 0.02},
        MOVING | {"spinning_friction_rate": 20.0, "rolling_friction": 0.005},
    ),
    "the cloth in impacts": on(CUE, MOVING, ball_impact="mathavan2014"),
    "a joint impact": on(AT_BOTH, *PAIR),
    "a joint impact that sticks": on(AT_BOTH, *PAIR, ball_friction=0.4),
    "in air": on(CUE, MOVING, air_drag=0.05, t_max=0.5),
    "a cloth that slows by the square": on(CUE, MOVING, rolling_friction_quadratic=0.05),
    "cushions of one restitution": on(
        CUE, MOVING, table=BOUNDED, cushion="restitution", cushion_restitution=0.75
    ),
    "cushions that rub": on(CUE, MOVING, table=BOUNDED, cushion="frictional"),
    "cushions with a nose": on(CUE, MOVING, table=BOUNDED, cushion="han2005", cushion_height=0.03),
    "cushions that integrate": on(
        CUE, MOVING, table=BOUNDED, t_max=0.5, cushion="mathavan2010", cushion_height=0.03
    ),
    "one falls on another": on(ALOFT, UNDER, airborne=True, table_restitution=0.5, t_max=0.3),
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_a_shot_of_unequal_balls_is_the_same_by_every_path(scene):
    result = simulate(scene, record="events")
    assert EventKind.BALL_BALL in result.events["kind"]
    assert is_promised(scene)  # otherwise the renumbered scene would be skipped
    assert image(scene, "diagonal") != scene
    assert differences(scene, ("sampled", "invariants", "cells", "renumbered", "mirrored")) == {}


PUSHES = {
    "a large one pushes a small one": pushing_pair((R, S), (0.25, 0.0625)),
    "a small one pushes a large one": pushing_pair((S, R), (0.0625, 0.25)),
    "one pushes a row of two": on(
        ball((0.0, 0.0), radius=R, mass=0.25, angular_velocity=(0.0, 100.0, 0.0)),
        ball((R + S, 0.0), radius=S, mass=0.0625),
        ball((R + 3.0 * S, 0.0), radius=S, mass=0.125),
    ),
}


@pytest.mark.parametrize("scene", PUSHES.values(), ids=PUSHES)
def test_a_push_of_unequal_balls_ends_alike_when_renumbered_or_mirrored(scene):
    """The tolerance is 1e-10 m, because contact steps find forces by iteration."""
    result = simulate(scene)
    assert result.work["contact_steps"] > 5
    order = list(range(len(scene.balls)))[::-1]
    other = simulate(shuffled(scene, order))
    assert other.rest_positions == pytest.approx(result.rest_positions[order], abs=1e-10)
    for name, (plane, _) in MAPS.items():
        found = simulate(image(scene, name)).rest_positions
        x, y = plane(*result.rest_positions[:, :2].T)
        assert found[:, :2] == pytest.approx(np.column_stack((x, y)), abs=1e-10)

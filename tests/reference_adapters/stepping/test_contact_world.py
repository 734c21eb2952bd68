"""Contacts of a step are collisions if they were inactive before."""

from __future__ import annotations

import numpy as np
import pytest
from shots import ball, scene_of

from ghostball.reference_adapters.stepping.contact_world import (
    SINGLE_PRECISION_NOISE,
    ContactWorld,
    collision_of,
    tuples_of,
)
from ghostball.reference_adapters.stepping.plane import Collision

PAIR, RAIL = Collision(0, 1, cushion=False), Collision(1, 2, cushion=True)


@pytest.fixture
def world() -> ContactWorld:
    scene = scene_of(*(ball((float(k), 0.0), (1.0, 0.0)) for k in range(3)))
    return ContactWorld(scene, noise=SINGLE_PRECISION_NOISE, rubs=False)


def test_a_contact_that_lasts_is_one_collision(world):
    found = []
    for pushing, near in (
        ({PAIR}, set()),
        ({PAIR, RAIL}, set()),
        ({RAIL}, {PAIR}),  # rounding: inactive during one step
        ({PAIR}, set()),
        (set(), set()),
        ({PAIR}, set()),
    ):
        world._note(pushing, near)
        found.append(world.collisions)
    assert found == [[PAIR], [RAIL], [], [], [], [PAIR]]
    assert world.contacts_solved == 6


def test_what_nothing_pushed_keeps_the_velocity_that_it_was_given(world):
    world._note({PAIR})
    rounded = np.full((3, 2), 0.5)
    assert world._kept(rounded).tolist() == [[0.5, 0.5], [0.5, 0.5], [1.0, 0.0]]
    assert world._turned(np.ones((3, 3)))[2].tolist() == [0.0, 0.0, 0.0]


def test_of_two_parts_the_ball_comes_first_and_of_two_balls_the_first():
    assert collision_of((2, True), (1, False)) == RAIL
    assert collision_of((1, False), (0, False)) == PAIR


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_vectors_of_coming_steps_become_tuples(dtype):
    vectors = np.arange(24, dtype=dtype).reshape(4, 3, 2)
    found = tuples_of(vectors)
    assert found == [tuple(map(tuple, step)) for step in vectors.tolist()]
    assert isinstance(found[0], tuple)

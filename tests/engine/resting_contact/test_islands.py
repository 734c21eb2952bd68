"""Islands of balls in resting contact: numbering doesn't matter, and all forces are found."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest
from islands import kept_shot, largest_overlap
from same.images import rows_of, shuffled

from ghostball.engine import simulate
from ghostball.model import Status


@pytest.mark.parametrize(
    "name",
    [
        "squeezed-pair",  # one is hit, while another rests on a cushion
        "three-in-a-corner",  # two pairs come into resting contact at one instant
        "five-in-contact",  # a cushion collision parts an island, and two of it stop at one instant
        "unequal-joint-impact",
        "two-at-one-cushion",
    ],
)
@pytest.mark.compiled
def test_the_numbering_of_the_balls_does_not_matter(name):
    base = kept_shot(name)
    orders = list(itertools.permutations(range(len(base.scene.balls))))
    for order in random.Random(0).sample(orders, min(len(orders), 6)):
        other = simulate(shuffled(base.scene, order), record="events")
        assert rows_of(other, order) == rows_of(base, range(len(order)))
        assert np.array_equal(other.rest_positions, base.rest_positions[list(order)])


@pytest.mark.parametrize(
    "name",
    [
        "heavy-on-light-at-cushion",  # 17 times as heavy
        "light-between-heavy-and-cushion",  # 200 times
        "thrown-back-to-cushion",  # by the impulse that ends the island's approach
        "hard-to-roll",  # rolling friction above sliding friction
        pytest.param("slip-ended-by-impulse", marks=pytest.mark.compiled),
        pytest.param("all-but-wedged", marks=pytest.mark.compiled),
        pytest.param("wedged-by-a-millionth", marks=pytest.mark.compiled),
    ],
)
def test_an_island_is_solved_without_overlap(name):
    result = kept_shot(name)
    assert result.work["contact_steps"] > 0
    assert result.work["unsolved_contact_steps"] == 0
    assert largest_overlap(result) <= 1e-12
    assert np.max(np.diff(result.energy(result.events["t"]).total)) <= 0.0


@pytest.mark.slow
@pytest.mark.compiled
def test_a_contact_that_jams_at_a_cushion_comes_to_rest():
    """Friction 1 at the cushion, 0.2 between balls, one 17 times as heavy.

    Where friction jumped between sticking and slipping no force was a solution: ever shorter steps
    with ever greater forces gained energy, and the clock stood still.
    """
    result = kept_shot("jammed-at-cushion")
    assert result.status is Status.REST
    assert result.work["unsolved_contact_steps"] == 0
    assert largest_overlap(result) <= 1e-12
    energy = result.energy(result.events["t"]).total
    assert np.max(np.diff(energy)) <= 1e-12 * energy[0]

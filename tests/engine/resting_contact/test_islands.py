"""Tests of islands in resting contact: numbering has no effect, and all forces are found."""

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
        "squeezed-pair",  # one ball is hit while another touches a cushion
        "three-in-a-corner",  # two pairs come into resting contact simultaneously
        "five-in-contact",  # a cushion collision splits an island, and two balls stop at once
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
        "heavy-on-light-at-cushion",  # mass ratio 17
        "light-between-heavy-and-cushion",  # mass ratio 200
        "thrown-back-to-cushion",  # the impulse that ends the island's approach throws it back
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
    """Friction is 1 at the cushion and 0.2 between the balls; one ball has 17 times the mass.

    If friction jumped between sticking and slipping, no force was a solution: steps became shorter
    and forces larger without limit, energy increased, and the clock stood still.
    """
    result = kept_shot("jammed-at-cushion")
    assert result.status is Status.REST
    assert result.work["unsolved_contact_steps"] == 0
    assert largest_overlap(result) <= 1e-12
    energy = result.energy(result.events["t"]).total
    assert np.max(np.diff(energy)) <= 1e-12 * energy[0]

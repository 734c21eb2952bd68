"""Islands of balls in resting contact: numbering doesn't matter, and all forces are found."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest
from same.images import rows_of, shuffled
from shots import kept_scene

from ghostball.engine import simulate
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.resting_contact import paths
from ghostball.model import Result, Status


def shot(name: str) -> Result:
    result = simulate(kept_scene(name), record="events", max_events=100_000)
    assert result.status is Status.REST, result.reason
    return result


def largest_overlap(result: Result) -> float:
    """Return how far [m] a ball goes into another or beyond a cushion, at and between events."""
    assert result.trajectory is not None
    starts = np.unique(np.concatenate([k[:, 0] for k in result.trajectory.segments]))
    times = np.union1d(starts, 0.5 * (starts[1:] + starts[:-1]))
    places, radii = result.sample(times).positions[:, :, :2], result.scene.radii
    gaps = [
        np.min(np.hypot(*(places[:, i] - places[:, j]).T) - radii[i] - radii[j])
        for i, j in itertools.combinations(range(len(radii)), 2)
    ]
    table = result.scene.table
    if table is not None:
        far = np.array([table.length, table.width])
        room = np.minimum(places, far - places) - radii[:, np.newaxis]
        gaps.append(np.min(room))
    return -min(gaps)


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
    base = shot(name)
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
    result = shot(name)
    assert result.work["contact_steps"] > 0
    assert result.work["unsolved_contact_steps"] == 0
    assert largest_overlap(result) <= 1e-12
    assert np.max(np.diff(result.energy(result.events["t"]).total)) <= 0.0


@pytest.mark.skipif(COMPILED, reason="what is compiled can't be replaced")
def test_a_motion_of_too_many_pieces_is_followed_less_far(monkeypatch):
    """Breaks where it gets fewer pieces than its gaps ask for."""
    far = shot("squeezed-pair")
    monkeypatch.setattr(paths, "_MOST_PIECES", 4)
    near = shot("squeezed-pair")
    assert near.work["contact_steps"] > far.work["contact_steps"]
    assert largest_overlap(near) <= 1e-12
    assert near.rest_positions == pytest.approx(far.rest_positions, rel=0.0, abs=1e-7)


@pytest.mark.slow
@pytest.mark.compiled
def test_a_contact_that_jams_at_a_cushion_comes_to_rest():
    """Friction 1 at the cushion, 0.2 between balls, one 17 times as heavy.

    Where friction jumped between sticking and slipping no force was a solution: ever shorter steps
    with ever greater forces gained energy, and the clock stood still.
    """
    result = shot("jammed-at-cushion")
    assert result.status is Status.REST
    assert result.work["unsolved_contact_steps"] == 0
    assert largest_overlap(result) <= 1e-12
    energy = result.energy(result.events["t"]).total
    assert np.max(np.diff(energy)) <= 1e-12 * energy[0]

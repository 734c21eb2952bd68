"""Tests that both schedulers, cells and a bound for every pair, give bit-identical results."""

import numpy as np
import pytest
from many_balls import alike, by_both, many_balls
from recorded import fingerprint
from shots import R, random_shot

from ghostball.model import EventKind, Table
from ghostball.validation.runs.sampling import overlaps_of_balls

SLIDES = {
    "motion": "sliding",
    "ball_restitution": 0.95,
    "ball_friction": 0.06,
    "cushion": "restitution",
    "cushion_restitution": 0.8,
}


@pytest.mark.compiled
@pytest.mark.parametrize("spread", [1.0, 4.0])
def test_cells_give_the_same_bits(spread, monkeypatch):
    """Use more balls than random scenes have; the stress suite tests random scenes."""
    scene = many_balls(60, 0.5, t_max=1.0, rolling_friction=0.0, spread=spread)
    paired, celled = by_both(scene, monkeypatch)
    assert len(paired.events) > 100
    assert fingerprint(paired) == fingerprint(celled)
    assert paired.work["cell_moves"] == 0 < celled.work["cell_moves"]


GASES = {
    "points": {"motion": "rolling", "rolling_friction": 0.01, "ball_restitution": 0.95},
    "sliding": SLIDES,
    "in-air": SLIDES | {"air_drag": 0.05, "t_max": 0.25},
}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("physics", GASES.values(), ids=GASES)
def test_a_small_gas_in_cells_has_the_same_bits_and_no_overlap(physics, seed, monkeypatch):
    """The balls have many sizes, and are so dense that bounds are advanced many times."""
    table = Table(length=0.8, width=0.5)
    scene = random_shot(2 * seed, 14, table=table, **({"t_max": 2.0} | physics))
    paired, celled = by_both(scene, monkeypatch)
    assert celled.work["cell_moves"] >= 10
    assert fingerprint(paired) == fingerprint(celled)
    times = np.linspace(0.0, celled.rest_time, 400)
    here = np.ones((400, 14), dtype=np.bool_)
    deepest = overlaps_of_balls(scene, celled.sample(times).positions, here).max()
    assert deepest <= 1e-12


@pytest.mark.compiled
@pytest.mark.parametrize("spin", [(0.0, 0.0, 0.0), (3.0, 7.0, 20.0)])
def test_events_of_several_kinds_that_tie_have_the_same_order(monkeypatch, spin):
    """Slides end, and rolls end, at the same time."""
    velocities, spins = np.full((128, 2), (1.0, 0.0)), np.full((128, 3), spin)
    velocities[1::3], spins[1::3] = (0.3, 0.0), (0.0, 0.3 / R, 0.0)  # rolls
    paired, celled = by_both(alike(velocities, spins, preset="pool"), monkeypatch)
    assert len(paired.events) >= 128
    assert fingerprint(paired) == fingerprint(celled)


def test_an_event_of_a_lesser_kind_that_ties_later_comes_before_the_others(monkeypatch):
    """Each slide ends with the ball at rest, before the other slides of the same time end."""
    count, spin = 5, -2.5 / R * (1.0 + 2.0**-52)
    scene = alike(
        np.full((count, 2), (1.0, 0.0)),
        np.full((count, 3), (0.0, spin, 0.0)),
        preset="pool",
        sliding_friction=1e-2,
    )
    paired, celled = by_both(scene, monkeypatch)
    kinds = [EventKind.SLIDE_TO_ROLL, EventKind.ROLL_TO_REST] * count
    assert [EventKind(kind) for kind in celled.events["kind"]] == kinds
    assert fingerprint(paired) == fingerprint(celled)

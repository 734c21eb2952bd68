"""Breaks: each number has one reproducible break of its setup; counts have standard errors."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import POOL_BALL_RADIUS, Physics
from ghostball.reference_adapters import make_engine
from ghostball.validation.measured.breaks import (
    BreakCounts,
    Starts,
    break_physics,
    count_breaks,
    counts_of_results,
    fallen,
    inputs,
    setup_of,
    setups,
    starts_of,
    values_of,
)
from ghostball.validation.measured.facts import binomial_error, facts_of
from ghostball.validation.measured.table_agreement import BREAKS, MeasuredEngine, families_of

FIRST = setups()[0]


def physics(**changed: float) -> Physics:
    fields = break_physics("ghostball", make_engine("ghostball").capabilities, values_of(**changed))
    assert fields is not None
    return Physics(**fields)


def starts(name: str, count: int, **changed: float) -> Starts:
    return starts_of(setup_of(name), physics(**changed), values_of(**changed), count)


@pytest.mark.parametrize("setup", setups())
def test_a_break_is_the_same_however_many_are_made_and_hits_what_it_aims_at(setup):
    few, many = (starts(setup.name, count) for count in (2, 5))
    for one, other in zip(few[1:], many[1:], strict=True):
        assert np.array_equal(one, other[:2])
    places, velocities = many.positions, many.velocities[:, 0]
    way = velocities / np.linalg.norm(velocities, axis=1)[:, None]
    to_target = places[:, 1 + setup.target] - places[:, 0]
    beside = way[:, 0] * to_target[:, 1] - way[:, 1] * to_target[:, 0]
    assert -beside / POOL_BALL_RADIUS == pytest.approx(np.full(5, setup.offset), abs=0.3)
    on_spot = places[:, 1 + setup.on_spot]
    table = many.scene.table
    assert on_spot == pytest.approx(
        np.tile([0.75 * table.length, 0.5 * table.width], (5, 1)), abs=2e-5
    )
    assert table.pockets.corner.mouth == setup.mouth


@pytest.mark.parametrize(("name", "beside"), [("aside", 0.37), ("offset", 0.15), ("side", -0.2)])
def test_an_input_of_a_setup_changes_only_setups_that_have_it(name, beside):
    assert getattr(setup_of("8-ball, second ball"), name) == beside
    for setup, changes in (("8-ball, first ball", False), ("8-ball, second ball", True)):
        one, other = starts(setup, 1), starts(setup, 1, **{name: 0.05})
        same = all(np.array_equal(a, b) for a, b in zip(one[1:], other[1:], strict=True))
        assert same is not changes


def test_every_input_changes_breaks_of_some_setup():
    for one in inputs():
        changed = {one.name: one.value + one.error}
        same = [
            physics(**changed) == physics()
            and starts(setup.name, 2, **changed).scene == starts(setup.name, 2).scene
            and all(
                np.array_equal(a, b)
                for a, b in zip(
                    starts(setup.name, 2, **changed)[1:], starts(setup.name, 2)[1:], strict=True
                )
            )
            for setup in setups()
        ]
        assert not all(same), one.name


def test_breaks_as_arrays_are_breaks_as_scenes():
    begun = starts(FIRST.name, 4)
    fell = [fallen(simulate(scene, record="events")) for scene in begun.scenes()]
    assert counts_of_results(FIRST, fell) == count_breaks(FIRST, begun)


def test_what_fell_is_counted():
    eight = FIRST.ids.index("8")
    fell = np.zeros((4, 16), dtype=np.bool_)
    fell[0, 0] = True  # the cue ball
    fell[1, [0, 3]] = True  # the cue ball and an object ball
    fell[2, [6, eight]] = True
    assert BreakCounts.of(fell, eight) == (4, 2, 1, 2, 1, 3)


def test_the_error_of_a_share_is_that_of_counting():
    assert binomial_error(800, 1000) == pytest.approx(math.sqrt(0.8 * 0.2 / 1000), rel=1e-3)
    assert 0.0 < binomial_error(0, 50) < binomial_error(1, 50)
    assert facts_of("breaks-made").rows[0].error == pytest.approx(0.036, abs=0.001)


def families(spec: str, facts: str):
    engine = make_engine(spec)
    play = partial(engine.simulate, record="trajectory")
    return families_of(facts, MeasuredEngine(engine, play))


def test_breaks_with_impacts_that_last_are_like_measured_ones():
    (made,) = families("ghostball", "breaks-made")
    assert made.settings["impacts"] == "compliant"
    assert [one.what for one in made.figures] == [one.name for one in setups()]
    assert made.is_within_known
    for one, row in zip(made.figures, facts_of("breaks-made").rows, strict=True):
        counting = binomial_error(round(one.played * BREAKS), BREAKS)
        assert one.error == pytest.approx(math.hypot(row.uncertainty, counting))


def test_breaks_of_an_engine_without_batches_take_too_long():
    (family,) = families("pymunk", "breaks-made")
    assert "too long" in family.lacks
    (family,) = families("paper-discrete", "breaks-scratch")
    assert family.lacks == "it has no cushion law that changes spin"

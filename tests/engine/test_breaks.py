"""Breaks of sixteen balls, random over the whole physics: never stuck, never overlapping.

They are the crowded shots in which engines get stuck, explode or let balls pass through each other.
"""

from __future__ import annotations

import numpy as np
import pytest
from breaks import COMBINATIONS, assert_sound, break_scene, physics_of

from ghostball.engine import Status, simulate

ENOUGH_EVENTS = 20_000
"""Some fifty times what a break needs: more is a storm of contacts."""

FAST = range(40)
DENSE = range(1000, 1000 + len(COMBINATIONS))
MANY = range(len(FAST), len(FAST) + 3 * len(COMBINATIONS))
"""`ghostball stress` plays 500 others with its quick suite and 100 000 with its full one."""


def test_every_law_comes_round():
    assert len({repr(physics_of(seed)) for seed in range(len(COMBINATIONS))}) == len(COMBINATIONS)
    for field in ("ball_impact", "cushion", "ball_friction", "ball_restitution", "impacts"):
        values = {repr(physics.get(field)) for physics in COMBINATIONS}
        assert {repr(physics_of(seed).get(field)) for seed in FAST} == values


@pytest.mark.compiled
@pytest.mark.parametrize("seed", FAST)
def test_a_break_ends_at_rest_without_overlap_or_gain(seed):
    result = simulate(break_scene(seed), record="events", max_events=ENOUGH_EVENTS)
    assert_sound(result, between=12)


@pytest.mark.slow
@pytest.mark.compiled
def test_a_break_of_every_combination_sampled_densely():
    for seed in DENSE:
        result = simulate(break_scene(seed), record="events", max_events=ENOUGH_EVENTS)
        assert_sound(result, between=25)


@pytest.mark.slow
@pytest.mark.compiled
def test_many_breaks_have_no_storm_of_events():
    counts = []
    for seed in MANY:
        result = simulate(break_scene(seed), record="events", max_events=ENOUGH_EVENTS)
        assert result.status is Status.REST, f"seed {seed}: {result.status}: {result.reason}"
        try:
            assert_sound(result, between=0)
        except AssertionError as error:
            raise AssertionError(f"seed {seed}: {error}") from None
        counts.append(result.work["events"])
    print(f"events of a break: median {np.median(counts):.0f}, most {max(counts)}")
    assert max(counts) < 600

"""Run times: intervals by order statistics, slower only beyond doubt."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from ghostball.validation.baselines.regression import Timing
from ghostball.validation.baselines.timing import (
    SLOWER,
    compare_samples,
    median_interval,
    timing_of,
)


@pytest.mark.parametrize(
    ("count", "confidence", "ranks"),
    # Conover 1999, table A3 of the binomial distribution: the largest rank r with
    # 2 P(X < r) <= 1 - confidence, for X of n tosses of a coin.
    [
        (5, 0.95, None),
        (6, 0.95, (1, 6)),
        (8, 0.95, (1, 8)),
        (9, 0.95, (2, 8)),
        (15, 0.95, (4, 12)),
        (20, 0.95, (6, 15)),
        (10, 0.999, None),
        (11, 0.999, (1, 11)),
        (15, 0.999, (2, 14)),
        (1, 0.95, None),
        (0, 0.95, None),
    ],
)
def test_the_interval_of_a_median_is_that_of_the_tables(count, confidence, ranks):
    values = [float(k + 1) for k in range(count)]
    expected = (-math.inf, math.inf) if ranks is None else ranks
    assert median_interval(values, confidence) == expected
    assert median_interval(values[::-1], confidence) == expected


def test_few_samples_have_their_range_as_interval():
    assert timing_of([3.0, 1.0, 2.0]) == Timing(median=2.0, low=1.0, high=3.0, samples=3)


# --- by turns ---------------------------------------------------------------------------------


def test_what_is_slower_in_every_round_is_slower():
    change = compare_samples([1.0] * 15, [1.3] * 15)
    assert change.slower
    assert change.ratio == change.ratio_low == 1.3
    assert change.words == "1.30 times as slow, 1.30 at least"


@pytest.mark.parametrize("few", [1, 5, 10])
def test_few_rounds_leave_doubt_however_slow(few):
    change = compare_samples([1.0] * few, [9.0] * few)
    assert not change.slower
    assert change.ratio == 9.0
    assert math.isfinite(change.ratio_low)
    assert math.isfinite(change.ratio_high)


def test_two_rounds_that_were_not_slower_leave_doubt():
    # Of 15 rounds the interval of 999 in 1000 begins at the second: one stray round is noise.
    base = [1.0] * 15
    assert compare_samples(base, [1.0, *[2.0] * 14]).slower
    assert not compare_samples(base, [1.0, 1.0, *[2.0] * 13]).slower


def test_a_slow_moment_of_the_machine_hits_both_sides_of_a_round():
    base = [1.0 * (1 + k) for k in range(15)]
    change = compare_samples(base, base)
    assert change.ratio == change.ratio_low == change.ratio_high == 1.0
    assert not change.slower


def test_slower_than_the_threshold_means_more_than_it():
    assert not compare_samples([1.0] * 15, [SLOWER] * 15).slower


@given(st.lists(st.tuples(st.floats(0.1, 10), st.floats(0.1, 10)), min_size=1, max_size=30))
def test_both_ways_round_only_one_side_can_be_slower(pairs):
    base, head = zip(*pairs, strict=True)
    there, back = compare_samples(base, head), compare_samples(head, base)
    assert not (there.slower and back.slower)
    assert there.ratio_low <= there.ratio <= there.ratio_high


def test_a_round_that_one_side_lacks_is_a_bug():
    with pytest.raises(ValueError, match="zip"):
        compare_samples([1.0, 1.0], [1.0])

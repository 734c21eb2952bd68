"""The bands of metrics and counters, and which side of one is nearer to the truth."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given, strategies as st

from ghostball.validation.baselines.bands import (
    Band,
    band_of_counter,
    band_of_metric,
    direction,
    is_error,
)
from ghostball.validation.baselines.regression import Quantity
from ghostball.validation.checks.metric_table import METRICS


def quantity(name, base, head, *, low=None, high=None, level="error"):
    band = Band(low, high, level, "")
    return Quantity(
        name=name, unit="1", base=base, head=head, level=level, within=band.holds(head), why="."
    )


def test_a_count_may_not_move_at_all():
    for band in (band_of_metric("collision_count", {"collision_count": 5}), band_of_counter(5)):
        assert band.holds(5)
        assert not band.holds(4)
        assert not band.holds(6)
        assert band.level == "error"


def test_an_error_in_roundings_may_move_by_a_factor_or_by_some_of_them():
    many = band_of_metric("quality_factor", {"quality_factor": 100.0})
    assert (many.low, many.high) == (50.0, 200.0)
    few = band_of_metric("quality_factor", {"quality_factor": 0.5})
    assert (few.low, few.high) == (0.0, 4.5)


def test_an_error_in_metres_may_move_as_far_as_the_same_one_in_roundings():
    # In a chaotic shot the last bits decide its leading digits: only the roundings mean something.
    metrics = {"rest_error_max": 1e-3, "rest_error_ulps": 100.0}
    band = band_of_metric("rest_error_max", metrics)
    assert (band.low, band.high) == pytest.approx((0.5e-3, 2e-3))
    alone = band_of_metric("rest_error_max", {"rest_error_max": 1e-3})
    assert (alone.low, alone.high) == (0.5e-3, 2e-3)


def test_an_error_of_nothing_may_become_a_few_roundings_and_no_more():
    band = band_of_metric("rest_error_max", {"rest_error_max": 0.0, "rest_error_ulps": 0.0})
    assert band.holds(1e-15)
    assert not band.holds(1e-14)


@example("ball_ball_count", 0.0, 2.225073858507e-311)
@given(
    st.sampled_from(sorted(METRICS)),
    st.floats(0.0, 1e6, allow_nan=False),
    st.floats(0.0, 1e6, allow_nan=False),
)
def test_every_metric_lies_in_the_band_that_is_made_from_it(name, value, roundings):
    # Else accepting would write a baseline that is refused when it is read.
    metrics = {"rest_error_ulps": roundings, name: value}
    assert band_of_metric(name, metrics).holds(metrics[name])


def test_a_band_has_no_place_for_nothing_and_for_what_is_no_number():
    for band in (Band(None, None, "error", ""), Band(0.0, 1.0, "error", "")):
        assert not band.holds(None)
    assert not Band(0.0, 1.0, "error", "").holds(math.nan)


@pytest.mark.parametrize(
    ("name", "base", "head", "expected"),
    [
        ("rest_error_max", 1.0, 3.0, -1),
        ("rest_error_max", 3.0, 1.0, 1),
        ("events_missing", 0, 1, -1),
        ("matching_events", 3, 2, -1),
        ("matching_events", 3, 4, 1),
        ("collision_count", 3, 4, 0),  # neither side is right by itself
        ("energy_drift", 0.0, 1.0, 0),
        ("rest_error_max", None, 1.0, 0),
        ("rest_error_max", 1.0, None, 0),
    ],
)
def test_only_truth_says_which_side_is_nearer(name, base, head, expected):
    assert direction(quantity(name, base, head, low=base, high=base)) == (
        0 if base is None else expected
    )


def test_within_the_band_or_switched_off_nothing_has_a_direction():
    assert direction(quantity("rest_error_max", 1.0, 1.5, high=2.0)) == 0
    assert direction(quantity("rest_error_max", 1.0, 9.0, high=2.0, level="off")) == 0


def test_which_metrics_are_errors():
    # A metric of another kind that is compared with truth must say in which direction it is better.
    others = {name for name, one in METRICS.items() if one.compares and not is_error(one)}
    assert others == {
        "matching_events",
        "first_divergence_time",
        "energy_difference_time",
        "graded_until",
        "graded_events",
    }

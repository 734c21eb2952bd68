"""What a change is called: made up from a small run, one part replaced at a time."""

from __future__ import annotations

import math
from dataclasses import replace

import gate
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ghostball.model import EventKind
from ghostball.validation.baselines.classify import classify
from ghostball.validation.baselines.observed import KEPT_EVENTS
from ghostball.validation.grading.tolerances import ROUNDINGS
from ghostball.validation.scenes.library import find_scene

SHOT = gate.cut_shot()
BASE = gate.observed(SHOT)
ULP = 2.0**-52


def of(head, base=BASE, **changes):
    """Compare with so much explained by rounding as `changes` say, 1e-12 of everything else."""
    explained = gate.allowance(len(head.events), balls=len(head.ids), **changes)
    return classify(base, head, gate.bands_of(base), lambda: explained)


def with_metrics(run, **values):
    """Return a run with some other metrics."""
    return replace(run, metrics={**run.metrics, **values})


def shifted(run, index, by):
    """Return a run whose event comes later by so much [s]."""
    events = run.events.copy()
    events["t"][index] += by
    return gate.with_events(run, events)


# --- identical --------------------------------------------------------------------------------


def test_the_same_bits_are_identical_and_cost_no_other_run():
    def never():
        raise AssertionError("the allowance costs a run, and nothing differs")

    change = classify(BASE, BASE, gate.bands_of(BASE), never, "ghostball ...")
    assert change.change == "identical"
    assert not change.failed
    assert change.first_difference is None
    assert change.summary == "the same bits"
    assert change.base_hash == change.head_hash == BASE.bits
    assert {one.name for one in change.metrics} == set(BASE.metrics)
    assert {one.name for one in change.counters} == set(BASE.work)
    assert all(one.within for one in (*change.metrics, *change.counters))


@given(st.floats(0.2, 3.0), st.floats(-6.0, 6.0))
@settings(max_examples=15)
def test_what_is_worse_one_way_is_better_the_other_way(speed, octaves):
    # The band of an error is a factor of 2 in both directions, where it is many roundings.
    scene = gate.cut_shot(speed)
    run = with_metrics(gate.observed(scene), rest_error_ulps=100.0)
    assert gate.compared(run, run, scene).change == "identical"
    other = gate.observed(gate.cut_shot(speed + 0.01), like=scene)
    other = with_metrics(other, rest_error_ulps=100.0, rest_error_max=1e-12 * 2.0**octaves)
    pair = of(other, run).change, of(run, other).change
    if abs(abs(octaves) - 1.0) < 1e-9:
        return  # on the edge the last bit decides
    if abs(octaves) < 1.0:
        assert pair == ("results-changed", "results-changed")
    else:
        assert pair == (("worse", "better") if octaves > 0 else ("better", "worse"))


# --- rounding ---------------------------------------------------------------------------------


def test_another_last_bit_is_rounding_only_and_fails():
    # It fails all the same: our engine promises its bits, so someone must accept it with a reason.
    head = shifted(BASE, 0, ULP)
    change = of(head)
    assert change.change == "rounding-only"
    assert change.failed
    assert change.first_difference.index == 0
    assert "2.22e-16 s later" in change.first_difference.words
    relaxed = replace(gate.bands_of(BASE), hash_level="warn")
    explained = gate.allowance(len(head.events))
    assert not classify(BASE, head, relaxed, lambda: explained).failed


def test_a_speed_changed_by_1e9th_is_no_rounding():
    # Would be called rounding if the allowance were 10^5 times too wide.
    head = gate.observed(gate.cut_shot(1.0 + 1e-9), like=SHOT)
    change = gate.compared(BASE, replace(head, scene_hash=BASE.scene_hash), gate.cut_shot(1 + 1e-9))
    assert change.change == "results-changed"
    assert change.failed
    first = change.first_difference
    assert first.index == 0
    assert first.before_horizon
    assert first.words.startswith("event 0: cue meets object")
    assert "cue meets object" in first.words
    assert "sooner" in first.words
    assert first.words in change.summary


def test_an_end_that_moved_alone_is_reported_without_an_event():
    places = BASE.rest_positions + np.array([[0.0, 0.0, 0.0], [1e-6, 0.0, 0.0]])
    change = of(gate.at_rest(BASE, places))
    assert change.change == "results-changed"
    assert change.first_difference is None
    assert "object rests 1e-06 m from where it did" in change.summary
    change = of(gate.at_rest(BASE, BASE.rest_positions + ULP))
    assert change.change == "rounding-only"


# --- events -----------------------------------------------------------------------------------


def test_an_event_that_is_no_more_is_named():
    change = of(gate.with_events(BASE, np.delete(BASE.events, 1)))
    first = change.first_difference
    assert change.change == "results-changed"
    assert first.index == 1
    assert first.words.startswith("event 1: ")
    assert first.words.endswith("is no more")


def test_an_event_that_was_not_there_is_named():
    extra = gate.log((0.9, EventKind.BALL_CUSHION, 1, 3))
    events = np.concatenate([BASE.events, extra])
    change = of(gate.with_events(BASE, events[np.argsort(events["t"])]))
    first = change.first_difference
    assert change.change == "results-changed"
    assert "object meets the top cushion at 0.9 s comes 1.74 s sooner" in first.words


def test_an_event_of_other_balls_that_was_not_there_is_named():
    extra = gate.log((0.9, EventKind.BALL_CUSHION, 1, 0))
    events = np.concatenate([BASE.events, extra])
    first = of(gate.with_events(BASE, events[np.argsort(events["t"])])).first_difference
    assert "object meets the left cushion at 0.9 s was not there before" in first.words


def test_the_order_of_events_of_one_instant_is_a_convention():
    tied = [(1.0, EventKind.BALL_BALL, 0, 1), (1.0, EventKind.BALL_BALL, 2, 3)]
    base = gate.with_events(BASE, gate.log(*tied))
    change = of(gate.with_events(BASE, gate.log(*reversed(tied))), base)
    assert change.change == "rounding-only"
    # ... not where they share a ball, or are apart.
    shared = [(1.0, EventKind.BALL_BALL, 0, 1), (1.0, EventKind.BALL_BALL, 1, 2)]
    base = gate.with_events(BASE, gate.log(*shared))
    assert of(gate.with_events(BASE, gate.log(*reversed(shared))), base).change == "results-changed"


# --- past the horizon -------------------------------------------------------------------------


def test_past_the_horizon_nothing_is_compared():
    head = shifted(BASE, 2, 0.01)
    instant = float(BASE.events["t"][2])
    before, after = (of(head, horizon=instant + by, rest=None) for by in (-0.005, 0.005))
    assert before.change == "rounding-only"
    assert "nothing is compared past the horizon" in before.summary
    assert before.horizon == instant - 0.005
    assert not before.first_difference.before_horizon
    assert after.change == "results-changed"
    assert after.first_difference.before_horizon
    assert before.failed
    assert after.failed


@pytest.mark.parametrize("name", ["chaos-a", "chaos-b"])
def test_an_ulp_of_a_chaotic_shot_is_rounding_up_to_its_horizon(name):
    scene = find_scene(name)
    cue, *others = scene.balls
    vx, vy, _ = cue.velocity
    moved = cue.model_copy(update={"velocity": (math.nextafter(vx, 9.0), vy, 0.0)})
    near = scene.model_copy(update={"balls": (moved, *others)})
    base, head = gate.observed(scene), gate.observed(near, like=scene)
    change = gate.compared(base, head, near)
    assert change.change == "rounding-only", change.summary
    assert change.horizon is not None
    assert np.max(np.abs(base.rest_positions - head.rest_positions)) > 1e-6, "not chaotic"
    # 1e-7 of the speed is seen even there.
    moved = cue.model_copy(update={"velocity": (vx * (1 + 1e-7), vy, 0.0)})
    far = scene.model_copy(update={"balls": (moved, *others)})
    change = gate.compared(base, gate.observed(far, like=scene), far)
    assert change.change == "results-changed"
    assert change.first_difference.before_horizon


# --- logs longer than what is kept ------------------------------------------------------------

LONG = 5 * KEPT_EVENTS


def long_run(count=LONG):
    return gate.with_events(BASE, gate.long_log(count))


def test_a_long_log_is_identical_to_its_baseline():
    assert of(long_run(), gate.as_accepted(long_run())).change == "identical"


@pytest.mark.parametrize("index", [KEPT_EVENTS, 2 * KEPT_EVENTS, LONG - 1])
def test_another_event_beyond_what_is_kept_is_reported(index):
    base = gate.as_accepted(long_run())
    events = long_run().events.copy()
    events["b"][index] = 5
    change = of(gate.with_events(BASE, events), base)
    assert change.change == "results-changed"
    assert change.first_difference.index == KEPT_EVENTS
    assert change.first_difference.words.startswith(
        f"events from {KEPT_EVENTS} on come in another order (there were {LONG} events"
    )
    assert "`ghostball diff`" in change.summary


# --- against truth ----------------------------------------------------------------------------


CHANGED = shifted(BASE, 1, 1e-3)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({}, "results-changed"),
        ({"rest_error_max": 1e-11}, "worse"),
        ({"rest_error_max": 1e-14}, "results-changed"),  # within four roundings of what it was
        ({"rest_error_ulps": 20.0}, "worse"),
        ({"matching_events": 1}, "worse"),
        ({"matching_events": 3}, "better"),
        ({"matching_events": 3, "rest_error_max": 1.0}, "worse"),  # one that is worse decides
    ],
)
def test_truth_says_which_side_is_right(values, expected):
    change = of(with_metrics(CHANGED, **values))
    assert change.change == expected
    assert change.failed
    assert all(name in change.summary for name in values if expected != "results-changed")


@pytest.mark.parametrize(
    ("level", "change", "failed"),
    [
        ("error", "worse", True),
        ("warn", "worse", False),
        ("off", "identical", False),
    ],
)
def test_the_level_of_a_metric_decides_what_leaving_its_band_means(level, change, failed):
    bands = gate.bands_of(BASE)
    band = bands.metrics["rest_error_max"]._replace(level=level)
    bands = replace(bands, metrics={**bands.metrics, "rest_error_max": band})
    found = classify(BASE, with_metrics(BASE, rest_error_max=1.0), bands, lambda: None)
    assert (found.change, found.failed) == (change, failed)


@pytest.mark.parametrize(("level", "failed"), [("error", True), ("warn", False), ("off", False)])
def test_a_counter_that_moved_fails_as_its_level_says(level, failed):
    bands = gate.bands_of(BASE)
    band = bands.counters["events"]._replace(level=level)
    bands = replace(bands, counters={**bands.counters, "events": band})
    head = replace(BASE, work={**BASE.work, "events": BASE.work["events"] + 1})
    found = classify(BASE, head, bands, lambda: None)
    assert (found.change, found.failed) == ("identical", failed)
    assert ("events" in found.summary) == (level != "off")


def test_a_number_that_is_no_more_fails():
    head = replace(
        BASE,
        metrics={k: v for k, v in BASE.metrics.items() if k != "rest_error_max"},
        work={k: v for k, v in BASE.work.items() if k != "events"},
    )
    change = of(head)
    assert change.failed
    assert "rest_error_max 1e-12 m -> none" in change.summary
    assert "-> none" in change.summary.partition("rest_error_max")[2]
    assert change.change == "identical", "nobody knows in which direction"


def test_a_number_that_is_new_warns():
    head = replace(with_metrics(BASE, quality_factor=1.0), work={**BASE.work, "rocks": 3})
    change = of(head)
    assert (change.change, change.failed) == ("identical", False)
    new = [one for one in (*change.metrics, *change.counters) if not one.within]
    assert {one.name for one in new} == {"quality_factor", "rocks"}
    assert {one.level for one in new} == {"warn"}
    assert all("not measured" in one.why for one in new)


def test_errors_against_another_truth_are_not_compared_and_that_is_said():
    # Else a proof that is found no more would let every error pass in silence.
    change = of(replace(with_metrics(BASE, rest_error_max=1.0), truth="closed form"))
    assert (change.change, change.failed) == ("identical", False)
    (one,) = [one for one in change.metrics if one.name == "rest_error_max"]
    assert (one.level, one.within) == ("warn", False)
    assert "the truth was certified, and is closed form now" in one.why
    assert "rest_error_max" in change.summary


def test_another_scene_is_not_comparable_and_not_compared():
    change = classify(
        BASE, replace(CHANGED, scene_hash="0" * 64), gate.bands_of(BASE), lambda: None
    )
    assert change.change == "not-comparable"
    assert not change.failed
    assert not change.metrics


def test_an_end_within_its_band_that_moved_by_more_than_rounding_is_better_or_worse():
    # Breaks where a step's error that grows from 162 mm to 191 mm is only "changed".
    base = with_metrics(BASE, rest_error_max=0.162)
    moved = gate.at_rest(base, base.rest_positions + 0.03)
    farther = of(with_metrics(moved, rest_error_max=0.191), base)
    assert (farther.change, farther.failed) == ("worse", True)
    assert "rest_error_max 0.162 m -> 0.191 m" in farther.summary
    assert of(with_metrics(moved, rest_error_max=0.150), base).change == "better"
    assert of(with_metrics(moved, rest_error_max=0.162 + 1e-13), base).change == "results-changed"
    # Past the horizon no place says anything.
    lost = of(with_metrics(moved, rest_error_max=0.191), base, rest=None, horizon=0.1)
    assert lost.change != "worse"


def test_nothing_is_worse_that_moved_by_a_tiny_part_of_its_own_error():
    base = with_metrics(BASE, rest_error_max=1.5e-3)
    moved = gate.at_rest(base, base.rest_positions + 1e-6)
    assert of(with_metrics(moved, rest_error_max=1.5e-3 + 1e-6), base).change == "results-changed"
    assert of(with_metrics(moved, rest_error_max=1.5e-3 - 1e-6), base).change == "results-changed"
    # A tenth more is a regression.
    assert of(with_metrics(moved, rest_error_max=1.65e-3), base).change == "worse"


@pytest.mark.parametrize(("steps", "change"), [(0, "worse"), (5000, "rounding-only")])
def test_the_rounding_of_every_step_makes_nothing_worse(steps, change):
    # A ball along a rail ends 166 fm off; on another processor 900 fm, after 5000 steps.
    base = with_metrics(BASE, rest_error_max=1.66e-13, rest_error_ulps=300.0)
    head = gate.at_rest(base, base.rest_positions + 5e-13)
    head = with_metrics(head, rest_error_max=9e-13, rest_error_ulps=1600.0)
    explained = replace(
        gate.allowance(len(head.events), rest=4e-12), roundings=max(ROUNDINGS, steps)
    )
    assert classify(base, head, gate.bands_of(base), lambda: explained).change == change
    # What is more than all steps could round is worse all the same.
    worse = with_metrics(head, rest_error_max=1e-11, rest_error_ulps=20_000.0)
    assert classify(base, worse, gate.bands_of(base), lambda: explained).change == "worse"


@pytest.mark.parametrize(
    ("metric", "rest", "time", "within"),
    [
        ("rest_error_max", 1e-5, 1e-12, True),
        ("path_error", 1e-5, 1e-12, True),
        ("rest_error_max", 1e-12, 1e-5, False),
        ("rest_time_error", 1e-5, 1e-12, False),
        ("rest_time_error", 1e-12, 1e-5, True),
        ("energy_difference_max", 1e-5, 1e-5, False),
        ("energy_rise", 1e-5, 1e-5, False),
        ("energy_drift", 1e-5, 1e-5, False),
        ("overlap_max", 1e-5, 1e-5, False),
    ],
)
def test_rounding_explains_an_error_only_by_what_has_its_unit(metric, rest, time, within):
    # A displacement in metres explained a longer rest time and a larger share of energy.
    base = with_metrics(BASE, **{metric: 1e-6})
    head = with_metrics(gate.at_rest(base, base.rest_positions + 1e-13), **{metric: 5e-6})
    explained = replace(gate.allowance(len(head.events), rest=rest, time=time), roundings=5000.0)
    found = classify(base, head, gate.bands_of(base), lambda: explained)
    (one,) = (one for one in found.metrics if one.name == metric)
    assert one.within is within

"""The three rules of the comparison and their answers; each test changes a part of a small run."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import get_args

import gate
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from ghostball.model import Ball, EventKind
from ghostball.validation.baselines.baseline import KEPT_EVENTS
from ghostball.validation.baselines.compare import NEGLIGIBLE, compare
from ghostball.validation.baselines.compared_run import MotionNotKeptError
from ghostball.validation.baselines.regression import Answer
from ghostball.validation.results.records import OUR_ENGINE, Accuracy
from ghostball.validation.scenes.library import find_scene

SHOT = gate.cut_shot()
BASE = gate.played(SHOT)
ULP = 2.0**-52


def of(head, base=BASE, **explained):
    """Compare two runs; rounding explains `explained`, by default 1e-12 in each quantity."""
    allowed = gate.allowance(len(head.log().events), **explained)
    return compare(base, head, lambda: allowed)


def shifted(run, index, by):
    """Return a run in which event `index` comes later by `by` [s]."""
    events = run.log().events.copy()
    events["t"][index] += by
    return gate.with_events(run, events)


def with_another_collision(run):
    """Return a run with an additional collision at 0.9 s."""
    extra = gate.log((0.9, EventKind.BALL_CUSHION, 1, 0))
    events = np.concatenate([run.log().events, extra])
    return gate.with_events(run, events[np.argsort(events["t"])])


# --- the first rule: hash ---------------------------------------------------------------------


def test_the_same_hash_is_unchanged_and_costs_no_other_run():
    def never():
        raise AssertionError("read or played, and nothing differs")

    change = compare(
        gate.ComparedRun(BASE.record, never),
        gate.ComparedRun(BASE.record, never),
        never,
        "ghostball ...",
    )
    assert (change.change, change.summary, change.moved) == ("unchanged", "bit-identical", False)
    assert change.first_difference is None
    assert change.base_hash == change.head_hash == BASE.record.bits


def test_the_same_hash_is_unchanged_however_it_is_measured_now():
    head = gate.having(BASE, metrics={"rest_error_max": 1.0}, accuracy=Accuracy("exact", 0.0))
    change = of(head)
    assert (change.change, change.moved) == ("unchanged", False)
    assert [one.words for one in change.metrics] == [
        "rest_error_max 1e-12 -> 1.0 m",
        "matching_events 2 -> none",
    ]


def test_another_end_with_the_same_hash_is_a_change():
    assert of(gate.having(BASE, rest_time=9.0)).change == "changed"
    stopped = of(gate.having(BASE, status="t-max"))
    assert stopped.change == "changed"
    assert 'the run ended as "t-max" instead of "rest"' in stopped.summary


def test_counters_that_differ_are_named_and_new_ones_are_not():
    work = {**BASE.record.work, "events": 99, "rocks": 3}
    change = of(gate.having(BASE, work=work))
    assert (change.change, change.moved, change.words) == (
        "unchanged",
        True,
        "same result, different work counters",
    )
    (one,) = change.counters
    assert one.words == f"events {BASE.record.work['events']} -> 99"
    assert one.words in change.summary
    gone = {name: count for name, count in BASE.record.work.items() if name != "events"}
    assert of(gate.having(BASE, work=gone)).counters[0].words.endswith("-> none")


# --- the second rule: rounding ----------------------------------------------------------------


def test_another_last_bit_is_rounding():
    change = of(shifted(BASE, 0, ULP))
    assert change.change == "rounding"
    assert change.first_difference.index == 0
    assert "2.22e-16 s later" in change.first_difference.words


def test_a_speed_changed_by_1e9th_is_no_rounding():
    # Fails if the allowance is 10^5 times too wide: then the change counts as rounding.
    faster = gate.cut_shot(1.0 + 1e-9)
    change = gate.compared(BASE, gate.off(gate.played(faster, like=SHOT), 1e-9), faster)
    assert change.change == "worse"
    first = change.first_difference
    assert (first.index, first.before_horizon) == (0, True)
    assert first.words.startswith('event 0: "cue" hits "object" at ')
    assert first.words.endswith("s earlier")
    assert first.words in change.summary


def test_an_end_that_moved_alone_is_reported_without_an_event():
    places = BASE.record.rest_positions + np.array([[0.0, 0.0, 0.0], [1e-6, 0.0, 0.0]])
    change = of(gate.at_rest(BASE, places))
    assert (change.change, change.first_difference) == ("changed", None)
    assert "object rests 1 µm from its old position" in change.summary
    assert of(gate.at_rest(BASE, BASE.record.rest_positions + ULP)).change == "rounding"


def test_an_event_that_is_no_more_or_new_is_named():
    fewer = of(gate.with_events(BASE, np.delete(BASE.log().events, 1)))
    assert (fewer.change, fewer.first_difference.index) == ("changed", 1)
    assert ": missing: " in fewer.first_difference.words
    more = of(with_another_collision(BASE))
    assert 'new: "object" hits the left cushion at 0.9 s' in more.first_difference.words


def test_the_order_of_events_of_one_instant_is_a_convention():
    more = [Ball(id=str(k), position=(1.0 + 0.2 * k, 1.0)) for k in range(2)]
    four = gate.played(SHOT.model_copy(update={"balls": (*SHOT.balls, *more)}), accuracy=None)

    def ordered(*pairs):
        rows = [(1.0, EventKind.BALL_BALL, *pair) for pair in pairs]
        return gate.with_events(four, gate.log(*rows))

    def of(head, base):
        return compare(base, head, lambda: gate.allowance(2, balls=4))

    assert of(ordered((2, 3), (0, 1)), ordered((0, 1), (2, 3))).change == "rounding"
    # If events share a ball, their order is no convention.
    assert of(ordered((1, 2), (0, 1)), ordered((0, 1), (1, 2))).change != "rounding"


def test_past_the_horizon_nothing_is_compared():
    head = shifted(BASE, 2, 0.01)
    instant = float(BASE.log().events["t"][2])
    before, after = (of(head, horizon=instant + by, rest=None) for by in (-0.005, 0.005))
    assert (before.change, after.change) == ("rounding", "changed")
    assert "nothing is compared after the horizon" in before.summary
    assert before.horizon == instant - 0.005
    assert not before.first_difference.before_horizon
    assert after.first_difference.before_horizon


@pytest.mark.parametrize("name", ["chaos-a", "chaos-b"])
def test_an_ulp_of_a_chaotic_shot_is_rounding_up_to_its_horizon(name):
    scene = find_scene(name)
    cue, *others = scene.balls
    vx, vy, _ = cue.velocity
    moved = cue.model_copy(update={"velocity": (math.nextafter(vx, 9.0), vy, 0.0)})
    near = scene.model_copy(update={"balls": (moved, *others)})
    base, head = gate.played(scene), gate.played(near, like=scene)
    change = gate.compared(base, head, near)
    assert change.change == "rounding", change.summary
    assert change.horizon is not None
    assert np.max(np.abs(base.record.rest_positions - head.record.rest_positions)) > 1e-6
    # A change of the speed by 1e-7 isn't rounding, even in this shot.
    moved = cue.model_copy(update={"velocity": (vx * (1 + 1e-7), vy, 0.0)})
    far = scene.model_copy(update={"balls": (moved, *others)})
    change = gate.compared(base, gate.played(far, like=scene), far)
    assert change.change == "changed"
    assert change.first_difference.before_horizon


LONG = 5 * KEPT_EVENTS


@pytest.mark.parametrize("index", [KEPT_EVENTS, 2 * KEPT_EVENTS, LONG - 1])
def test_another_event_beyond_what_a_baseline_keeps_is_no_rounding(index):
    run = gate.with_events(BASE, gate.long_log(LONG))
    events = gate.long_log(LONG)
    assert of(gate.with_events(run, events), gate.as_accepted(run)).change == "unchanged"
    events["t"][index] += ULP * LONG
    assert of(gate.with_events(run, events), gate.as_accepted(run)).change == "rounding"
    events["b"][index] = 5
    assert of(gate.with_events(run, events), gate.as_accepted(run)).change == "changed"


# --- the third rule: error --------------------------------------------------------------------

MOVED = gate.at_rest(BASE, BASE.record.rest_positions + 0.03)
OTHER = Accuracy("another shot", at=0.5, agree=3, of=9)
BROKEN = Accuracy("broken", cause="energy", amount=1.0)


def right(error, kind="millimetres"):
    return Accuracy(kind, error=error)


@pytest.mark.parametrize(
    ("before", "now", "answer"),
    [
        (right(0.162), right(0.191), "worse"),
        (right(0.162), right(0.150), "better"),
        (right(0.162), right(0.162 * (1.0 + NEGLIGIBLE / 2.0)), "changed"),
        (right(0.162), right(0.162 * (1.0 - NEGLIGIBLE / 2.0)), "changed"),
        (right(1e-3), right(1.01e-3), "worse"),
        (right(1e-14, "exact"), right(5e-14, "exact"), "changed"),
        (right(1e-14, "exact"), right(1e-9, "nanometres"), "worse"),
        (right(0.162), OTHER, "wrong collisions"),
        (right(0.162), BROKEN, "worse"),
        (OTHER, right(0.2), "better"),
        (BROKEN, OTHER, "better"),
        (BROKEN, right(0.2), "better"),
        (BROKEN, BROKEN, "changed"),
        (OTHER, OTHER, "changed"),
        (OTHER, Accuracy("another shot", at=0.4, agree=2, of=9), "wrong collisions"),
        (OTHER, Accuracy("another shot", at=0.6, agree=4, of=9), "better"),
        (None, right(0.2), "changed"),
        (right(0.2), None, "changed"),
    ],
)
def test_the_error_says_which_is_better(before, now, answer):
    change = of(gate.having(MOVED, accuracy=now), gate.having(BASE, accuracy=before))
    assert change.change == answer
    assert change.change in get_args(Answer)
    if before is not None and now is not None:
        assert change.summary.startswith(f"{before.sentence} -> {now.sentence}; ")


@given(st.floats(1e-9, 1e-1), st.floats(-2.0, 2.0))
@settings(max_examples=25)
def test_what_is_worse_one_way_is_better_the_other_way(error, octaves):
    one, two = gate.off(BASE, error), gate.off(MOVED, error * 2.0**octaves)
    there, back = of(two, one).change, of(one, two).change
    opposite = {"worse": "better", "better": "worse", "changed": "changed"}
    if 0.9 < abs(2.0**octaves - 1.0) / NEGLIGIBLE < 1.1:
        return  # the difference may be negligible relative to one error only
    assert back == opposite[there]


def test_what_rounding_explains_makes_nothing_worse():
    # For a ball along a rail, the error is 166 fm; on another processor 900 fm, after 5000 steps.
    base = gate.off(BASE, 1.66e-13, "nanometres")
    head = gate.off(gate.at_rest(BASE, BASE.record.rest_positions + 5e-12), 9e-13, "nanometres")
    assert of(head, base, rest=4e-12).change == "changed"
    assert of(head, base, rest=1e-13).change == "worse"
    # After the horizon, rounding may move a ball by up to a millimetre.
    late = shifted(head, 0, 1e-3)
    assert of(gate.off(late, 9e-4), base, rest=None).change == "changed"
    assert of(gate.off(late, 2e-3), base, rest=None).change == "worse"


def test_errors_against_another_reference_are_not_compared():
    other = gate.having(gate.off(MOVED, 1.0), truth="closed form")
    change = of(other, gate.off(BASE, 1e-3))
    assert (change.change, change.base_error, change.head_error) == ("changed", None, None)
    assert of(gate.off(MOVED, 1.0), BASE).base_error == 1e-12


def proved(run, factor):
    return gate.having(run, accuracy=None, metrics={"quality_factor": factor})


WAS_BROKEN = gate.having(BASE, accuracy=BROKEN, truth="closed form")
EARLY = gate.having(BASE, accuracy=None)


@pytest.mark.parametrize(
    ("base", "head", "answer"),
    [
        # A run that became unphysical is worse, whatever was known about the baseline.
        (EARLY, gate.having(MOVED, accuracy=BROKEN), "worse"),
        (gate.having(EARLY, truth=None), gate.having(MOVED, accuracy=BROKEN), "worse"),
        (gate.having(BASE, truth="closed form"), gate.having(MOVED, accuracy=BROKEN), "worse"),
        (WAS_BROKEN, gate.having(MOVED, accuracy=BROKEN), "changed"),
        (WAS_BROKEN, gate.off(MOVED, 1e-3), "better"),
        # Without a reference result, the proved part decides, or else the collisions.
        (proved(BASE, 0.5), proved(MOVED, 1e6), "worse"),
        (proved(BASE, 1e6), proved(MOVED, 0.5), "better"),
        (proved(BASE, 0.5), proved(MOVED, 31.0), "changed"),
        (EARLY, with_another_collision(EARLY), "wrong collisions"),
        (EARLY, shifted(EARLY, 0, 1e-6), "changed"),
    ],
)
def test_the_answer_without_a_common_reference(base, head, answer):
    assert of(head, base).change == answer


def test_past_the_horizon_another_collision_is_rounding():
    assert of(with_another_collision(EARLY), EARLY, horizon=0.8, rest=None).change == "rounding"


def test_the_reference_itself_is_neither_better_nor_worse_but_an_unphysical_run_is_worse():
    ours = gate.having(BASE, accuracy=None, truth=OUR_ENGINE)
    other = gate.having(gate.off(MOVED, 1e-3), engine="pymunk", truth=ours.record.truth)
    other = gate.with_events(other, np.delete(BASE.log().events, 0))
    assert compare(ours, other).change == compare(other, ours).change == "changed"
    assert compare(ours, gate.having(other, accuracy=BROKEN)).change == "worse"


def test_two_engines_are_compared_by_their_errors_and_collisions_alone():
    other = gate.having(gate.off(MOVED, 1e-3), work={"steps": 9})
    change = compare(BASE, other)
    assert (change.change, change.counters) == ("worse", ())
    late = compare(BASE, gate.off(shifted(BASE, 0, 1e-3), 1e-3))
    assert (late.change, late.first_difference) == ("worse", None)
    fewer = gate.having(BASE, accuracy=OTHER)
    fewer = gate.with_events(fewer, np.delete(BASE.log().events, 0))
    change = compare(BASE, fewer)
    assert change.change == "wrong collisions"
    assert change.first_difference.words.startswith('event 0: missing: "cue" hits "object" at ')


def no_motion():
    raise MotionNotKeptError("its motion was not kept")


def test_runs_without_motion_are_compared_by_error_counts_and_status():
    def bare(run, **changes):
        return gate.ComparedRun(replace(run.record, **changes), no_motion)

    def never():
        raise AssertionError("an allowance needs events")

    base = bare(BASE, collision_counts={"ball-ball": 1})
    far = bare(gate.off(MOVED, 1e-3), collision_counts={"ball-ball": 3}, status="t-max")
    for allowance in (None, never):
        change = compare(base, far, allowance)
        assert (change.change, change.first_difference) == ("worse", None)
        assert "ball-ball collisions 1 -> 3" in change.summary
        assert 'the run ended as "t-max" instead of "rest"' in change.summary
        assert "events aren't compared" in change.summary
        assert change.rest_head != change.rest_base
    unknown = compare(bare(BASE, accuracy=None), bare(MOVED, accuracy=None))
    assert unknown.change == "changed"
    # If one run has motion, the runs are compared. Equal bits need no events.
    assert compare(BASE, far).change == "worse"
    assert compare(base, base).change == "unchanged"


# --- no answer, or no run ---------------------------------------------------------------------


def test_another_scene_is_not_comparable():
    change = compare(BASE, gate.played(gate.cut_shot(1.5)))
    assert (change.change, change.metrics) == ("not-comparable", ())
    assert "the scene itself has changed" in change.summary


def test_a_shot_that_is_not_finished_is_worse_than_one_that_is():
    lost = gate.having(BASE, outcome="failed", reason="planted", bits="")
    assert compare(BASE, lost).change == "worse"
    assert "did not run the scene: planted" in compare(BASE, lost).summary
    assert compare(lost, BASE).change == "better"
    assert compare(lost, lost).change == "unchanged"
    unable = gate.having(BASE, outcome="not-representable", bits="")
    assert compare(lost, unable).change == "changed"

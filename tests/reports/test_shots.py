"""A scene's runs are in the right order, and errors without meaning aren't shown as errors."""

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import GhostballError
from ghostball.reports.shots import (
    CHAOTIC,
    Run,
    Shot,
    distance_from,
    legend_text,
    load_shot,
    rest_error_text,
)
from ghostball.validation.checks.verdict import Verdict
from ghostball.validation.results.store import Motion
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes.library import find_scene


def test_runs_are_in_the_order_that_was_asked_for_and_drawn_ours_first(results):
    shot = load_shot(results, "break-7")
    assert [run.label for run in shot.runs] == results.labels
    assert shot.drawn[0] is shot.ours
    assert shot.ours.label == "ghostball"
    assert {run.label for run in shot.drawn} == {
        run.label for run in shot.runs if run.motion is not None
    }
    assert shot.has_many_balls
    with pytest.raises(GhostballError, match=r'no result for scene "none"\. Available: .*break-7'):
        load_shot(results, "none")


def test_a_shot_without_results_has_no_values(results):
    shot = Shot(load_shot(results, "stop").scene, (Run("pymunk", None, None),))
    assert (shot.drawn, shot.ours, shot.truth, shot.truth_positions) == ((), None, None, None)
    assert (shot.truth_counts, shot.end) == (None, "rest")
    assert rest_error_text(None) == ""


def test_an_error_that_nothing_judges_is_in_brackets_and_one_past_prediction_is_none(results):
    case = replace(results.case("stop", "pymunk"), horizon=None)
    judged = replace(case.checks[0], metric="rest_error_max", limit_kind="at_most", passed=True)
    case = replace(case, metrics=case.metrics | {"rest_error_max": 1e-3}, checks=(judged,))
    free = replace(case, checks=())
    shown = [rest_error_text(one) for one in (case, free, replace(free, horizon=1.0))]
    assert shown == ["1 mm", "(1 mm)", CHAOTIC]


def test_signs_are_explained_once_each():
    said = legend_text([Verdict.PASS, Verdict.FAIL, Verdict.PASS, Verdict.MISSING])
    assert said == f"✓ {Verdict.PASS.words}; ✗ {Verdict.FAIL.words}"


def sampled(result, times):
    times = np.asarray(times, dtype=np.float64)
    zeros = np.zeros(len(times))
    return Motion(result.events, times, *result.sample(times), zeros, zeros, zeros)


@pytest.mark.parametrize("name", ["half-ball-cut", "draw-shot", "around-the-table", "break-7"])
def test_a_motion_is_at_no_distance_from_itself_between_its_samples(name):
    result = simulate(find_scene(name), record="trajectory")
    reference = motion_of(result)
    between = np.linspace(0.0, result.rest_time, 3001)
    assert np.max(distance_from(reference, sampled(result, between))) < 1e-12


def test_a_shift_is_its_distance_and_past_the_end_the_balls_stay():
    result = simulate(find_scene("stop"), record="trajectory")
    reference = motion_of(result)
    other = sampled(result, [0.0, 1.0, result.rest_time, result.rest_time + 5.0])
    other.positions[:, 0, 1] += 0.25
    assert distance_from(reference, other) == pytest.approx(0.25)


def test_height_is_left_out():
    result = simulate(find_scene("stop"), record="trajectory")
    other = sampled(result, [0.0, 1.0])
    other.positions[:, 0, 2] += 1.0
    assert np.max(distance_from(motion_of(result), other)) < 1e-12

"""What is known of a run: the same from a run at hand and from a stored one."""

from __future__ import annotations

from dataclasses import fields, replace

import gate
import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import GhostballError
from ghostball.validation.baselines.observed import Observed, judged
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.metrics import measure
from ghostball.validation.results.store import Results
from ghostball.validation.suite.suite import run_suite
from ghostball.validation.truth.scene_truth import truth_of

SHOT = gate.cut_shot()


@pytest.fixture
def stored(tmp_path):
    """The shot as it is stored, and its motion."""
    run_suite([SHOT], ["ghostball"], tmp_path, criteria={"cut": Criteria(truth="certified")})
    results = Results.open(tmp_path)
    (case,) = results.cases
    return case, results.motion(case)


def test_a_stored_run_is_the_run_itself(stored):
    # Else `regress` and `regress --against` would call one change by two names.
    found = Observed.of_case(*stored)
    truth = truth_of(SHOT, "certified")
    result = simulate(SHOT, record="trajectory")
    metrics = judged(measure(result, truth).values, truth.kind)
    expected = replace(Observed.of_result(result), metrics=metrics, truth=truth.kind)
    for part in fields(Observed):
        one, two = getattr(found, part.name), getattr(expected, part.name)
        if isinstance(one, np.ndarray):
            assert one.tobytes() == two.tobytes(), part.name
        else:
            assert one == two, part.name
    assert found.metrics["rest_error_max"] < 1e-12
    assert "wall_time" not in found.metrics


def test_a_run_that_did_not_end_says_why(stored):
    case, motion = stored
    crashed = replace(case, rest_positions=None, reason="it crashed")
    with pytest.raises(GhostballError, match='"cut" did not run on `ghostball`: it crashed'):
        Observed.of_case(crashed, motion)


@pytest.mark.parametrize("truth", [None, "our engine (not independent)"])
def test_what_compares_our_engine_with_itself_says_nothing(truth):
    metrics = {"rest_error_max": 0.0, "quality_factor": 0.5, "collision_count": 3, "wall_time": 1.0}
    assert judged(metrics, truth) == {"quality_factor": 0.5, "collision_count": 3}
    assert "rest_error_max" in judged(metrics, "certified")


def test_what_has_no_value_is_left_out():
    assert judged({"rest_error_max": None, "collision_count": 0}, "certified") == {
        "collision_count": 0
    }

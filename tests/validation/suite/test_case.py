"""The record of a case has what its engine did, and whose fault a failure is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from suite_runs import scene

import ghostball.validation.suite.case
import ghostball.validation.suite.suite
from ghostball.model import Ball, Scene
from ghostball.reference_adapters import EngineUnavailableError, ReferenceEngine
from ghostball.validation.results.store import CaseRecord, Results
from ghostball.validation.suite.case import run_case
from ghostball.validation.suite.judge import Case
from ghostball.validation.suite.suite import run_suite
from ghostball.validation.truth.scene_truth import Truth

pytestmark = pytest.mark.usefixtures("fake_engines")


def by_label(cases: list[CaseRecord]) -> dict[str, CaseRecord]:
    return {case.label: case for case in cases}


def test_what_an_engine_cannot_do_is_said_with_the_reason(tmp_path: Path) -> None:
    outcome = run_suite([scene()], ["fake:does=refuse", "absent"], tmp_path)
    refused, absent = outcome.cases
    assert (refused.outcome, refused.reason) == (
        "not-representable",
        "no pure rolling (it slips)",
    )
    assert absent.outcome == "unavailable"
    assert "not installed here" in absent.reason
    assert outcome.exit_status == 4  # nothing was judged


def test_a_failure_is_kept_and_the_run_continues(tmp_path: Path) -> None:
    outcome = run_suite([scene()], ["fake:does=raise", "fake"], tmp_path)
    failed, fine = Results.open(tmp_path).cases
    assert (failed.outcome, failed.fault) == ("failed", "engine")
    assert "lost the" in failed.reason
    assert "Traceback" in failed.traceback
    assert (fine.outcome, fine.fault) == ("ran", "")
    assert outcome.exit_status == 1  # the engine failed, not Ghostball


@pytest.mark.parametrize("does", ["raise half a letter", "stop at half a letter"])
def test_an_engine_may_say_what_no_file_takes(tmp_path: Path, does: str) -> None:
    outcome = run_suite([scene()], [f"fake:does={does}"], tmp_path)
    (case,) = Results.open(tmp_path).cases
    assert r"lost \udcff" in case.reason
    assert (case.fault, outcome.exit_status) == ("engine" if "raise" in does else "", 1)


@pytest.mark.parametrize(
    ("does", "says"),
    [
        (
            "end elsewhere at rest",
            '`rest_positions` differ by 0.2 m between `record="rest"` and `record="trajectory"`',
        ),
        ("end later at rest", '`rest_time` differs by 0.25 s between `record="rest"` and'),
        (
            "count more at rest",
            "`collision_counts` differ ({'ball-ball': 3, 'ball-cushion': 0} and {'ball-ball': 0, "
            "'ball-cushion': 0}) between `record=\"rest\"` and",
        ),
        ("say other events", '`events` differ between `record="events"` and'),
    ],
)
def test_a_shot_that_depends_on_what_is_recorded_has_failed_once(
    tmp_path: Path, does: str, says: str
) -> None:
    balls = (*scene().balls, Ball(id="far", position=(9.0, 9.0)))
    two = Scene(name="two", balls=balls)
    outcome = run_suite([two, scene()], [f"fake:does={does}", "fake"], tmp_path)
    cases = {(case.scene, case.label): case for case in outcome.cases}
    failed = cases["roll", f"fake:does={does}"]  # the scene with the fewest balls
    assert (failed.outcome, failed.fault) == ("failed", "engine")
    assert says in failed.reason
    assert [case.outcome for case in outcome.cases].count("ran") == 3
    assert outcome.exit_status == 1


def test_an_engine_that_plays_another_shot_each_time_is_not_said_to_depend_on_records(
    tmp_path: Path,
) -> None:
    outcome = run_suite([scene()], ["fake:does=play by chance"], tmp_path)
    assert [case.reason for case in outcome.cases] == [""]


def test_what_raises_in_our_own_code_is_our_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("by ten")

    monkeypatch.setattr("ghostball.validation.suite.judge.measure", fail)
    found = run_suite([scene()], ["fake"], tmp_path)
    assert (found.cases[0].fault, found.cases[0].reason) == (
        "ghostball",
        "ZeroDivisionError: by ten",
    )
    assert found.exit_status == 3


@pytest.mark.parametrize(
    ("does", "reason"),
    [
        ("lose a ball", "`rest_positions[0]` must be finite"),
        ("hand back a dict", "must return a `Result`, got dict"),
        ("exit", "SystemExit: 0"),
    ],
)
def test_a_result_that_breaks_the_contract_is_a_failure_that_names_the_field(
    tmp_path: Path, does: str, reason: str
) -> None:
    # Fails if NaN reaches the figures; `test_returned.py` tests every part of the contract.
    outcome = run_suite([scene()], [f"fake:does={does}", "fake"], tmp_path)
    cases = by_label(Results.open(tmp_path).cases)
    failed = cases[f"fake:does={does}"]
    assert failed.outcome == "failed"
    assert reason in failed.reason
    assert failed.rest_positions is None
    assert cases["fake"].outcome == "ran"
    assert outcome.exit_status == 1


def test_a_truth_that_fails_fails_its_scene_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(shot: Scene, *wanted: Any, **more: Any) -> object:
        if shot.name == "broken":
            raise ZeroDivisionError("no truth today")
        return real(shot, *wanted, **more)

    real = ghostball.validation.suite.case.truth_of
    monkeypatch.setattr(ghostball.validation.suite.case, "truth_of", broken)
    outcome = run_suite([scene("broken"), scene()], ["fake"], tmp_path)
    assert [case.outcome for case in outcome.cases] == ["failed", "ran"]
    assert "no truth today" in outcome.cases[0].reason
    assert "ZeroDivisionError" in outcome.cases[0].traceback


def test_an_engine_that_is_here_and_is_missing_where_it_runs_has_failed() -> None:
    # For example on a machine of a cluster; as "unavailable", the case would let the run pass.
    def lacking(_: str) -> ReferenceEngine:
        raise EngineUnavailableError("engine `mine` is unavailable: its library isn't there")

    def record(*, is_here: bool) -> CaseRecord:
        return run_case(Case(scene("a"), "pymunk", Truth(None), is_here=is_here), lacking)[0]

    assert record(is_here=False).outcome == "unavailable"
    assert (record(is_here=True).outcome, record(is_here=True).fault) == ("failed", "engine")
    assert "its library isn't there" in record(is_here=True).reason

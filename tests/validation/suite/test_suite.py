"""The suite: every case becomes a record, and an interrupt keeps the finished cases."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from suite_runs import limits, scene

from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.store import CaseRecord, Results
from ghostball.validation.suite.judge import Case
from ghostball.validation.suite.suite import run_suite

pytestmark = pytest.mark.usefixtures("fake_engines")


PROVED = (
    "energy_rise",
    "events_missing",
    "events_invented",
    "quality_factor",
    "path_factor",
    "event_time_factor",
    "rest_time_factor",
    "energy_difference_factor",
)
"""Metrics with limits for every engine that claims to err by rounding only, with any reference."""


def by_label(cases: list[CaseRecord]) -> dict[str, CaseRecord]:
    return {case.label: case for case in cases}


def test_a_run_measures_judges_and_stores(tmp_path: Path) -> None:
    seen: list[tuple[str, int, int]] = []
    outcome = run_suite(
        [scene()],
        ["ghostball", "fake", "fake:shift=0.003"],
        tmp_path / "out",
        progress=lambda done, total, record: seen.append((record.label, done, total)),
        criteria={"roll": limits("ghostball", "fake").model_copy(update={"truth": "engine"})},
    )
    assert seen == [("ghostball", 1, 3), ("fake", 2, 3), ("fake:shift=0.003", 3, 3)]
    folder = Results.open(tmp_path / "out")
    assert folder.state == "complete"
    assert folder.labels == ["ghostball", "fake", "fake:shift=0.003"]
    assert folder.environment["engine_settings"]["fake"] == {
        "does": "run",
        "shift": 0.0,
        "sees": 0.0,
    }
    cases = by_label(folder.cases)
    # Our engine is the reference, so it can't pass; the copy agrees; the shifted engine is 3 mm
    # off.
    verdicts = [
        next(check.passed for check in cases[label].checks if check.metric == "rest_error_max")
        for label in folder.labels
    ]
    assert verdicts == [None, True, False]
    # The certified result still judges our engine.
    proved = {check.metric: check.passed for check in cases["ghostball"].checks}
    assert proved == {"rest_error_max": None} | dict.fromkeys(PROVED, True)
    shifted = cases["fake:shift=0.003"]
    assert shifted.metrics["rest_error_max"] == pytest.approx(0.003, rel=1e-9)
    assert shifted.ball_errors == pytest.approx([0.003], rel=1e-9)
    assert (shifted.status, shifted.engine, shifted.work) == ("rest", "fake", {"steps": 3})
    assert shifted.approximations == ("pure rolling: nearly",)
    assert shifted.load_scene() == scene()
    assert shifted.energy_initial == pytest.approx(0.7 * 0.170097, rel=1e-12)  # 7/10 m v^2
    assert shifted.energy_final == 0.0
    motion = folder.motion(shifted)
    assert motion is not None
    assert (
        len(motion.times) == 402
    )  # the uniform grid, whose end is the one event, and the time before
    assert motion.times[-1] == shifted.rest_time
    counts = outcome.counts
    assert (counts.ran, counts.checks_passed, counts.checks_failed) == (3, 3 + len(PROVED), 1)
    assert counts.checks_reference == 1
    assert outcome.exit_status == 1


def test_an_engine_of_another_package_is_held_to_the_resolution_that_it_states(
    tmp_path: Path,
) -> None:
    labels = ["fake:sees=1e-3", "fake:sees=1e-3,shift=0.1", "fake"]
    outcome = run_suite([scene()], labels, tmp_path)
    assert [verdict_of(case) for case in outcome.cases] == [
        Verdict.PASS,
        Verdict.FAIL,
        Verdict.LIMITS_HOLD,  # it supports rolling approximately, with an unknown error
    ]
    assert all(case.accuracy is not None for case in outcome.cases)


def test_an_interrupted_run_keeps_what_is_done(tmp_path: Path) -> None:
    outcome = run_suite([scene()], ["fake", "fake:does=interrupt", "ghostball"], tmp_path)
    assert outcome.interrupted
    assert outcome.exit_status == 130
    assert outcome.planned == 3
    folder = Results.open(tmp_path)
    assert [case.label for case in folder.cases] == ["fake"]
    assert folder.motion(folder.cases[0]) is not None
    assert folder.state == "interrupted"


def test_processes_find_what_one_process_finds(tmp_path: Path) -> None:
    scenes = [scene("one"), scene("two")]
    engines = ["ghostball", "fake:shift=0.25", "fake:does=lose time", "fake:does=exit"]
    run_suite(scenes, engines, tmp_path / "alone")
    run_suite(scenes, engines, tmp_path / "two", jobs=2)
    alone, two = Results.open(tmp_path / "alone"), Results.open(tmp_path / "two")
    assert two.scene_names == alone.scene_names
    assert two.labels == alone.labels
    for case in alone.cases:
        other = two.case(case.scene, case.label)
        assert other is not None
        left = {name: value for name, value in case.metrics.items() if name != "wall_time"}
        right = {name: value for name, value in other.metrics.items() if name != "wall_time"}
        assert left == right
        assert (case.outcome, case.reason) == (other.outcome, other.reason)
        assert np.array_equal(case.rest_positions, other.rest_positions)
    assert multiprocessing.active_children() == []


def test_with_a_limit_of_time_a_crash_and_a_hang_cost_one_case_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Fails if one job runs the engines in this process. Only the hanging engine has a short limit,
    # because the machine may be busy.
    def limit_of(seconds: float | None) -> Callable[[Case], float]:
        assert seconds == 300.0
        return lambda case: 0.5 if "hang" in case.label else seconds

    monkeypatch.setattr("ghostball.validation.parallel.pool.limit_of", limit_of)
    engines = ["fake:does=crash", "fake:does=hang", "fake"]
    outcome = run_suite([scene()], engines, tmp_path, time_limit=300.0)
    cases = by_label(Results.open(tmp_path).cases)
    assert "exit code 7" in cases["fake:does=crash"].reason
    assert "exceeded the time limit of 0.5 s" in cases["fake:does=hang"].reason
    assert cases["fake"].outcome == "ran"
    assert outcome.exit_status == 1
    assert multiprocessing.active_children() == []


SPOILING = """
from dataclasses import replace
from ghostball.reference_adapters.paper.discrete import PaperDiscreteEngine
from ghostball.validation.checks.criterion import Criterion

class First(PaperDiscreteEngine):
    name = "{name}"

    def simulate(self, scene, *, record="rest"):
        spoiled = getattr(Criterion, "spoiled", "nobody")
        Criterion.spoiled = self.name
        result = super().simulate(scene, record=record)
        return replace(result, engine=self.name, settings={{"spoiled_by": spoiled}})
"""


def test_what_an_engine_changes_in_its_process_reaches_no_other_engine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Otherwise an engine that patches the harness would change the verdicts of other engines.
    labels = ["spoils_one:First", "spoils_two:First", "paper-discrete"]
    for label in labels[:2]:
        name = label.partition(":")[0]
        (tmp_path / f"{name}.py").write_text(SPOILING.format(name=name))
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.syspath_prepend(str(tmp_path))
    two = [scene("one"), scene("two")]
    outcome = run_suite(two, labels, tmp_path / "out", jobs=1, time_limit=60.0)
    assert [case.outcome for case in outcome.cases] == ["ran"] * 6
    found = {(one.label, one.settings.get("spoiled_by")) for one in outcome.cases}
    assert found == {
        ("spoils_one:First", "nobody"),
        ("spoils_one:First", "spoils_one"),
        ("spoils_two:First", "nobody"),
        ("spoils_two:First", "spoils_two"),
        ("paper-discrete", None),
    }

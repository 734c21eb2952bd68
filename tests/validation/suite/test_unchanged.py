"""Reused results equal new results to the bit; cases that may differ run again."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from step_rules import asked_of_all
from stored_records import record

from ghostball.model import Ball, Result, Scene, Status, Table
from ghostball.reference_adapters.ghostball import GhostballEngine
from ghostball.reference_adapters.paper.discrete import PaperDiscreteEngine
from ghostball.validation.checks.criteria import Criteria, common_criteria
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.checks.requirements import Requirements
from ghostball.validation.parallel.sources import is_ours, versions
from ghostball.validation.results.records import CaseRecord, Motion, status_name
from ghostball.validation.results.store import Results, ResultsWriter
from ghostball.validation.runs.runner import Reuse
from ghostball.validation.suite.suite import SuiteResult, run_suite
from ghostball.validation.suite.unchanged import code_hash, inputs_hash

ENGINES = ("ghostball", "paper-discrete")
PAIRS = [(scene, label) for scene in ("cut", "roll") for label in ENGINES]


def scenes(speed: float = 1.0) -> list[Scene]:
    cue = Ball(id="cue", position=(0.5, 0.5), velocity=(speed, 0.0))
    table = Table(length=2.0, width=1.0)
    return [
        Scene(name="cut", table=table, balls=[cue, Ball(id="object", position=(1.0, 0.53))]),
        Scene(name="roll", balls=[cue]),
    ]


def limits(at_most: float = 1e-6, metric: str = "rest_error_max") -> Criteria:
    # The limit applies after the horizon, too, because steps of 20 ms may cause wrong collisions.
    criterion = {"engines": ENGINES, "metric": metric, "at_most": at_most, "past_horizon": True}
    criterion["reason"] = "by hand"
    return Criteria(criteria=(Criterion.model_validate(criterion),))


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, str]]:
    """Return a list to which the engines add each case that they run in this process."""
    seen: list[tuple[str, str]] = []
    for engine in (GhostballEngine, PaperDiscreteEngine):
        spy_on(monkeypatch, engine, lambda name, scene: seen.append((scene.name, name)))
    return seen


def spy_on(
    monkeypatch: pytest.MonkeyPatch, engine: type[Any], before: Callable[[str, Scene], object]
) -> None:
    """Make an engine call `before` with its name and the scene before it simulates."""
    real = engine.simulate

    def simulate(self: Any, scene: Scene, *, record: Any = "rest") -> Result:
        before(self.name, scene)
        result: Result = real(self, scene, record=record)
        return result

    monkeypatch.setattr(engine, "simulate", simulate)


def run(out: Path, **options: Any) -> SuiteResult:
    chosen = {"scenes": scenes(), "engines": ENGINES, "reuse": True} | options
    shots, engines = chosen.pop("scenes"), chosen.pop("engines")
    return run_suite(shots, engines, out, **chosen)


def plain(case: CaseRecord) -> dict[str, Any]:
    """Return a record without its date and its run times."""
    kept = {part.name: getattr(case, part.name) for part in fields(CaseRecord)}
    for name in ("wall_time", "measured", "reused"):
        del kept[name]
    kept["metrics"] = {name: v for name, v in case.metrics.items() if name != "wall_time"}
    for name, value in kept.items():
        if isinstance(value, np.ndarray):
            kept[name] = (value.shape, value.tobytes())
    return kept


# --- what is reused


def test_what_is_reused_is_what_is_measured_again_to_the_bit(tmp_path: Path) -> None:
    out, again = tmp_path / "out", tmp_path / "again"
    options = {"criteria": {"roll": limits()}}
    run(out, **options)
    before = Results.open(out)
    run(out, **options)
    run(again, reuse=False, **options)
    taken, measured = Results.open(out), Results.open(again)
    for pair in PAIRS:
        first, kept, fresh = (folder.case(*pair) for folder in (before, taken, measured))
        assert first is not None
        assert kept is not None
        assert fresh is not None
        assert (first.reused, kept.reused, fresh.reused) == (False, True, False)
        assert plain(kept) == plain(fresh)
        assert replace(kept, reused=False).wall_time == first.wall_time
        ours, theirs = taken.motion(kept), measured.motion(fresh)
        assert ours is not None
        assert theirs is not None
        for part in fields(Motion):
            left, right = getattr(ours, part.name), getattr(theirs, part.name)
            assert (left is None) == (right is None)
            assert left is None or (left.dtype, left.tobytes()) == (right.dtype, right.tobytes())


def test_nothing_runs_twice_and_all_say_so(tmp_path: Path, ran: list[tuple[str, str]]) -> None:
    run(tmp_path)
    assert sorted(ran) == PAIRS
    ran.clear()
    announced: list[Reuse[CaseRecord]] = []
    outcome = run(
        tmp_path,
        progress=lambda *_: pytest.fail("nothing was run"),
        announce=announced.append,
    )
    assert ran == []
    assert [list(one.records) for one in announced] == [PAIRS]
    assert (outcome.counts.reused, outcome.counts.ran) == (4, 4)
    folder = Results.open(tmp_path)
    assert folder.state == "complete"
    assert folder.environment["reused"] == {
        "cases": 4,
        "measured_first": min(case.measured for case in folder.cases),
        "measured_last": max(case.measured for case in folder.cases),
    }
    assert all(case.measured for case in folder.cases)


# --- what runs again


UNCHANGED = "ghostball.validation.suite.unchanged"
OTHER_CODE: dict[str, Callable[[pytest.MonkeyPatch], None]] = {
    "sources": lambda patch: patch.setattr(f"{UNCHANGED}._loaded_sources", lambda: "edited"),
    "library": lambda patch: patch.setattr(
        f"{UNCHANGED}.versions", lambda: versions() | {"pymunk": "99.0"}
    ),
    "python": lambda patch: patch.setattr(sys, "version", sys.version + " [another compiler]"),
    "processor": lambda patch: patch.setattr(f"{UNCHANGED}.cpu_name", lambda: "another"),
    "variable": lambda patch: patch.setenv("NPY_DISABLE_CPU_FEATURES", "AVX2"),
}


@pytest.mark.parametrize("other", OTHER_CODE)
def test_what_computes_is_in_the_hash_of_the_code(
    monkeypatch: pytest.MonkeyPatch, other: str
) -> None:
    before = code_hash()
    OTHER_CODE[other](monkeypatch)
    assert code_hash() not in (before, "")


def test_what_changes_no_result_is_not_in_the_hash_of_the_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = code_hash()
    monkeypatch.setenv("PYTHONPATH", "/elsewhere")
    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.chdir(tmp_path)
    assert code_hash() == before


def test_other_criteria_are_judged(tmp_path: Path) -> None:
    far = limits(1.0, "rest_time_error")
    loose = run(tmp_path, criteria={"roll": far, "cut": far})
    assert loose.exit_status == 0
    strict = run(tmp_path, criteria={"roll": limits(1e-12), "cut": far})
    assert strict.exit_status == 1
    assert strict.counts.reused == 2
    # This criterion is for one engine only, so the verdict of the other engine is reused.
    own = Criterion.model_validate(
        {"engines": ["ghostball"], "metric": "energy_rise", "at_most": 1.0, "reason": "by hand"}
    )
    both = Criteria(criteria=(*limits(1e-12).criteria, own))
    third = run(tmp_path, criteria={"roll": both, "cut": far})
    assert third.counts.reused == 3
    assert third.exit_status == 1  # a failed check that is reused still fails the run


def test_what_failed_runs_again_until_it_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def crash(name: str, scene: Scene) -> None:
        if scene.name == "cut":
            raise ZeroDivisionError("today")

    with monkeypatch.context() as broken:
        spy_on(broken, PaperDiscreteEngine, crash)
        for reused in (0, 3):
            outcome = run(tmp_path)
            assert outcome.exit_status == 1
            assert outcome.counts.reused == reused
    mended = run(tmp_path)
    assert (mended.exit_status, mended.counts.reused) == (0, 3)
    assert run(tmp_path).counts.reused == 4


def test_only_an_end_that_comes_again_is_reused(tmp_path: Path) -> None:
    stands = ResultsWriter(tmp_path).is_repeatable
    case = record(status="rest")
    assert stands(case)
    assert stands(replace(case, status="t-max"))
    for status in Status:  # a limit of time isn't reproducible
        ended = stands(replace(case, status=status_name(status)))
        assert ended is (status in (Status.REST, Status.T_MAX))
    assert not stands(replace(case, outcome="failed"))
    assert not stands(replace(case, outcome="unavailable"))
    assert stands(replace(case, outcome="not-representable", status=None))


@pytest.mark.usefixtures("fake_engines")
def test_engines_of_other_packages_always_run(tmp_path: Path) -> None:
    options = {"engines": ["fake", "paper-discrete"]}
    run(tmp_path / "out", **options)
    outcome = run(tmp_path / "out", **options)
    assert {case.label: case.reused for case in outcome.cases} == {
        "fake": False,
        "paper-discrete": True,
    }
    assert not is_ours("fake")
    assert is_ours("pymunk:contact_steps=exact")


# --- the hashes


def test_every_input_is_in_the_hash() -> None:
    shot = scenes()[1]
    criteria, rules = limits().criteria, common_criteria().steps
    base: dict[str, Any] = {
        "scene": shot,
        "label": "paper-discrete",
        "settings": {"dt": 0.02},
        "asked": asked_of_all(criteria),
        "truth": None,
        "metrics": None,
    }
    moved = shot.balls[0].model_copy(update={"velocity": (1.0, -0.0, 0.0)})
    changes: list[dict[str, Any]] = [
        {"scene": scenes(float(np.nextafter(1.0, 2.0)))[1]},
        {"scene": shot.model_copy(update={"title": "renamed"})},
        {"scene": shot.model_copy(update={"balls": (moved,)})},
        {"label": "paper-discrete:dt=0.02"},
        {"settings": {"dt": 0.01}},
        {"settings": {"dt": 0.02, "new": None}},
        {"asked": Requirements()},
        {"asked": asked_of_all(limits(2e-6).criteria)},
        {"asked": asked_of_all(limits(metric="rest_error_rms").criteria)},
        {"asked": asked_of_all((criteria[0].model_copy(update={"reason": "another"}),))},
        {"asked": asked_of_all(criteria, rules[0])},
        {"asked": Requirements(law=asked_of_all(criteria).stated)},
        {"truth": "engine"},
        {"metrics": ["rest_error_max"]},
    ]
    hashes = {inputs_hash(**base)} | {inputs_hash(**base | change) for change in changes}
    assert len(hashes) == len(changes) + 1
    assert inputs_hash(**base) == inputs_hash(**base | {"scene": scenes()[1]})

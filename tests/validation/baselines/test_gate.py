"""Results compared with baselines: with no baseline, with a planted change, after acceptance."""

from __future__ import annotations

from dataclasses import replace

import gate
import pytest

import ghostball.reference_adapters.ghostball
import ghostball.validation.runs.engine_runs
from ghostball.engine import simulate
from ghostball.model import EngineFailedError, UnsupportedSceneError
from ghostball.validation.baselines import gate as gate_module
from ghostball.validation.baselines.accept import CHANGES_FILE, AcceptError, RefusedError
from ghostball.validation.baselines.baseline import Baseline, baseline_path, load_baseline
from ghostball.validation.baselines.compared_run import ComparedRun
from ghostball.validation.baselines.gate import outcome_of, second_runs

SCENES = [gate.cut_shot(), gate.roll_shot()]


def test_another_cost_of_the_same_bits_fails_until_it_is_accepted(accepted, monkeypatch):
    def busier(scene, **options):
        result = simulate(scene, **options)
        more = {"events": result.work["events"] + (scene.name == "roll")}
        return replace(result, work={**result.work, **more})

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", busier)
    found = accepted.compare()
    roll = found.scene("roll")
    assert (roll.change, roll.failed, found.outcome) == ("unchanged", True, "failed")
    assert roll.summary == "bit-identical; events 1 -> 2"
    accepted.accept("Counts one more.")
    assert "* roll: same result, different work counters; bit-identical; events 1 -> 2" in (
        accepted.baselines / CHANGES_FILE
    ).read_text("utf-8")
    assert accepted.compare().outcome == "passed"


def test_another_reference_is_a_warning(accepted):
    path = baseline_path(accepted.baselines, "roll")
    old = load_baseline(path)
    record = replace(old.record, truth="certified")
    moved = Baseline.of(ComparedRun(record, lambda: old.events.log), old.accepted)
    path.write_text(moved.text, encoding="utf-8")
    found = accepted.compare()
    assert found.outcome == "passed"
    (warning,) = found.warnings
    assert (
        "errors can't be compared: the reference was certified, and is Ghostball's engine"
        in warning
    )
    assert warning.startswith("roll: ")


def test_another_scene_of_the_same_name_is_not_comparable(accepted):
    changed = gate.cut_shot(1.5)
    found = accepted.compare(scenes=[changed, SCENES[1]])
    assert gate.changes(found) == {"cut": "not-comparable", "roll": "unchanged"}
    assert found.outcome == "no-baseline"
    accepted.accept("Another shot.")
    assert accepted.compare(scenes=[changed, SCENES[1]]).outcome == "passed"


def test_a_baseline_of_another_version_is_not_comparable_and_not_overwritten(accepted):
    path = baseline_path(accepted.baselines, "cut")
    path.write_text(path.read_text("utf-8").replace('"schema": 4', '"schema": 3', 1), "utf-8")
    accepted.gate.check(["cut"])
    before = accepted.contents()
    found = accepted.compare()
    assert found.outcome == "no-baseline"
    assert "`schema` must be 4, got 3" in found.scene("cut").summary
    assert accepted.contents() == before
    accepted.accept("Of this version.")
    assert accepted.compare().outcome == "passed"


def test_a_run_that_crashed_fails(accepted, monkeypatch):
    def crash(scene, **options):
        if scene.name == "cut":
            raise ZeroDivisionError("planted")
        return simulate(scene, **options)

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", crash)
    found = accepted.compare()
    cut = found.scene("cut")
    assert (cut.change, cut.failed) == ("worse", True)
    assert "planted" in cut.summary
    assert found.outcome == "failed"
    assert accepted.candidates == ()
    with pytest.raises(AcceptError, match="planted"):
        accepted.accept()


def refuse_rolling(monkeypatch):
    """Make our engine reject scenes without a table."""

    def refuse(scene, **options):
        if scene.name == "roll":
            raise UnsupportedSceneError("ghostball", ("planted: no cloth without a table",))
        return simulate(scene, **options)

    monkeypatch.setattr(ghostball.reference_adapters.ghostball, "simulate", refuse)


def test_a_scene_that_our_engine_no_longer_represents_fails(accepted, monkeypatch):
    # Otherwise the loss of a capability would pass.
    refuse_rolling(monkeypatch)
    found = accepted.compare(whole=True)
    roll = found.scene("roll")
    assert (roll.change, roll.failed) == ("worse", True)
    assert "no cloth without a table" in roll.summary
    assert found.outcome == "failed"


def test_an_empty_comparison_is_no_pass():
    assert outcome_of([]) == "no-baseline"


def test_a_baseline_of_a_scene_that_is_no_more_is_told_of(accepted):
    one = [SCENES[0]]
    assert accepted.compare(scenes=one).warnings == (), "only a part was run"
    found = accepted.compare(scenes=one, whole=True)
    assert found.outcome == "passed"
    (warning,) = found.warnings
    assert "no longer exists: roll. Remove their files from" in warning


@pytest.fixture
def unsteady(monkeypatch):
    """Make our engine return rest positions that differ by a nanometre at each call."""
    count = iter(range(1, 99))

    def unsteady(scene, **options):
        result = simulate(scene, **options)
        state = result.final_state
        moved = state._replace(positions=state.positions + 1e-9 * next(count))
        return replace(result, final_state=moved)

    for module in (ghostball.reference_adapters.ghostball, ghostball.validation.runs.engine_runs):
        monkeypatch.setattr(module, "simulate", unsteady)


def test_an_engine_that_gives_other_bits_each_time_is_reported(accepted, unsteady):
    before = {path: path.read_bytes() for path in accepted.baselines.iterdir()}
    found = accepted.compare()
    assert found.outcome == "failed"
    assert [one.change for one in found.scenes] == ["not-deterministic"] * 2
    assert accepted.candidates == ()
    assert "the second time it gave a different result" in found.scenes[0].summary
    differs = "a different result each time it simulates"
    with pytest.raises(RefusedError, match=f"{differs} cut, roll"):
        accepted.accept()
    with pytest.raises(RefusedError, match=f"{differs} roll,"):
        accepted.accept(only=["roll"])
    assert {path: path.read_bytes() for path in accepted.baselines.iterdir()} == before


def test_a_shot_is_played_to_its_bits_or_to_why_there_are_none(monkeypatch):
    run = gate.played(SCENES[0])
    with second_runs("ghostball") as again:
        assert again(SCENES[0]) == run.record.bits

        def fails(*_):
            raise EngineFailedError("ghostball", "gone")

        monkeypatch.setattr(gate_module, "run_engine", fails)
        assert again(SCENES[0]).startswith("it failed: ")

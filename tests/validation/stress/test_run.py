"""A run of generated shots: the limits per engine, the stored results, and the counts."""

from __future__ import annotations

from pathlib import Path

import pytest
from stored_records import record

from ghostball.reference_adapters.pymunk.engine import PymunkEngine
from ghostball.validation.results.records import CaseRecord, Check
from ghostball.validation.results.store import Results
from ghostball.validation.stress import StressSize, chosen_shots, run_stress
from ghostball.validation.stress.tally import (
    again,
    are_stress,
    explaining,
    sweeps,
    tallies,
    why_failed,
)

ONE, OTHER = ["grazing/rolling-hit-1e-01"], ["grazing/rolling-miss-1e-01"]


def run(out: Path, labels: list[str], only: list[str]):
    return run_stress(chosen_shots(StressSize(), only), labels, out)


def test_what_the_same_code_left_of_other_shots_stays_and_is_reused(tmp_path):
    first = run(tmp_path, ["ghostball", "pymunk"], ONE)
    assert (first.exit_status, first.planned) == (0, 2)
    more = run(tmp_path, ["ghostball"], OTHER)
    assert (more.planned, len(Results.open(tmp_path).cases)) == (1, 3)
    again_all = run(tmp_path, ["ghostball"], ONE + OTHER)
    assert again_all.counts.reused == 2
    cases = Results.open(tmp_path).cases
    assert all(Results.open(tmp_path).motion(case) is None for case in cases)


def test_an_engine_with_a_step_is_asked_no_shot_that_lasts(tmp_path):
    slow = run(tmp_path, ["ghostball", "pymunk"], ["extremes/speed-elastic-1e-09"])
    assert [case.label for case in slow.cases] == ["ghostball"]


@pytest.mark.usefixtures("in_this_process")
def test_an_engine_that_cannot_state_its_error_is_asked_and_fails(tmp_path, monkeypatch):
    def broken(engine, scene):
        raise ZeroDivisionError("planted")

    monkeypatch.setattr(PymunkEngine, "resolution", broken)
    (found,) = run(tmp_path, ["pymunk"], ["extremes/speed-elastic-1e-09"]).cases
    assert (found.outcome, found.fault) == ("failed", "engine")
    assert "planted" in found.reason


SHOT = chosen_shots(StressSize(), ONE)[0].scene


def case(depth: float, label: str = "pymunk", passed: bool | None = True, **changes) -> CaseRecord:
    check = Check("collision_count", 0, "equals", 1, "1", passed, "They meet.")
    fields = {
        "scene": "grazing.shot",
        "tags": ("stress", "grazing", f"depth={depth:g}"),
        "status": "t-max",
        "checks": () if passed is None else (check,),
    }
    return record(label, SHOT, **(fields | changes))


def test_shots_are_counted_by_family_and_engine():
    cases = [
        case(0.1),
        case(0.2, passed=False),
        case(0.3, passed=None),
        case(0.4, outcome="failed", reason="lost the balls"),
        case(0.5, outcome="not-representable"),
        case(0.1, "other", outcome="unavailable"),
    ]
    assert are_stress(cases)
    assert not are_stress([])
    for other in ({"tags": ("stress",)}, {"tags": ("stress", "mine")}, {"scene": "mine"}):
        assert not are_stress([*cases, case(0.1, **other)])
    found = tallies(cases)
    assert found["grazing", "pymunk"].text == "1/3, 1 not judged"
    assert found["grazing", "other"].text == "–"
    assert [why_failed(one) for one in found["grazing", "pymunk"].failed] == [
        "collision_count must be exactly 1, got 0",
        "lost the balls",
    ]


@pytest.mark.parametrize(
    ("failing", "said"),
    [
        ((), "never"),
        ((1, 2, 3, 4), "always"),
        ((1, 2), "≤ 2"),
        ((4,), "≥ 4"),
        ((1, 4), "≤ 1, ≥ 4"),
        ((2,), "2"),
    ],
)
def test_where_an_engine_begins_to_fail_is_said(failing, said):
    cases = [case(depth, passed=depth not in failing) for depth in (3, 1, 4, 2)]
    (sweep,) = sweeps([*cases, case(1, "other", outcome="unavailable")])
    assert (sweep.parameter, sweep.values) == ("depth [diameters]", (1.0, 2.0, 3.0, 4.0))
    assert sweep.fails == {"pymunk": said, "other": ""}


def test_a_speed_is_said_in_diameters_a_time_step():
    tags = ("stress", "tunnelling", "speed=80")
    fast = case(0.0, passed=False, tags=tags, settings={"dt": 1e-3})
    slow = case(0.0, tags=("stress", "tunnelling", "speed=2"), settings={"dt": 1e-3})
    (sweep,) = sweeps([slow, fast])
    assert sweep.fails["pymunk"] == "≥ 80 (1.4 diameters a time step)"


def test_a_failed_shot_is_saved_and_can_be_run_and_explained_again(tmp_path):
    failed = case(0.1, "pymunk:dt=0.05", scene=SHOT.name)
    assert again(failed) == f"ghostball stress {ONE[0]} -e pymunk:dt=0.05"
    command = explaining(failed, tmp_path)
    file = tmp_path / "scenes" / f"{SHOT.name}.toml"
    assert command == f"ghostball explain {file} -e pymunk:dt=0.05"
    assert type(SHOT).load(file) == SHOT

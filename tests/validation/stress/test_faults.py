"""Faults: what judges the harness sees each result that is lost, wrong or not explained."""

from __future__ import annotations

import subprocess

import pytest

from reference_adapters import make_engine
from validation.files import ResultsError
from validation.stress.families import faults
from validation.stress.families.faults import (
    SAYS,
    FaultTrial,
    FaultyEngines,
    FaultyMembers,
    FullDisk,
    Killed,
    check_outcomes,
)
from validation.stress.faulty_engine import FaultyEngine, fail

SOUND = {("roll", "faulty"): ("ran", ""), ("roll", "faulty:does=die"): ("failed", "exit code 7")}


class TestJudge:
    def test_right_outcomes_have_no_fault(self):
        assert check_outcomes("validate", SOUND, ("die",), 2) == []

    @pytest.mark.parametrize(
        ("found", "planned", "fault"),
        [
            (SOUND, 3, "the faults cost some"),
            (SOUND | {("roll", "faulty"): ("failed", "why")}, 2, "does nothing wrong: why"),
            (SOUND | {("roll", "faulty:does=die"): ("ran", "")}, 2, "should say 'exit code 7'"),
            (SOUND | {("roll", "faulty:does=die"): ("failed", "so")}, 2, "for the reason 'so'"),
        ],
    )
    def test_a_wrong_one_is_seen(self, found, planned, fault):
        assert fault in check_outcomes("validate", found, ("die",), planned)[0]

    @pytest.mark.parametrize(
        ("error", "fault"),
        [
            (subprocess.TimeoutExpired("ghostball", 1.0), "hangs"),
            (ResultsError("out: damaged"), "can't be read: out: damaged"),
        ],
    )
    def test_a_hang_and_damaged_results_are_faults(self, error, fault):
        class Planted(FaultTrial):
            name = "planted"

            def faults(self, place):
                raise error

        verdict = Planted().run(make_engine("ghostball"))
        assert fault in verdict.faults[0]
        assert verdict.broken == 1


def test_every_fault_has_its_words():
    ways = set(FaultyEngine.Settings.model_fields["does"].annotation.__args__)
    assert ways == {"none", *SAYS}


@pytest.mark.parametrize(
    ("does", "error"), [("raise", RuntimeError), ("exit", SystemExit), ("garbage", ValueError)]
)
def test_the_faulty_engine_fails_as_it_is_told(does, error):
    with pytest.raises(error):
        fail(does)
    fail("none")


@pytest.mark.slow
@pytest.mark.parametrize(
    "trial",
    [
        FaultyEngines("engines", "validate", ("die", "raise", "hang"), 2),
        FaultyEngines("engines", "stress", ("abort", "freeze"), 1),
        FaultyMembers("members", "hang"),
        Killed("killed", "validate"),
        Killed("killed", "stress"),
        FullDisk("full", "validate"),
        FullDisk("full", "stress"),
    ],
    ids=lambda trial: f"{trial.name}-{getattr(trial, 'command', '')}",
)
def test_the_harness_survives(trial):
    assert trial.run(make_engine("ghostball")).faults == ()


def test_the_full_suite_has_every_fault_on_both_commands():
    trials = list(faults._trials("full"))
    assert len({trial.name for trial in trials}) == len(trials)
    for kind in (FaultyEngines, Killed, FullDisk):
        assert {one.command for one in trials if isinstance(one, kind)} == {"validate", "stress"}

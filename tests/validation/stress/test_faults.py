"""Faults: what judges the harness sees each result that is lost, wrong or not explained."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from reference_adapters import make_engine
from validation.files import ResultsError
from validation.leash import leashed
from validation.stress.commands import Asked, Ended, Place
from validation.stress.families import faults
from validation.stress.families.faults import (
    PATIENCE,
    SAYS,
    FaultTrial,
    FaultyEngines,
    FaultyMembers,
    FullDisk,
    Killed,
    check_next_run,
    check_outcomes,
    check_quiet,
    check_told,
    check_whole,
)
from validation.stress.faulty_engine import FaultyEngine, fail

SOUND = {("roll", "faulty"): ("ran", ""), ("roll", "faulty:does=die"): ("failed", "exit code 7")}


class TestJudge:
    def test_right_outcomes_have_no_fault(self):
        assert check_outcomes("validate", SOUND, ("die",)) == []
        assert check_whole(SOUND, SOUND) == []

    @pytest.mark.parametrize(
        ("found", "fault"),
        [
            (SOUND | {("roll", "faulty"): ("failed", "why")}, "does nothing wrong: why"),
            (SOUND | {("roll", "faulty:does=die"): ("ran", "")}, "should say 'exit code 7'"),
            (SOUND | {("roll", "faulty:does=die"): ("failed", "so")}, "for the reason 'so'"),
        ],
    )
    def test_a_wrong_one_is_seen(self, found, fault):
        assert fault in check_outcomes("validate", found, ("die",))[0]

    def test_a_result_that_is_lost_or_of_something_else_is_seen(self):
        # What was asked for is known beforehand: where a scene lost all of its results as well.
        assert check_whole({}, SOUND) == [
            "roll on faulty: no result, one of 2 that were asked for",
            "roll on faulty:does=die: no result, one of 2 that were asked for",
        ]
        assert "not asked for" in check_whole(SOUND | {("spin", "faulty"): ("ran", "")}, SOUND)[0]

    def test_what_is_asked_for_is_known_before_anything_runs(self):
        assert Asked("validate", ("a", "b"), 2).results == {
            ("roll-0", "a"), ("roll-0", "b"), ("roll-1", "a"), ("roll-1", "b"),
        }  # fmt: skip
        assert len(Asked("stress", ("a", "b"), 4).results) == 8

    @pytest.mark.parametrize(
        ("status", "errors", "found", "fault"),
        [
            (0, "2 cases taken over", {("roll-0", "a"): ("ran", "")}, None),
            (3, "2 cases taken over", {("roll-0", "a"): ("ran", "")}, "it ends in 3"),
            (0, "", {("roll-0", "a"): ("ran", "")}, "nothing is taken over"),
            (0, "are known", {}, "roll-0 on a: no result"),
            (0, "are known", {("roll-0", "a"): ("failed", "")}, "does nothing wrong"),
        ],
    )
    def test_a_next_run_that_does_not_go_on_is_seen(self, status, errors, found, fault):
        asked = Asked("validate", ("a",), 1)
        wrong = check_next_run(
            asked, {("roll-0", "a"): ("ran", "")}, Ended(status, "", errors), found
        )
        assert wrong == [] if fault is None else fault in wrong[0]

    def test_a_full_disk_that_is_not_told_is_seen(self):
        assert check_told(Ended(2, "", "can't write")) == []
        assert "doesn't say so" in check_told(Ended(0, "", "can't write"))[0]
        assert "doesn't say so" in check_told(Ended(2, "", "done"))[0]
        assert "a traceback" in check_told(Ended(2, "", "Traceback: can't"))[0]
        assert check_quiet("Traceback")

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


def test_a_trial_has_time_for_all_that_it_waits_for():
    # The run itself, what it had started, and the next run: it says which of them hangs.
    assert all(trial.limit > 3.0 * PATIENCE for trial in faults._trials("full"))


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="groups of processes are POSIX")
class TestLeash:
    def test_nothing_of_a_command_that_hangs_is_left(self, tmp_path):
        pids = tmp_path / "pids"
        with leashed([sys.executable, "-c", FAMILY_OF_TWO, str(pids)]):
            found = running_pids(pids)
            assert all(map(is_alive, found))
        assert gone(found)

    def test_nor_where_who_started_it_was_killed(self, tmp_path):
        # Breaks where a trial that is ended by its limit of time leaves its commands running.
        pids = tmp_path / "pids"
        starter = subprocess.Popen([sys.executable, "-c", STARTER, FAMILY_OF_TWO, str(pids)])
        found = running_pids(pids)
        starter.kill()
        starter.wait()
        assert gone(found)

    def test_a_command_that_ends_gives_its_status_and_messages(self, tmp_path):
        ended = Place(tmp_path).run(["simulate", "no-such-scene"])
        assert ended.status == 2
        assert "no-such-scene" in ended.errors


FAMILY_OF_TWO = """
import os, signal, subprocess, sys, time
from validation.leash import end_with_input

end_with_input()
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
os.kill(child.pid, signal.SIGSTOP)
with open(sys.argv[1] + ".part", "w") as file:
    file.write(f"{os.getpid()} {child.pid}")
os.replace(sys.argv[1] + ".part", sys.argv[1])
time.sleep(600)
"""

STARTER = """
import sys, time
from validation.leash import leashed

with leashed([sys.executable, "-c", *sys.argv[1:]]):
    time.sleep(600)
"""


def running_pids(path: Path) -> list[int]:
    """Wait until a process and its child have written their numbers."""
    while not path.exists():
        time.sleep(0.02)
    return [int(pid) for pid in path.read_text().split()]


def is_alive(pid: int) -> bool:
    """Whether a process runs; one that has ended, and that nobody waits for, doesn't."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    stat = Path(f"/proc/{pid}/stat")
    return not (stat.exists() and stat.read_text().rpartition(")")[2].split()[0] == "Z")


def gone(pids: list[int]) -> bool:
    """Wait for the end of processes."""
    deadline = time.monotonic() + 30.0
    while any(map(is_alive, pids)) and time.monotonic() < deadline:
        time.sleep(0.02)
    return not any(map(is_alive, pids))


def test_every_fault_has_its_words():
    ways = set(FaultyEngine.Settings.model_fields["does"].annotation.__args__)
    # One stops early and one prints, which are outcomes of their own; so is a motion that can't be
    # sampled, which only commands that ask for one come to (`test_faulty_engines.py`).
    assert ways == {"none", "stop", "print", "lose-motion", "cut-motion", *SAYS}


@pytest.mark.parametrize(
    ("does", "error"), [("raise", RuntimeError), ("exit", SystemExit), ("garbage", ValueError)]
)
def test_the_faulty_engine_fails_as_it_is_told(does, error):
    with pytest.raises(error):
        fail(does)
    fail("none")


# What `make stress` tries as well, with the quick suite, isn't tried here again.
TRIALS = [
    FaultyEngines("engines", "stress", ("abort", "freeze", "raise"), 1),
    FaultyMembers("members", "hang"),
    Killed("killed", "validate"),
    FullDisk("full", "validate"),
    FullDisk("full", "stress"),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    "trial", TRIALS, ids=lambda trial: f"{trial.name}-{getattr(trial, 'command', '')}"
)
def test_the_harness_survives(trial):
    assert trial.run(make_engine("ghostball")).faults == ()


def test_the_full_suite_has_every_fault_on_both_commands():
    trials = list(faults._trials("full"))
    assert len({trial.name for trial in trials}) == len(trials)
    for tried in (trials, [*faults._trials("quick"), *TRIALS]):
        for kind in (FaultyEngines, Killed, FullDisk):
            assert {one.command for one in tried if isinstance(one, kind)} == {"validate", "stress"}

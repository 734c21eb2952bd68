"""The self-test: bugs are caught, the clean engine isn't, and what goes wrong on the way.

A copy of the engine takes a second to start, so of the tests that plant a bug two are fast: of one
that is killed, beside the copy without one that survives, and of one that is an error.
"""

from __future__ import annotations

import os
import signal
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from validation.mutants import MutantError, Mutation
from validation.stress import StressError
from validation.stress.mutations import MUTATIONS
from validation.stress.probe import lines, small_trials
from validation.stress.self_test import UNCHANGED, Found, SelfTest, self_test

NAMED = {one.name: one for one in MUTATIONS}

FEW = ("graded/head-on", "graded/stop", "graded/draw-shot")
"""Trials that take no time."""

START = "    check_request(scene, record, max_events)\n    # The compiler"


def raising(text: str) -> Mutation:
    """Return a bug that does something drastic in shots of one ball."""
    new = START.replace(
        "\n", f"\n    if len(scene.balls) == 1:\n        import os, time\n        {text}\n"
    )
    return Mutation("drastic", "shot.py", START, new, "")


def test_a_bug_is_killed_and_the_unchanged_copy_survives() -> None:
    seen: list[tuple[str, int, int]] = []
    outcome = self_test(
        only=FEW,
        mutations=[NAMED["restitution - 1e-6"]],
        progress=lambda found, done, planned: seen.append((found.name, done, planned)),
    )
    assert outcome.exit_status == 0
    assert outcome.survivors == ()
    (bug,) = outcome.mutants
    assert bug.killed_by == "graded/draw-shot"
    assert "quality_factor" in bug.faults[0]
    assert outcome.unchanged is not None
    assert outcome.unchanged.tried == outcome.trials == 3
    assert seen == [(UNCHANGED, 1, 2), ("restitution - 1e-6", 2, 2)]


@pytest.mark.slow
def test_a_bug_that_no_trial_shows_survives_and_fails_the_self_test() -> None:
    harmless = Mutation("harmless", "shot.py", START, START + " ", "Nothing is wrong.")
    outcome = self_test(only=["graded/stop"], mutations=[harmless])
    assert [one.name for one in outcome.survivors] == ["harmless"]
    assert outcome.exit_status == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "limit", "reason"),
    [
        ("raise ZeroDivisionError('planted')", 60.0, "ZeroDivisionError: planted"),
        ("os._exit(7)", 60.0, "exit code 7"),
        ("time.sleep(600)", 10.0, "no answer in 10 s"),  # without its start
    ],
)
def test_a_shot_that_raises_dies_or_hangs_kills_its_mutant(
    text: str, limit: float, reason: str
) -> None:
    outcome = self_test(only=["graded/stop"], mutations=[raising(text)], time_limit=limit)
    (bug,) = outcome.mutants
    assert bug.killed_by == "graded/stop"
    assert reason in bug.faults[0]
    assert outcome.exit_status == 0


def test_a_mutant_that_breaks_its_module_is_an_error() -> None:
    broken = Mutation("broken", "errors.py", "from __future__", "from __past__", "")
    with pytest.raises(MutantError, match=r'"broken" can\'t be imported.*__past__'):
        self_test(only=["graded/stop"], mutations=[broken])


@pytest.mark.parametrize(("only", "jobs"), [(["no-such"], 1), ([], 0)])
def test_what_makes_no_sense_is_refused(only: list[str], jobs: int) -> None:
    with pytest.raises(StressError):
        self_test(only=only, jobs=jobs, mutations=[])


@pytest.mark.slow
def test_an_interrupt_ends_every_process() -> None:
    def interrupt(found: Found, done: int, planned: int) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    before = threading.active_count()
    mutations = [NAMED["spin for ever"], NAMED["late roll"]]
    outcome = self_test(only=["graded/stop"], jobs=2, mutations=mutations, progress=interrupt)
    assert outcome.interrupted
    assert outcome.exit_status == 130
    assert len(outcome.mutants) < 2 or outcome.unchanged is None
    assert threading.active_count() == before


CLEAN = Found(UNCHANGED, "", "", (), 9, 1.0)
KILLED = Found("a", "", "graded/stop", ("wrong",), 1, 1.0)


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({}, 0),
        ({"mutants": (KILLED, replace(KILLED, killed_by=""))}, 1),
        ({"mutants": (KILLED,)}, 1),
        ({"unchanged": replace(CLEAN, killed_by="graded/stop")}, 1),
        ({"unchanged": None}, 1),
        ({"interrupted": True}, 130),
    ],
)
def test_only_all_killed_and_the_unchanged_alive_pass(
    changed: dict[str, object], status: int
) -> None:
    whole = SelfTest(2, 9, (KILLED, replace(KILLED, name="b")), CLEAN)
    assert replace(whole, **changed).exit_status == status  # type: ignore[arg-type]


def test_every_mutation_fits_and_has_a_name_of_its_own(tmp_path: Path) -> None:
    names = [one.name for one in MUTATIONS]
    assert len(set(names)) == len(names) >= 14
    assert UNCHANGED not in names
    import engine

    packages = Path(engine.__file__).parent.parent
    for mutation in MUTATIONS:
        copy = tmp_path / mutation.package / mutation.file
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes((packages / mutation.package / mutation.file).read_bytes())
        mutation.apply(tmp_path)
        compile(copy.read_text("utf-8"), mutation.file, "exec")


def test_families_take_turns_and_patterns_choose() -> None:
    trials = small_trials()
    assert all(trial.small for _, trial in trials)
    first = [family for family, _ in trials[:2]]
    assert len(set(first)) == 2
    assert {family for family, _ in small_trials(["graded"])} == {"graded"}
    said = list(lines(["graded/stop"]))
    assert said[0] == {"tries": "graded/stop"}
    assert said[1]["outcome"] == "survived"
    assert len(said) == 2


@pytest.mark.slow
@pytest.mark.first
def test_every_bug_is_caught_and_the_engine_is_clean() -> None:
    outcome = self_test(jobs=1)
    assert [one.name for one in outcome.survivors] == []
    assert outcome.unchanged is not None
    assert outcome.unchanged.faults == ()
    assert outcome.exit_status == 0
    (runaway,) = (one for one in outcome.mutants if one.name == "contact released too late")
    assert runaway.faults == ("no end in 10 s of processor time",)

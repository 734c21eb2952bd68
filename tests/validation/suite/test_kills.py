"""Runs that are killed at random times: everything they reported as done is stored completely."""

from __future__ import annotations

import multiprocessing
import os
import random
import signal
import sys
import time
from pathlib import Path

import pytest
from killed_runs import Key, run_until_killed, suite

from ghostball.validation.results.database import has_database
from ghostball.validation.results.store import Results, ResultsWriter, has_results
from ghostball.validation.suite.unchanged import code_hash

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="kills and fork servers are POSIX"),
]


def cases_in(out: Path) -> set[Key]:
    """Return the cases that the next run would reuse; read each case, so it must be complete."""
    stored, same = ResultsWriter(out, code_hash()).known()
    assert stored == len(same)
    found = {(case.scene, case.label) for case in same.values()}
    if has_database(out) and has_results(out):
        results = Results.open(out)
        assert all(results.motion(case) is not None for case in results.cases)
        assert {(case.scene, case.label) for case in results.cases} <= found
    return found


PLANNED, KILLS = 24, 30
"""Number of cases of a run, and number of kills."""


def test_a_kill_at_any_instant_loses_nothing_that_was_done(tmp_path: Path) -> None:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["killed_runs", "ghostball.validation.suite.suite"])
    rng = random.Random(KILLS)
    patience, killed, rounds = 0.0, 0, 0
    before: set[Key] = set()
    out = tmp_path / "0"
    while killed < KILLS:
        said = tmp_path / f"said-{rounds}"
        process = context.Process(
            target=run_until_killed, args=(suite, out, said, dict(os.environ))
        )
        begun = time.monotonic()
        process.start()
        # The first process isn't killed; it shows how long a run takes.
        process.join(rng.uniform(0.0, patience) if rounds else None)
        if process.is_alive():
            os.kill(process.pid or 0, signal.SIGKILL)
            process.join()
            killed += 1
        else:
            assert process.exitcode == 0
            patience = time.monotonic() - begun  # run time without a kill
        lines = said.read_text().splitlines(keepends=True) if said.exists() else []
        done = {tuple(line[:-1].split("\t")) for line in lines if line.endswith("\n")}
        there = cases_in(out)
        assert done <= there, "what was said to be done is lost"
        assert before <= there, "what an earlier run did is lost"
        before, rounds = there, rounds + 1
        if len(there) == PLANNED:  # complete: start again in a new folder
            out, before = tmp_path / str(rounds), set()
    assert rounds > KILLS

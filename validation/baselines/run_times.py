"""Run times of two revisions, measured alternately, so that a slow moment affects both.

Each revision has its own process with its own code. The two simulate one scene after the other,
repeatedly; compilation happens before the first sample.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from threading import Timer

from ghostball.model import GhostballError
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.runs.interleave import Sampler, Task, interleave

ROUNDS = 5
"""Number of samples for each scene and revision."""

LONGEST = 2.0
"""A shot with a longer run time [s] is measured once."""

_PROGRAM = """\
import json, os, sys
answers = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)  # the output of an engine must not mix with the answers
from ghostball.model import Scene
from ghostball.reference_adapters import make_engine
engines = {}
for line in sys.stdin:
    label, scene = json.loads(line)
    if label not in engines:
        engines[label] = make_engine(label)
    result = engines[label].simulate(Scene.model_validate(scene), record="rest")
    print(result.wall_time, file=answers, flush=True)
"""


@dataclass(frozen=True)
class Revision:
    """Code that runs: the working directory, and the environment variables for importing it."""

    folder: Path
    environment: Mapping[str, str]


def run_time_ratios(
    base: Revision, head: Revision, cases: Sequence[CaseRecord], time_limit: float
) -> list[float]:
    """Return the run time of the head divided by that of the base, for each case.

    `cases`: cases that ran at both revisions.
    `time_limit` [s]: for each shot.

    Raises `GhostballError` if a shot fails, or exceeds the time limit.
    """
    with _player(base, time_limit) as before, _player(head, time_limit) as after:

        def sampler(case: CaseRecord) -> Sampler:
            shot = json.dumps([case.label, case.definition])
            for play in (before, after):  # compiles
                play(shot)
            return lambda: {"base": before(shot), "head": after(shot)}

        tasks = [
            Task(
                f"{case.scene} on {case.label}",
                partial(sampler, case),
                most=1 if (case.wall_time or 0.0) > LONGEST else None,
            )
            for case in cases
        ]
        found = interleave(tasks, ROUNDS)
    times = [(median(one["base"]), median(one["head"])) for one in found.values()]
    return [after / before for before, after in times if before > 0.0]


@contextmanager
def _player(revision: Revision, time_limit: float) -> Iterator[Callable[[str], float]]:
    """Yield a function that simulates a shot at a revision and returns its run time [s]."""
    process = subprocess.Popen(
        [sys.executable, "-c", _PROGRAM],
        cwd=revision.folder,
        env=dict(revision.environment),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    asked, answers = process.stdin, process.stdout

    def play(shot: str) -> float:
        timer = Timer(time_limit, process.kill)
        timer.start()
        try:
            print(shot, file=asked, flush=True)
            return float(answers.readline())
        except (OSError, ValueError):
            raise GhostballError(
                f"{revision.folder}: a shot failed while run times were measured"
            ) from None
        finally:
            timer.cancel()

    try:
        yield play
    finally:
        process.kill()
        process.communicate()

"""Run the stress suite: families x engines, in processes of their own, kept as they come.

>>> from ghostball.validation.stress import run_stress
>>> outcome = run_stress(["ghostball", "pymunk"], Path("out/stress"), suite="quick")
>>> outcome.exit_status
0
"""

from __future__ import annotations

import hashlib
import json
import logging
import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ghostball.model import EngineFailedError, GhostballError, UnsupportedSceneError
from ghostball.reference_adapters.registry import (
    OURS,
    EngineUnavailableError,
    make_engine,
    parse_spec,
)
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.cluster import Cluster
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.parallel.pool import Done, Progress
from ghostball.validation.parallel.sources import code_kind, is_ours
from ghostball.validation.results.database import SCHEMA
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.record_store import Name
from ghostball.validation.runs.runner import check_each_once, check_limits, run
from ghostball.validation.scenes.library import FOLDER
from ghostball.validation.stress.families import FAMILIES, chosen_trials
from ghostball.validation.stress.findings import (
    RUN,
    Finding,
    Key,
    StressFolder,
    StressRun,
    StressWriter,
    is_stress_folder,
    save_worst,
)
from ghostball.validation.stress.trial import CRASHED, NotJudgedError, Suite, Trial, Verdict
from ghostball.validation.suite.unchanged import code_hash, code_with_engines

DEFAULT_ENGINES: tuple[str, ...] = (
    "ghostball",
    "pymunk",
    "pymunk:contact_steps=exact",
    "pybullet",
    "pybullet:contact_steps=exact",
    "paper-discrete",
    "paper-continuous",
)
"""What is tried where no engine is named."""

_LOGGER = logging.getLogger("ghostball.validation")


@dataclass(frozen=True)
class StressTask:
    """One trial on one engine."""

    family: str
    trial: Trial
    label: str


@dataclass(frozen=True)
class StressOutcome:
    """What a run came to.

    `folder`: all that it now holds: also what earlier runs of the same code found, and this one
        wasn't asked for.
    `asked`: keys of the findings that this run was asked for, as far as it came.
    `must_hold`: the engines that have to survive what they are asked; of the others it is shown.
    `reused`: findings of an earlier run, by the same code, that stood.
    `interrupted`: by Ctrl-C: what was found is kept, and a next run continues from there.
    `wall_time` [s]: of this run, from its start to its last finding; kernels that had to be
        compiled included.
    """

    folder: StressFolder
    asked: tuple[Key, ...]
    must_hold: tuple[str, ...]
    reused: int = 0
    interrupted: bool = False
    wall_time: float = 0.0
    jobs: int = 1

    @property
    def exit_status(self) -> ExitStatus:
        """0 what must hold survived; 1 not.

        3 the harness failed to judge something; 4 nothing was judged, for no engine could be asked,
        or no limit covers what one did that must hold; 130 interrupted.
        """
        if self.interrupted:
            return ExitStatus.INTERRUPTED
        asked = frozenset(self.asked)
        found = [one for one in self.folder.findings if one.key in asked]
        if any(one.outcome == "failed" for one in found):
            return ExitStatus.HARNESS_FAILED
        if not any(one.outcome in ("survived", "broken") for one in found):
            return ExitStatus.NOT_JUDGED
        broken = {one.label for one in found if one.outcome == "broken"}
        if broken.intersection(self.must_hold):
            return ExitStatus.CHECK_FAILED
        survived = {one.label for one in found if one.outcome == "survived"}
        unjudged = {one.label for one in found if one.outcome == "not-judged"} - survived
        passed = not unjudged.intersection(self.must_hold)
        return ExitStatus.PASSED if passed else ExitStatus.NOT_JUDGED


def run_stress(
    labels: Sequence[str],
    out: Path,
    *,
    suite: Suite = "quick",
    only: Sequence[str] = (),
    must_hold: Sequence[str] | None = None,
    jobs: int = 1,
    cluster: Cluster | None = None,
    progress: Progress[Finding] | None = None,
    compiling: Progress[str] | None = None,
    reuse: bool = True,
    time_limit: float | None = None,
) -> StressOutcome:
    """Try to break engines, and keep what they survived in a folder.

    `labels`: engines, each `NAME` or `NAME:key=value,...`.
    `only`: families, or trials as `FAMILY/TRIAL`, each of which may be a pattern such as
        "grazing/*-miss-*"; all where it is empty.
    `must_hold`: which of the engines have to survive it all; by default all of them.
    `jobs`, `cluster`, `progress`, `compiling`, `reuse`, `time_limit`: as of `suite.run_suite`, of
        trials in place of cases. Every trial runs in another process, and has a limit of time of
        its own, which holds where it is the shorter one.

    Raises `GhostballError` before anything runs: where an engine, a family or a trial is unknown,
    or the folder can't be used.
    """
    check_limits(jobs, time_limit)
    begun = time.perf_counter()
    planned = {_key(task): task for task in _plan(labels, suite, only)}
    tasks = dict[Name, StressTask](planned.items())
    code = _hash_of_all()
    store = StressWriter(out, code, code_with_engines(code))
    earlier = store.earlier(suite)
    # What this run isn't asked for stays: a look at one family must not cost the others.
    known = dict.fromkeys([*planned, *(() if earlier is None else earlier.asked)])
    asked = StressRun(
        suite,
        tuple(name for name in FAMILIES if name in {family for family, _, _ in known}),
        tuple(dict.fromkeys([*labels, *(label for _, _, label in known)])),
        describe_environment(),
        store.code,
        tuple(known),
    )

    def prepare(names: Sequence[Name]) -> Callable[[], None]:
        rest = [tasks[name] for name in names]
        trials = {id(task.trial): task.trial for task in rest}.values()
        ours = any(parse_spec(task.label)[0] == OURS for task in rest)
        scenes = [scene for trial in trials for scene in trial.examples()] if ours else []
        left = dict.fromkeys(task.label for task in rest)
        return compile_kernels(scenes, jobs, labels=left, compiling=compiling)

    heard: set[str] = set()

    def conclude(done: Done[StressTask, Finding]) -> Finding:
        if done.printed and done.task.label not in heard:  # once: it may well print in every shot
            heard.add(done.task.label)
            where = f"{done.task.family}/{done.task.trial.name}"
            _LOGGER.warning(
                "engine %s printed in %s, and maybe more: %s", done.task.label, where, done.printed
            )
        return done.or_else(_crashed)

    ran = run(
        {name: _hash(name) if is_ours(task.label) else "" for name, task in tasks.items()},
        lambda names: (tasks[name] for name in names),
        run_trial,
        conclude,
        store,
        jobs=cluster or jobs,
        limit=lambda task: min(task.trial.limit, math.inf if time_limit is None else time_limit),
        prepare=prepare,
        kind=lambda task: code_kind(task.label),
        about=lambda _: RUN.dump_python(asked, mode="json"),
        reuse=reuse,
        progress=progress,
    )
    folder = StressFolder.load(out) if is_stress_folder(out) else StressFolder(out, asked, [])
    if ran.begun:
        save_worst(folder)
    found = tuple(key for key in planned if key in ran.records)
    wall_time = time.perf_counter() - begun
    held = tuple(labels if must_hold is None else must_hold)
    return StressOutcome(folder, found, held, ran.reused, ran.interrupted, wall_time, jobs)


def _plan(labels: Sequence[str], suite: Suite, only: Sequence[str]) -> list[StressTask]:
    """Return what is to be done, in order; refuse what is unknown."""
    check_each_once("engine", labels)
    for label in labels:
        with suppress(EngineUnavailableError):  # its trials say so
            make_engine(label)
    return [
        StressTask(family.name, trial, label)
        for family, trial in chosen_trials(suite, only)
        for label in labels
    ]


def _hash_of_all() -> str:
    """Return the hash of all that decides what is found; "" where the code isn't known.

    Of the code; and of the shipped scenes with their criteria, which some trials play.
    """
    code = code_hash()
    digest = hashlib.sha256(code.encode())
    for path in sorted(FOLDER.glob("*.toml")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest() if code else ""


def _hash(key: Name) -> str:
    """Return the hash of what a finding depends on besides the code, which makes the trials."""
    return hashlib.sha256(json.dumps([SCHEMA, *key]).encode()).hexdigest()


def _key(task: StressTask) -> Key:
    return task.family, task.trial.name, task.label


def run_trial(task: StressTask) -> Finding:
    """Try one engine with one trial; whatever goes wrong becomes part of what is found."""
    begun = time.perf_counter()
    found: dict[str, Any]
    try:
        verdict = task.trial.run(make_engine(task.label))
        found = _of_verdict(verdict)
    except EngineUnavailableError as error:
        found = {"outcome": "unavailable", "faults": (str(error),)}
    except UnsupportedSceneError as error:
        # Ours has to represent all that is tried: each trial was made for it.
        if parse_spec(task.label)[0] == OURS:
            found = _broke(task, f"it refuses a scene of its own: {error}")
        else:
            found = {"outcome": "not-representable", "faults": error.features}
    except EngineFailedError as error:
        found = _broke(task, error.reason)
    except NotJudgedError as error:
        found = {"outcome": "not-judged", "faults": (str(error),)}
    except GhostballError as error:
        found = {"outcome": "failed", "faults": (f"{type(error).__name__}: {error}",)}
    # An engine may raise anything, and its `sys.exit` must not end the run: kept, never fatal.
    except (Exception, SystemExit) as error:
        found = _broke(task, f"{type(error).__name__}: {error}")
    seconds = time.perf_counter() - begun
    return Finding(task.family, task.trial.name, task.label, **found, seconds=seconds)


def _of_verdict(verdict: Verdict) -> dict[str, Any]:
    scene = verdict.scene
    return {
        "outcome": "broken" if verdict.faults else "survived",
        "faults": verdict.faults,
        "severity": verdict.severity,
        "shots": verdict.shots,
        "broken": verdict.broken,
        "values": dict(verdict.values),
        "scene": None if scene is None else scene.model_dump(mode="json", by_alias=True),
    }


def _crashed(task: StressTask, reason: str) -> Finding:
    return Finding(task.family, task.trial.name, task.label, **_broke(task, reason))


def _broke(task: StressTask, reason: str) -> dict[str, Any]:
    """Return what is found where a trial gave no verdict."""
    scene = next(iter(task.trial.examples()), None)
    return {
        "outcome": "broken",
        "faults": (reason,),
        "severity": CRASHED,
        "shots": 1,
        "broken": 1,
        "scene": None if scene is None else scene.model_dump(mode="json", by_alias=True),
    }

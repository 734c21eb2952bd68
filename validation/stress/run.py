"""Run the stress suite: families x engines, in processes of their own, kept as they come.

>>> from ghostball.validation.stress import run_stress
>>> outcome = run_stress(["ghostball", "pymunk"], Path("out/stress"), suite="quick")
>>> outcome.exit_status
0
"""

from __future__ import annotations

import hashlib
import logging
import math
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ghostball.engine import EngineFailedError, GhostballError, UnsupportedSceneError
from ghostball.reference_adapters.registry import (
    OURS,
    EngineUnavailableError,
    make_engine,
    parse_spec,
)
from ghostball.validation.parallel.cluster import Cluster
from ghostball.validation.parallel.compiling import Compiling, compile_kernels
from ghostball.validation.parallel.pool import run_tasks
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.scenes.library import FOLDER
from ghostball.validation.stress.families import FAMILIES
from ghostball.validation.stress.findings import Finding, Key, StressFolder, StressRun, StressWriter
from ghostball.validation.stress.selection import chosen_trials
from ghostball.validation.stress.trial import (
    CRASHED,
    StressError,
    Suite,
    Trial,
    Verdict,
)
from ghostball.validation.suite.unchanged import code_hash, is_ours

DEFAULT_ENGINES: tuple[str, ...] = (
    "ghostball",
    "pymunk",
    "pymunk:mode=landed",
    "pybullet",
    "pybullet:mode=landed",
    "paper-discrete",
    "paper-continuous",
)
"""What is tried where no engine is named."""

PASSED, CHECK_FAILED, HARNESS_FAILED, NOTHING_JUDGED, INTERRUPTED = 0, 1, 3, 4, 130

_LOGGER = logging.getLogger("ghostball.validation")

Progress = Callable[[Finding, int, int], None]
"""Called with each finding, how many there are, and how many there will be."""


@dataclass(frozen=True)
class StressTask:
    """One trial on one engine."""

    family: str
    trial: Trial
    label: str


@dataclass(frozen=True)
class StressOutcome:
    """What a run came to.

    Attributes
    ----------
    folder : StressFolder
        All that it now holds: also what earlier runs of the same code found, and this one wasn't
        asked for.
    asked : tuple of (str, str, str)
        Keys of the findings that this run was asked for, as far as it came.
    taken_over : int
        Findings of an earlier run, by the same code, that stood.
    interrupted : bool
        By Ctrl-C: what was found is kept, and a next run goes on from there.
    wall_time : float [s]
        Of this run, from its start to its last finding; kernels that had to be compiled included.
    jobs : int
        Processes in which it ran.
    """

    folder: StressFolder
    asked: tuple[Key, ...]
    taken_over: int = 0
    interrupted: bool = False
    wall_time: float = 0.0
    jobs: int = 1

    @property
    def must_hold(self) -> tuple[str, ...]:
        """The engines that have to survive everything: ours, where it is asked; else all."""
        labels = tuple(dict.fromkeys(label for _, _, label in self.asked))
        return tuple(label for label in labels if parse_spec(label)[0] == OURS) or labels

    @property
    def exit_status(self) -> int:
        """0 our engine survived (or, where it isn't asked, all did); 1 not.

        3 the harness failed to judge something; 4 nothing was judged, for no engine could be asked;
        130 interrupted.
        """
        if self.interrupted:
            return INTERRUPTED
        asked = frozenset(self.asked)
        found = [one for one in self.folder.findings if one.key in asked]
        if any(one.outcome == "failed" for one in found):
            return HARNESS_FAILED
        if not any(one.outcome in ("survived", "broken") for one in found):
            return NOTHING_JUDGED
        broken = {one.label for one in found if one.outcome == "broken"}
        return CHECK_FAILED if broken.intersection(self.must_hold) else PASSED


def run_stress(
    labels: Sequence[str],
    out: Path,
    *,
    suite: Suite = "quick",
    only: Sequence[str] = (),
    jobs: int = 1,
    cluster: Cluster | None = None,
    progress: Progress | None = None,
    compiling: Compiling | None = None,
    reuse: bool = True,
    time_limit: float | None = None,
) -> StressOutcome:
    """Try to break engines, and keep what they survived in a folder.

    Parameters
    ----------
    labels : sequence of str
        Engines, each `NAME` or `NAME:key=value,...`.
    out : Path
    suite : "quick" or "full"
    only : sequence of str
        Families, or trials as `FAMILY/TRIAL`, each of which may be a pattern such as
        "grazing/*-miss-*"; all where it is empty.
    jobs : int
        Processes. Every trial runs in one of them, apart from this one: an engine that crashes or
        hangs costs that trial.
    cluster : Cluster, optional
        Where the trials run instead; `jobs` processes then only compile.
    progress : callable, optional
        See `Progress`. Not called for what is taken over.
    compiling : callable, optional
        How far the compiling of our engine's kernels is, where they aren't; see `Compiling`.
    reuse : bool
        Whether what an earlier run of the same code found in the folder stands.
    time_limit : float, optional [s]
        For each trial, where that is less than its own limit.

    Raises
    ------
    GhostballError
        Before anything runs: where an engine, a family or a trial is unknown, or the folder can't
        be used.
    """
    if jobs < 1:
        raise StressError(f"`jobs` must be at least 1, got {jobs}")
    if time_limit is not None and not 0.0 < time_limit < math.inf:
        raise StressError(f"`time_limit` must be a positive number of seconds, got {time_limit!r}")
    tasks = _plan(labels, suite, only)
    writer = StressWriter(out)
    with writer.reserved():
        return _run(
            tasks,
            tuple(labels),
            suite,
            writer,
            jobs,
            cluster,
            progress,
            compiling,
            reuse,
            time_limit,
        )


def _plan(labels: Sequence[str], suite: Suite, only: Sequence[str]) -> list[StressTask]:
    """Return what is to be done, in order; refuse what is unknown."""
    if not labels:
        raise StressError("a run needs at least one engine, got none")
    repeated = sorted({label for label in labels if labels.count(label) > 1})
    if repeated:
        raise StressError(f"each engine must be given once, got {', '.join(repeated)} again")
    for label in labels:
        _check_label(label)
    tasks = [
        StressTask(family.name, trial, label)
        for family, trial in chosen_trials(suite, only)
        for label in labels
        if not family.ours_alone or parse_spec(label)[0] == OURS
    ]
    if not tasks:
        raise StressError(
            f"what is asked for is tried on our engine alone: name `{OURS}` among the engines, got "
            f"{', '.join(labels)}"
        )
    return tasks


def _check_label(label: str) -> None:
    try:
        make_engine(label)
    except EngineUnavailableError:
        return  # its trials say so


def _run(
    tasks: Sequence[StressTask],
    labels: tuple[str, ...],
    suite: Suite,
    writer: StressWriter,
    jobs: int,
    cluster: Cluster | None,
    progress: Progress | None,
    compiling: Compiling | None,
    reuse: bool,
    time_limit: float | None,
) -> StressOutcome:
    begun = time.perf_counter()
    code = _hash_of_all()
    asked = [_key(task) for task in tasks]
    # What this run isn't asked for stays: a look at one family must not cost the others.
    stays, missing = _left_by(writer.earlier(suite), code, frozenset(asked))
    found = {key: stays[key] for key in asked if reuse and key in stays and _stands(stays[key])}
    others = [one for key, one in stays.items() if key not in frozenset(asked)]
    known = [*asked, *missing, *(one.key for one in others)]
    run = StressRun(
        suite,
        tuple(name for name in FAMILIES if name in {key[0] for key in known}),
        tuple(dict.fromkeys([*labels, *(label for _, _, label in known)])),
        describe_environment(),
        code,
        tuple(key for key in [*asked, *missing] if key not in found),
    )
    taken_over = len(found)
    rest = [task for task in tasks if _key(task) not in found]
    writer.begin(run, [*others, *found.values()])
    interrupted = False

    def limit(task: StressTask) -> float:
        return min(task.trial.limit, math.inf if time_limit is None else time_limit)

    heard: set[str] = set()

    def printed(task: StressTask, text: str) -> None:
        if task.label not in heard:  # once: it may well print in every shot
            heard.add(task.label)
            trial = f"{task.family}/{task.trial.name}"
            _LOGGER.warning("engine %s printed in %s, and maybe more: %s", task.label, trial, text)

    prepare: Callable[[], None] | None = None
    try:
        examples = {id(task.trial): task.trial for task in rest}.values()
        ours = any(parse_spec(task.label)[0] == OURS for task in rest)
        scenes = [scene for trial in examples for scene in trial.examples()] if ours else []
        labels_left = dict.fromkeys(task.label for task in rest)
        prepare = compile_kernels(scenes, jobs, labels=labels_left, compiling=compiling)
        findings = run_tasks(rest, cluster or jobs, run_trial, _died, limit, printed, prepare)
        with closing(findings):
            for one in findings:
                found[one.key] = one
                writer.add(one)
                if progress is not None:
                    progress(one, len(found), len(tasks))
    except KeyboardInterrupt:
        interrupted = True
    in_order = [*(found[key] for key in asked if key in found), *others]
    run = replace(run, missing=tuple(key for key in run.missing if key not in found))
    writer.finish(run, in_order)
    folder = StressFolder(writer.path, run, in_order)
    wall_time = time.perf_counter() - begun
    return StressOutcome(folder, tuple(found), taken_over, interrupted, wall_time, jobs)


def _hash_of_all() -> str:
    """Return the hash of all that decides what is found; "" where the code can't be told.

    Of the code; and of the shipped scenes with their criteria, which some trials play.
    """
    code = code_hash()
    digest = hashlib.sha256(code.encode())
    for path in sorted(FOLDER.glob("*.toml")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest() if code else ""


def _left_by(
    earlier: StressFolder | None, code: str, asked: frozenset[Key]
) -> tuple[dict[Key, Finding], list[Key]]:
    """Return what an earlier run by the same code found, and what was asked of it in vain.

    The latter without what is asked of this run.
    """
    if earlier is None or not earlier.run.code_hash == code != "":
        return {}, []
    stays = {one.key: one for one in earlier.findings}
    return stays, [key for key in earlier.run.missing if key not in stays and key not in asked]


def _stands(one: Finding) -> bool:
    """Whether trying it again would find the same, as far as can be told."""
    # A crash or a limit of time may have had a cause outside of all this.
    known = one.severity < CRASHED and one.outcome not in ("unavailable", "failed")
    return known and is_ours(one.label)


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


def _died(task: StressTask, reason: str) -> Finding:
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

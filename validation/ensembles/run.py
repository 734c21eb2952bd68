"""Run ensembles: the same perturbed shots on every engine, kept as they come.

>>> from ghostball.validation import run_suite
>>> from ghostball.validation.ensembles import Ensembles, compare, run_ensembles
>>> scenes, engines = [find_scene("chaos-a")], ["ghostball", "pymunk"]
>>> run_suite(scenes, engines, Path("out"))
>>> run_ensembles(scenes, engines, Path("out"), 50)
>>> compare(Ensembles.load("out"))
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from ghostball.engine import Scene, UnsupportedSceneError
from ghostball.engine.result import initial_state
from ghostball.engine.trajectory import energy_of
from ghostball.reference_adapters.registry import EngineUnavailableError, engine_name, make_engine
from ghostball.validation.ensembles.ensemble_record import (
    INSTANTS,
    REFERENCE,
    EnsembleOutcomeName,
    EnsembleRecord,
    EnsembleRun,
    EnsembleState,
)
from ghostball.validation.ensembles.ensembles_folder import Ensembles, EnsembleWriter, Key
from ghostball.validation.ensembles.member import MemberResult, MemberTask, died, run_member
from ghostball.validation.ensembles.members import EnsembleError, Size, Stream, perturb
from ghostball.validation.parallel.cluster import Cluster
from ghostball.validation.parallel.compiling import Compiling, compile_kernels
from ghostball.validation.parallel.pool import run_tasks
from ghostball.validation.results.database import SCHEMA, reserved, writing
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.store import ResultsError, has_results
from ghostball.validation.runs.our_run import run_ours
from ghostball.validation.suite.case import plain_settings
from ghostball.validation.suite.suite import check_time_limit
from ghostball.validation.suite.unchanged import code_hash, is_ours

FEWEST, MOST = 2, 1_000
"""Members of an ensemble. The tests hold a matrix of (2 x members)^2 distances in memory."""

Progress = Callable[[MemberResult, int, int], None]
"""Called with each member that is done, how many are, and how many there are."""


@dataclass(frozen=True)
class EnsembleOutcome:
    """What a run of ensembles came to.

    Attributes
    ----------
    folder : Path
    planned, done, taken_over : int
        Members: in all, those that are done, those of them that an earlier run did.
    failed : int
        Members that an engine failed on.
    interrupted : bool
        By Ctrl-C; what was done is kept, and a next run goes on from there.
    begun : bool
        Whether any member was run: if not, an interrupt left the folder as it was.
    """

    folder: Path
    planned: int = 0
    done: int = 0
    taken_over: int = 0
    failed: int = 0
    interrupted: bool = False
    begun: bool = False


def check_ensembles(
    scenes: Sequence[Scene],
    labels: Sequence[str],
    out: Path,
    count: int,
    size: Size | None = None,
) -> None:
    """Refuse what `run_ensembles` would refuse, before anything else is run.

    Raises
    ------
    GhostballError
        As `run_ensembles`.
    """
    _check_request(scenes, labels, count, size or Size())
    Ensembles.load(out)


def run_ensembles(
    scenes: Sequence[Scene],
    labels: Sequence[str],
    out: Path,
    count: int,
    *,
    size: Size | None = None,
    jobs: int = 1,
    cluster: Cluster | None = None,
    progress: Progress | None = None,
    compiling: Compiling | None = None,
    reuse: bool = True,
    time_limit: float | None = None,
) -> EnsembleOutcome:
    """Run `count` perturbed members of every scene on every engine, into a results folder.

    Parameters
    ----------
    scenes : sequence of Scene
    labels : sequence of str
        Engines, `ghostball` among them: the others are compared with it.
    out : Path
        A results folder: the suite comes first, for a report is about its cases too.
    count : int
        Members of each ensemble, 2 to 1000; our engine runs as many others for its null test.
    size : Size, optional
    jobs : int
        Processes; 1, without a `time_limit`, runs everything in this one.
    cluster : Cluster, optional
        Where the members run instead; `jobs` processes then only compile.
    progress : callable, optional
        See `Progress`.
    compiling : callable, optional
        How far the compiling of our engine's kernels is, where they aren't; see `Compiling`.
    reuse : bool
        Whether members that came to their end in an earlier run into the folder, unchanged in
        scene, size, settings and code, are taken over; see `validation.suite.unchanged`.
    time_limit : float, optional [s]
        For each member, which then runs in another process: one that takes longer has failed.

    Raises
    ------
    GhostballError
        Before anything runs: where a number is wrong, our engine or another is missing, the size is
        too large for a scene, or the folder holds ensembles that can't be read.

    Notes
    -----
    An engine that can't represent a scene is asked once. One that crashes costs the member that it
    crashed on. What came to no end is counted and named, and left out of the tests.
    """
    size = size or Size()
    _check_request(scenes, labels, count, size)
    check_time_limit(time_limit)
    if jobs < 1:
        raise EnsembleError(f"`jobs` must be at least 1, got {jobs}")
    if not has_results(out):
        raise ResultsError(
            f"{out}: not a results folder yet. Run the suite into it first: `ghostball validate`"
        )
    with reserved(out), writing(out) as database:
        run = EnsembleRun(
            count,
            size,
            tuple(scene.name for scene in scenes),
            tuple(labels),
            describe_environment(),
        )
        return _Run(run, scenes, out, database, reuse).go(
            jobs, cluster, progress, compiling, time_limit
        )


def _check_request(scenes: Sequence[Scene], labels: Sequence[str], count: int, size: Size) -> None:
    if not FEWEST <= count <= MOST:
        raise EnsembleError(
            f"an ensemble must have {FEWEST} to {MOST} members, got {count}. Tests need about 20"
        )
    if not scenes:
        raise EnsembleError("ensembles need at least one scene, got none")
    if REFERENCE not in labels or len(labels) < 2:
        raise EnsembleError(
            f"ensembles compare engines with `{REFERENCE}`, so there must be that one and another, "
            f"got {', '.join(labels) or 'none'}. Name both with `--engine`"
        )
    for what, names in (("scene", [scene.name for scene in scenes]), ("engine", labels)):
        repeated = sorted({name for name in names if names.count(name) > 1})
        if repeated:
            raise EnsembleError(f"each {what} must be given once, got {', '.join(repeated)} again")
    for scene in scenes:
        size.check(scene)


@dataclass(eq=False)
class _Ensemble:
    """One ensemble while it is made."""

    record: EnsembleRecord
    scene: Scene
    before: frozenset[int]  # numbers of the members that an earlier run did
    settled: int = 0  # members of this run of which nothing more is to come

    def missing(self, count: int) -> list[int]:
        """Return the numbers of the members that must be run."""
        if self.record.outcome != "ran":
            return []
        return [index for index in range(count) if index not in self.before]


class _Run:
    """A run of ensembles, from the plan to the last member."""

    def __init__(
        self,
        run: EnsembleRun,
        scenes: Sequence[Scene],
        out: Path,
        database: sqlite3.Connection,
        reuse: bool,
    ) -> None:
        self._count, self._out = run.count, out
        self._writer = EnsembleWriter(database, run)
        code = code_hash()
        before = self._writer.done_before(code, run.count) if reuse else {}
        self._ensembles: dict[Key, _Ensemble] = {}
        for scene in scenes:
            for planned in _planned(scene, run):
                record = replace(planned, code_hash=code)
                done = before.get(record.inputs_hash, frozenset())
                self._ensembles[record.key] = _Ensemble(record, scene, done)

    def go(
        self,
        jobs: int,
        cluster: Cluster | None,
        progress: Progress | None,
        compiling: Compiling | None,
        time_limit: float | None,
    ) -> EnsembleOutcome:
        """Run what is missing; each member is kept as soon as it is done."""
        missing = {key: one.missing(self._count) for key, one in self._ensembles.items()}
        planned = self._count * len(self._ensembles)
        done = taken_over = planned - sum(map(len, missing.values()))
        state: EnsembleState = "interrupted"
        begun, failed = False, 0
        prepare: Callable[[], None] | None = None
        try:
            labels = {key[1] for key, those in missing.items() if those}
            if wanted := [self._ensembles[key].scene for key, those in missing.items() if those]:
                prepare = compile_kernels(wanted, jobs, labels=labels, compiling=compiling)
            finished = run_tasks(
                self._tasks(missing),
                cluster or jobs,
                run_member,
                died,
                time_limit,
                prepare=prepare,
            )
            with closing(finished):
                for result in finished:
                    if not begun:
                        self._begin()
                        begun = True
                    key = (result.scene, result.label, result.stream)
                    done += self._note(result, len(missing[key]))
                    failed += result.outcome == "failed"
                    if progress is not None:
                        progress(result, done, planned)
            if not begun:
                self._begin()
            state = "complete"
        except KeyboardInterrupt:
            pass  # said in the outcome
        finally:
            # Interrupted before anything was done, the folder stays as it was.
            if begun or state == "complete":
                self._writer.finish(state)
        return EnsembleOutcome(
            self._out, planned, done, taken_over, failed, state == "interrupted", begun
        )

    def _begin(self) -> None:
        self._writer.begin({one.record: bool(one.before) for one in self._ensembles.values()})

    def _note(self, result: MemberResult, missing: int) -> int:
        """Keep a member that is done; return how many of the missing ones that settles."""
        one = self._ensembles[result.scene, result.label, result.stream]
        if one.record.outcome != "ran":
            return 0  # it was on its way already when the first one was refused
        settles = 1
        if result.outcome in ("not-representable", "unavailable") and not one.settled:
            one.record = replace(one.record, outcome=result.outcome, reason=result.reason)
            self._writer.refuse(one.record)
            settles = missing
        else:
            self._writer.write(result)
        one.settled += settles
        return settles

    def _tasks(self, missing: Mapping[Key, Sequence[int]]) -> Iterator[MemberTask]:
        """Yield what is to be run, ensemble by ensemble; one that was refused is left at once."""
        for key, indices in missing.items():
            one = self._ensembles[key]
            for index in indices:
                if one.record.outcome != "ran":
                    break
                record = one.record
                member = perturb(one.scene, record.size, index, record.stream)
                yield MemberTask(member, record.label, record.stream, index, record.times)


def _planned(scene: Scene, run: EnsembleRun) -> Iterator[EnsembleRecord]:
    """Yield the ensembles of a scene, without members."""
    try:
        alone = run_ours(scene, "rest")
        reason, t_end = "", alone.rest_time
    except UnsupportedSceneError as error:
        lacks = "; ".join(error.features)
        reason, t_end = f"`{REFERENCE}`, with which engines are compared, lacks it: {lacks}", 0.0
    definition = scene.model_dump(mode="json", by_alias=True)
    for label in run.labels:
        settings: dict[str, Any] = {}
        outcome: EnsembleOutcomeName = "not-representable" if reason else "ran"
        why = reason
        try:
            settings = plain_settings(make_engine(label))
        except EngineUnavailableError as error:
            outcome, why = "unavailable", str(error)
        streams: tuple[Stream, ...] = ("shots", "null") if label == REFERENCE else ("shots",)
        for stream in streams:
            record = EnsembleRecord(
                scene.name,
                definition,
                label,
                engine_name(label),
                stream,
                run.size,
                settings,
                np.linspace(0.0, t_end, INSTANTS),
                float(energy_of(scene, initial_state(scene)).total[0]),
                outcome,
                why,
            )
            ours = outcome == "ran" and is_ours(label)
            yield replace(record, inputs_hash=_inputs_hash(record)) if ours else record


def _inputs_hash(record: EnsembleRecord) -> str:
    """Return the hash of all that an ensemble is asked to do, but for how many members it has."""
    asked = {
        "schema": SCHEMA,
        "scene": record.definition,
        "label": record.label,
        "stream": record.stream,
        "size": asdict(record.size),
        "settings": record.settings,
        "times": record.times.tolist(),
    }
    return sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()

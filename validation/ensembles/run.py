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
from collections.abc import Callable, Iterator, Sequence
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
)
from ghostball.validation.ensembles.ensembles_folder import RUN, Ensembles, EnsembleWriter
from ghostball.validation.ensembles.member import MemberResult, MemberTask, run_member, unended
from ghostball.validation.ensembles.members import EnsembleError, Size, Stream, perturb
from ghostball.validation.parallel.cluster import Cluster
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.parallel.pool import Done, Progress
from ghostball.validation.results.database import SCHEMA
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.record_store import Name
from ghostball.validation.results.store import ResultsError, has_results
from ghostball.validation.runs.our_run import run_ours
from ghostball.validation.runs.runner import run
from ghostball.validation.suite.case import plain_settings
from ghostball.validation.suite.plan import check_time_limit
from ghostball.validation.suite.unchanged import code_hash, is_ours

FEWEST, MOST = 2, 1_000
"""Members of an ensemble. The tests hold a matrix of (2 x members)^2 distances in memory."""


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
        Whether earlier ensembles gave way to these: if not, an interrupt left the folder as it was.
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
    progress: Progress[MemberResult] | None = None,
    compiling: Progress[str] | None = None,
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
        Called with how many members are done, of how many, and the last.
    compiling : callable, optional
        How far the compiling of our engine's kernels is, where they aren't; see `compile_kernels`.
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
    check_ensembles(scenes, labels, out, count, size)
    check_time_limit(time_limit)
    if jobs < 1:
        raise EnsembleError(f"`jobs` must be at least 1, got {jobs}")
    if not has_results(out):
        raise ResultsError(
            f"{out}: not a results folder yet. Run the suite into it first: `ghostball validate`"
        )
    records: dict[Name, EnsembleRecord] = {
        one.key: one for scene in scenes for one in _planned(scene, labels, size)
    }
    by_name = {scene.name: scene for scene in scenes}
    keys: dict[Name, str] = {
        (*record.key, record.inputs, str(index)): (
            f"{record.inputs} {index}" if is_ours(record.label) else ""
        )
        for record in records.values()
        if record.outcome == "ran"
        for index in range(count)
    }
    asked = EnsembleRun(
        count,
        size,
        tuple(by_name),
        tuple(labels),
        describe_environment(),
        ensembles=tuple(records.values()),
    )
    refused: set[Name] = set()  # what an engine can't represent, it isn't asked again

    def tasks(names: Sequence[Name]) -> Iterator[MemberTask]:
        for name in names:
            if name[:3] not in refused:
                record, index = records[name[:3]], int(name[-1])
                member = perturb(by_name[record.scene], size, index, record.stream)
                yield MemberTask(
                    member, record.label, record.stream, index, record.times, record.inputs
                )

    def settle(done: Done[MemberTask, MemberResult]) -> MemberResult:
        result = done.or_else(unended)
        if result.outcome in ("not-representable", "unavailable"):
            refused.add(result.ensemble)
        return result

    def prepare(names: Sequence[Name]) -> Callable[[], None]:
        wanted = dict.fromkeys(name[0] for name in names)
        left = dict.fromkeys(name[1] for name in names)
        those = [by_name[name] for name in wanted]
        return compile_kernels(those, jobs, labels=left, compiling=compiling)

    ran = run(
        keys,
        tasks,
        run_member,
        settle,
        EnsembleWriter(out, code_hash()),
        jobs=cluster or jobs,
        limit=time_limit,
        prepare=prepare,
        about=lambda _: RUN.dump_python(asked, mode="json"),
        reuse=reuse,
        progress=progress,
    )
    unasked = count * sum(record.outcome != "ran" for record in records.values())
    skipped = sum(name[:3] in refused and name not in ran.records for name in keys)
    return EnsembleOutcome(
        out,
        count * len(records),
        unasked + skipped + len(ran.records),
        unasked + ran.taken_over,
        sum(one.outcome == "failed" for one in ran.records.values()),
        ran.interrupted,
        ran.begun,
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


def _planned(scene: Scene, labels: Sequence[str], size: Size) -> Iterator[EnsembleRecord]:
    """Yield the ensembles of a scene, without members."""
    try:
        alone = run_ours(scene, "rest")
        reason, t_end = "", alone.rest_time
    except UnsupportedSceneError as error:
        lacks = "; ".join(error.features)
        reason, t_end = f"`{REFERENCE}`, with which engines are compared, lacks it: {lacks}", 0.0
    definition = scene.model_dump(mode="json", by_alias=True)
    for label in labels:
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
                size,
                settings,
                np.linspace(0.0, t_end, INSTANTS),
                float(energy_of(scene, initial_state(scene)).total[0]),
                outcome,
                why,
            )
            yield replace(record, inputs=_inputs_hash(record))


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

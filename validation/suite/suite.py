"""The suite: scenes x engines, run, measured, judged, and written as they come.

>>> from ghostball.validation import run_suite, select
>>> outcome = run_suite(select(["smoke"]), ["ghostball", "pymunk"], Path("out"))
>>> outcome.exit_status
0
"""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ghostball.engine import GhostballError, Scene
from ghostball.engine.compilation import MANY
from ghostball.reference_adapters.registry import (
    EngineUnavailableError,
    engine_name,
    engine_names,
    make_engine,
)
from ghostball.validation.checks.criteria import Criteria, criteria_beside
from ghostball.validation.checks.law import Asked, asked_of
from ghostball.validation.checks.metric_table import METRICS, choose_metrics
from ghostball.validation.checks.verdict import is_nothing_judged, is_unfinished
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.cluster import Cluster
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.parallel.pool import Done, Progress
from ghostball.validation.parallel.runner import Name, Reuse, run
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import Finished, PartWriter, ResultsWriter
from ghostball.validation.scenes.library import FOLDER, find_scene, paths_among, scene_names
from ghostball.validation.suite.case import (
    Case,
    TruthFailure,
    blank_record,
    failed,
    plain_settings,
    run_case,
)
from ghostball.validation.suite.unchanged import code_hash, dates_of, inputs_hash, is_ours
from ghostball.validation.truth.scene_truth import PARTS, Truth, TruthPart, check_truth, truth_of

DEFAULT_ENGINES: tuple[str, ...] = (
    "ghostball",
    "pymunk",
    "pymunk:mode=landed",
    "pymunk:config=default",
    "pybullet",
    "pybullet:mode=landed",
    "pybullet:config=default",
    "paper-discrete",
    "paper-continuous",
)
"""What `ghostball validate` runs where `--engine` is left out."""


@dataclass(frozen=True)
class Counts:
    """How many cases, by outcome, and how many checks, by verdict.

    Unfinished is a case that is no run to its end: it failed, or it stopped early.
    """

    ran: int = 0
    not_representable: int = 0
    unavailable: int = 0
    failed: int = 0
    unfinished: int = 0
    checks_passed: int = 0
    checks_failed: int = 0
    checks_reference: int = 0
    checks_left_out: int = 0
    taken_over: int = 0


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run came to.

    Attributes
    ----------
    folder : Path
        Where the results are.
    cases : list of CaseRecord
        Those that are done: those taken over, then the others in order of completion.
    planned : int
        How many there would have been.
    interrupted : bool
        Whether the run was cut short by Ctrl-C; the folder then holds what was done.
    begun : bool
        Whether earlier results in the folder gave way to those of this run, be they none.
    """

    folder: Path
    cases: list[CaseRecord] = field(default_factory=list)
    planned: int = 0
    interrupted: bool = False
    begun: bool = False

    @property
    def counts(self) -> Counts:
        """Cases by outcome and checks by verdict."""
        outcomes = [case.outcome for case in self.cases]
        verdicts = [check.passed for case in self.cases for check in case.checks]
        return Counts(
            ran=outcomes.count("ran"),
            not_representable=outcomes.count("not-representable"),
            unavailable=outcomes.count("unavailable"),
            failed=outcomes.count("failed"),
            unfinished=sum(is_unfinished(case) for case in self.cases),
            checks_passed=verdicts.count(True),
            checks_failed=verdicts.count(False),
            checks_reference=verdicts.count(None),
            checks_left_out=sum(len(case.left_out) for case in self.cases),
            taken_over=sum(case.taken_over for case in self.cases),
        )

    @property
    def exit_status(self) -> ExitStatus:
        """0 all passed; 1 a check failed, or an engine didn't come to its end; 130 interrupted.

        3 ghostball itself failed to judge a case; 4 nothing was judged.
        """
        return ExitStatus.INTERRUPTED if self.interrupted else exit_status_of(self.cases)


def exit_status_of(cases: Collection[CaseRecord]) -> ExitStatus:
    """Return what these cases come to, as `Outcome.exit_status` says."""
    if any(case.fault == "ghostball" for case in cases):
        return ExitStatus.HARNESS_FAILED
    if any(map(is_unfinished, cases)) or any(
        check.passed is False for case in cases for check in case.checks
    ):
        return ExitStatus.CHECK_FAILED
    return ExitStatus.NOT_JUDGED if is_nothing_judged(cases) else ExitStatus.PASSED


class SuiteError(GhostballError, ValueError):
    """A run that can't start: no scene, no engine, the same one twice, a wrong number of jobs."""


def run_suite(
    scenes: Sequence[Scene],
    engine_specs: Sequence[str],
    out: Path,
    *,
    jobs: int = 1,
    cluster: Cluster | None = None,
    progress: Progress[CaseRecord] | None = None,
    compiling: Progress[str] | None = None,
    criteria: Mapping[str, Criteria] | None = None,
    metrics: Sequence[str] | None = None,
    reuse: bool = False,
    announce: Callable[[Reuse[CaseRecord]], None] | None = None,
    time_limit: float | None = None,
    only: Collection[Name] | None = None,
) -> Outcome:
    """Run every scene on every engine and write a results folder.

    Parameters
    ----------
    scenes : sequence of Scene
        Names must differ.
    engine_specs : sequence of str
        `NAME` or `NAME:key=value,...`; an engine that is known but can't run here gives cases
        that say so.
    out : Path
        The results folder; earlier results in it are replaced when the first case that runs is
        done.
    jobs : int
        Processes; 1, without a `time_limit`, runs everything in this one, which an engine that
        crashes then ends. Wall times are best taken with 1.
    cluster : Cluster, optional
        Where the cases run instead; `jobs` processes then only compile.
    progress : callable, optional
        Called with how many cases are done, of how many, and the last; not for what is taken over.
    compiling : callable, optional
        How far the compiling of our engine's kernels is, where they aren't; see `compile_kernels`.
    criteria : mapping of str to Criteria, optional
        By scene name. A scene that isn't named here and equals a shipped one has that one's.
    metrics : sequence of str, optional
        Names, or patterns such as "rest_error_*", of the metrics that are computed and judged; all
        where it is left out. A criterion on another metric isn't judged: `CaseRecord.left_out`.
    reuse : bool
        Whether cases that are unchanged since an earlier run into the same folder are taken over
        from there instead of run again; see `validation.suite.unchanged`.
    announce : callable, optional
        Called once, before anything runs, with what is taken over from earlier results.
    time_limit : float, optional [s]
        For each case, which then runs in another process, also with one of `jobs`: an engine that
        takes longer, or crashes, costs that case, which has "failed". Guard a script with
        `if __name__ == "__main__"`.
    only : collection of (str, str), optional
        The scene and the label of each case that is run, where not every scene is run on every
        engine. What else the same code left in the folder then stays beside them.

    Raises
    ------
    GhostballError
        Before anything runs: where an engine, a setting or a metric is unknown, the criteria are
        wrong, or the folder can't be used, such as while another run writes there.

    Notes
    -----
    Each case is recorded with its whole motion. The truth of a scene is computed once. Interrupted
    by Ctrl-C, the run stops, keeps what is done and says so in `Outcome.interrupted`; what earlier
    runs found and this one has not come to is kept too, for a later run with `reuse`.
    """
    plan = _plan(scenes, engine_specs, criteria or {}, jobs, metrics, only)
    check_time_limit(time_limit)
    store = (ResultsWriter if only is None else PartWriter)(out, code_hash())

    def prepare(pairs: Sequence[Name]) -> Callable[[], None]:
        return compile_kernels(
            plan.scenes_of(pairs),
            jobs,
            labels=dict.fromkeys(label for _, label in pairs),
            tangents=True,
            contacts_from=MANY,
            compiling=compiling,
        )

    def about(taken_over: Mapping[Name, CaseRecord]) -> dict[str, Any]:
        dates = dates_of(taken_over.values())
        return describe_environment() | plan.describe() | {"taken_over": dates}

    ran = run(
        plan.inputs,
        plan.cases,
        run_case,
        finished,
        store,
        jobs=cluster or jobs,
        limit=time_limit,
        prepare=prepare,
        about=about,
        reuse=reuse,
        announce=announce,
        progress=progress,
    )
    return Outcome(out, list(ran.records.values()), plan.size, ran.interrupted, ran.begun)


def finished(done: Done[Case, Finished]) -> Finished:
    """Return what came of a case, with what its engine printed and when that was."""
    record, motion = done.or_else(lambda case, why: (failed(blank_record(case), why), None))
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return replace(record, printed=done.printed, measured=now), motion


def check_time_limit(seconds: float | None) -> None:
    """Refuse a limit of time that is none.

    Raises
    ------
    SuiteError
        Where it isn't a positive number of seconds.
    """
    if seconds is not None and not 0.0 < seconds < math.inf:
        raise SuiteError(f"`time_limit` must be a positive number of seconds, got {seconds!r}")


def shipped_criteria(scene: Scene) -> Criteria:
    """Return the criteria of the shipped scene that `scene` is; none where it is no shipped one.

    A scene that shares its name with a shipped one but differs in a value has none: the numbers
    were chosen for the shipped values.

    Raises
    ------
    CriteriaError
        Where its criteria file is refused.
    """
    if scene.name not in scene_names() or find_scene(scene.name) != scene:
        return Criteria()
    return criteria_beside(FOLDER / f"{scene.name}.toml")


def criteria_beside_paths(names_or_tags: Sequence[str]) -> dict[str, Criteria]:
    """Return the criteria of the scenes that are given by path, by scene name.

    Parameters
    ----------
    names_or_tags : sequence of str
        What `select` was asked for; names and tags are passed over.

    Raises
    ------
    GhostballError
        Where such a scene or the criteria beside it are refused.
    """
    return {find_scene(path).name: criteria_beside(path) for path in paths_among(names_or_tags)}


@dataclass(frozen=True, eq=False)
class _Plan:
    """A run, checked: what will be run and against which criteria."""

    scenes: Sequence[Scene]
    settings: Mapping[str, dict[str, Any] | None]  # by label; None: the engine is unavailable
    criteria: Mapping[str, Criteria]  # by scene name
    asked: Mapping[Name, Asked]  # by scene name and label
    inputs: Mapping[Name, str]  # hashes; "": always run
    metrics: tuple[str, ...] | None  # None: all

    @property
    def size(self) -> int:
        return len(self.inputs)

    def describe(self) -> dict[str, Any]:
        """Return what the environment of the results says of the run."""
        return {
            "scenes": [scene.name for scene in self.scenes],
            "engines": list(self.settings),
            "engine_settings": dict(self.settings),
            "metrics": list(self.metrics or METRICS),
            "planned": self.size,
        }

    def scenes_of(self, pairs: Sequence[Name]) -> list[Scene]:
        """Return the scenes that these cases need, each once."""
        names = {name for name, _ in pairs}
        return [scene for scene in self.scenes if scene.name in names]

    def cases(self, pairs: Sequence[Name]) -> Iterator[Case]:
        """Yield these cases, scene by scene; a scene's truth is computed when its turn comes."""
        computed = METRICS if self.metrics is None else self.metrics
        parts = frozenset(part for name in computed if (part := METRICS[name].compares) is not None)
        if "accuracy" in computed or any(self.asked[pair].rule is not None for pair in pairs):
            parts |= {"proof"}  # limits of a step are computed along the proved motion
        if "accuracy" in computed:
            parts |= {"events", "conditioning"}
        for scene in self.scenes_of(pairs):
            truth = truth_or_failure(scene, self.criteria[scene.name], parts)
            for pair in pairs:
                if pair[0] == scene.name:
                    yield Case(scene, pair[1], truth, self.asked[pair], self.metrics)


def _plan(
    scenes: Sequence[Scene],
    labels: Sequence[str],
    criteria: Mapping[str, Criteria],
    jobs: int,
    metrics: Sequence[str] | None,
    only: Collection[Name] | None = None,
) -> _Plan:
    if jobs < 1:
        raise SuiteError(f"`jobs` must be at least 1, got {jobs}")
    chosen = None if metrics is None else choose_metrics(metrics)
    _each_once("scene", [scene.name for scene in scenes])
    _each_once("engine", labels)
    settings = {label: _settings_of(label) for label in labels}
    own = {
        scene.name: criteria[scene.name] if scene.name in criteria else shipped_criteria(scene)
        for scene in scenes
    }
    names = {label: engine_name(label) for label in labels}
    known = tuple(dict.fromkeys((*engine_names(), *names.values())))
    for scene in scenes:
        own[scene.name].check_engines(known, f'criteria of scene "{scene.name}"')
        if scene.name in criteria:  # the shipped ones are checked as their truth is computed
            check_truth(scene, own[scene.name].truth)
    foreign = tuple(e for e, values in settings.items() if values is not None and not is_ours(e))
    asked: dict[Name, Asked] = {}
    inputs: dict[Name, str] = {}
    for scene in scenes:
        for label, values in settings.items():
            pair, limits = (scene.name, label), own[scene.name]
            if only is not None and pair not in only:
                continue
            asked[pair] = Asked() if values is None else asked_of([(names[label], values)], limits)
            inputs[pair] = (
                ""
                if values is None or label in foreign
                else inputs_hash(scene, label, values, asked[pair], limits.truth, chosen)
            )
    return _Plan(scenes, settings, own, asked, inputs, chosen)


def _each_once(what: str, names: Sequence[str]) -> None:
    if not names:
        raise SuiteError(f"a run needs at least one {what}, got none")
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise SuiteError(f"each {what} must be given once, got {', '.join(repeated)} again")


def _settings_of(label: str) -> dict[str, Any] | None:
    """Return all settings of the engine that `label` names, or None where it can't run here."""
    try:
        return plain_settings(make_engine(label))
    except EngineUnavailableError:
        return None


def truth_or_failure(
    scene: Scene, criteria: Criteria, parts: frozenset[TruthPart] = PARTS
) -> Truth | TruthFailure:
    """Return the truth of a scene, or why it could not be computed."""
    try:
        return truth_of(scene, criteria.truth, parts, least=criteria.least_proved)
    except Exception as error:  # a fault of ours; the run goes on and reports it
        return TruthFailure(f"{type(error).__name__}: {error}", traceback.format_exc())

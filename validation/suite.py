"""The suite: scenes x engines, run, measured, judged, and written as they come.

>>> from validation import run_suite, select
>>> outcome = run_suite(select(suite="smoke"), ["ghostball", "pymunk"], Path("out"))
>>> outcome.exit_status
0
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from engine import GhostballError, Scene, warm_up
from reference_adapters.registry import (
    EngineUnavailableError,
    engine_names,
    make_engine,
    parse_spec,
)
from validation.case import Case, TruthFailure, plain_settings
from validation.criteria import SUFFIX, Criteria, Criterion, criteria_beside
from validation.environment import describe_environment
from validation.library import FOLDER, find_scene, paths_among, scene_names
from validation.records import CaseRecord
from validation.store import ResultsWriter, RunState
from validation.truth import Truth, check_truth, truth_of
from validation.worker import run_cases

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
"""What `ghostball validate` runs where `--engines` is left out."""

PASSED, CHECK_FAILED, HARNESS_FAILED = 0, 1, 3
"""Exit statuses of a run that went to its end."""

INTERRUPTED = 130
"""Exit status of an interrupted run, as shells have it: 128 + SIGINT."""

Progress = Callable[[CaseRecord, int, int], None]
"""Called after each case with its record, how many are done, and how many there are."""


@dataclass(frozen=True)
class Counts:
    """How many cases, by outcome, and how many checks, by verdict."""

    ran: int = 0
    not_representable: int = 0
    unavailable: int = 0
    failed: int = 0
    checks_passed: int = 0
    checks_failed: int = 0
    checks_reference: int = 0


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run came to.

    Attributes
    ----------
    folder : Path
        Where the results are.
    cases : list of CaseRecord
        Those that are done, in order of completion.
    planned : int
        How many there would have been.
    interrupted : bool
        Whether the run was cut short by Ctrl-C; the folder then holds what was done.
    """

    folder: Path
    cases: list[CaseRecord] = field(default_factory=list)
    planned: int = 0
    interrupted: bool = False

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
            checks_passed=verdicts.count(True),
            checks_failed=verdicts.count(False),
            checks_reference=verdicts.count(None),
        )

    @property
    def exit_status(self) -> int:
        """0 all passed; 1 a check failed; 3 the harness failed; 130 interrupted."""
        counts = self.counts
        if self.interrupted:
            return INTERRUPTED
        if counts.failed:
            return HARNESS_FAILED
        return CHECK_FAILED if counts.checks_failed else PASSED


class SuiteError(GhostballError, ValueError):
    """A run that can't start: no scene, no engine, the same one twice, a wrong number of jobs."""


def run_suite(
    scenes: Sequence[Scene],
    engine_specs: Sequence[str],
    out: Path,
    *,
    jobs: int = 1,
    progress: Progress | None = None,
    criteria: Mapping[str, Criteria] | None = None,
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
        The results folder; earlier results in it are replaced when the first case is done.
    jobs : int
        Processes; 1 runs everything in this one. Wall times are best taken with 1.
    progress : callable, optional
        See `Progress`.
    criteria : mapping of str to Criteria, optional
        By scene name. A scene that isn't named here and equals a shipped one has that one's.

    Raises
    ------
    GhostballError
        Before anything runs: where an engine or a setting is unknown, the criteria are wrong, or
        the folder can't be used.

    Notes
    -----
    Each case is recorded with its whole motion. The truth of a scene is computed once. Interrupted
    by Ctrl-C, the run stops, keeps what is done and says so in `Outcome.interrupted`.
    """
    plan = _plan(scenes, engine_specs, criteria or {}, jobs)
    writer = ResultsWriter(out)
    outcome = Outcome(writer.path, planned=plan.size)
    environment = describe_environment() | plan.describe()
    state: RunState = "interrupted"
    try:
        warm_up(plan.scenes)  # here, once: else each process would compile, and say so
        with closing(run_cases(plan.cases(), jobs)) as finished:
            for record, motion in finished:
                if not outcome.cases:
                    writer.begin(environment)
                outcome.cases.append(writer.write(record, motion))
                if progress is not None:
                    progress(outcome.cases[-1], len(outcome.cases), plan.size)
        state = "complete"
    except KeyboardInterrupt:
        return replace(outcome, interrupted=True)
    finally:
        writer.finish(state)
    return outcome


def shipped_criteria(scene: Scene) -> Criteria:
    """Return the criteria of the shipped scene that `scene` is; none where it is no shipped one.

    A scene that shares its name with a shipped one but differs in a value has none: the numbers
    were chosen for the shipped values.

    Raises
    ------
    CriteriaError
        Where its criteria file is refused.
    """
    path = FOLDER / f"{scene.name}{SUFFIX}"
    if scene.name not in scene_names() or find_scene(scene.name) != scene or not path.exists():
        return Criteria()
    return Criteria.load(path)


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
    applying: Mapping[tuple[str, str], tuple[Criterion, ...]]  # by scene name and label

    @property
    def size(self) -> int:
        return len(self.scenes) * len(self.settings)

    def describe(self) -> dict[str, Any]:
        """Return what `env.json` says of the run."""
        return {
            "scenes": [scene.name for scene in self.scenes],
            "engines": list(self.settings),
            "engine_settings": dict(self.settings),
        }

    def cases(self) -> Iterator[Case]:
        """Yield every case, scene by scene; a scene's truth is computed when its turn comes."""
        for scene in self.scenes:
            truth = _truth_or_failure(scene, self.criteria[scene.name])
            for label in self.settings:
                yield Case(scene, label, truth, self.applying[scene.name, label])


def _plan(
    scenes: Sequence[Scene],
    labels: Sequence[str],
    criteria: Mapping[str, Criteria],
    jobs: int,
) -> _Plan:
    if jobs < 1:
        raise SuiteError(f"`jobs` must be at least 1, got {jobs}")
    _each_once("scene", [scene.name for scene in scenes])
    _each_once("engine", labels)
    settings = {label: _settings_of(label) for label in labels}
    own = {
        scene.name: criteria[scene.name] if scene.name in criteria else shipped_criteria(scene)
        for scene in scenes
    }
    for scene in scenes:
        own[scene.name].check_engines(engine_names(), f'criteria of scene "{scene.name}"')
        check_truth(scene, own[scene.name].truth)
    applying = {
        (scene.name, label): ()
        if values is None
        else own[scene.name].applying_to(parse_spec(label)[0], values)
        for scene in scenes
        for label, values in settings.items()
    }
    return _Plan(scenes, settings, own, applying)


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


def _truth_or_failure(scene: Scene, criteria: Criteria) -> Truth | TruthFailure:
    try:
        return truth_of(scene, criteria.truth)
    except Exception as error:  # a fault of ours; the run goes on and reports it
        return TruthFailure(f"{type(error).__name__}: {error}", traceback.format_exc())

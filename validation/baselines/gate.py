"""Compare the present results of an engine with its accepted baselines.

A baseline holds exact bits, so it can't describe an engine that isn't deterministic. Every scene
with a result different from its baseline is therefore simulated a second time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ghostball.model import EngineFailedError, GhostballError, Scene, UnsupportedSceneError
from ghostball.model.hashes import bits_hash
from ghostball.reference_adapters.registry import (
    OURS,
    EngineUnavailableError,
    engine_class,
    make_engine,
    parse_spec,
)
from ghostball.reference_adapters.returned import check_result
from ghostball.validation.baselines.baseline import (
    Accepted,
    Baseline,
    BaselineSchemaError,
    baseline_names,
    baseline_path,
    engine_folder,
    engine_key,
    load_baseline,
)
from ghostball.validation.baselines.compare import compare
from ghostball.validation.baselines.compared_run import ComparedRun, EventLog
from ghostball.validation.baselines.regression import (
    UNCOMPARED,
    Change,
    FailOn,
    Regression,
    SceneChange,
)
from ghostball.validation.baselines.revision import checkout_of
from ghostball.validation.baselines.rounding import allowance
from ghostball.validation.checks.verdict import not_judged
from ghostball.validation.parallel.sources import (
    SourcesError,
    code_kind,
    engine_code,
    hash_sources,
    is_ours,
    source_folders,
)
from ghostball.validation.results.environment import describe_environment, git_state
from ghostball.validation.results.records import CaseRecord, Check, status_name
from ghostball.validation.results.store import Results
from ghostball.validation.runs.engine_runs import in_other_process, run_engine, run_ours
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.scenes import commands
from ghostball.validation.scenes.gases import many_balls
from ghostball.validation.suite.case import blank_record, failed
from ghostball.validation.suite.judge import Case, TruthFailure
from ghostball.validation.suite.unchanged import hash_of

RunAgain = Callable[[Scene], str]
"""Simulate a scene again and return the hash of the result, or why there is none."""

NOT_FINITE = "its results contain NaN or infinity, so they can't be compared or accepted"


@dataclass(frozen=True)
class Gate:
    """An engine that is compared with baselines: its label, its baseline key, and the folder."""

    label: str
    engine: str
    folder: Path

    @classmethod
    def of(cls, label: str, baselines: Path) -> Gate:
        """Return the gate of an engine; `baselines` is the folder of all baselines.

        Raises `BaselineError` if the path exists and isn't a folder.
        """
        engine = engine_key(label)
        return cls(label, engine, engine_folder(baselines, engine))

    def guards(self, scene: str) -> bool:
        """Return True if the scene has a baseline."""
        return baseline_path(self.folder, scene).exists()

    def check(self, scenes: Sequence[str]) -> None:
        """Read the baselines of some scenes, to refuse a damaged one before anything runs.

        Baselines of another schema version are ignored here; the comparison reports them with their
        scenes.

        Raises `BaselineError` if a baseline can't be read or is damaged.
        """
        for name in filter(self.guards, scenes):
            with suppress(BaselineSchemaError):
                load_baseline(baseline_path(self.folder, name), self.engine)


def compare_results(
    results: Results,
    gate: Gate,
    *,
    whole: bool,
    only: Container[str] | None = None,
    time_limit: float | None = None,
    fail_on: FailOn = "changed",
) -> Regression:
    """Compare the runs of an engine in a results folder with their baselines.

    `whole`: True if all scenes of the project were run. Then baselines of other scenes cause a
        warning, and Ghostball's engine also runs the shots with many balls.
    `only`: names of the scenes that are compared; None: all scenes that were run.
    `time_limit` [s]: for each scene that is simulated again, as in `run_suite`.
    `fail_on`: the changes that count as failures; see `FailOn`.

    Raises `GhostballError` if a baseline is damaged, or if a motion can't be read.
    """
    environment = head_of(gate.label)
    changes: list[SceneChange] = []
    warnings: list[str] = []
    cases: list[CaseRecord] = []
    with second_runs(gate.label, time_limit) as run_again:
        for name in _scenes_of(results, gate.label, whole=whole):
            played = compared_run_in(results, gate, name)
            case = played.record
            never = case.outcome not in ("ran", "failed") and not gate.guards(name)
            if never or (only is not None and name not in only):
                continue
            change, warning = _compare(played, gate, environment, run_again)
            changes.append(_judged(change, gate, fail_on, case.broken))
            warnings += warning
            cases.append(case)
    compared = {one.scene for one in changes}
    if whole and (gone := [one for one in baseline_names(gate.folder) if one not in compared]):
        warnings.append(
            f"baselines whose scene no longer exists: {', '.join(gone)}. Remove their files from "
            f"{gate.folder}"
        )
    return Regression(
        label=gate.label,
        engine=gate.engine,
        head=environment,
        fail_on=fail_on,
        outcome=outcome_of(changes, fail_on),
        scenes=tuple(changes),
        unjudged=not_judged(cases),
        warnings=tuple(warnings),
    )


def compare_case(
    played: ComparedRun, gate: Gate, *, time_limit: float | None = None, fail_on: FailOn = "changed"
) -> SceneChange:
    """Compare one run of an engine with its baseline.

    `time_limit` [s], `fail_on`: see `compare_results`.

    Raises `BaselineError` if the baseline is damaged.
    """
    with second_runs(gate.label, time_limit) as run_again:
        change, _ = _compare(played, gate, head_of(gate.label), run_again)
    return _judged(change, gate, fail_on)


@contextmanager
def second_runs(label: str, time_limit: float | None = None) -> Iterator[RunAgain]:
    """Yield a function that simulates a scene again; nothing is started before its first call.

    `label`: the engine with its settings.
    `time_limit` [s]: for each scene, for engines other than Ghostball's; see
        `runs.engine_runs.in_other_process`.
    """
    with in_other_process(make_engine(label), time_limit) as engine:

        def play(scene: Scene) -> str:
            try:
                result = run_engine(engine, scene)
            except (EngineFailedError, EngineUnavailableError, UnsupportedSceneError) as error:
                return f"it failed: {error}"
            return bits_hash(events_of(result), result.rest_positions)

        yield play


def head_of(label: str) -> dict[str, Any]:
    """Return the environment in which an engine runs, with the hash and revision of its code."""
    environment = describe_environment() | {"sources": sources_hash(label)}
    if not is_ours(label):
        root = checkout_of(source_of(label))
        state = None if root is None else git_state(root)
        environment["git"] = state or {"revision": "unknown", "dirty": False}
    return environment


def outcome_of(changes: Sequence[SceneChange], fail_on: FailOn = "changed") -> Any:
    """Return the outcome of a comparison, which doesn't pass if nothing was compared."""
    if any(change.failed for change in changes):
        return "failed"
    incomparable = any(change.change in UNCOMPARED for change in changes) and fail_on != "limits"
    return "no-baseline" if incomparable or not changes else "passed"


def _scenes_of(results: Results, label: str, *, whole: bool) -> Iterator[str]:
    """Yield the scenes that an engine ran, and those that the comparison itself runs."""
    yield from (name for name in results.scene_names if results.case(name, label) is not None)
    yield from (scene.name for scene in many_balls() if whole and label == OURS)


def compared_run_in(results: Results, gate: Gate, scene: str) -> ComparedRun:
    """Return the run of an engine in a compared scene; shots with many balls run again.

    Raises `GhostballError` if the results hold no run of the scene.
    """
    case = results.case(scene, gate.label)
    if case is not None:
        return ComparedRun.stored(results, case)
    shot = next((one for one in many_balls() if one.name == scene), None)
    if shot is None or gate.label != OURS:
        raise GhostballError(
            f'scene "{scene}" was compared, but {results.path} no longer has its result on '
            f"`{gate.label}`. Run `ghostball regress` again"
        )
    return _many_ball_run(shot)


def _many_ball_run(scene: Scene) -> ComparedRun:
    """Return the run of a shot with many balls on Ghostball's engine, or the failure."""
    record = blank_record(Case(scene, OURS, TruthFailure("", "")))
    try:
        result = run_ours(scene, "events")
        check_result(result, scene, OURS, "events")
    except Exception as error:  # reported with its scene, like a failure in any other shot
        return ComparedRun.of(failed(record, f"{type(error).__name__}: {error}"), None)
    events = events_of(result)
    record = replace(
        record,
        outcome="ran",
        status=status_name(result.status),
        rest_time=float(result.rest_time),
        rest_positions=result.rest_positions,
        bits=bits_hash(events, result.rest_positions),
        work={name: int(count) for name, count in result.work.items()},
    )
    return ComparedRun(record, lambda: EventLog.of(events))


def _judged(
    change: SceneChange, gate: Gate, fail_on: FailOn, broken: Sequence[Check] = ()
) -> SceneChange:
    """Return a change with its failed limits, and with `failed` set as the gate demands."""
    if sentences := tuple(check.sentence for check in broken):
        summary = f"{change.summary}; failed limits: {'; '.join(sentences)}"
        change = change.model_copy(update={"summary": summary, "broken": sentences})
    fails = change.fails(fail_on, ours=gate.label == OURS)
    return change.model_copy(update={"failed": fails})


def _compare(
    played: ComparedRun, gate: Gate, environment: Mapping[str, Any], run_again: RunAgain
) -> tuple[SceneChange, list[str]]:
    """Return the change of a scene, and warnings."""
    record, path = played.record, baseline_path(gate.folder, played.record.scene)
    facts: dict[str, Any] = {"scene": record.scene, "title": record.title}
    if record.outcome != "ran" or not _is_finite(played):
        why = NOT_FINITE
        if record.outcome != "ran":
            why = f"the engine did not run the scene: {record.reason}"
        command = commands.simulate(record.scene, gate.label)
        return SceneChange(**facts, change="worse", summary=why, command=command), []
    scene = record.load_scene()
    # Shots with many balls have no scene file: `regress` runs them only with all other scenes.
    named = None if scene in many_balls() else scene.name
    facts |= {"command": commands.regress(named, engine=gate.label), "head_hash": record.bits}
    baseline: Baseline | None = None
    uncompared: tuple[Change, str] = ("no-baseline", "there is no baseline to compare with")
    if path.exists():
        try:
            baseline = load_baseline(path, gate.engine)
        except BaselineSchemaError as error:
            uncompared = ("not-comparable", str(error))
    facts["base_hash"] = "" if baseline is None else baseline.record.bits
    # An accepted result isn't simulated again: the engine has produced it twice.
    if record.bits != facts["base_hash"] and (again := run_again(scene)) != record.bits:
        how = again if again.startswith("it failed") else "it gave a different result"
        why = (
            f"the engine ran the scene twice: the second time {how}, so nothing can be compared or "
            "accepted. Seed all random numbers, and read no memory before it is written"
        )
        return SceneChange(**facts, change="not-deterministic", summary=why), []
    if baseline is None:
        change, why = uncompared
        return SceneChange(**facts, change=change, summary=why), []
    found = compare(baseline.played, played, lambda: allowance(played), facts["command"])
    ours, platform = gate.label == OURS, baseline.accepted.platform
    if found.fails("changed", ours=ours) and platform != _platform_of(environment):
        promise = "; Ghostball's results are bit-identical on all platforms" * ours
        summary = f"{found.summary} (accepted on {platform}{promise})"
        found = found.model_copy(update={"summary": summary})
    warnings = []
    if baseline.record.truth != record.truth:
        warnings.append(
            f"{scene.name}: errors can't be compared: the reference was {baseline.record.truth}, "
            f"and is {record.truth} now"
        )
    return found, warnings


def _is_finite(played: ComparedRun) -> bool:
    """Return True if all numbers of a run are finite; otherwise it can't be compared."""
    record = played.record
    numbers = (record.rest_time, *record.metrics.values())
    arrays = (record.rest_positions, played.log().events["t"])
    return all(math.isfinite(one) for one in numbers if one is not None) and all(
        np.isfinite(one).all() for one in arrays if one is not None
    )


def sources_hash(label: str) -> str:
    """Return the hash of all code that determines the results of an engine."""
    ours = hash_sources(source_folders())
    name = code_kind(label)
    return hash_of([ours, engine_code(name)]) if name else ours


def source_of(label: str) -> Path:
    """Return the file of the package of an engine (its `__init__.py`), or of its module.

    Raises `SourcesError` if no source file exists.
    """
    module = str(engine_class(parse_spec(label)[0]).__module__)
    for name in (module.partition(".")[0], module):
        if file := getattr(import_module(name), "__file__", None):
            return Path(file).resolve()
    raise SourcesError(
        f"engine `{label}`: module `{module}` has no source file, so changes to "
        f"its code can't be detected"
    )


def accepted_now(environment: Mapping[str, Any], reason: str) -> Accepted:
    """Return the description of an acceptance made today."""
    return Accepted(
        date=datetime.now(UTC).date().isoformat(),
        revision=_revision_of(environment),
        platform=_platform_of(environment),
        reason=" ".join(reason.split()),
    )


def _revision_of(environment: Mapping[str, Any]) -> str:
    """Return the code revision of an environment, and whether there are uncommitted changes."""
    git = environment.get("git")
    if not git:
        return str(environment["versions"]["ghostball"])
    return str(git["revision"])[:12] + (" with changes" if git["dirty"] else "")


def _platform_of(environment: Mapping[str, Any]) -> str:
    """Return the properties of an environment that could affect bits of results, but must not."""
    versions = environment["versions"]
    return (
        f"{environment['os']}, Python {environment['python']}, numba {versions['numba']}, "
        f"{environment['cpu']}"
    )

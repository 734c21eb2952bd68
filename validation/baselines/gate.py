"""Compares what an engine does now with what was accepted of it."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path
from typing import Any

from ghostball.model import Scene
from ghostball.reference_adapters.registry import OURS, engine_class, make_engine, parse_spec
from ghostball.reference_adapters.returned import check_result
from ghostball.validation.baselines.baseline import (
    Accepted,
    Baseline,
    BaselineSchemaError,
    load_baseline,
)
from ghostball.validation.baselines.classify import classify
from ghostball.validation.baselines.observed import Observed
from ghostball.validation.baselines.places import baseline_names, baseline_path, engine_key
from ghostball.validation.baselines.regression import (
    UNCOMPARED,
    Change,
    FailOn,
    Regression,
    SceneChange,
)
from ghostball.validation.baselines.replay import PlayAgain, not_deterministic, playing_again
from ghostball.validation.baselines.revision import checkout_of
from ghostball.validation.baselines.rounding import Allowance, allowance_of, allowance_of_other
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
from ghostball.validation.results.records import CaseRecord, Motion
from ghostball.validation.results.store import Results
from ghostball.validation.runs.playing import run_ours
from ghostball.validation.runs.steps import step_of
from ghostball.validation.scenes import commands
from ghostball.validation.scenes.gases import many_balls
from ghostball.validation.suite.case import blank_record, failed
from ghostball.validation.suite.judge import Case, TruthFailure
from ghostball.validation.suite.unchanged import hash_of

PENDING = "not accepted yet"

NOT_FINITE = "its numbers are not finite, so they can't be compared or accepted"


def check_baselines(folder: Path, scenes: Sequence[str], engine: str = OURS) -> None:
    """Read an engine's baselines of some scenes: what is nonsense is refused before anything runs.

    One of another schema version is passed over here, and reported with its scene.

    Raises `BaselineError` where one can't be read, or is nonsense.
    """
    for name in scenes:
        path = baseline_path(folder, name)
        if path.exists():
            with suppress(BaselineSchemaError):
                load_baseline(path, engine)


def compare_results(
    results: Results,
    folder: Path,
    label: str = OURS,
    *,
    whole: bool,
    only: Container[str] | None = None,
    time_limit: float | None = None,
    fail_on: FailOn = "changed",
) -> Regression:
    """Compare the runs of an engine in a results folder with their baselines.

    `folder`: of the baselines of this engine.
    `label`: the engine, as it was asked for.
    `whole`: whether all scenes that it is guarded by were run: then baselines of others are
        `stale`, and our engine runs the shots of many balls too.
    `only`: names of the scenes that are compared; all that were run where it is left out.
    `time_limit` [s]: for each shot that is played again, as `run_suite` has it; see
        `baselines.replay`.
    `fail_on`: what fails it; see `FailOn`.

    Raises `GhostballError` where a baseline is nonsense, or a motion can't be read.
    """
    names = baseline_names(folder)
    environment, engine = head_of(label), engine_key(label)
    changes: list[SceneChange] = []
    accepted: dict[str, Any] = {}
    scenes: list[str] = []
    with playing_again(label, time_limit) as play_again:
        for scene, found in _observed(results, label, whole):
            if only is not None and scene.name not in only:
                continue
            never = isinstance(found, CaseRecord) and found.outcome != "failed"
            if never and scene.name not in names:
                continue  # it never could
            scenes.append(scene.name)
            if isinstance(found, CaseRecord):
                why = f"the engine did not run it: {found.reason}"
                changes.append(_worse(found.scene, found.title, found.label, why))
                continue
            if not found.is_finite:
                changes.append(_worse(scene.name, scene.title, label, NOT_FINITE))
                continue
            change, candidate, before = _compare(
                scene, found, folder, environment, label, play_again
            )
            change = _within_limits(change, results.case(scene.name, label))
            if candidate is not None:
                change = change.model_copy(update={"candidate": candidate.text()})
            changes.append(change)
            accepted = before or accepted
    changes = [change.judged(fail_on) for change in changes]
    cases = [case for name in scenes if (case := results.case(name, label)) is not None]
    stale = tuple(name for name in names if name not in scenes) if whole else ()
    return Regression(
        label=label,
        engine=engine,
        base=accepted,
        head=environment,
        fail_on=fail_on,
        outcome=outcome_of(changes, fail_on),
        scenes=tuple(changes),
        stale=stale,
        unjudged=not_judged(cases),
        warnings=tuple(_warnings(changes, stale)),
    )


def compare_case(
    case: CaseRecord,
    motion: Motion,
    folder: Path,
    label: str,
    *,
    time_limit: float | None = None,
    fail_on: FailOn = "changed",
) -> SceneChange:
    """Compare one case of an engine that ran with its baseline.

    `folder`: of the baselines of this engine.
    `label`: the engine, as it was asked for.
    `time_limit` [s], `fail_on`: as of `compare_results`.

    Raises `BaselineError` where the baseline is nonsense.
    """
    scene, found = case.load_scene(), Observed.of_case(case, motion)
    if not found.is_finite:
        return _worse(scene.name, scene.title, label, NOT_FINITE)
    with playing_again(label, time_limit) as play_again:
        change = _compare(scene, found, folder, head_of(label), label, play_again)[0]
    return change.judged(fail_on)


def head_of(label: str) -> dict[str, Any]:
    """Return the environment that an engine runs in: its code, and the revision of that."""
    environment = describe_environment() | {"sources": sources_hash(label)}
    if not is_ours(label):
        root = checkout_of(source_of(label))
        state = None if root is None else git_state(root)
        environment["git"] = state or {"revision": "unknown", "dirty": False}
    return environment


def outcome_of(changes: Sequence[SceneChange], fail_on: FailOn = "changed") -> Any:
    """Return what a comparison comes to; nothing compared is no pass, where that is asked."""
    if any(change.failed for change in changes):
        return "failed"
    incomparable = any(change.change in UNCOMPARED for change in changes) and fail_on != "limits"
    return "no-baseline" if incomparable or not changes else "passed"


def _observed(
    results: Results, label: str, whole: bool
) -> Iterator[tuple[Scene, Observed | CaseRecord]]:
    """Yield each scene with what the engine did there, or with the case that did not run."""
    for name in results.scene_names:
        case = results.case(name, label)
        if case is None:
            continue
        motion = results.motion(case)
        yield (
            case.load_scene(),
            case if motion is None else Observed.of_case(case, motion),
        )
    for scene in many_balls() if whole and label == OURS else ():
        yield scene, _many_ball_run(scene)


def _many_ball_run(scene: Scene) -> Observed | CaseRecord:
    """Return what our engine did in a shot of many balls, or that it failed."""
    try:
        result = run_ours(scene, "events")
        check_result(result, scene, OURS, "events")
    except Exception as error:  # reported with its scene, as a fault of any other shot
        case = Case(scene, OURS, TruthFailure("", ""))
        return failed(blank_record(case), f"{type(error).__name__}: {error}")
    return Observed.of_result(result)


def _within_limits(change: SceneChange, case: CaseRecord | None) -> SceneChange:
    """Return a change that fails also where the scene's limits are broken."""
    checks = () if case is None else case.checks
    broken = tuple(check.sentence for check in checks if check.passed is False)
    if not broken:
        return change
    summary = f"{change.summary}; breaks its limits: {'; '.join(broken)}"
    return change.model_copy(update={"failed": True, "summary": summary, "broken": broken})


def _compare(
    scene: Scene,
    head: Observed,
    folder: Path,
    environment: Mapping[str, Any],
    label: str,
    play_again: PlayAgain,
) -> tuple[SceneChange, Baseline | None, dict[str, Any]]:
    """Return what became of a scene, the baseline to accept where one moved, and who accepted."""
    path, engine = baseline_path(folder, scene.name), engine_key(label)
    pending = Accepted(
        date=datetime.now(UTC).date().isoformat(),
        revision=revision_of(environment),
        platform=platform_of(environment),
        reason=PENDING,
    )
    common: dict[str, Any] = {
        "scene": scene.name,
        "title": scene.title,
        # The shots of many balls are no files: they run with all others.
        "command": commands.regress(None if scene in many_balls() else scene.name, engine=label),
        "head_hash": head.bits,
    }

    baseline: Baseline | None = None
    uncompared: tuple[Change, str] = ("no-baseline", "there is no baseline to compare with")
    if path.exists():
        try:
            baseline = load_baseline(path, engine)
        except BaselineSchemaError as error:
            uncompared = ("not-comparable", str(error))
    accepted = {} if baseline is None else baseline.accepted.model_dump()
    # Whoever switches the hash off says that the bits are others each time.
    if baseline is None or baseline.hash.level != "off":
        bits = "" if baseline is None else baseline.hash.bits
        unsteady = not_deterministic(head, bits, play_again, scene, common["command"])
        if unsteady is not None:
            return unsteady, None, accepted
    if baseline is None:
        kind, why = uncompared
        change = SceneChange(**common, change=kind, failed=False, summary=why)
        return change, Baseline.of(head, pending, engine=engine), {}
    change = classify(
        baseline.observed,
        head,
        baseline.bands,
        lambda: allowance(scene, head, label),
        common["command"],
    )
    if change.failed and baseline.accepted.platform != pending.platform:
        change = change.model_copy(
            update={
                "summary": f"{change.summary} (accepted on {baseline.accepted.platform}"
                + "; our engine promises the same bits on every platform" * (engine == OURS)
                + ")"
            }
        )
    # Sums that only measure may differ in a last bit from machine to machine: no reason to write.
    affected = change.base_hash != change.head_hash or change.change == "not-comparable"
    affected |= any(not one.within for one in (*change.metrics, *change.counters))
    # The bands of another shot say nothing of this one.
    earlier = None if change.change == "not-comparable" else baseline
    candidate = Baseline.of(head, pending, earlier, engine) if affected else None
    return change, candidate, accepted


def allowance(scene: Scene, head: Observed, label: str) -> Allowance:
    """Return what rounding explains in a shot that an engine, ours or another, played."""
    if label == OURS:
        return allowance_of(scene)
    return allowance_of_other(scene, head, _steps(label, head))


def _steps(label: str, head: Observed) -> float:
    """Return how many time steps an engine makes in a shot by its setting; 0 without a step.

    An engine's own count of its steps would widen its allowance without bound.
    """
    step = step_of(make_engine(label))
    return 0.0 if step is None else head.rest_time / step


def _worse(scene: str, title: str, label: str, why: str) -> SceneChange:
    """Return that there is nothing that could be compared."""
    command = commands.simulate(scene, label)
    return SceneChange(
        scene=scene, title=title, change="worse", failed=True, summary=why, command=command
    )


def _warnings(changes: Sequence[SceneChange], stale: Sequence[str]) -> Iterator[str]:
    for change in changes:
        for one in (*change.metrics, *change.counters):
            if one.level == "warn" and not one.within:
                yield f"{change.scene}: `{one.name}` {one.base} -> {one.head}: {one.why}"
    if stale:
        yield f"baselines of scenes that are no more: {', '.join(stale)}"


def sources_hash(label: str) -> str:
    """Return the hash of the code that determines an engine's results: Ghostball's and its own."""
    ours = hash_sources(source_folders())
    name = code_kind(label)
    return hash_of([ours, engine_code(name)]) if name else ours


def source_of(label: str) -> Path:
    """Return the file of an engine's package, its `__init__.py`, or of its module.

    Raises `SourcesError` where its code is in no file.
    """
    module = str(engine_class(parse_spec(label)[0]).__module__)
    for name in (module.partition(".")[0], module):
        if file := getattr(import_module(name), "__file__", None):
            return Path(file).resolve()
    raise SourcesError(f"engine `{label}`: module `{module}` is no file, so its code is not known")


def revision_of(environment: Mapping[str, Any]) -> str:
    """Return the revision of an environment, and whether files differ from it."""
    git = environment.get("git")
    if not git:
        return str(environment["versions"]["ghostball"])
    return str(git["revision"])[:12] + (" with changes" if git["dirty"] else "")


def platform_of(environment: Mapping[str, Any]) -> str:
    """Return what of an environment might decide a bit, though it must not."""
    versions = environment["versions"]
    return (
        f"{environment['os']}, Python {environment['python']}, numba {versions['numba']}, "
        f"{environment['cpu']}"
    )

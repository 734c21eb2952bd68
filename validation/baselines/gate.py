"""Compares what our engine does now with what was accepted."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from ghostball.engine import Scene
from ghostball.validation.baselines.baseline import (
    FOLDER,
    Accepted,
    Baseline,
    BaselineSchemaError,
    baseline_names,
    baseline_path,
    load_baseline,
)
from ghostball.validation.baselines.classify import Bands, classify
from ghostball.validation.baselines.observed import Observed
from ghostball.validation.baselines.regression import BASELINES, Regression, SceneChange
from ghostball.validation.baselines.rounding import allowance_of
from ghostball.validation.bench.skips import many_balls
from ghostball.validation.parallel.sources import hash_sources, source_folders
from ghostball.validation.results.environment import describe_environment
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.results.store import Results
from ghostball.validation.runs.our_run import run_ours
from ghostball.validation.runs.returned import check_result
from ghostball.validation.scenes import commands
from ghostball.validation.suite.case import Case, TruthFailure, blank_record, failed
from ghostball.validation.truth.scene_truth import OUR_NAME

PENDING = "not accepted yet"


@cache
def crowds() -> tuple[Scene, ...]:
    """Return the shots of many balls that have baselines but no files: they are made by a rule."""
    return many_balls()


def check_baselines(folder: Path, scenes: Sequence[str]) -> None:
    """Read the baselines of some scenes, so that nonsense is told before anything runs.

    One of another schema version is passed over: it is told with its scene.

    Raises
    ------
    BaselineError
        Where one can't be read, or is nonsense.
    """
    for name in scenes:
        path = baseline_path(folder, name)
        if path.exists():
            with suppress(BaselineSchemaError):
                load_baseline(path)


def compare_results(
    results: Results,
    folder: Path = FOLDER,
    *,
    whole: bool,
    only: Container[str] | None = None,
    candidates: bool = True,
) -> Regression:
    """Compare the runs of our engine in a results folder with their baselines.

    Parameters
    ----------
    results : Results
    folder : Path
        Of the baselines.
    whole : bool
        Whether all shipped scenes were run: then the shots of many balls are run too, and baselines
        of scenes that are no more are `stale`.
    only : container of str, optional
        Names of the scenes that are compared; all that were run where it is left out.
    candidates : bool
        Whether to say which baselines would accept what has moved.

    Raises
    ------
    GhostballError
        Where a baseline is nonsense, or a motion can't be read.
    """
    names = baseline_names(folder)
    environment = describe_environment() | {"sources": hash_sources(source_folders())}
    changes: list[SceneChange] = []
    accepted: dict[str, Any] = {}
    scenes: list[str] = []
    for scene, found in _observed(results, whole):
        if only is not None and scene.name not in only:
            continue
        if isinstance(found, CaseRecord) and found.outcome != "failed" and scene.name not in names:
            continue  # it never could
        scenes.append(scene.name)
        if isinstance(found, CaseRecord):
            changes.append(_not_run(found))
            continue
        change, candidate, before = _compare(scene, found, folder, environment)
        change = _within_limits(change, results.case(scene.name, OUR_NAME))
        if candidate is not None and candidates:
            change = change.model_copy(update={"candidate": candidate.text()})
        changes.append(change)
        accepted = before or accepted
    stale = tuple(name for name in names if name not in scenes) if whole else ()
    return Regression(
        against=BASELINES,
        base=accepted,
        head=environment,
        outcome=outcome_of(changes),
        scenes=tuple(changes),
        stale=stale,
        warnings=tuple(_warnings(changes, stale)),
    )


def outcome_of(changes: Sequence[SceneChange]) -> Any:
    """Return what a comparison comes to; nothing compared is no pass."""
    if any(change.failed for change in changes):
        return "failed"
    incomparable = any(change.change in ("no-baseline", "not-comparable") for change in changes)
    return "no-baseline" if incomparable or not changes else "passed"


def _observed(results: Results, whole: bool) -> Iterator[tuple[Scene, Observed | CaseRecord]]:
    """Yield each scene with what our engine did there, or with the case that did not run."""
    for name in results.scene_names:
        case = results.case(name, OUR_NAME)
        if case is None:
            continue
        motion = results.motion(case)
        yield (
            case.load_scene(),
            case if motion is None else Observed.of_case(case, motion),
        )
    for scene in crowds() if whole else ():
        yield scene, _crowd(scene)


def _crowd(scene: Scene) -> Observed | CaseRecord:
    """Return what our engine did in a shot of many balls, or that it failed."""
    try:
        result = run_ours(scene, "events")
        check_result(result, scene, OUR_NAME, "events")
    except Exception as error:  # a fault of the engine, told with its scene, as in every other one
        case = Case(scene, OUR_NAME, TruthFailure("", ""))
        return failed(blank_record(case), f"{type(error).__name__}: {error}")
    return Observed.of_result(result)


def with_cases(regression: Regression, results: Results) -> Regression:
    """Return a comparison with what else was found of our engine: broken limits, and crashes."""
    cases = {case.scene: case for case in results.cases if case.label == OUR_NAME}
    changes = [_within_limits(one, cases.pop(one.scene, None)) for one in regression.scenes]
    changes += [_not_run(case) for case in cases.values() if case.outcome == "failed"]
    return regression.model_copy(
        update={"scenes": tuple(changes), "outcome": outcome_of(changes)},
    )


def _within_limits(change: SceneChange, case: CaseRecord | None) -> SceneChange:
    """Return a change that fails also where the scene's limits are broken."""
    checks = () if case is None else case.checks
    broken = tuple(check.sentence for check in checks if check.passed is False)
    if not broken:
        return change
    summary = f"{change.summary}; breaks its limits: {'; '.join(broken)}"
    return change.model_copy(update={"failed": True, "summary": summary, "broken": broken})


def _compare(
    scene: Scene, head: Observed, folder: Path, environment: Mapping[str, Any]
) -> tuple[SceneChange, Baseline | None, dict[str, Any]]:
    """Return what became of a scene, the baseline to accept where one moved, and who accepted."""
    path = baseline_path(folder, scene.name)
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
        "command": commands.regress(None if scene in crowds() else scene.name),
        "head_hash": head.bits,
    }
    if not path.exists():
        summary = "there is no baseline to compare with"
        change = SceneChange(**common, change="no-baseline", failed=False, summary=summary)
        return change, Baseline.of(head, pending), {}
    try:
        baseline = load_baseline(path)
    except BaselineSchemaError as error:
        change = SceneChange(**common, change="not-comparable", failed=False, summary=str(error))
        return change, Baseline.of(head, pending), {}
    bands = Bands(
        {name: value.band for name, value in baseline.metrics.items()},
        {name: value.band for name, value in baseline.work.items()},
        baseline.hash.level,
    )
    change = classify(
        baseline.observed, head, bands, lambda: allowance_of(scene), common["command"]
    )
    if change.failed and baseline.accepted.platform != pending.platform:
        change = change.model_copy(
            update={
                "summary": f"{change.summary} (accepted on {baseline.accepted.platform}; our "
                "engine promises the same bits on every platform)"
            }
        )
    # Sums that only measure may differ in a last bit from machine to machine: no reason to write.
    affected = change.base_hash != change.head_hash or change.change == "not-comparable"
    affected |= any(not one.within for one in (*change.metrics, *change.counters))
    # The bands of another shot say nothing of this one.
    earlier = None if change.change == "not-comparable" else baseline
    candidate = Baseline.of(head, pending, earlier) if affected else None
    return change, candidate, baseline.accepted.model_dump()


def _not_run(case: CaseRecord) -> SceneChange:
    return SceneChange(
        scene=case.scene,
        title=case.title,
        change="worse",
        failed=True,
        summary=f"our engine did not run it: {case.reason}",
        command=commands.simulate(case.scene),
    )


def _warnings(changes: Sequence[SceneChange], stale: Sequence[str]) -> Iterator[str]:
    for change in changes:
        for one in (*change.metrics, *change.counters):
            if one.level == "warn" and not one.within:
                yield f"{change.scene}: `{one.name}` {one.base} -> {one.head}: {one.why}"
    if stale:
        yield f"baselines of scenes that are no more: {', '.join(stale)}"


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

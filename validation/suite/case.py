"""Run one scene on one engine: step two of the five steps of a run.

`prepare` does the work that all cases need before the first one. `cases_of` computes the reference
result of a scene when its turn comes, once for all engines. `run_case` runs a case, in a process
that the engine may crash.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from ghostball.model import EngineFailedError, Scene, Status, UnsupportedSceneError
from ghostball.model.errors import storable
from ghostball.reference_adapters.base import ReferenceEngine, resolution_of
from ghostball.reference_adapters.registry import EngineUnavailableError, engine_name, make_engine
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.metrics import METRICS, USUAL
from ghostball.validation.checks.requirements import (
    Requirements,
    approximations_of,
    claim_of,
    is_unstated,
)
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.parallel.pool import Done, Progress
from ghostball.validation.results.record_store import Name
from ghostball.validation.results.records import CaseRecord, Fault
from ghostball.validation.results.store import Finished
from ghostball.validation.runs.engine_runs import blamed_on_engine, differs_by_record, run_engine
from ghostball.validation.suite.ensemble import MEMBER_METRICS
from ghostball.validation.suite.judge import Case, TruthFailure, judge
from ghostball.validation.suite.plan import SuitePlan
from ghostball.validation.truth.scene_truth import (
    PARTS,
    Truth,
    TruthPart,
    check_closed_form,
    truth_of,
)

_NO_TRUTH = Truth(None, missing="a perturbed initial state has no reference result")


def prepare(
    planned: SuitePlan, pairs: Sequence[Name], jobs: int, compiling: Progress[str] | None
) -> Callable[[], None]:
    """Do the work that these cases of a plan need before the first one runs.

    Kernels are compiled in `jobs` processes; see `compile_kernels`, also for the return value.

    Raises `TruthError` if given criteria ask for a closed form that a scene doesn't have.
    """
    scenes = planned.scenes_of(pairs)
    for scene in scenes:
        if scene.name in planned.given:
            check_closed_form(scene, planned.criteria[scene.name].truth)
    return compile_kernels(
        scenes,
        jobs,
        labels=dict.fromkeys(label for _, label in pairs),
        compiling=compiling,
    )


def cases_of(planned: SuitePlan, pairs: Sequence[Name]) -> Iterator[Case]:
    """Yield these cases of a plan, scene by scene, each with the reference result of its scene."""
    computed = USUAL if planned.metrics is None else planned.metrics
    parts = frozenset(part for name in computed if (part := METRICS[name].compares) is not None)
    if "accuracy" in computed or any(planned.asked[pair].rule is not None for pair in pairs):
        parts |= {"certificate"}  # limits from the time step need the certified motion
    if "accuracy" in computed:
        parts |= {"events", "conditioning"}
    for scene in planned.scenes_of(pairs):
        origin = planned.origins.get(scene.name, "")
        truth: Truth | TruthFailure = _NO_TRUTH
        if not origin:
            truth = truth_or_failure(scene, planned.criteria[scene.name], parts)
        for pair in pairs:
            if pair[0] == scene.name:
                asked, metrics = planned.asked[pair], planned.metrics
                if origin:
                    metrics = _without_truth(computed, asked)
                here = planned.settings[pair[1]] is not None
                yield Case(
                    scene,
                    pair[1],
                    truth,
                    asked,
                    metrics,
                    varied_from=origin,
                    is_here=here,
                    every_record=planned.firsts.get(pair[1]) == scene.name,
                    keeps_motion=planned.keeps_motion,
                )


def run_case(case: Case, make: Callable[[str], ReferenceEngine] = make_engine) -> Finished:
    """Run a case; any error becomes part of the record.

    `make`: creates the engine from the label of the case; by default an installed engine.

    Raises `KeyboardInterrupt` if the run was interrupted; the unfinished result is dropped.
    """
    record = blank_record(case)
    truth = case.truth
    if isinstance(truth, TruthFailure):
        reason = f"the reference result of the scene could not be computed: {truth.reason}"
        return failed(record, reason, truth.traceback, fault="ghostball"), None
    try:
        with blamed_on_engine(record.engine):
            engine = make(case.label)
            record = replace(
                record,
                settings=plain_settings(engine),
                approximations=approximations_of(engine, case.scene),
            )
            resolution = resolution_of(engine, case.scene)
            judged = engine if case.judged_as is None else case.judged_as()
            limits = case.asked.limits(judged, case.scene, truth)
            dropped = case.asked.not_asked(judged, case.scene, truth)
            record = replace(
                record,
                excused=case.asked.excuse,
                not_asked=tuple(dict.fromkeys(one.metric for one in dropped)),
                unstated=is_unstated(judged, case.scene),
                claim=claim_of(judged, case.scene),
            )
        result = run_engine(engine, case.scene)
        if result.status is Status.FAILED:  # its numbers may be invalid
            return failed(record, f"the engine reports a failure: {result.reason}"), None
        if case.every_record and (differs := differs_by_record(engine, result)):
            return failed(record, differs), None
        return judge(record, case, truth, result, resolution, limits, engine)
    except EngineUnavailableError as error:
        # The plan found the engine, so only this process lacks it, for example on a cluster.
        if case.is_here:
            return failed(record, str(error)), None
        return replace(record, outcome="unavailable", reason=str(error)), None
    except UnsupportedSceneError as error:
        reason = "; ".join(error.features)
        return replace(record, outcome="not-representable", reason=reason), None
    except EngineFailedError as error:
        fault: Fault = "ghostball" if error.is_our_bug else "engine"
        return failed(record, error.reason, error.trace, fault=fault), None
    # Any other exception is a bug of the harness: it is recorded and never ends the run.
    except (Exception, SystemExit) as error:
        reason, trace = f"{type(error).__name__}: {error}", traceback.format_exc()
        return failed(record, storable(reason), storable(trace), fault="ghostball"), None


def blank_record(case: Case) -> CaseRecord:
    """Return a record that names the case and holds no result yet."""
    scene = case.scene
    return CaseRecord(
        scene=scene.name,
        title=scene.title,
        tags=scene.tags,
        definition=scene.model_dump(mode="json", by_alias=True),
        label=case.label,
        engine=engine_name(case.label),
        outcome="failed",
        varied_from=case.varied_from,
    )


def failed(
    record: CaseRecord, reason: str, trace: str = "", *, fault: Fault = "engine"
) -> CaseRecord:
    """Return the record of a case that failed: the reason, the traceback, and who is at fault."""
    return replace(record, outcome="failed", reason=reason, traceback=trace, fault=fault)


def plain_settings(engine: ReferenceEngine) -> dict[str, Any]:
    """Return all settings of an engine as plain values."""
    return engine.settings.model_dump(mode="json")


def finished(done: Done[Case, Finished]) -> Finished:
    """Return the result of a case, with the output of its engine and the time of measurement."""
    record, motion = done.or_else(lambda case, why: (failed(blank_record(case), why), None))
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return replace(record, printed=done.printed, measured=now), motion


def _without_truth(metrics: Collection[str], asked: Requirements) -> tuple[str, ...]:
    """Return the metrics that a perturbed initial state has without a reference result.

    The accuracy class is kept, because it shows unphysical results, except for engines with limits
    from their time step: these limits need a reference result.
    """
    kept = (
        name
        for name in metrics
        if METRICS[name].compares is None or (name == "accuracy" and asked.rule is None)
    )
    return tuple(dict.fromkeys([*kept, *MEMBER_METRICS]))


def truth_or_failure(
    scene: Scene, criteria: Criteria, parts: frozenset[TruthPart] = PARTS
) -> Truth | TruthFailure:
    """Return the reference result of a scene, or why it could not be computed."""
    try:
        return truth_of(scene, criteria.truth, parts, least=criteria.least_certified)
    except Exception as error:  # a bug of Ghostball; the run continues and reports it
        return TruthFailure(f"{type(error).__name__}: {error}", traceback.format_exc())

"""One case: one scene on one engine, run, measured and judged."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ghostball.engine import EngineFailedError, Result, Scene, Status, UnsupportedSceneError
from ghostball.engine.result import initial_state
from ghostball.engine.scene.features import scene_features
from ghostball.engine.trajectory import energy_of
from ghostball.reference_adapters.base import ReferenceEngine, Resolution, resolution_of
from ghostball.reference_adapters.registry import (
    EngineUnavailableError,
    engine_name,
    make_engine,
)
from ghostball.validation.checks.accuracy import accuracy_of
from ghostball.validation.checks.criterion import Criterion, StepRule
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.metrics import measure
from ghostball.validation.checks.step_limits import step_criteria
from ghostball.validation.results.records import CaseRecord, Fault, Motion, status_name
from ghostball.validation.runs.playing import blamed_on_engine, run_engine
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.truth.scene_truth import Truth


@dataclass(frozen=True, eq=False)
class TruthFailure:
    """Why the truth of a scene could not be computed: a fault, and where it arose."""

    reason: str
    traceback: str


@dataclass(frozen=True, eq=False)
class Case:
    """What to run, and what to hold it against.

    Attributes
    ----------
    scene : Scene
    label : str
        The engine with its settings, as asked for.
    truth : Truth or TruthFailure
    criteria : tuple of Criterion
        Those that apply to this engine with its settings, and whose metric is computed.
    rule : StepRule or None
        By which limits are computed from the engine's step, on metrics that none of them limits.
    metrics : tuple of str, or None
        The metrics that are computed; None is all of them.
    left_out : tuple of str
        The metric of each criterion that would apply too, but isn't computed.
    """

    scene: Scene
    label: str
    truth: Truth | TruthFailure
    criteria: tuple[Criterion, ...] = ()
    metrics: tuple[str, ...] | None = None
    left_out: tuple[str, ...] = ()
    rule: StepRule | None = None


def run_case(
    case: Case, make: Callable[[str], ReferenceEngine] = make_engine
) -> tuple[CaseRecord, Motion | None]:
    """Run a case; whatever goes wrong becomes part of the record.

    Parameters
    ----------
    case : Case
    make : callable
        Makes the engine of the case's label: an installed one, unless told.

    Raises
    ------
    KeyboardInterrupt
        Where the run was interrupted; what it did until then is dropped.
    """
    record = blank_record(case)
    truth = case.truth
    if isinstance(truth, TruthFailure):
        reason = f"the truth of the scene could not be computed: {truth.reason}"
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
            case = with_step_limits(case, engine)
        result = run_engine(engine, case.scene)
        if result.status is Status.FAILED:  # of its numbers none need be one
            return failed(record, f"it says that it failed: {result.reason}"), None
        # A motion that blew up may hold nan and infinity; the metrics say so, numpy need not.
        with np.errstate(invalid="ignore", over="ignore"):
            return _judged(record, case, truth, result, resolution), motion_of(result)
    except EngineUnavailableError as error:
        return replace(record, outcome="unavailable", reason=str(error)), None
    except UnsupportedSceneError as error:
        reason = "; ".join(error.features)
        return replace(record, outcome="not-representable", reason=reason), None
    except EngineFailedError as error:
        fault: Fault = "ghostball" if error.is_our_bug else "engine"
        return failed(record, error.reason, error.trace, fault=fault), None
    # What is left is a bug of the harness: kept, never fatal.
    except (Exception, SystemExit) as error:
        reason, trace = f"{type(error).__name__}: {error}", traceback.format_exc()
        return failed(record, reason, trace, fault="ghostball"), None


def with_step_limits(case: Case, engine: ReferenceEngine) -> Case:
    """Return a case with what is computed from its engine's step among its criteria.

    What is stated wins: nothing is computed on a metric that a criterion of the case limits.
    """
    if case.rule is None or isinstance(case.truth, TruthFailure):
        return case
    stated = {criterion.metric for criterion in case.criteria} | set(case.left_out)
    computed = [
        one
        for one in step_criteria(case.rule, engine, case.scene, case.truth)
        if one.metric not in stated
    ]
    asked = [one for one in computed if case.metrics is None or one.metric in case.metrics]
    unasked = tuple(one.metric for one in computed if one not in asked)
    return replace(
        case, criteria=(*case.criteria, *asked), left_out=(*case.left_out, *unasked), rule=None
    )


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
    )


def failed(
    record: CaseRecord, reason: str, trace: str = "", *, fault: Fault = "engine"
) -> CaseRecord:
    """Return the record of a case that went wrong, with where it did, and whose fault it is."""
    return replace(record, outcome="failed", reason=reason, traceback=trace, fault=fault)


def plain_settings(engine: ReferenceEngine) -> dict[str, Any]:
    """Return all settings of an engine as plain values."""
    return engine.settings.model_dump(mode="json")


def approximations_of(engine: ReferenceEngine, scene: Scene) -> tuple[str, ...]:
    """Return what of a scene an engine represents only approximately, one sentence each."""
    capabilities = engine.capabilities
    return tuple(
        f"{feature.value}: {capabilities[feature].how}"
        for feature in scene_features(scene)
        if feature in capabilities and capabilities[feature].support == "approximate"
    )


def _judged(
    record: CaseRecord, case: Case, truth: Truth, result: Result, resolution: Resolution
) -> CaseRecord:
    horizon = truth.horizon_of(resolution)
    anyway = {criterion.metric for criterion in case.criteria if criterion.past_horizon}
    measured = measure(
        result, truth, case.metrics, horizon=horizon, resolution=resolution, anyway=anyway
    )
    start = energy_of(result.scene, initial_state(result.scene))
    end = energy_of(result.scene, result.final_state)
    return replace(
        record,
        outcome="ran",
        # An engine says in its result what a setting left open, such as a step of None, came to.
        settings=record.settings | dict(result.settings),
        status=status_name(result.status),
        reason=result.reason,
        accuracy=(
            None
            if truth.is_own_measure(record.engine, "rest")
            else accuracy_of(result, truth, resolution=resolution)
        ),
        truth=truth.kind,
        truth_positions=truth.rest_positions,
        truth_rest_time=truth.rest_time,
        horizon=_before_end(horizon, truth),
        truth_counts=truth.collision_counts,
        rest_positions=result.rest_positions,
        ball_errors=measured.ball_errors,
        rest_time=float(result.rest_time),
        collision_counts=_integers(result.collision_counts),
        energy_initial=float(start.total[0]),
        energy_final=float(end.total[0]),
        work=_integers(result.work),
        wall_time=float(result.wall_time),
        metrics=measured.values,
        notes=measured.notes,
        checks=tuple(
            criterion.check(
                measured.values[criterion.metric],
                measured.notes.get(criterion.metric, ""),
                reference=truth.is_own_measure(record.engine, METRICS[criterion.metric].compares),
            )
            for criterion in case.criteria
            if not criterion.if_measured
            or measured.values[criterion.metric] is not None
            or criterion.metric in measured.fell_short
        ),
        left_out=case.left_out,
    )


def _before_end(horizon: float, truth: Truth) -> float | None:
    """Return a horizon that comes before the end of the shot, else None."""
    return horizon if truth.rest_time is not None and horizon < truth.rest_time else None


def _integers(counters: Mapping[str, int]) -> dict[str, int]:
    return {name: int(count) for name, count in counters.items()}

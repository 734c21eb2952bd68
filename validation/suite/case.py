"""One case: one scene on one engine, run, measured and judged."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ghostball.engine import EngineFailedError, Result, Scene, Status, UnsupportedSceneError
from ghostball.engine.result import initial_state
from ghostball.engine.trajectory import energy_of
from ghostball.reference_adapters.base import ReferenceEngine, Resolution, resolution_of
from ghostball.reference_adapters.registry import (
    EngineUnavailableError,
    engine_name,
    make_engine,
)
from ghostball.validation.checks.accuracy import accuracy_of
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.checks.law import Asked, approximations_of
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.metrics import Measured, measure
from ghostball.validation.results.records import CaseRecord, Check, Fault, Motion, status_name
from ghostball.validation.runs.playing import blamed_on_engine, run_engine
from ghostball.validation.runs.sampling import first_not_finite, motion_of
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
    asked : Asked
        What it is asked there.
    metrics : tuple of str, or None
        The metrics that are computed; None is all of them. Limits on others aren't judged.
    judged_as : callable, optional
        Makes another engine, whose step and claims are held against this one; None: its own.
    """

    scene: Scene
    label: str
    truth: Truth | TruthFailure
    asked: Asked = field(default_factory=Asked)
    metrics: tuple[str, ...] | None = None
    judged_as: Callable[[], ReferenceEngine] | None = None


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
            judged = engine if case.judged_as is None else case.judged_as()
            limits = case.asked.limits(judged, case.scene, truth)
        result = run_engine(engine, case.scene)
        if result.status is Status.FAILED:  # of its numbers none need be one
            return failed(record, f"it says that it failed: {result.reason}"), None
        # A motion that blew up may hold nan and infinity; the metrics say so, numpy need not.
        with np.errstate(invalid="ignore", over="ignore"):
            return _judged(record, case, truth, result, resolution, limits), motion_of(result)
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


def _judged(
    record: CaseRecord,
    case: Case,
    truth: Truth,
    result: Result,
    resolution: Resolution,
    limits: Sequence[Criterion],
) -> CaseRecord:
    horizon = truth.horizon_of(resolution)
    asked = [one for one in limits if case.metrics is None or one.metric in case.metrics]
    anyway = {criterion.metric for criterion in asked if criterion.past_horizon}
    measured = measure(
        result, truth, case.metrics, horizon=horizon, resolution=resolution, anyway=anyway
    )
    accuracy = accuracy_of(result, truth, resolution=resolution)
    if accuracy is not None and accuracy.kind != "broken":
        accuracy = None if truth.is_own_measure(record.engine, "rest") else accuracy
    if case.metrics is None or "accuracy" in case.metrics:
        broken = accuracy is not None and accuracy.cause == "not finite"
        measured.add_class(accuracy, first_not_finite(result) if broken else result.reason)
    start = energy_of(result.scene, initial_state(result.scene))
    end = energy_of(result.scene, result.final_state)
    return replace(
        record,
        outcome="ran",
        # An engine says in its result what a setting left open, such as a step of None, came to.
        settings=record.settings | dict(result.settings),
        status=status_name(result.status),
        reason=result.reason,
        accuracy=accuracy,
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
            _check(one, measured, truth, record.engine)
            for one in asked
            if _is_judged(one, measured, truth)
        ),
        left_out=tuple(one.metric for one in limits if one not in asked),
    )


def _is_judged(criterion: Criterion, measured: Measured, truth: Truth) -> bool:
    """Whether a criterion has something to judge; where it has nothing, the record says why."""
    metric = criterion.metric
    if metric in measured.fell_short:
        return True
    if not criterion.if_measured:
        return metric not in measured.unpredictable
    part = METRICS[metric].compares
    return measured.values[metric] is not None and (part is None or part in truth.independent)


def _check(criterion: Criterion, measured: Measured, truth: Truth, engine: str) -> Check:
    metric = criterion.metric
    own = truth.is_own_measure(engine, METRICS[metric].compares)
    return criterion.check(
        measured.values[metric],
        measured.notes.get(metric) or measured.said.get(metric, ""),
        reference=own and metric not in measured.fell_short,
    )


def _before_end(horizon: float, truth: Truth) -> float | None:
    """Return a horizon that comes before the end of the shot, else None."""
    return horizon if truth.rest_time is not None and horizon < truth.rest_time else None


def _integers(counters: Mapping[str, int]) -> dict[str, int]:
    return {name: int(count) for name, count in counters.items()}

"""Judge the result of an engine: step three of the five steps of a run."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ghostball.model import Result, Scene, energy_of, first_energy
from ghostball.model.hashes import bits_hash
from ghostball.reference_adapters.base import ReferenceEngine, Resolution
from ghostball.validation.checks.accuracy import accuracy_of
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.checks.metrics import METRICS, USUAL, CaseMetrics, measure
from ghostball.validation.checks.requirements import Requirements
from ghostball.validation.results.records import Accuracy, CaseRecord, Check, status_name
from ghostball.validation.results.store import Finished
from ghostball.validation.runs.sampling import events_of, first_not_finite, motion_of
from ghostball.validation.truth.scene_truth import Truth


@dataclass(frozen=True, eq=False)
class TruthFailure:
    """Why the reference result of a scene could not be computed: the error and its traceback."""

    reason: str
    traceback: str


@dataclass(frozen=True, eq=False)
class Case:
    """A scene and an engine to run, with its reference result and limits.

    `label`: the engine with its settings, as the user wrote it.
    `asked`: the limits that apply.
    `metrics`: the metrics that are computed; None: the usual ones, and those with a limit. Limits
        on other metrics aren't judged.
    `judged_as`: creates another engine, whose time step and claims set the limits; None: the
        engine's own.
    `is_here`: whether the engine is installed where the run was planned.
    `every_record`: also run with less recorded, which must not change the result.
    `varied_from`: the scene of which this one is a perturbed initial state, or "". Its motion isn't
        stored.
    `keeps_motion`: whether the motion is stored.
    """

    scene: Scene
    label: str
    truth: Truth | TruthFailure
    asked: Requirements = field(default_factory=Requirements)
    metrics: tuple[str, ...] | None = None
    judged_as: Callable[[], ReferenceEngine] | None = None
    varied_from: str = ""
    is_here: bool = True
    every_record: bool = False
    keeps_motion: bool = True


# A diverged motion may hold nan and infinity; metrics report them, so numpy's warnings are off.
@np.errstate(invalid="ignore", over="ignore", divide="ignore")
def judge(
    record: CaseRecord,
    case: Case,
    truth: Truth,
    result: Result,
    resolution: Resolution,
    limits: Sequence[Criterion],
    engine: ReferenceEngine,
) -> Finished:
    """Return the record of a finished case with metrics and checked limits, and the motion.

    `record`: the record of the case before it ran.
    `engine`: the engine that ran it.
    `resolution`: position error that the engine states for balls at a collision.
    `limits`: limits that apply to this engine with its settings.
    """
    asked = [one for one in limits if case.metrics is None or one.metric in case.metrics]
    measured, accuracy = _measured(result, truth, asked, resolution, case.metrics, engine)
    end = energy_of(result.scene, result.final_state)
    judged = replace(
        record,
        outcome="ran",
        # The result holds the value of settings that were left open, such as a time step of None.
        settings=record.settings | dict(result.settings),
        status=status_name(result.status),
        reason=result.reason,
        accuracy=accuracy,
        truth=truth.kind,
        truth_positions=truth.rest_positions,
        truth_rest_time=truth.rest_time,
        horizon=_before_end(truth.horizon_of(resolution), truth),
        shot_horizon=_before_end(truth.shot_horizon, truth),
        truth_counts=truth.collision_counts,
        rest_positions=result.rest_positions,
        ball_errors=measured.ball_errors,
        rest_time=float(result.rest_time),
        bits=bits_hash(events_of(result), result.rest_positions),
        collision_counts=_integers(result.collision_counts),
        energy_initial=first_energy(result.scene),
        energy_final=float(end.total[0]),
        work=_integers(result.work),
        wall_time=float(result.wall_time),
        engine_time=result.engine_time,
        metrics=measured.values,
        notes=measured.notes,
        related=measured.related,
        checks=_checks(asked, measured, truth, record.engine),
        left_out=tuple(one.metric for one in limits if one not in asked and not case.varied_from),
    )
    keeps_motion = case.keeps_motion and not case.varied_from
    return judged, motion_of(result) if keeps_motion else None


def _measured(
    result: Result,
    truth: Truth,
    asked: Sequence[Criterion],
    resolution: Resolution,
    metrics: Collection[str] | None,
    engine: ReferenceEngine,
) -> tuple[CaseMetrics, Accuracy | None]:
    """Return the metrics of a run and its accuracy; no accuracy if the run is its own reference."""
    measured = measure(
        result,
        truth,
        {*USUAL, *(one.metric for one in asked)} if metrics is None else metrics,
        horizon=truth.horizon_of(resolution),
        resolution=resolution,
        include_past_horizon={criterion.metric for criterion in asked if criterion.past_horizon},
        engine=engine,
    )
    accuracy = accuracy_of(result, truth, resolution=resolution)
    own = truth.is_own_measure(result.engine, "rest")
    if accuracy is not None and accuracy.kind != "broken":
        accuracy = None if own else accuracy
    if metrics is None or "accuracy" in metrics:
        broken = accuracy is not None and accuracy.cause == "not finite"
        why = first_not_finite(result) if broken else result.reason
        compared = truth.rest_positions is not None and not own
        measured.add_class(accuracy, why, compared=compared)
    return measured, accuracy


def _checks(
    asked: Sequence[Criterion], measured: CaseMetrics, truth: Truth, engine: str
) -> tuple[Check, ...]:
    judged = (one for one in asked if _is_judged(one, measured, truth))
    return tuple(_check(one, measured, truth, engine) for one in judged)


def _is_judged(criterion: Criterion, measured: CaseMetrics, truth: Truth) -> bool:
    """Return True if a criterion can be judged; otherwise the record states why not."""
    metric = criterion.metric
    if metric in measured.incomplete:
        return True
    if not criterion.if_measured:
        return metric not in measured.unpredictable
    part = METRICS[metric].compares
    return measured.values[metric] is not None and (part is None or part in truth.independent)


def _check(criterion: Criterion, measured: CaseMetrics, truth: Truth, engine: str) -> Check:
    metric = criterion.metric
    own = truth.is_own_measure(engine, METRICS[metric].compares)
    return criterion.check(
        measured.values[metric],
        measured.notes.get(metric) or measured.said.get(metric, ""),
        reference=own and metric not in measured.incomplete,
    )


def _before_end(horizon: float, truth: Truth) -> float | None:
    """Return the horizon if it comes before the end of the shot, else None."""
    return horizon if truth.rest_time is not None and horizon < truth.rest_time else None


def _integers(counters: Mapping[str, int]) -> dict[str, int]:
    return {name: int(count) for name, count in counters.items()}

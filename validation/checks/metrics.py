"""All metrics, and their measurement for a run.

A metric that can't be computed is None, with a note of the reason, never 0.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from fnmatch import fnmatchcase

import numpy as np

from ghostball.model import GhostballError, Result
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import ReferenceEngine, Resolution
from ghostball.validation.checks.certificate_metrics import CERTIFICATE
from ghostball.validation.checks.metric import (
    Metric,
    MetricGroup,
    NotMeasuredError,
    RunAndTruth,
    RunIncompleteError,
)
from ghostball.validation.checks.motion_metrics import MOTION
from ghostball.validation.checks.outcome_metrics import OUTCOME
from ghostball.validation.checks.relations import RELATIONS
from ghostball.validation.grading.tolerances import TOLERANCE
from ghostball.validation.results.records import ACCURACY_KINDS, Accuracy, RelatedRun
from ghostball.validation.truth.scene_truth import Truth

Value = int | float | None

METRICS = MetricGroup(OUTCOME | CERTIFICATE | MOTION | RELATIONS)
"""Every metric by name, in the order of reports."""


@METRICS.metric("wall_time", "s", "run time of the simulation only, one sample")
def _wall_time(run: RunAndTruth) -> float:
    return run.result.wall_time


_CLASSES = f"accuracy class, best first: {', '.join(ACCURACY_KINDS)}"
METRICS["accuracy"] = Metric("accuracy", "class", _CLASSES, None, "rest", "shot")

USUAL: tuple[str, ...] = tuple(name for name, metric in METRICS.items() if not metric.on_demand)
"""The metrics that are measured for every shot."""


class MetricError(GhostballError, ValueError):
    """A choice of metrics that matches no known metric."""


def choose_metrics(patterns: Sequence[str]) -> tuple[str, ...]:
    """Return the metrics that match the patterns, in the order of `METRICS`, each once.

    `patterns`: names, or patterns with `*`, `?` and `[...]` such as "rest_error_*".

    Raises `MetricError` if there is no pattern, or if a pattern matches no metric.
    """
    if not patterns:
        raise MetricError("`metrics` must name at least one metric, got none")
    found = {pattern: [n for n in METRICS if fnmatchcase(n, pattern)] for pattern in patterns}
    for pattern, names in found.items():
        if not names:
            close = get_close_matches(pattern, METRICS, n=1)
            hint = f"Did you mean `{close[0]}`? " if close else ""
            raise MetricError(
                f"`metrics` must name known metrics, got {pattern!r}. {hint}"
                f"Known: {', '.join(METRICS)}"
            )
    return tuple(name for name in METRICS if any(name in names for names in found.values()))


@dataclass
class CaseMetrics:
    """Metrics of one case.

    `values`: by name, one for each requested metric, in the order of `METRICS`.
    `notes`: why a value is None.
    `said`: details of a value.
    `related`: both runs of each measured relation, by its name.
    `incomplete`: metrics without a valid value because the run stopped early, isn't finite, or is
        unphysical.
    `unpredictable`: metrics of the end of the shot without a value, because the end is after the
        engine's horizon.
    `ball_errors` (n,) float64 [m] or None: distance of each ball from its reference rest position;
        None if no metric needed it.
    """

    values: dict[str, Value] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    said: dict[str, str] = field(default_factory=dict)
    ball_errors: FloatArray | None = None
    related: dict[str, RelatedRun] = field(default_factory=dict)
    incomplete: set[str] = field(default_factory=set)
    unpredictable: set[str] = field(default_factory=set)

    def add_class(self, found: Accuracy | None, why: str = "", *, compared: bool = True) -> None:
        """Add the metric `accuracy`, if a class describes the end of the shot.

        If only the horizon can be compared, the metric has a value only if the error there exceeds
        `TOLERANCE`, or if there are wrong collisions. `why` adds details of an
        unphysical run. `compared` states whether the run has a reference.
        """
        name = "accuracy"
        self.values[name] = None
        if found is None and compared:
            self.notes[name] = "rounding alone may change the collisions of this shot"
        elif found is None:
            self.notes[name] = "there is no reference result"
        elif found.at is not None and found.error is not None and found.error <= TOLERANCE:
            self.notes[name] = f"the shot is predictable only up to t = {found.at:.3g} s"
        else:
            self.values[name] = ACCURACY_KINDS.index(found.kind)
            more = f": {why}" if why else ""
            self.said[name] = found.sentence.partition(": ")[2] + more
        if found is not None and found.kind == "broken":
            self.incomplete.add(name)


def measure(
    result: Result,
    truth: Truth,
    metrics: Collection[str] | None = None,
    *,
    horizon: float = math.inf,
    resolution: Resolution = 0.0,
    include_past_horizon: Collection[str] = (),
    engine: ReferenceEngine | None = None,
) -> CaseMetrics:
    """Measure a run recorded with `record="trajectory"` against the reference of its scene.

    `metrics`: names of the metrics to compute; default: all that aren't measured only on demand.
    `horizon` [s]: time up to which the engine can be expected to simulate this shot:
        `Truth.horizon_of`. Errors of the end of a shot have no value if the end is later; energies
        are compared up to the horizon.
    `resolution` [m]: of the engine: `reference_adapters.base.resolution_of`.
    `include_past_horizon`: metrics that have a value even after the horizon.
    `engine`: simulates the second shot that a metric of `relations` needs; None: these metrics have
        no value.
    """
    measured = CaseMetrics()
    wanted = frozenset(USUAL if metrics is None else metrics)
    beyond = truth.rest_time is not None and horizon < truth.rest_time
    run = RunAndTruth(result, truth, horizon, resolution, engine)
    for name, metric in METRICS.items():
        if metric.compute is None or name not in wanted:
            continue
        try:
            if beyond and metric.judges == "end" and name not in include_past_horizon:
                measured.unpredictable.add(name)
                raise NotMeasuredError(past_horizon(horizon))
            value = metric.compute(run)
        except NotMeasuredError as why:
            measured.values[name], measured.notes[name] = None, str(why)
            if isinstance(why, RunIncompleteError):
                measured.incomplete.add(name)
            continue
        if not np.isfinite(value):
            measured.values[name] = None
            measured.notes[name] = f"not finite: {value}"
            measured.incomplete.add(name)
            continue
        measured.values[name] = value
    measured.said |= run.said
    measured.related = {name: compared.ends for name, (_, compared) in run.related.items()}
    if any(
        measured.values.get(f"rest_error_{kind}") is not None for kind in ("max", "rms", "ulps")
    ):
        measured.ball_errors = run.ball_errors
    return measured


def past_horizon(horizon: float) -> str:
    """Return why the end of a shot isn't judged if it is after the horizon."""
    return (
        f"after the horizon: from t = {horizon:.3g} s on, errors of this engine's size may change "
        "the collisions"
    )

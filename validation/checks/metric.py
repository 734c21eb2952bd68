"""A metric: its name, unit and meaning, and how it is computed from a run and its reference."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, TypeVar

import numpy as np

from ghostball.model import ExactTrajectory, Result
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import ReferenceEngine, Resolution
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.grading.certified_growth import RoundingEffects
from ghostball.validation.grading.grading import Grade, grade
from ghostball.validation.grading.horizon import SampledGrowth, growth_along, sampled_growth
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.truth.scene_truth import Truth, TruthPart

T = TypeVar("T")


class NotMeasuredError(Exception):
    """A metric that has no value in a case; the message gives the reason in one sentence."""


class RunIncompleteError(NotMeasuredError):
    """A metric without a value because of the run itself; then a criterion on the metric fails."""


@dataclass(frozen=True, eq=False)
class RunAndTruth:
    """A run and its reference; quantities that several metrics need are computed once.

    `result`: recorded with `record="trajectory"`.
    `horizon` [s]: time up to which the engine can be expected to simulate this shot:
        `Truth.horizon_of`.
    `resolution` [m]: of the engine: `reference_adapters.base.resolution_of`.
    `engine`: simulates the second shot that a metric of `relations` needs; None: these metrics have
        no value.
    `said`: details of the values of metrics, in words, by metric.
    `related`: second shots by relation, with their comparison.

    Each property raises `NotMeasuredError` if its value doesn't exist for this shot.
    """

    result: Result
    truth: Truth
    horizon: float = math.inf
    resolution: Resolution = 0.0
    engine: ReferenceEngine | None = None
    said: dict[str, str] = field(default_factory=dict)
    related: dict[str, Any] = field(default_factory=dict)

    def known(self, part: TruthPart, value: T | None) -> T:
        """Return a part of the reference."""
        if value is None:
            raise NotMeasuredError(self.truth.why_not(part))
        return value

    def require_end(self) -> None:
        """Raise `RunIncompleteError` if the run did not reach its end."""
        result = self.result
        if not result.status.complete:
            why = f": {result.reason}" if result.reason else ""
            raise RunIncompleteError(f"the run stopped early ({result.status.value}){why}")

    @cached_property
    def ball_errors(self) -> FloatArray:
        """Each ball's distance from its reference rest position, (n,) float64 [m]."""
        self.require_end()
        right = self.known("rest", self.truth.rest_positions)
        # The difference of nearly equal doubles is exact; the low part completes the reference.
        difference = (self.result.rest_positions - right) - self.truth.rest_positions_low
        distances: FloatArray = np.linalg.norm(difference, axis=1)
        return distances

    @property
    def certificate(self) -> Certificate:
        """The certified result of the shot, or of its beginning."""
        return self.known("certificate", self.truth.certificate)

    @cached_property
    def growth(self) -> SampledGrowth:
        """The growth of errors along the whole shot: certified, else that of Ghostball's engine."""
        scene = self.result.scene
        ours = run_ours(scene)
        return sampled_growth(growth_along(scene, self.truth.certificate, ours), ours)

    @property
    def rounding(self) -> RoundingEffects:
        """The effect of rounding on the times of the certified events and on the energy."""
        return self.known("certificate", self.truth.rounding)

    @cached_property
    def grade(self) -> Grade:
        """The run compared with its certificate."""
        certificate = self.certificate
        self.require_end()
        # An engine with rounding errors only is graded as exact, even if it records only frames.
        exact = isinstance(self.result.trajectory, ExactTrajectory) or self.resolution in (
            0.0,
            "proved",
        )
        within = self.truth.graded if exact else self.truth.graded_steps
        found = grade(self.result, certificate, within)
        if found.until == 0.0:
            raise NotMeasuredError(f"no part of this shot is certified: {found.why}")
        return found


Compute = Callable[[RunAndTruth], int | float]
"""Computes a metric; raises `NotMeasuredError` if it has no value."""


@dataclass(frozen=True)
class Metric:
    """A row of the table of metrics.

    `name`, `unit`: SI; "1" is a pure number, "class" an accuracy class.
    `meaning`: one line.
    `compute`: None: the value is added later, by `CaseMetrics.add_class`.
    `compares`: the part of the reference that the metric needs; None: it needs no reference.
    `judges`: what an upper limit, or an exact value, judges: "end": the end of the shot, which has
        no meaning after the engine's horizon; "shot": the collisions of the whole shot, or
        positions at the horizon; "": neither. Energy, overlaps and the first collisions can be
        right in a shot with a wrong end.
    `on_demand`: True if it is measured only when a limit or the user names it, because it concerns
        a special kind of shot or needs a second shot.
    """

    name: str
    unit: str
    meaning: str
    compute: Compute | None
    compares: TruthPart | None = None
    judges: Literal["end", "shot", ""] = ""
    on_demand: bool = False


class MetricGroup(dict[str, Metric]):
    """Metrics by name, in the order of reports."""

    def metric(
        self,
        name: str,
        unit: str,
        meaning: str,
        compares: TruthPart | None = None,
        judges: Literal["end", "shot", ""] = "",
        *,
        on_demand: bool = False,
    ) -> Callable[[Compute], Compute]:
        """Return a decorator that adds a metric, computed by the function; see `Metric`."""

        def add(compute: Compute) -> Compute:
            self[name] = Metric(name, unit, meaning, compute, compares, judges, on_demand)
            return compute

        return add

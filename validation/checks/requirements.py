"""The limits on any engine in a scene, for all commands that judge.

    >>> asked = asked_of([(engine.name, settings)], criteria_of_the_scene)
    >>> asked.limits(engine, scene, truth)
    (Criterion(...), ...)

For each metric, the first of these sources with a limit applies: the criteria of the scene, or a
file for all scenes; then limits from the time step of the engine (`step_limits`); then the common
limits, which are the same rows of `scenes/common.expect.toml` for every engine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ghostball.model import Scene
from ghostball.model.features import scene_features
from ghostball.reference_adapters.base import ReferenceEngine, resolution_of, stated_error
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.checks.accuracy import LARGEST_ERROR
from ghostball.validation.checks.criteria import Criteria, common_criteria
from ghostball.validation.checks.criterion import CLAIMS, Claim, Criterion, StepRule
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.checks.step_limits import STEP_METRICS, step_criteria, touching, travel
from ghostball.validation.grading.grading import Grade
from ghostball.validation.runs.time_steps import step_of
from ghostball.validation.truth.scene_truth import Truth

Named = tuple[str, Mapping[str, Any]]
"""The name of an engine, and its settings."""

ByClaim = Mapping[Claim, tuple[Criterion, ...]]


def _nothing() -> ByClaim:
    return dict.fromkeys(CLAIMS, ())


@dataclass(frozen=True)
class Requirements:
    """The limits on an engine in a scene, for every claim that it may make.

    `stated`: from the scene, or from a file for all scenes.
    `law`: from the common criteria.
    `rule`: the rule for limits computed from the time step of the engine.
    `excuse`: why only the stated limits apply; "" if all apply.
    """

    stated: ByClaim = field(default_factory=_nothing)
    law: ByClaim = field(default_factory=_nothing)
    rule: StepRule | None = None
    excuse: str = ""

    def metrics(self, claim: Claim) -> tuple[str, ...]:
        """Return the metrics that may have limits for an engine with this claim, in order."""
        limited = {one.metric for one in self.stated[claim]}
        if not self.excuse:
            limited |= {one.metric for one in self.law[claim]}
            limited |= set() if self.rule is None else STEP_METRICS
        return tuple(name for name in METRICS if name in limited)

    def limits(self, engine: ReferenceEngine, scene: Scene, truth: Truth) -> tuple[Criterion, ...]:
        """Return the limits that apply to an engine in a scene."""
        if self.excuse:
            stated = self.stated[claim_of(engine, scene)]
            return tuple(_in_scene(one, engine, scene, truth) for one in stated)
        return self._all(engine, scene, truth)

    def not_asked(
        self, engine: ReferenceEngine, scene: Scene, truth: Truth
    ) -> tuple[Criterion, ...]:
        """Return the limits that would also apply to an excused engine without its excuse."""
        if not self.excuse:
            return ()
        asked = self.limits(engine, scene, truth)
        return tuple(one for one in self._all(engine, scene, truth) if one not in asked)

    def _all(self, engine: ReferenceEngine, scene: Scene, truth: Truth) -> tuple[Criterion, ...]:
        claim = claim_of(engine, scene)
        found = self.stated[claim]
        computed = () if self.rule is None else step_criteria(self.rule, engine, scene, truth)
        for others in (computed, self.law[claim]):
            found = _with_others(found, others)
        return tuple(_in_scene(one, engine, scene, truth) for one in found)

    def plain(self) -> dict[str, Any]:
        """Return the limits as plain values, for a hash."""
        return {
            "limits": [
                [one.model_dump(mode="json") for one in rows[claim]]
                for rows in (self.stated, self.law)
                for claim in CLAIMS
            ],
            "rule": None if self.rule is None else self.rule.model_dump(mode="json"),
            "excuse": self.excuse,
        }


def asked_of(
    names: Sequence[Named], own: Criteria, for_all: Criteria | None = None
) -> Requirements:
    """Return the limits on an engine in a scene.

    `names`: the engine; if it is judged as another engine, that engine follows.
    `own`: criteria of the scene.
    `for_all`: criteria for all scenes.

    Raises `CriteriaError` if criteria contradict each other.
    """
    files = (own,) if for_all is None else (own, for_all)
    stated: dict[Claim, tuple[Criterion, ...]] = {}
    law: dict[Claim, tuple[Criterion, ...]] = {}
    for claim in CLAIMS:
        stated[claim], law[claim] = (), ()
        for name, settings in names:
            for criteria in files:
                rows = criteria.applying_to(name, settings, claim)
                stated[claim] = _with_others(stated[claim], rows)
            rows = common_criteria().applying_to(name, settings, claim)
            law[claim] = _with_others(law[claim], rows)
    judged, settings = names[-1]
    rule = own.step_rule(judged, settings, *files[1:], common_criteria())
    excuses = (one.excuse(judged, settings) for one in (*files, common_criteria()))
    return Requirements(stated, law, rule, next(filter(None, excuses), ""))


def faults_of(grade: Grade, scene: Scene) -> tuple[str, ...]:
    """Return the failed limits for engines with rounding errors only, one sentence each.

    A metric without a value fails no limit.
    """
    values = {
        "events_missing": len(grade.missing),
        "events_invented": len(grade.invented),
        "event_time_error_ulps": grade.time_error_max,
        "quality_factor": grade.quality_factor,
    }
    broken = [
        criterion
        for criterion in common_criteria().applying_to(OURS, {}, "rounding")
        if (value := values.get(criterion.metric)) is not None and not criterion.allows(value)
    ]
    faults = [
        f"{criterion.metric} is {values[criterion.metric]:.6g}, {criterion.limit_kind} "
        f"{criterion.limit:g}"
        for criterion in broken
    ]
    if grade.first is not None and faults:
        faults.append(grade.first.describe(scene))
    return tuple(faults)


def claim_of(engine: ReferenceEngine, scene: Scene) -> Claim:
    """Return the claim of an engine in a scene."""
    stated = resolution_of(engine, scene)
    if approximations_of(engine, scene):
        return "less"
    if stated is None:
        return "exact"
    if stated in (0.0, "proved"):
        return "rounding"
    fine = step_of(engine) is None and stated_error(stated) < LARGEST_ERROR["nanometres"]
    return "exact" if fine else "less"


def is_unstated(engine: ReferenceEngine, scene: Scene) -> bool:
    """Return True if an engine states nothing useful about its accuracy in a scene.

    It states neither a time step nor exactness, or it states that positions at a collision may be
    off by a radius.
    """
    stated = resolution_of(engine, scene)
    if stated is None:
        return claim_of(engine, scene) == "less"
    return stated_error(stated) >= float(np.min(scene.radii))


def approximations_of(engine: ReferenceEngine, scene: Scene) -> tuple[str, ...]:
    """Return the features of a scene that an engine supports only approximately."""
    capabilities = engine.capabilities
    return tuple(
        f"{feature.value}: {capabilities[feature].how}"
        for feature in scene_features(scene)
        if feature in capabilities and capabilities[feature].support == "approximate"
    )


def _in_scene(
    criterion: Criterion, engine: ReferenceEngine, scene: Scene, truth: Truth
) -> Criterion:
    """Return a criterion with its limit in the unit of its metric."""
    if criterion.of is None:
        return criterion
    unit = touching(scene, truth)
    if criterion.of == "step":
        unit += travel(engine, scene)
    limit = criterion.limit * unit
    return criterion.model_copy(update={criterion.limit_kind: limit, "of": None})


def _with_others(
    first: tuple[Criterion, ...], others: Sequence[Criterion]
) -> tuple[Criterion, ...]:
    """Return `first`, and the criteria of `others` on metrics that `first` doesn't limit."""
    limited = {one.metric for one in first}
    return first + tuple(one for one in others if one.metric not in limited)

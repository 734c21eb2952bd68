"""Requirements on an engine in tests, and the limits of the shipped rules for its time step."""

from __future__ import annotations

from collections.abc import Sequence

from ghostball.model import Scene
from ghostball.reference_adapters import ReferenceEngine, make_engine
from ghostball.validation.checks.criteria import Criteria, common_criteria
from ghostball.validation.checks.criterion import Criterion, StepRule
from ghostball.validation.checks.requirements import CLAIMS, Requirements
from ghostball.validation.checks.step_limits import step_criteria
from ghostball.validation.suite.case import plain_settings
from ghostball.validation.truth.scene_truth import truth_of


def asked_of_all(criteria: Sequence[Criterion], rule: StepRule | None = None) -> Requirements:
    """Return requirements with these criteria for every engine, without the common limits."""
    return Requirements(dict.fromkeys(CLAIMS, tuple(criteria)), rule=rule)


def criteria_of_step(scene: Scene, engine: ReferenceEngine) -> tuple[Criterion, ...]:
    """Return all limits that are computed for an engine in a scene."""
    rule = Criteria().step_rule(engine.name, plain_settings(engine), common_criteria())
    assert rule is not None
    return step_criteria(rule, engine, scene, truth_of(scene))


def limit_of_step(scene: Scene, label: str) -> float | None:
    """Return the limit on the rest position error [m], or None if there is none."""
    found = criteria_of_step(scene, make_engine(label))
    return next((one.limit for one in found if one.metric == "rest_error_max"), None)

"""What is asked of an engine in tests, and what the shipped rules allow it for its step."""

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
    """Return that these criteria are asked, whatever an engine claims, and no law."""
    return Requirements(dict.fromkeys(CLAIMS, tuple(criteria)), rule=rule)


def criteria_of_step(scene: Scene, engine: ReferenceEngine) -> tuple[Criterion, ...]:
    """Return all that is computed of an engine in a scene."""
    rule = Criteria().step_rule(engine.name, plain_settings(engine), common_criteria())
    assert rule is not None
    return step_criteria(rule, engine, scene, truth_of(scene))


def limit_of_step(scene: Scene, label: str) -> float | None:
    """Return how far from its place a ball may rest [m], or None where nothing says it."""
    found = criteria_of_step(scene, make_engine(label))
    return next((one.limit for one in found if one.metric == "rest_error_max"), None)

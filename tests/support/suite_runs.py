"""Short shots and limits for the tests of the suite."""

from __future__ import annotations

from ghostball.model import Ball, Scene
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.criterion import Criterion


def scene(name: str = "roll") -> Scene:
    return Scene(name=name, balls=[Ball(id="cue", position=(0.0, 0.0), velocity=(1.0, 0.0))])


def limits(*engines: str, metric: str = "rest_error_max", at_most: float = 1e-6) -> Criteria:
    criterion = Criterion.model_validate(
        {"engines": engines, "metric": metric, "at_most": at_most, "reason": "by hand"}
    )
    return Criteria(criteria=(criterion,))

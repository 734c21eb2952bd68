"""Limits that tests ask engines to keep."""

from __future__ import annotations

from typing import Any

from ghostball.validation.checks.criterion import Criterion


def criterion(*engines: str, metric: str = "rest_error_max", **limit: Any) -> Criterion:
    """Return a criterion; without a limit, that the metric is 1 at most."""
    named = {"engines": engines, "metric": metric, "reason": "by hand"}
    return Criterion.model_validate(named | (limit or {"at_most": 1.0}))

"""Whom a criterion covers, and what it makes of a value."""

from __future__ import annotations

import math

import pytest

from ghostball.validation.checks.criterion import CriteriaError, Criterion, Selector

FIXED = {"contact_steps": "fixed", "dt": 0.001, "gate": True}


def criterion(*engines: str, metric: str = "rest_error_max", **limit: float) -> Criterion:
    return Criterion.model_validate(
        {"engines": engines, "metric": metric, "reason": "because", **(limit or {"at_most": 1.0})}
    )


@pytest.mark.parametrize(
    ("selector", "covered"),
    [
        ("pymunk", True),
        ("pymunk:dt=1e-3", True),  # a number, however it is spelled
        ("pymunk:dt=0.002", False),
        ("pymunk:dt=small", False),
        ("pymunk:gate=TRUE", True),
        ("pymunk:gate=1", False),
        ("pymunk:gate=true,contact_steps=fixed", True),
        ("pymunk:gate=true,contact_steps=exact", False),
        ("pybullet", False),
    ],
)
def test_a_selector_compares_the_effective_settings(selector: str, covered: bool) -> None:
    assert Selector.parse(selector).covers("pymunk", FIXED) is covered


def test_a_selector_with_a_setting_that_the_engine_lacks_is_refused() -> None:
    # It would never match, and the criterion would guard nothing.
    with pytest.raises(
        CriteriaError, match=r"`pymunk:contact_step=exact` names the setting `contact_step`"
    ):
        Selector.parse("pymunk:contact_step=exact").covers("pymunk", FIXED)


@pytest.mark.parametrize(
    ("limit", "value", "passed"),
    [
        ({"at_most": 2.0}, 2.0, True),
        ({"at_most": 2.0}, math.nextafter(2.0, 3.0), False),
        ({"at_least": 2.0}, 2.0, True),
        ({"at_least": 2.0}, math.nextafter(2.0, 1.0), False),
        ({"equals": 3}, 3, True),
        ({"equals": 3}, 4, False),
        ({"at_most": 2.0}, math.nan, False),
        ({"at_least": 2.0}, math.nan, False),
        ({"at_most": 0.0}, 0.0, True),  # 0 is a limit like any other, not "none given"
    ],
)
def test_a_limit_includes_its_bound(limit: dict[str, float], value: float, passed: bool) -> None:
    check = criterion("pymunk", **limit).check(value)
    assert check.passed is passed
    assert (check.limit_kind, check.limit) == next(iter(limit.items()))
    assert (check.unit, check.reason) == ("m", "because")


def test_a_metric_without_a_value_fails_its_criterion() -> None:
    check = criterion("pymunk").check(None, "the run stopped early")
    assert check.passed is False
    assert check.note == "the run stopped early"


def test_our_engine_against_itself_gets_no_verdict() -> None:
    check = criterion("ghostball").check(0.0, reference=True)
    assert check.passed is None
    assert "itself" in check.note

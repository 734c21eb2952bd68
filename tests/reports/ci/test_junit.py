"""The JUnit document of a run: tests that can't fail don't pass, and failures of `regress` fail."""

from __future__ import annotations

from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

import pytest
from regressions import regression, unchanged, worse
from stored_records import record

from ghostball.reports.ci.junit import junit_xml
from ghostball.validation.baselines.regression import Regression
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.checks.verdict import NOTHING_JUDGED
from ghostball.validation.results.records import Accuracy, CaseRecord, Check


def case(**changes: Any) -> CaseRecord:
    fields = {
        "definition": {},  # without balls no limit is wider than the smallest one
        "status": "rest",
        "wall_time": 1.25,
        "metrics": dict.fromkeys(METRICS, 0.5) | {"energy_drift": None},
        "notes": {"energy_drift": "energy is lost"},
    }
    return record("pymunk:contact_steps=exact", "roll", **(fields | changes))


def check(metric: str = "rest_error_max", passed: bool | None = True, **changes: Any) -> Check:
    return replace(Check(metric, 0.5, "at_most", 0.25, "m", passed, "the reason"), **changes)


def parsed(*cases: CaseRecord) -> dict[str, ElementTree.Element]:
    root = ElementTree.fromstring(junit_xml(cases).encode())
    return {str(element.get("name")): element for element in root.iter("testcase")}


def verdict(element: ElementTree.Element) -> tuple[str, str]:
    (child,) = list(element)
    return child.tag, str(child.get("message"))


def test_one_test_case_for_each_scene_engine_and_metric() -> None:
    found = parsed(case(checks=(check(),)))
    assert list(found) == [f"pymunk:contact_steps=exact: {metric}" for metric in METRICS]
    assert {element.get("classname") for element in found.values()} == {"roll"}
    assert sum(float(element.get("time", "nan")) for element in found.values()) == 1.25


def test_only_a_limit_that_was_kept_passes() -> None:
    found = parsed(case(checks=(check(), check("wall_time", passed=False))))
    passed = [name for name, element in found.items() if len(element) == 0]
    assert passed == ["pymunk:contact_steps=exact: rest_error_max"]


def test_a_failure_says_value_limit_and_reason() -> None:
    element = parsed(case(checks=(check(passed=False),)))[
        "pymunk:contact_steps=exact: rest_error_max"
    ]
    assert verdict(element) == ("failure", "rest_error_max must be at most 250 mm, got 500 mm")
    assert element[0].text == "the reason"


@pytest.mark.parametrize(
    ("metric", "checks", "message"),
    [
        ("rest_error_rms", (), "measured 500 mm; no limit applies"),
        ("energy_drift", (), "energy is lost"),
        ("rest_error_max", (check(passed=None, note="itself"),), "reference: itself"),
    ],
)
def test_what_proves_nothing_is_skipped(
    metric: str, checks: tuple[Check, ...], message: str
) -> None:
    element = parsed(case(checks=checks))[f"pymunk:contact_steps=exact: {metric}"]
    assert verdict(element) == ("skipped", message)


@pytest.mark.parametrize(
    ("outcome", "tag", "message"),
    [
        ("not-representable", "skipped", "not-representable: no flight"),
        ("unavailable", "skipped", "unavailable: no flight"),
        ("failed", "error", "no flight"),
    ],
)
def test_a_case_that_did_not_run(outcome: str, tag: str, message: str) -> None:
    raised = "line 1\nline 2" if outcome == "failed" else ""
    found = parsed(case(outcome=outcome, reason="no flight", traceback=raised))
    assert ("judged" in found) is (outcome != "failed")  # nothing was, else
    element = found["pymunk:contact_steps=exact: simulate"]
    assert verdict(element) == (tag, message)
    assert element[0].text == (raised or None)


def test_a_metric_that_was_not_asked_for_is_skipped_and_says_whether_it_has_a_limit() -> None:
    # Leaving out a limit must not make a test pass.
    some = case(metrics={"wall_time": 0.5}, notes={}, left_out=("rest_error_max",))
    found = parsed(some)
    for metric, more in (
        ("rest_error_max", ", although the scene has a limit on it"),
        ("energy_rise", ""),
    ):
        message = f"not measured: left out by --metric{more}"
        assert verdict(found[f"pymunk:contact_steps=exact: {metric}"]) == ("skipped", message)
    assert verdict(found.pop("judged")) == ("error", NOTHING_JUDGED)
    assert len(found) == len(METRICS)


def test_a_run_that_stopped_early_is_in_error() -> None:
    # An engine that stops early must not pass, although no limit applies to this.
    found = parsed(case(status="step-limit", reason="too many"), case(checks=(check(),)))
    assert verdict(found["pymunk:contact_steps=exact: simulate"]) == (
        "error",
        "stopped early: step-limit: too many",
    )
    assert "judged" not in found


def test_the_first_test_case_says_how_right_the_run_is() -> None:
    found = Accuracy("another shot", at=1.25, agree=4, of=7)
    first, *others = parsed(case(accuracy=found, printed="hello\n")).values()
    (given,) = first.iter("property")
    assert given.attrib == {"name": "accuracy", "value": "another shot"}
    assert first.findtext("system-out") == (
        "accuracy: wrong collisions: the first 4 of 7 are right; first wrong collision at 1.25 "
        "s\nhello"
    )
    assert not any(list(other.iter("property")) for other in others)
    # Without a reference there is no accuracy class.
    assert not list(next(iter(parsed(case()).values())).iter("property"))


def test_control_characters_and_markup_survive() -> None:
    # A terminal colour in an exception's text must not make the whole file unreadable.
    bad = case(outcome="failed", reason="\x1b[31m<&\x00\ud800\ufffe", traceback="a\x08\tb\n")
    (element,) = parsed(bad).values()
    assert verdict(element) == ("error", r"\x1b[31m<&\x00\ud800\ufffe")
    assert element[0].text == "a\\x08\tb\n"


# --- baselines --------------------------------------------------------------------------------


def of_baselines(*compared: Regression) -> dict[tuple[str, str], ElementTree.Element]:
    root = ElementTree.fromstring(junit_xml((), compared).encode())
    return {(str(one.get("classname")), str(one.get("name"))): one for one in root.iter("testcase")}


def kind_of(element: ElementTree.Element) -> str:
    kinds = [one.tag for one in element if one.tag in ("failure", "error", "skipped")]
    assert len(kinds) <= 1
    return kinds[0] if kinds else "passed"


def test_a_scene_that_is_as_accepted_passes() -> None:
    found = of_baselines(regression(unchanged(), outcome="passed"))
    assert list(found) == [("stop", "ghostball: baseline")]
    assert kind_of(found["stop", "ghostball: baseline"]) == "passed"


def test_a_scene_that_moved_says_by_how_much_and_how_to_see_it() -> None:
    element = of_baselines(regression(worse()))["break-7", "ghostball: baseline"]
    assert verdict(element) == ("failure", "worse: rest error 3 mm, was 7 fm")
    for part in (
        "which is missing now",
        "rest_error_max 7e-15 -> 0.003 m",
        "roots 10 -> 12",
        "ghostball run break-7",
    ):
        assert part in str(element[0].text)


@pytest.mark.parametrize("change", ["rounding", "better", "changed"])
def test_bits_that_may_move_pass_and_say_so(change: str) -> None:
    moved = regression(worse(change=change, failed=False), outcome="passed")
    element = of_baselines(moved)["break-7", "ghostball: baseline"]
    assert kind_of(element) == "passed"
    assert str(element.findtext("system-out")).startswith(f"{change}: ")

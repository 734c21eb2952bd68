"""A comparison as JUnit XML: a suite for each scene, a test case for each quantity.

Beside the quantities, each scene has a test case for its verdict, for the bits of its results and
for its events; whoever counts failures finds one exactly where the gate fails. What only warns
passes, with the warning as its output. What could not be compared is in error, never passed.
"""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree

from ghostball.validation.baselines.regression import Quantity, Regression, SceneChange
from ghostball.validation.results.junit_document import (
    case_element,
    document,
    set_output,
    set_verdict,
)

UNCOMPARED = ("no-baseline", "not-comparable")
"""Changes that say that there was nothing to compare with."""

_UNCHANGED = ("identical", "rounding-only")


def regression_xml(*regressions: Regression) -> str:
    """Return comparisons as one JUnit document; `classname` is the scene, `name` the quantity."""
    suites: dict[str, list[ElementTree.Element]] = {}
    notes: list[str] = []
    for regression in regressions:
        on = f" on {regression.label}" * (len(regressions) > 1)
        suites |= {f"{one.scene}{on}": list(_test_cases(one)) for one in regression.scenes}
        if regression.outcome == "no-baseline" and not any(map(_uncompared, regression.scenes)):
            nothing = case_element("regression", "baselines")
            message = f"nothing could be compared with {regression.against}"
            set_verdict(nothing, "error", message, "\n".join(regression.warnings))
            suites[f"regression{on}"] = [nothing]
        notes += regression.warnings
        notes += [f"baseline of a scene that is no more: {name}" for name in regression.stale]
    return document(suites, notes)


def number_of(quantity: Quantity, value: float | int | None) -> str:
    """Return a value of a quantity with its unit, to all digits, for it may differ in the last."""
    number = "nothing" if value is None else repr(value)
    return number if quantity.unit == "1" else f"{number} {quantity.unit}"


def moved_text(quantity: Quantity) -> str:
    """Say in one sentence where a quantity was, where it is, and where it may be."""
    base, head, low, high = (
        number_of(quantity, value)
        for value in (quantity.base, quantity.head, quantity.low, quantity.high)
    )
    band = {
        (True, True): f"within [{low}, {high}]",
        (True, False): f"at least {low}",
        (False, True): f"at most {high}",
        (False, False): f"{base}, as it was",
    }[quantity.low is not None, quantity.high is not None]
    return f"{quantity.name} must be {band}, got {head} (before: {base})"


def _test_cases(change: SceneChange) -> Iterator[ElementTree.Element]:
    verdict = case_element(change.scene, "verdict")
    if _uncompared(change):
        words = f"{change.change}: {change.summary}"
        set_verdict(verdict, "failure" if change.failed else "error", words, change.command)
        yield verdict
        return
    if change.failed:
        set_verdict(verdict, "failure", f"{change.change}: {change.summary}", change.command)
    elif change.change != "identical":
        set_output(verdict, [f"{change.change}: {change.summary}"])
    yield verdict
    yield from (_quantity_case(change, one) for one in (*change.metrics, *change.counters))
    yield _hash_case(change)
    yield _difference_case(change)
    if change.time is not None:
        yield _time_case(change)


def _quantity_case(change: SceneChange, quantity: Quantity) -> ElementTree.Element:
    element = case_element(change.scene, quantity.name)
    if quantity.level == "off":
        set_verdict(element, "skipped", f"not judged: {quantity.why}")
    elif not quantity.within and quantity.level == "error" and change.failed:
        set_verdict(element, "failure", moved_text(quantity), f"{quantity.why}\n{change.command}")
    elif not quantity.within:
        set_output(element, [f"warning: {moved_text(quantity)}", quantity.why])
    return element


def _hash_case(change: SceneChange) -> ElementTree.Element:
    element = case_element(change.scene, "hash")
    hashes = f"base {change.base_hash or 'none'}, head {change.head_hash or 'none'}"
    if not change.base_hash or not change.head_hash:
        set_verdict(element, "error", f"there is no hash to compare: {hashes}")
    elif change.base_hash != change.head_hash:
        _judge_moved(element, change, f"the bits of events and rest positions differ: {hashes}")
    return element


def _difference_case(change: SceneChange) -> ElementTree.Element:
    element = case_element(change.scene, "first difference")
    first = change.first_difference
    if first is not None and first.before_horizon:
        _judge_moved(element, change, first.words)
    elif first is not None:
        set_output(element, [f"past the predictability horizon: {first.words}"])
    return element


def _judge_moved(element: ElementTree.Element, change: SceneChange, words: str) -> None:
    """Fail a test case about results that moved, where the scene fails for more than rounding."""
    if change.failed and change.change not in _UNCHANGED:
        set_verdict(element, "failure", words, change.command)
    else:
        set_output(element, [f"{change.change}: {words}"])


def _time_case(change: SceneChange) -> ElementTree.Element:
    assert change.time is not None
    element = case_element(change.scene, "run time", change.time.head.median)
    if change.time.slower:
        set_verdict(element, "failure", f"slower: {change.time.words}", change.command)
    return element


def _uncompared(change: SceneChange) -> bool:
    return change.change in UNCOMPARED

"""Results as JUnit XML: one test case for each scene, engine and metric.

The first of a scene and engine says how right the run is: its class is a property `accuracy`, with
its numbers in the output. A metric with a limit passes or fails. One that has none, that proves
nothing (our engine against itself) or that could not be measured is skipped with the reason: a test
that can't fail must not count as passed. A case that did not run is one test case, skipped or in
error; one that stopped early has a test case in error too. So has a run in which nothing was
judged.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator
from xml.etree import ElementTree

from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.verdict import (
    NOTHING_JUDGED,
    is_nothing_judged,
    is_unfinished,
    unfinished_text,
)
from ghostball.validation.results.junit_document import (
    case_element,
    document,
    set_output,
    set_property,
    set_verdict,
)
from ghostball.validation.results.records import CaseRecord, Check, number_with_unit


def junit_xml(cases: Collection[CaseRecord]) -> str:
    """Return the cases as one JUnit document; `classname` is the scene, `name` "engine: metric"."""
    by_scene: dict[str, list[ElementTree.Element]] = defaultdict(list)
    for case in cases:
        by_scene[case.scene].extend(_test_cases(case))
    if is_nothing_judged(cases):
        element = case_element("ghostball", "judged")
        set_verdict(element, "error", NOTHING_JUDGED)
        by_scene["ghostball"].append(element)
    return document(by_scene)


def _test_cases(case: CaseRecord) -> Iterator[ElementTree.Element]:
    if case.outcome != "ran":
        element = _test_case(case, "simulate")
        if is_unfinished(case):
            set_verdict(element, "error", case.reason, case.traceback)
        else:
            set_verdict(element, "skipped", f"{case.outcome}: {case.reason}")
        set_output(element, case.printed.splitlines())
        yield element
        return
    if is_unfinished(case):
        element = _test_case(case, "simulate")
        set_verdict(element, "error", unfinished_text(case))
        yield element
    checks: dict[str, list[Check]] = defaultdict(list)
    for check in case.checks:
        checks[check.metric].append(check)
    for position, metric in enumerate(METRICS):
        # A simulation's time is given once, with its first metric, so that sums are right.
        element = _test_case(case, metric, case.wall_time if position == 0 else None)
        _judge(element, case, metric, checks[metric])
        if position == 0:
            said = case.printed.splitlines()
            if case.accuracy is not None:
                set_property(element, "accuracy", case.accuracy.kind)
                said.insert(0, f"accuracy: {case.accuracy.sentence}")
            set_output(element, said)
        yield element


def _judge(
    element: ElementTree.Element, case: CaseRecord, metric: str, checks: list[Check]
) -> None:
    failures = [check.sentence for check in checks if check.passed is False]
    if failures:
        reasons = "\n".join(check.reason for check in checks if check.passed is False)
        set_verdict(element, "failure", "; ".join(failures), reasons)
    elif any(check.passed is None for check in checks):
        set_verdict(element, "skipped", f"reference: {checks[0].note}")
    elif metric not in case.metrics:
        limit = ", though the scene limits it" if metric in case.left_out else ""
        set_verdict(element, "skipped", f"not measured: the run asked for other metrics{limit}")
    elif not checks:
        value = number_with_unit(case.metrics[metric], METRICS[metric].unit)
        note = case.notes.get(metric)
        set_verdict(element, "skipped", note or f"measured {value}; the scene sets no limit")


def _test_case(case: CaseRecord, what: str, seconds: float | None = None) -> ElementTree.Element:
    return case_element(case.scene, f"{case.label}: {what}", seconds or 0.0)

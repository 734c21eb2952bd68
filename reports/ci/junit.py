"""A run as a JUnit document: the checks of all cases, and the changes since the baselines.

There is one test case for each scene, engine and metric. The first test case of a scene and engine
has the accuracy class as the property `accuracy`, and the errors in its output. A metric with a
limit passes or fails. A metric is skipped, with the reason, if it has no limit, if it compares
Ghostball's engine with itself, or if it could not be measured: a test that can't fail must not
count as passed.

A case that did not run is one test case, skipped or in error. A case that stopped early has an
additional test case in error. Without comparisons, the document has a test case `judged` in error
if nothing was judged, or if the final positions of some engine were judged in no case. A scene that
was compared with its baseline has a test case `baseline`: it fails if the change fails, and is in
error if there was nothing to compare with.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Literal
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from ghostball.reports.ci.findings import change_lines
from ghostball.validation.baselines.regression import UNCOMPARED, Regression, SceneChange
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.checks.verdict import is_unfinished, not_judged, unfinished_text
from ghostball.validation.results.records import CaseRecord, Check, number_with_unit

Kind = Literal["failure", "error", "skipped"]
"""JUnit's element of a test case that doesn't pass."""

# XML 1.0 can't hold these characters, even escaped.
_FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit_xml(cases: Collection[CaseRecord], regressions: Sequence[Regression] = ()) -> str:
    """Return a run as a JUnit document; `classname` is the scene, `name` "engine: metric"."""
    by_scene: dict[str, list[Element]] = defaultdict(list)
    for case in cases:
        by_scene[case.scene].extend(_of_case(case))
    for regression in regressions:
        for change in regression.scenes:
            by_scene[change.scene].append(_of_change(regression.label, change))
    if (why := not_judged(cases)) and not regressions:
        by_scene["ghostball"].append(_test_case("ghostball", "judged", "error", why))
    root = Element("testsuites", name="ghostball")
    for scene, found in by_scene.items():
        suite = SubElement(root, "testsuite", name=_clean(scene))
        suite.extend(found)
        _count(suite, found)
    _count(root, [one for found in by_scene.values() for one in found])
    _put_output(root, [note for one in regressions for note in one.warnings])
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode", xml_declaration=False)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _of_case(case: CaseRecord) -> Iterator[Element]:
    if case.outcome != "ran" or is_unfinished(case):
        kind: Kind = "error" if is_unfinished(case) else "skipped"
        why = unfinished_text(case) or f"{case.outcome}: {case.reason}"
        found = _test_case(case.scene, f"{case.label}: simulate", kind, why, case.traceback)
        yield found
        if case.outcome != "ran":
            _put_output(found, case.printed.splitlines())
            return
    checks: dict[str, list[Check]] = defaultdict(list)
    for check in case.checks:
        checks[check.metric].append(check)
    for position, metric in enumerate(METRICS):
        found = _of_metric(case, metric, checks[metric])
        if position == 0:
            # The run time is given once, with the first metric, because readers add all times.
            found.set("time", f"{case.wall_time or 0.0:.6f}")
            said = case.printed.splitlines()
            if case.accuracy is not None:
                properties = SubElement(found, "properties")
                SubElement(properties, "property", name="accuracy", value=case.accuracy.kind)
                said.insert(0, f"accuracy: {case.accuracy.sentence}")
            _put_output(found, said)
        yield found


def _of_metric(case: CaseRecord, metric: str, checks: list[Check]) -> Element:
    failed = [check for check in case.broken if check.metric == metric]
    scene, name = case.scene, f"{case.label}: {metric}"
    if failed:
        words = "; ".join(check.sentence for check in failed)
        return _test_case(scene, name, "failure", words, "\n".join(one.reason for one in failed))
    if why := _unjudged(case, metric, checks):
        return _test_case(scene, name, "skipped", why)
    return _test_case(scene, name)


def _unjudged(case: CaseRecord, metric: str, checks: list[Check]) -> str:
    """Return why a metric can't fail; "" if it has a limit."""
    if any(check.passed is None for check in checks):
        return f"reference: {checks[0].note}"
    if metric not in case.metrics:
        limit = ", although the scene has a limit on it" if metric in case.left_out else ""
        return f"not measured: left out by --metric{limit}"
    if checks:
        return ""
    value = number_with_unit(case.metrics[metric], METRICS[metric].unit)
    return case.notes.get(metric) or f"measured {value}; no limit applies"


def _of_change(label: str, change: SceneChange) -> Element:
    """Return the test case of a scene's comparison with its baseline.

    It fails because of changes only; failed limits have their own test cases.
    """
    name, words = f"{label}: baseline", f"{change.change}: {change.summary}"
    lines = [*change_lines(change), *([change.command] if change.command else [])]
    if change.failed and change.moved:
        return _test_case(change.scene, name, "failure", words, "\n".join(lines))
    if change.change in UNCOMPARED:
        return _test_case(change.scene, name, "error", words, change.command)
    found = _test_case(change.scene, name)
    if change.moved:
        _put_output(found, [words, *lines])
    return found


def _test_case(
    suite: str, name: str, kind: Kind | None = None, message: str = "", text: str = ""
) -> Element:
    found = Element("testcase", classname=_clean(suite), name=_clean(name), time="0")
    if kind is not None:
        verdict = SubElement(found, kind, message=_clean(message))
        verdict.text = _clean(text) or None
    return found


def _put_output(element: Element, lines: Iterable[str]) -> None:
    if text := "\n".join(lines):
        SubElement(element, "system-out").text = _clean(text)


def _count(suite: Element, found: Sequence[Element]) -> None:
    suite.set("tests", str(len(found)))
    for kind, attribute in (("failure", "failures"), ("error", "errors"), ("skipped", "skipped")):
        suite.set(attribute, str(sum(one.find(kind) is not None for one in found)))


def _clean(text: str) -> str:
    r"""Write characters that XML can't hold as Python escapes, such as \x1b."""
    return _FORBIDDEN.sub(lambda found: found[0].encode("unicode_escape").decode(), text)

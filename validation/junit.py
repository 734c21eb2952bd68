"""Results as JUnit XML: one test case for each scene, engine and metric.

A metric with a limit passes or fails. One that has none, that proves nothing (our engine against
itself) or that could not be measured is skipped with the reason: a test that can't fail must not
count as passed. A case that did not run is one test case, skipped or in error.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from xml.etree import ElementTree

from engine import GhostballError
from validation.metric_table import METRICS
from validation.records import CaseRecord, Check, number_with_unit

# XML 1.0 has no way to write these, not even escaped.
_FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_junit(cases: Iterable[CaseRecord], path: str | Path) -> None:
    """Write the JUnit file of a run, whole or not at all.

    Raises
    ------
    GhostballError
        Where it can't be written.
    """
    target = Path(path)
    part = target.with_name(target.name + ".part")
    try:
        part.write_text(junit_xml(cases), encoding="utf-8")
        part.replace(target)
    except OSError as error:
        with suppress(OSError):  # nothing to clean up where not even the folder can be entered
            part.unlink()
        reason = error.strerror or type(error).__name__
        raise GhostballError(
            f"{target}: can't write the JUnit file: {reason}. Choose another `--junit`"
        ) from error


def junit_xml(cases: Iterable[CaseRecord]) -> str:
    """Return the cases as one JUnit document; `classname` is the scene, `name` "engine: metric"."""
    root = ElementTree.Element("testsuites", name="ghostball")
    by_scene: dict[str, list[ElementTree.Element]] = defaultdict(list)
    for case in cases:
        by_scene[case.scene].extend(_test_cases(case))
    for scene, elements in by_scene.items():
        suite = ElementTree.SubElement(root, "testsuite", name=_clean(scene))
        suite.extend(elements)
        _count(suite, elements)
    _count(root, [element for elements in by_scene.values() for element in elements])
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode", xml_declaration=False)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _test_cases(case: CaseRecord) -> Iterator[ElementTree.Element]:
    if case.outcome != "ran":
        element = _test_case(case, "simulate")
        if case.outcome == "failed":
            _verdict(element, "error", case.reason, case.traceback)
        else:
            _verdict(element, "skipped", f"{case.outcome}: {case.reason}")
        yield element
        return
    checks: dict[str, list[Check]] = defaultdict(list)
    for check in case.checks:
        checks[check.metric].append(check)
    for position, metric in enumerate(METRICS):
        # A simulation's time is given once, with its first metric, so that sums are right.
        element = _test_case(case, metric, case.wall_time if position == 0 else None)
        _judge(element, case, metric, checks[metric])
        yield element


def _judge(
    element: ElementTree.Element, case: CaseRecord, metric: str, checks: list[Check]
) -> None:
    failures = [check.sentence for check in checks if check.passed is False]
    if failures:
        reasons = "\n".join(check.reason for check in checks if check.passed is False)
        _verdict(element, "failure", "; ".join(failures), reasons)
    elif any(check.passed is None for check in checks):
        _verdict(element, "skipped", f"reference: {checks[0].note}")
    elif metric not in case.metrics:
        limit = ", though the scene limits it" if metric in case.left_out else ""
        _verdict(element, "skipped", f"not measured: the run asked for other metrics{limit}")
    elif not checks:
        value = number_with_unit(case.metrics[metric], METRICS[metric].unit)
        note = case.notes.get(metric)
        _verdict(element, "skipped", note or f"measured {value}; the scene sets no limit")


def _test_case(case: CaseRecord, what: str, seconds: float | None = None) -> ElementTree.Element:
    name = f"{case.label}: {what}"
    element = ElementTree.Element("testcase", classname=_clean(case.scene), name=_clean(name))
    element.set("time", f"{seconds or 0.0:.6f}")
    return element


def _verdict(element: ElementTree.Element, kind: str, message: str, text: str = "") -> None:
    verdict = ElementTree.SubElement(element, kind, message=_clean(message))
    if text:
        verdict.text = _clean(text)


def _count(suite: ElementTree.Element, elements: list[ElementTree.Element]) -> None:
    suite.set("tests", str(len(elements)))
    for kind, attribute in (("failure", "failures"), ("error", "errors"), ("skipped", "skipped")):
        suite.set(attribute, str(sum(element.find(kind) is not None for element in elements)))


def _clean(text: str) -> str:
    r"""Write characters that XML can't hold as Python escapes, such as \x1b."""
    return _FORBIDDEN.sub(lambda found: found[0].encode("unicode_escape").decode(), text)

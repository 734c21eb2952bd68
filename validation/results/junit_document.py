"""What JUnit files are made of: test cases in suites, and the text of the whole."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal
from xml.etree import ElementTree

# XML 1.0 has no way to write these, not even escaped.
_FORBIDDEN = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def case_element(suite: str, name: str, seconds: float = 0.0) -> ElementTree.Element:
    """Return a test case that has passed, so far."""
    element = ElementTree.Element("testcase", classname=_clean(suite), name=_clean(name))
    element.set("time", f"{seconds:.6f}")
    return element


def set_verdict(
    element: ElementTree.Element,
    kind: Literal["failure", "error", "skipped"],
    message: str,
    text: str = "",
) -> None:
    """Say that a test case has not passed, and why."""
    verdict = ElementTree.SubElement(element, kind, message=_clean(message))
    if text:
        verdict.text = _clean(text)


def set_property(element: ElementTree.Element, name: str, value: str) -> None:
    """Set a property of a test case, which has one of that name at most."""
    properties = element.find("properties")
    if properties is None:
        properties = ElementTree.Element("properties")
        element.insert(0, properties)
    ElementTree.SubElement(properties, "property", name=_clean(name), value=_clean(value))


def set_output(element: ElementTree.Element, lines: Iterable[str]) -> None:
    """Set what a test case or suite has to say besides its verdict, where that is anything."""
    if text := "\n".join(lines):
        ElementTree.SubElement(element, "system-out").text = _clean(text)


def document(
    suites: Mapping[str, Sequence[ElementTree.Element]], output: Iterable[str] = ()
) -> str:
    """Return a whole document.

    Parameters
    ----------
    suites : mapping of str to sequence of test cases
    output : iterable of str
        What the run has to say as a whole, a line each.
    """
    root = ElementTree.Element("testsuites", name="ghostball")
    for name, elements in suites.items():
        suite = ElementTree.SubElement(root, "testsuite", name=_clean(name))
        suite.extend(elements)
        _count(suite, elements)
    _count(root, [element for elements in suites.values() for element in elements])
    set_output(root, output)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode", xml_declaration=False)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _count(suite: ElementTree.Element, elements: Sequence[ElementTree.Element]) -> None:
    suite.set("tests", str(len(elements)))
    for kind, attribute in (("failure", "failures"), ("error", "errors"), ("skipped", "skipped")):
        suite.set(attribute, str(sum(element.find(kind) is not None for element in elements)))


def _clean(text: str) -> str:
    r"""Write characters that XML can't hold as Python escapes, such as \x1b."""
    return _FORBIDDEN.sub(lambda found: found[0].encode("unicode_escape").decode(), text)

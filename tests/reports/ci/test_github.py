"""Findings as notes of GitHub: of one line each, and those that it doesn't show are counted."""

from __future__ import annotations

from ghostball.reports.ci.github import SHOWN, note, notes
from ghostball.reports.findings import Finding, Place


def test_a_note_is_one_line_that_ends_no_property_early():
    one = Finding("limit-broken", "error", "a: b, c", "100 %\nnext", Place("my,file:x.py", 12))
    assert notes([one]) == (
        "::error file=my%2Cfile%3Ax.py,line=12,title=Ghostball%3A a%3A b%2C c::100 %25%0Anext\n"
    )
    assert note("error", "x", "y") == "::error title=Ghostball%3A x::y"


def test_more_than_github_shows_are_counted():
    def some(level, count):
        return [Finding("limit-broken", level, f"{level}-{k}", "x", None) for k in range(count)]

    lines = notes([*some("error", SHOWN + 3), *some("warning", SHOWN)]).splitlines()
    assert len(lines) == 2 * SHOWN
    assert lines[SHOWN - 1].startswith("::error title=Ghostball%3A 4 more::error-9, error-10")

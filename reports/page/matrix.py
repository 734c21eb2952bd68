"""Sections of the changes since the baselines, and of the matrix of engines by scenes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

from markupsafe import Markup

from ghostball.reference_adapters.registry import OURS
from ghostball.reports.accuracy import (
    CLASSES,
    MARKS,
    MARKS_KEY,
    accuracy_text,
    allowed_text,
    kinds_of,
    meaning_text,
    size_of,
)
from ghostball.reports.outcome import CHANGES, of_comparison
from ghostball.reports.page.changed import has_part
from ghostball.reports.page.rendering import render, scene_link
from ghostball.validation.baselines import Regression
from ghostball.validation.checks.verdict import Verdict, unfinished_text, verdict_of
from ghostball.validation.results.store import CaseRecord, Results

FAILING = {"unchanged": "bit-identical, but its work counters differ or its limits failed"}
"""Explanation of a class of change whose scene fails, where it differs from `CHANGES`."""


MANY_ROWS = 40
"""With more scenes than this number, the table scrolls in a box below fixed headings."""


def changes_html(results: Results, regression: Regression | None) -> Markup:
    """Return the changes since the baselines, by class; failures come first."""
    return render(
        "changes.html",
        regression=regression,
        answer=None if regression is None else of_comparison(regression),
        groups=[] if regression is None else list(_groups(regression)),
        scenes=results.scene_names,
        has_part=has_part,
    )


def _groups(regression: Regression) -> Iterator[dict[str, Any]]:
    """Yield the sign, explanation and scenes of each class of change.

    A class with `quiet` may be shown folded.
    """
    for failing in (True, False):
        for name, (sign, words) in CHANGES.items():
            found = [
                one for one in regression.scenes if one.change == name and one.failed is failing
            ]
            if found:
                yield {
                    "sign": "✗" if failing else sign,
                    "words": FAILING.get(name, words) if failing else words,
                    "fails": failing,
                    "quiet": not failing and name in ("unchanged", "rounding"),
                    "found": found,
                }


def matrix_html(results: Results) -> Markup:
    """Return the table of engines by scenes; each cell has the reason of its verdict."""
    rows = [
        (scene, [_cell(*one, scene) for one in zip(cases, results.labels, strict=True)])
        for scene, cases in results.by_scene()
    ]
    return render(
        "matrix.html",
        labels=results.labels,
        rows=rows,
        MANY_ROWS=MANY_ROWS,
        legend=[CLASSES[kind] for kind in kinds_of(results.cases)],
        marks=MARKS_KEY,
        allowed=any(cell["allowed"] for _, cells in rows for cell in cells),
        reasons=list(_reasons(results)),
    )


def why_text(case: CaseRecord | None) -> str:
    """Return the reason of a case's verdict, in one line without markup."""
    verdict = verdict_of(case)
    if case is None:
        return "not run: the run stopped before this case"
    if case.outcome != "ran":
        return f"{verdict.words}: {' '.join(case.reason.split())}"
    if not case.broken and (why := unfinished_text(case)):
        return f"{verdict.words}: {' '.join(why.split())}"
    if case.broken:
        broken = "; ".join(check.sentence for check in case.broken)
        return f"{meaning_text(case) or 'no reference result'}; {verdict.words}: {broken}"
    stopped = f"; stopped early: {' '.join(case.reason.split())}" if case.reason else ""
    judged = sum(check.passed is True for check in case.checks)
    checks = f" ({judged} checks)" if judged else ""
    said = meaning_text(case)
    return f"{said}; {verdict.words}{checks}{stopped}" if said else f"{verdict.words}{stopped}"


def _cell(case: CaseRecord | None, label: str, scene: str) -> dict[str, Any]:
    verdict = verdict_of(case)
    found = None if case is None else case.accuracy
    kind = "" if found is None else f"acc-{CLASSES[found.kind].slug}"
    if verdict is Verdict.CRASHED:
        kind = "fail"
    return {
        "text": accuracy_text(case) or verdict.symbol or "not run",
        "mark": MARKS.get(verdict, ""),
        "allowed": allowed_text(case),
        "kind": kind,
        "size": size_of(found),
        "why": why_text(case),
        "link": scene_link(scene, found.at if found else None, (OURS, label)),
    }


def _reasons(results: Results) -> Iterator[tuple[str, str, list[str]]]:
    """Yield engine, reason, and scenes with this reason, for all cells that did not pass."""
    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for label in results.labels:
        for case in results.cases:
            if case.label == label and verdict_of(case) is not Verdict.PASS:
                found[label, why_text(case)].append(case.scene)
    for (label, why), scenes in found.items():
        yield label, why, scenes

"""The top of the page: the verdict, what changed since the baselines, and engines by scenes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from markupsafe import Markup

from reports.markdown import BAD, engine_table, headline, key_text, metrics_text
from reports.markdown_parts import taken_over_text
from reports.markdown_scene import failure_text
from reports.page.rendering import render
from reports.shots import cell_text
from validation.regression import Regression
from validation.regression.records import SceneChange
from validation.store import CaseRecord, ResultsFolder
from validation.verdict import Verdict, rest_error_standing, verdict_of

CHANGES = {
    "worse": ("✗", "worse than what was accepted"),
    "results-changed": ("△", "results changed, and truth can't say which is right"),
    "better": ("▲", "better: nearer to the truth"),
    "rounding-only": ("≈", "changed by rounding only"),
    "identical": ("=", "identical to the bit"),
    "no-baseline": ("?", "no baseline"),
    "not-comparable": ("–", "can't be compared"),
}
"""Classes of changes, the gravest first: sign, and what it means."""

CLASSES = {
    Verdict.PASS: "pass",
    Verdict.LIMITS_HOLD: "holds",
    Verdict.FAIL: "fail",
    Verdict.REFERENCE: "ref",
    Verdict.CRASHED: "fail",
}
"""Colours that stand beside the signs."""


@dataclass(frozen=True)
class Overall:
    """The verdict on the whole run: sign, word, class of its colour, and one sentence."""

    sign: str
    word: str
    kind: str
    why: str


@dataclass(frozen=True)
class Cell:
    """A cell of the matrix: what it shows, and why."""

    text: str
    kind: str
    why: str


def overall(results: ResultsFolder, regression: Regression | None) -> Overall:
    """Return the verdict on a whole run, the worst news first."""
    verdicts = [verdict_of(case) for case in results.cases]
    failed = verdicts.count(Verdict.FAIL)
    crashed = verdicts.count(Verdict.CRASHED)
    if failed or crashed:
        parts = [f"{failed} failed"] * bool(failed) + [f"{crashed} did not finish"] * bool(crashed)
        said = f"Of {len(verdicts)} cases, {', '.join(parts)}."
        return Overall("✗", "Failed", "fail", " ".join([said, *_gate(regression)]))
    if gate := _gate(regression):
        return Overall("✗", "Failed", "fail", " ".join(["Every limit holds.", *gate]))
    if results.state != "complete":
        return Overall("!", "Not complete", "fail", "What is there holds; the run did not end.")
    checks = [check for case in results.cases for check in case.checks]
    passed = sum(check.passed is True for check in checks)
    if not passed:
        return Overall("○", "Nothing judged", "holds", "No limit judges what was run.")
    return Overall("✓", "Passed", "pass", f"All {passed} checks passed.")


def _gate(regression: Regression | None) -> list[str]:
    """Return the sentence of a comparison that failed; none where it didn't."""
    if regression is None or regression.outcome != "failed":
        return []
    count = sum(change.failed for change in regression.scenes)
    named = "1 scene fails" if count == 1 else f"{count} scenes fail"
    return [f"Against {_base(regression)}, {named}."]


def _base(regression: Regression) -> str:
    if regression.against == "baselines":
        return "the accepted baselines"
    return f"revision {regression.against}"


def verdict_html(results: ResultsFolder, regression: Regression | None) -> Markup:
    """Return the verdict in words and numbers, with what failed by name."""
    failures = [
        (case, [failure_text(case, c) for c in case.checks if c.passed is False])
        for case in results.cases
        if verdict_of(case) in BAD
    ]
    return render(
        "verdict.html",
        overall=overall(results, regression),
        headline=headline(results),
        metrics=metrics_text(results),
        taken_over=taken_over_text(results),
        failures=failures,
    )


def changes_html(regression: Regression | None) -> Markup:
    """Return what changed since the baselines, by class of change."""
    classes: list[tuple[str, str, str, list[SceneChange]]] = []
    if regression is not None:
        classes = [
            (sign, name, words, found)
            for name, (sign, words) in CHANGES.items()
            if (found := [one for one in regression.scenes if one.change == name])
        ]
    return render("changes.html", regression=regression, classes=classes)


def matrix_html(results: ResultsFolder) -> Markup:
    """Return the table of engines by scenes, each cell with why it is what it is."""
    rows = [
        (scene, [_cell(results.case(scene, label)) for label in results.labels])
        for scene in results.scene_names
    ]
    return render(
        "matrix.html",
        labels=results.labels,
        rows=rows,
        key=key_text(results.cases),
        engines=engine_table(results),
        reasons=list(_reasons(results)),
    )


def why_text(case: CaseRecord | None) -> str:
    """Return why a case has its verdict, in one line without markup."""
    verdict = verdict_of(case)
    if case is None:
        return "not run: the run ended before it"
    if case.outcome != "ran":
        return f"{verdict.words}: {' '.join(case.reason.split())}"
    failed = [check for check in case.checks if check.passed is False]
    if failed:
        return f"{verdict.words}: {', '.join(f'{c.metric} breaks its limit' for c in failed)}"
    stopped = f"; stopped early: {' '.join(case.reason.split())}" if case.reason else ""
    judged = sum(check.passed is True for check in case.checks)
    checks = f", {judged} checks" if judged else ""
    return f"{verdict.words}{checks}; rest error: {rest_error_standing(case).value}{stopped}"


def _cell(case: CaseRecord | None) -> Cell:
    verdict = verdict_of(case)
    return Cell(cell_text(case) or "not run", CLASSES.get(verdict, ""), why_text(case))


def _reasons(results: ResultsFolder) -> Iterator[tuple[str, str, list[str]]]:
    """Yield engine, why, and the scenes of it, for every cell that is no pass."""
    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for label in results.labels:
        for case in results.cases:
            if case.label == label and verdict_of(case) is not Verdict.PASS:
                found[label, why_text(case)].append(case.scene)
    for (label, why), scenes in found.items():
        yield label, why, scenes

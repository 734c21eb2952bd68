"""The top of the page: the verdict, what changed since the baselines, and engines by scenes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from markupsafe import Markup

from ghostball.reports.markdown import engine_table, headline, key_text, metrics_text
from ghostball.reports.markdown_parts import taken_over_text
from ghostball.reports.markdown_scene import failure_text
from ghostball.reports.outcome import (
    CHANGES,
    bad_cases,
    base_text,
    kind_text,
    of_comparison,
    overall,
)
from ghostball.reports.page.changed import has_part
from ghostball.reports.page.rendering import render
from ghostball.reports.shots import cell_text
from ghostball.validation.baselines import Regression
from ghostball.validation.baselines.regression import SceneChange
from ghostball.validation.checks.verdict import (
    Verdict,
    rest_error_standing,
    unfinished_text,
    verdict_of,
)
from ghostball.validation.results.store import CaseRecord, Results

FAILING = {"identical": "identical to the bit, but not in work, run time or the limits it keeps"}
"""What a class of changes means where it fails, if that is something else."""

CLASSES = {
    Verdict.PASS: "pass",
    Verdict.LIMITS_HOLD: "holds",
    Verdict.FAIL: "fail",
    Verdict.REFERENCE: "ref",
    Verdict.CRASHED: "fail",
}
"""Colours that stand beside the signs."""


@dataclass(frozen=True)
class Group:
    """Scenes of one class of change: sign, what it means, and whether it may be closed."""

    sign: str
    words: str
    fails: bool
    quiet: bool
    found: list[SceneChange]


@dataclass(frozen=True)
class Cell:
    """A cell of the matrix: what it shows, and why."""

    text: str
    kind: str
    why: str


def verdict_html(results: Results, regression: Regression | None) -> Markup:
    """Return the verdict in words and numbers, with what failed by name."""
    failures = [
        (
            case,
            unfinished_text(case),
            [failure_text(case, check) for check in case.checks if check.passed is False],
        )
        for case in bad_cases(results)
    ]
    return render(
        "verdict.html",
        overall=overall(results, regression),
        headline=headline(results),
        metrics=metrics_text(results),
        taken_over=taken_over_text(results),
        failures=failures,
        beyond=[] if regression is None else [one for one in regression.scenes if one.failed],
        kind_text=kind_text,
    )


def changes_html(results: Results, regression: Regression | None) -> Markup:
    """Return what changed since the baselines, by class of change: what fails stands first."""
    return render(
        "changes.html",
        regression=regression,
        answer=None if regression is None else of_comparison(regression),
        base=None if regression is None else base_text(regression),
        groups=[] if regression is None else list(_groups(regression)),
        scenes=results.scene_names,
        has_part=has_part,
    )


def _groups(regression: Regression) -> Iterator[Group]:
    for failing in (True, False):
        for name, (sign, words) in CHANGES.items():
            found = [
                one for one in regression.scenes if one.change == name and one.failed is failing
            ]
            if not found:
                continue
            if failing:
                yield Group("✗", FAILING.get(name, words), True, False, found)
            else:
                quiet = name in ("identical", "rounding-only")
                yield Group(sign, words, False, quiet, found)


def matrix_html(results: Results) -> Markup:
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
    if not failed and (why := unfinished_text(case)):
        return f"{verdict.words}: {' '.join(why.split())}"
    if failed:
        return f"{verdict.words}: {', '.join(f'{c.metric} breaks its limit' for c in failed)}"
    stopped = f"; stopped early: {' '.join(case.reason.split())}" if case.reason else ""
    judged = sum(check.passed is True for check in case.checks)
    checks = f", {judged} checks" if judged else ""
    return f"{verdict.words}{checks}; rest error: {rest_error_standing(case).value}{stopped}"


def _cell(case: CaseRecord | None) -> Cell:
    verdict = verdict_of(case)
    return Cell(cell_text(case) or "not run", CLASSES.get(verdict, ""), why_text(case))


def _reasons(results: Results) -> Iterator[tuple[str, str, list[str]]]:
    """Yield engine, why, and the scenes of it, for every cell that is no pass."""
    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for label in results.labels:
        for case in results.cases:
            if case.label == label and verdict_of(case) is not Verdict.PASS:
                found[label, why_text(case)].append(case.scene)
    for (label, why), scenes in found.items():
        yield label, why, scenes

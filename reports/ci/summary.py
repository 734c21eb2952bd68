"""Summary of a run for CI services: Markdown for GitHub Actions, plain lines for other services.

    >>> from ghostball.reports import summary_markdown
    >>> print(summary_markdown(Results.open("out"), *load_regressions(Path("out"))))

Summaries use only stored results, like the report.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from ghostball.reference_adapters.output import harmless
from ghostball.reports import style
from ghostball.reports.accuracy import CLASSES, CLASSES_KEY, cell_text, kinds_of, tally
from ghostball.reports.ci.findings import findings
from ghostball.reports.error_changes import drawn, error_text, is_shifted, shifted
from ghostball.reports.outcome import (
    CHANGES,
    Failure,
    counts_text,
    failures,
    incomplete_text,
    kinds_text,
    of_comparison,
    of_limits,
    overall,
)
from ghostball.reports.shots import legend_text
from ghostball.reports.templating import templates_of
from ghostball.reports.words import many
from ghostball.validation.baselines.regression import UNCOMPARED, Regression, SceneChange
from ghostball.validation.checks.verdict import verdict_of
from ghostball.validation.results.records import AccuracyKind
from ghostball.validation.results.store import Results
from ghostball.validation.scenes import commands

ROWS = 250
"""Largest number of rows of a table; GitHub refuses a step summary above 1 MiB."""

CELL = 400
"""Largest number of characters of a cell; an error message can be longer."""

_UNMOVED = ("unchanged", "rounding")


def summary_markdown(results: Results | None, *regressions: Regression) -> str:
    """Return the summary as Markdown: the verdict, what changed, what failed, all verdicts.

    `results`: None if only a comparison was made.
    `*regressions`: the comparisons with baselines, one for each compared engine.
    """
    changes = []
    for regression in regressions:
        shown = [_change_cells(one) for one in _in_order(regression.scenes) if _is_shown(one)]
        before = [one for one in regression.scenes if not _is_shown(one)]
        changes.append((regression, shown, before, drawn(shifted(regression))))
    given: dict[str, Any] = {"failures": [], "results": results}
    if results is not None:
        kinds, labels = kinds_of(results.cases), [_code(label) for label in results.labels]
        given |= {
            "failures": list(map(_failure_cells, failures(results.cases))),
            "classes": CLASSES_KEY,
            "engine_heads": _engine_heads(kinds),
            "engines": [_engine_cells(results, label, kinds) for label in results.labels],
            "legend": legend_text(map(verdict_of, results.cases)),
            "scene_heads": ["scene", *labels],
            "scenes": [
                [_cell(scene), *(_cell(cell_text(case)) for case in cases)]
                for scene, cases in results.by_scene()
            ],
        }
    # Markdown, not HTML: cells escape external texts themselves.
    template = templates_of("ghostball.reports", escaped=False).get_template("summary.md")
    text = template.render(
        whole=overall(results, *regressions),
        verdicts=_verdicts(results, *regressions),
        changes=changes,
        cell=_cell,
        many=many,
        kinds_text=kinds_text,
        most=ROWS,
        **given,
    )
    return re.sub("\n{3,}", "\n\n", text).rstrip() + "\n"


def summary_text(results: Results | None, *regressions: Regression) -> str:
    """Return the summary as lines `ABOUT: LEVEL: MESSAGE`, errors first, then warnings.

    The level is "error", "warning" or "note". The last lines, with the place `ghostball`, are the
    verdicts.
    """
    lines: list[tuple[str, str, str]] = [
        (one.about, one.level, one.message.replace("\n", "; "))
        for one in findings(results, regressions)
    ]
    lines += [
        ("ghostball", "note" if sign == "✓" else "error", words)
        for sign, words in _verdicts(results, *regressions)
    ]
    return harmless(
        "".join(f"{place}: {level}: {' '.join(words.split())}\n" for place, level, words in lines)
    )


def _verdicts(results: Results | None, *regressions: Regression) -> list[tuple[str, str]]:
    """Return the verdicts, each with a sign and a sentence; those that don't pass come first."""
    said = []
    for regression in regressions:
        compared = of_comparison(regression)
        warned = f" {many(len(regression.warnings), 'warning')}." if regression.warnings else ""
        said.append((compared.sign, f"{compared.why}{warned}"))
    if results is not None:
        limits = of_limits(results)
        words = f"{limits.why} {counts_text(results)}. {incomplete_text(results)}".strip()
        said.append((limits.sign, words))
    return sorted(said, key=lambda one: one[0] == "✓")


def _is_shown(change: SceneChange) -> bool:
    return change.failed or change.change not in _UNMOVED


def _in_order(changes: Sequence[SceneChange]) -> list[SceneChange]:
    """Return the changes: failures first, then those that could not be compared, then the rest."""
    return sorted(changes, key=lambda one: (not one.failed, one.change not in UNCOMPARED))


def _change_cells(change: SceneChange) -> list[str]:
    sign = "✗" if change.failed else CHANGES[change.change][0]
    words = [f"rest error {error_text(change)}"] * is_shifted(change) + [change.summary]
    first = "" if change.first_difference is None else change.first_difference.words
    command = _code(change.command)
    kind = f"{sign} {change.words}"
    return [_cell(change.scene), kind, _cell("; ".join(words)), _cell(first), command]


def _failure_cells(failure: Failure) -> list[str]:
    """Return the failure, and the command that repeats the case."""
    case = failure.case
    again = commands.validate(case.scene, case.label, "out/again")
    said = (case.scene, failure.words, failure.reason)
    scene, words, reason = map(_cell, said)
    return [scene, _code(case.label), words, reason, _code(again)]


def _engine_heads(kinds: Sequence[AccuracyKind]) -> list[str]:
    return ["engine", *(CLASSES[kind].short for kind in kinds), "median error", "median time"]


def _engine_cells(results: Results, label: str, kinds: Sequence[AccuracyKind]) -> list[str]:
    found = tally(results, label)
    counts = [str(found.counts.get(kind, 0)) for kind in kinds]
    typical = (found.typical_text, style.format_time(found.seconds))
    return [_code(label), *counts, *typical]


def _cell(text: str) -> str:
    """Return a text for a cell: one line, shortened, with HTML escaped."""
    plain = " ".join(text.split())
    if len(plain) > CELL:
        plain = f"{plain[: CELL - 1]}…"
    return _one_line(plain.replace("<", "&lt;"))


def _code(text: str) -> str:
    """Return a command for a cell, as code and not shortened."""
    return f"`{_one_line(text)}`" if text else ""


def _one_line(text: str) -> str:
    """Return a text on one line, with visible control characters and escaped bars."""
    return harmless(" ".join(text.split())).replace("|", "\\|")

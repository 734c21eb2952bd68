"""Section of the failures: expected and found values, reasons, and commands to repeat them.

The template explains the possible causes of a failed limit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from markupsafe import Markup

from ghostball.reference_adapters.registry import OURS
from ghostball.reports.outcome import failures
from ghostball.reports.page.rendering import render
from ghostball.reports.page.scene_numbers import COMPARISONS
from ghostball.reports.page.scenes import ScenePagePart
from ghostball.validation.baselines import Regression
from ghostball.validation.checks.verdict import unfinished_text
from ghostball.validation.results.store import CaseRecord, Results
from ghostball.validation.scenes import commands
from ghostball.validation.scenes.library import scene_names


def failures_html(
    results: Results, scenes: Mapping[str, ScenePagePart], regression: Regression | None
) -> Markup:
    """Return the explained failures: checks, cases that did not finish, changes."""
    changes = [] if regression is None else [one for one in regression.scenes if one.failed]
    shipped = scene_names()
    return render(
        "failures.html",
        failures=list(_failures(results, scenes)),
        changes=changes,
        ours=OURS,
        own=[name for name in results.scene_names if name not in shipped],
    )


def _failures(results: Results, scenes: Mapping[str, ScenePagePart]) -> Iterator[dict[str, Any]]:
    """Yield every failure of a run, in the order of its cases."""
    for case, check, _, _ in failures(results.cases):
        yield {
            "case": case,
            "check": check,
            "limit": "" if check is None else COMPARISONS[check.limit_kind],
            "unfinished": unfinished_text(case),
            "command": commands.simulate(case.scene, case.label, recorded=True),
            "why": explaining(case),
            "rests": list(_rests(case)),
            "bits": scenes[case.scene].hashes.get(case.label, ""),
        }


def _rests(case: CaseRecord) -> Iterator[tuple[str, str, str]]:
    """Yield each ball with the rest position x, y [m] of this run; a repetition must match it."""
    if case.rest_positions is not None:
        for ball, (x, y, _) in zip(case.definition["balls"], case.rest_positions, strict=True):
            yield str(ball["id"]), repr(float(x)), repr(float(y))


def explaining(case: CaseRecord) -> str:
    """Return the command that finds the first wrong collision of a case and its cause.

    Return "" if the case did not run or is a case of Ghostball's own engine.
    """
    explains = case.outcome == "ran" and case.engine != OURS
    return commands.explain(case.scene, case.label) if explains else ""

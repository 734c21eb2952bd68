"""The first lines of the page: what became of all cases, and which of them are not right."""

from __future__ import annotations

from collections import Counter

from markupsafe import Markup

from ghostball.reports.outcome import bad_cases, overall
from ghostball.reports.page.first_screen import engines_html
from ghostball.reports.page.rendering import render
from ghostball.reports.page.scene_numbers import unsolved
from ghostball.reports.words import many, reused_text
from ghostball.validation.baselines import Regression
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.verdict import Verdict, unfinished_text, verdict_of
from ghostball.validation.results.store import Results

STATES = {"running": "it is still running, or was killed"}
"""What became of a run that isn't complete, where its state alone doesn't say it."""


def verdict_html(results: Results, regression: Regression | None) -> Markup:
    """Return the verdict in words and numbers, with what failed by name."""
    counts = Counter(map(verdict_of, results.cases))
    named = (
        Verdict.PASS,
        Verdict.FAIL,
        Verdict.LIMITS_HOLD,
        Verdict.CRASHED,
        Verdict.NOT_REPRESENTABLE,
    )
    left = unsolved(results)
    measured = results.environment.get("metrics", list(METRICS))
    left_out = sum(len(case.left_out) for case in results.cases)
    return render(
        "verdict.html",
        overall=overall(results, *([] if regression is None else [regression])),
        engines=engines_html(results),
        whole=results.state == "complete",
        state=STATES.get(results.state, results.state),
        done=f"{len(results.cases)} of {many(results.planned, 'case')}",
        scenes=many(len(results.scene_names), "scene"),
        on=_engines_text(results),
        passed=counts[Verdict.PASS],
        failed=counts[Verdict.FAIL],
        holding=counts[Verdict.LIMITS_HOLD],
        crashed=counts[Verdict.CRASHED],
        unable=counts[Verdict.NOT_REPRESENTABLE],
        rest=counts.total() - sum(counts[one] for one in named),
        unsolved=many(left, "sustained or joint contact") if left else "",
        metrics=[] if len(measured) == len(METRICS) else measured,
        left_out=many(left_out, "limit"),
        reused=reused_text(results),
        failures=[
            (case, unfinished_text(case), [one for one in case.checks if one.passed is False])
            for case in bad_cases(results)
        ],
        beyond=[] if regression is None else [one for one in regression.scenes if one.failed],
    )


def _engines_text(results: Results) -> str:
    """Say how many engines there are; one with other settings is no other engine."""
    labels, engines = results.labels, {case.engine for case in results.cases}
    text = many(len(engines), "engine")
    if len(labels) == len(engines):
        return text
    return f"{text} in {many(len(labels), 'configuration')}"

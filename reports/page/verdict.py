"""The first section of the page: verdict over all cases, and accuracy and speed of each engine."""

from __future__ import annotations

from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.accuracy import CLASSES, Tally, accuracy_text, kinds_of, tally
from ghostball.reports.outcome import counts_text, failures, incomplete_text, overall
from ghostball.reports.page.rendering import render
from ghostball.reports.page.scene_numbers import unsolved
from ghostball.reports.words import many, reused_text
from ghostball.validation.baselines import Regression
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.results.store import CaseRecord, Results

VARIANTS = {
    "contact_steps=exact": (
        "exact steps",
        "time steps end when balls touch, so the remaining error is from the engine's solver",
    ),
    "config=naive": ("naive", "with the settings that a newcomer types, 60 time steps per second"),
}
"""Words in the names of engines, with explanations, by setting."""


def verdict_html(results: Results, regression: Regression | None) -> Markup:
    """Return the verdict in words and numbers, with a list of all failures."""
    left = unsolved(results)
    measured = results.environment.get("metrics", list(METRICS))
    left_out = sum(len(case.left_out) for case in results.cases)
    return render(
        "verdict.html",
        overall=overall(results, regression),
        engines=engines_html(results),
        incomplete=incomplete_text(results),
        counts=counts_text(results),
        unsolved=many(left, "resting or simultaneous contact") if left else "",
        metrics=[] if len(measured) == len(METRICS) else measured,
        left_out=many(left_out, "limit"),
        reused=reused_text(results),
        failures=list(failures(results.cases)),
        beyond=[] if regression is None else [one for one in regression.scenes if one.failed],
    )


def engines_html(results: Results) -> Markup:
    """Return a table: each engine's scenes by accuracy class, median error and median run time."""
    tallies = [tally(results, label) for label in results.labels]
    labels = " ".join(results.labels)
    return render(
        "engines.html",
        scenes=many(len(results.scene_names), "scene"),
        rows=[(one, style.engine_name(one.label), _parts(one)) for one in tallies],
        # With a single scene, its result says more than the number 1.
        alone={case.label: accuracy_text(case) for case in results.cases}
        if len(results.scene_names) == 1
        else {},
        legend=[CLASSES[kind] for kind in kinds_of(results.cases)],
        own=any(one.compared_with for one in tallies),
        crashed=any(one.crashed for one in tallies),
        unplayed=any(one.unable for one in tallies),
        judged=any(one.expected or one.worse for one in tallies),
        excused=_excused(results),
        variants=[said for setting, said in VARIANTS.items() if setting in labels],
    )


def _excused(results: Results) -> list[tuple[str, str, int, str]]:
    """Return the engines excused from common limits: label, metrics, number of scenes, reason."""
    found: dict[tuple[str, str], list[CaseRecord]] = {}
    for case in results.cases:
        if case.excused:
            found.setdefault((case.label, case.excused), []).append(case)
    return [
        (
            label,
            ", ".join(name for name in METRICS if any(name in one.not_asked for one in cases)),
            len(cases),
            why,
        )
        for (label, why), cases in found.items()
    ]


def _parts(one: Tally) -> list[tuple[str, int, str]]:
    """Return the parts of an engine's bar: name of the colour, number of scenes, meaning."""
    counted = [
        *((look.slug, one.counts.get(kind, 0), look.meaning) for kind, look in CLASSES.items()),
        ("own", one.compared_with, "no independent reference: other engines are compared with it"),
        ("crashed", one.crashed, "did not finish"),
        ("unplayed", one.unable, "unsupported"),
    ]
    return [part for part in counted if part[1]]

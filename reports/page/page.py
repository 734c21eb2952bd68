"""The whole page: its sections in order, with styles and scripts within."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from markupsafe import Markup

from reports.markdown import TRUTH_TEXT, counted_section
from reports.outcome import overall
from reports.page.changed import changed_html
from reports.page.colours import engine_css
from reports.page.failures import failures_html
from reports.page.measured import (
    closed_forms_html,
    cost_html,
    hashes_html,
    horizons_html,
    ledgers_html,
    timing_html,
)
from reports.page.overview import changes_html, matrix_html, verdict_html
from reports.page.precision import engines_of_page
from reports.page.rendering import asset, markdown, render
from reports.page.replay_assets import replay_script, replay_style
from reports.page.scenes import ScenePart
from reports.page.surroundings import environment_html, stress_html
from validation.regression import Regression
from validation.store import ResultsFolder
from validation.verdict import Verdict, verdict_of


@dataclass(frozen=True)
class Section:
    """A section of the page: its anchor, its name in the navigation, its heading and content."""

    anchor: str
    name: str
    heading: str
    html: Markup


def page_text(
    results: ResultsFolder, scenes: Mapping[str, ScenePart], regression: Regression | None
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    results : ResultsFolder
    scenes : mapping of str to ScenePart
        The part of each scene, by its name.
    regression : Regression or None
        What changed since the baselines, where that was asked.
    """
    ledgers = {
        name: ledger for name in results.scene_names if (ledger := scenes[name].ledger) is not None
    }
    verdict = Markup("").join(
        [
            verdict_html(results, regression),
            changes_html(results, regression),
            changed_html(results, regression),
        ]
    )
    before = [
        Section("verdict", "Verdict", "Verdict and what changed", verdict),
        Section("matrix", "Matrix", "Engines by scenes", matrix_html(results)),
    ]
    after = [
        Section(
            "closed-forms", "Closed forms", "Closed forms, in ulps", closed_forms_html(results)
        ),
        Section("cost", "Cost", "Run time against error", cost_html(results)),
        Section(
            "horizons", "Horizons", "How far the shots can be predicted", horizons_html(results)
        ),
        Section("energy", "Energy", "Where the energy went", ledgers_html(ledgers)),
        Section("hashes", "Hashes", "Determinism", hashes_html(results, scenes, regression)),
        Section("timing", "Timing", "Run times", timing_html(results, regression)),
        Section("stress", "Stress", "Stress survival", stress_html(results)),
        Section(
            "failures", "Failures", "Failures explained", failures_html(results, scenes, regression)
        ),
        Section("environment", "Environment", "Environment", environment_html(results)),
        Section("truth", "Truth", "What is true here", _truth_html(results)),
    ]
    return str(
        render(
            "page.html",
            title=_title(results, regression),
            overall=overall(results, regression),
            about=_about(results),
            styles=[
                asset("page.css"),
                replay_style(),
                Markup(engine_css(engines_of_page(results))),
            ],
            scripts=[replay_script(), asset("page.js")],
            before=before,
            after=after,
            scene_list=[(name, _worst(results, name)) for name in results.scene_names],
            scenes=[scenes[name].html for name in results.scene_names],
        )
    )


def _title(results: ResultsFolder, regression: Regression | None) -> str:
    count = len(results.scene_names)
    scenes = "1 scene" if count == 1 else f"{count} scenes"
    return f"{overall(results, regression).word}: {scenes} - Ghostball validation report"


def _about(results: ResultsFolder) -> list[tuple[str, str]]:
    """Return what a reader asks first: of which code, when, where."""
    environment = results.environment
    git = environment.get("git") or {}
    revision = str(git.get("revision", ""))[:12]
    changed = " with changes" if git.get("dirty") else ""
    said = [
        ("Revision", revision + changed if revision else "not from a checkout"),
        ("Date", str(environment.get("date", "unknown"))),
        ("Machine", f"{environment.get('cpu', 'unknown')}, {environment.get('os', '')}"),
    ]
    return [(name, text.strip(", ")) for name, text in said]


def _worst(results: ResultsFolder, scene: str) -> tuple[str, str]:
    """Return the sign that stands before a scene in the list, and its words: the worst of it."""
    verdicts = {verdict_of(case) for case in results.cases if case.scene == scene}
    order = (Verdict.FAIL, Verdict.CRASHED, Verdict.PASS, Verdict.LIMITS_HOLD, Verdict.REFERENCE)
    worst = next((one for one in order if one in verdicts), Verdict.SHOWN)
    return worst.symbol, worst.words


def _truth_html(results: ResultsFolder) -> Markup:
    counted = counted_section(results).removeprefix("## What the runs counted\n\n")
    parts = [markdown(TRUTH_TEXT)]
    if counted:
        heading = Markup("<h3>What the runs counted</h3>")
        parts += [heading, markdown(counted, "What the runs counted", wraps=True)]
    return Markup("").join(parts)

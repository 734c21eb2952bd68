"""The whole page: its sections in order, with styles and scripts within."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from markupsafe import Markup

from ghostball.reports.guarded import FailedPart, attempt, failed_text
from ghostball.reports.markdown import TRUTH_TEXT, counted_section
from ghostball.reports.outcome import overall
from ghostball.reports.page.board import board_html
from ghostball.reports.page.changed import changed_html
from ghostball.reports.page.colours import engine_css
from ghostball.reports.page.failures import failures_html
from ghostball.reports.page.measured import (
    closed_forms_html,
    cost_html,
    hashes_html,
    horizons_html,
    ledgers_html,
    timing_html,
)
from ghostball.reports.page.overview import changes_html, matrix_html, verdict_html
from ghostball.reports.page.pictures import Pictures, ensembles_html
from ghostball.reports.page.rendering import asset, inline, markdown, render
from ghostball.reports.page.replay_assets import replay_script, replay_style
from ghostball.reports.page.scenes import ScenePart
from ghostball.reports.page.surroundings import environment_html, stress_html
from ghostball.validation.baselines import Regression
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.diagnose.energy_ledger import EnergyLedger
from ghostball.validation.results.store import Results


@dataclass(frozen=True)
class Section:
    """A section of the page: its anchor, its name in the navigation, its heading and content."""

    anchor: str
    name: str
    heading: str
    html: Markup


def page_text(
    results: Results,
    scenes: Mapping[str, ScenePart],
    pictures: Pictures,
    regression: Regression | None,
    failed: list[FailedPart],
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    results : Results
    scenes : mapping of str to ScenePart
        The part of each scene, by its name.
    pictures : mapping of str to path
        Figures of ensembles, which the page holds.
    regression : Regression or None
        What changed since the baselines, where that was asked.
    failed : list of FailedPart, appended to
        Sections that could not be made; each says so in its place.
    """

    def section(anchor: str, name: str, heading: str, *makes: Callable[[], Markup]) -> Section:
        html = Markup("").join(_made(heading, make, failed) for make in makes)
        return Section(anchor, name, heading, html)

    before = [
        section(
            "verdict",
            "Verdict",
            "Verdict and what changed",
            lambda: verdict_html(results, regression),
            lambda: changes_html(results, regression),
            lambda: changed_html(results, regression),
        ),
        section("matrix", "Matrix", "Engines by scenes", lambda: matrix_html(results)),
    ]
    after = [
        section(
            "closed-forms",
            "Closed forms",
            "Closed forms, in units of rounding",
            lambda: closed_forms_html(results),
        ),
        section("cost", "Cost", "Run time against error", lambda: cost_html(results)),
        section(
            "horizons",
            "Horizons",
            "How far the shots can be predicted",
            lambda: horizons_html(results),
        ),
        section(
            "ensembles",
            "Ensembles",
            "Ensembles: how perturbed shots end",
            lambda: ensembles_html(results, pictures) or _no_ensembles(),
        ),
        section(
            "energy",
            "Energy",
            "Where the energy went",
            lambda: ledgers_html(_ledgers(results, scenes)),
        ),
        section(
            "hashes", "Hashes", "Determinism", lambda: hashes_html(results, scenes, regression)
        ),
        section("timing", "Timing", "Run times", lambda: timing_html(results)),
        section(
            "board",
            "Board",
            "Engines on the questions that tell them apart",
            lambda: board_html(results.path),
        ),
        section("stress", "Stress", "Stress survival", lambda: stress_html(results)),
        section(
            "failures",
            "Failures",
            "Failures explained",
            lambda: failures_html(results, scenes, regression),
        ),
        section("environment", "Environment", "Environment", lambda: environment_html(results)),
        section("truth", "Truth", "What is true here", lambda: _truth_html(results)),
    ]
    return str(
        render(
            "page.html",
            title=_title(results, regression),
            overall=overall(results, *([] if regression is None else [regression])),
            about=_about(results),
            missing=failed_text(failed) if failed else "",
            styles=[
                asset("page.css"),
                replay_style(),
                Markup(engine_css(results.labels)),
            ],
            scripts=[replay_script(), asset("page.js")],
            before=before,
            after=after,
            scene_list=[(name, _worst(results, name)) for name in results.scene_names],
            scenes=[scenes[name].html for name in results.scene_names],
        )
    )


def _made(heading: str, make: Callable[[], Markup], failed: list[FailedPart]) -> Markup:
    """Return the content of a section, or part of it; where it can't be made, what says so."""
    made = attempt(f'section "{heading}" of report.html', make, failed)
    return render("failed.html", failed=failed[-1]) if made is None else made


def _ledgers(results: Results, scenes: Mapping[str, ScenePart]) -> dict[str, EnergyLedger]:
    parts = {name: scenes[name].ledger for name in results.scene_names}
    return {name: ledger for name, ledger in parts.items() if ledger is not None}


def _no_ensembles() -> Markup:
    advice = "No scene was perturbed. `ghostball validate SCENE --ensemble K` does so."
    return Markup("<p>%s</p>") % inline(advice)


def _title(results: Results, regression: Regression | None) -> str:
    count = len(results.scene_names)
    scenes = "1 scene" if count == 1 else f"{count} scenes"
    word = overall(results, *([] if regression is None else [regression])).word
    return f"{word}: {scenes} - Ghostball validation report"


def _about(results: Results) -> list[tuple[str, str]]:
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


def _worst(results: Results, scene: str) -> tuple[str, str]:
    """Return the sign that stands before a scene in the list, and its words: the worst of it."""
    verdicts = {verdict_of(case) for case in results.cases if case.scene == scene}
    order = (Verdict.FAIL, Verdict.CRASHED, Verdict.PASS, Verdict.LIMITS_HOLD, Verdict.REFERENCE)
    worst = next((one for one in order if one in verdicts), Verdict.SHOWN)
    return worst.symbol, worst.words


def _truth_html(results: Results) -> Markup:
    counted = counted_section(results).removeprefix("## What the runs counted\n\n")
    parts = [markdown(TRUTH_TEXT)]
    if counted:
        heading = Markup("<h3>What the runs counted</h3>")
        parts += [heading, markdown(counted, "What the runs counted", wraps=True)]
    return Markup("").join(parts)

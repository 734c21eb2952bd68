"""The whole page: its sections in order, with all styles and scripts embedded."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from markupsafe import Markup

from ghostball.reports.failed_parts import FailedPart, attempt, failed_text
from ghostball.reports.outcome import overall
from ghostball.reports.page.about import environment_html, truth_html
from ghostball.reports.page.changed import changed_html
from ghostball.reports.page.failures import failures_html
from ghostball.reports.page.matrix import changes_html, matrix_html
from ghostball.reports.page.numbers import (
    closed_forms_html,
    cost_html,
    ensembles_html,
    hashes_html,
    horizons_html,
    ledgers_html,
    timing_html,
)
from ghostball.reports.page.real_tables import real_tables_html
from ghostball.reports.page.relations import relations_html
from ghostball.reports.page.rendering import asset, engine_css, render, replay_script
from ghostball.reports.page.scenes import ScenePagePart
from ghostball.reports.page.stress import stress_html
from ghostball.reports.page.verdict import verdict_html
from ghostball.reports.words import many
from ghostball.validation.baselines import Regression
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.diagnose.energy_ledger import EnergyLedger
from ghostball.validation.results.fields import Environment
from ghostball.validation.results.store import Results


@dataclass(frozen=True)
class Section:
    """A section of the page: its anchor, its name in the navigation, its heading and content."""

    anchor: str
    name: str
    heading: str
    html: Markup


@dataclass(frozen=True)
class Part:
    """A part of a section. A part with an anchor and a heading is folded, unless `opened`."""

    make: Callable[[], Markup]
    anchor: str = ""
    heading: str = ""
    opened: bool = False


def page_text(
    results: Results,
    scenes: Mapping[str, ScenePagePart],
    regression: Regression | None,
    failed: list[FailedPart],
) -> str:
    """Return the page as HTML.

    `scenes`: the part of each scene, by its name.
    `regression`: the comparison with the baselines, or None if the run was not compared.
    `failed`: list to which the sections that raise an exception are added; the page shows the
        error in place of each.
    """

    def section(anchor: str, name: str, heading: str, *parts: Part) -> Section:
        made = [(part, _made(part.heading or heading, part.make, failed)) for part in parts]
        html = render("parts.html", parts=[(part, html) for part, html in made if html])
        return Section(anchor, name, heading, html if any(html for _, html in made) else Markup())

    before = [
        section(
            "verdict",
            "Result",
            "Result and changes",
            Part(lambda: verdict_html(results, regression)),
            Part(lambda: changes_html(results, regression)),
            Part(lambda: changed_html(results, regression)),
        ),
        section(
            "comparison",
            "Differences",
            "Where engines differ most",
            Part(lambda: most_different(scenes)),
        ),
        section(
            "matrix", "Engines by scene", "Engines by scene", Part(lambda: matrix_html(results))
        ),
    ]
    after = [
        section(
            "failures",
            "Failures",
            "Failures explained",
            Part(lambda: failures_html(results, scenes, regression)),
        ),
        section(
            "relations",
            "Relations",
            "Relations between shots",
            Part(lambda: relations_html(results)),
        ),
        section(
            "numbers",
            "Totals",
            "Totals over all scenes",
            Part(lambda: cost_html(results), "cost", "Run time against error", opened=True),
            Part(
                lambda: closed_forms_html(results),
                "closed-forms",
                "Errors in closed-form scenes, in units of rounding",
            ),
            Part(lambda: horizons_html(results), "horizons", "Predictability horizons"),
            Part(
                lambda: ensembles_html(results),
                "ensembles",
                "Ensembles: rest positions from perturbed initial states",
                opened=True,
            ),
            Part(lambda: ledgers_html(_ledgers(results, scenes)), "energy", "Energy losses"),
            Part(lambda: hashes_html(results, scenes, regression), "hashes", "Determinism"),
            Part(lambda: timing_html(results), "timing", "Run times"),
        ),
        section(
            "real-tables",
            "Real tables",
            "Engines compared with measured tables",
            Part(lambda: real_tables_html(results)),
        ),
        section("stress", "Generated shots", "Generated shots", Part(lambda: stress_html(results))),
        section(
            "run",
            "About this run",
            "About this run",
            Part(lambda: truth_html(results), "truth", "How results are judged"),
            Part(lambda: environment_html(results), "environment", "Environment"),
        ),
    ]
    return str(
        render(
            "page.html",
            title=_title(results, regression),
            overall=overall(results, regression),
            about=Environment.model_validate(results.environment),
            missing=failed_text(failed) if failed else "",
            styles=[asset("page.css"), asset("replay.css"), Markup(engine_css(results.labels))],
            scripts=[replay_script(), asset("page.js")],
            before=[one for one in before if one.html],
            after=[one for one in after if one.html],
            scene_list=[(name, _worst(results, name)) for name in results.scene_names],
            scenes=[scenes[name].html for name in results.scene_names],
        )
    )


def _made(heading: str, make: Callable[[], Markup], failed: list[FailedPart]) -> Markup:
    """Return the content of a section or of a part; if `make` raises, return the error."""
    made = attempt(f'section "{heading}" of report.html', make, failed)
    return render("failed.html", failed=failed[-1]) if made is None else made


def most_different(scenes: Mapping[str, ScenePagePart]) -> Markup:
    """Return the comparison of the scene in which the engines differ most; "" if there is none."""
    found = [part.comparison for part in scenes.values() if part.comparison is not None]
    most = max(found, key=lambda one: one.difference, default=None)
    return Markup() if most is None else most.html


def _ledgers(results: Results, scenes: Mapping[str, ScenePagePart]) -> dict[str, EnergyLedger]:
    parts = {name: scenes[name].ledger for name in results.scene_names}
    return {name: ledger for name, ledger in parts.items() if ledger is not None}


def _title(results: Results, regression: Regression | None) -> str:
    scenes = many(len(results.scene_names), "scene")
    word = overall(results, regression).word
    return f"{word}: {scenes} - Ghostball validation report"


def _worst(results: Results, scene: str) -> tuple[str, str]:
    """Return the sign and the words of the worst verdict in a scene, for the list of scenes."""
    verdicts = {verdict_of(case) for case in results.cases if case.scene == scene}
    order = (Verdict.FAIL, Verdict.CRASHED, Verdict.PASS, Verdict.LIMITS_HOLD, Verdict.REFERENCE)
    worst = next((one for one in order if one in verdicts), Verdict.SHOWN)
    return worst.symbol, worst.words

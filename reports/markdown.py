"""The text of `report.md`, from a results folder and the figures that were drawn of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import PurePosixPath
from statistics import median
from typing import Any

from ghostball.reports import style
from ghostball.reports.counted import COUNTED_MEANS, counted_rows, unsolved
from ghostball.reports.figures.summary import independent_errors
from ghostball.reports.guarded import FailedPart, attempt, failed_text
from ghostball.reports.markdown_ensembles import ensembles_section
from ghostball.reports.markdown_parts import (
    Drawn,
    figure_link,
    harmless_markdown,
    many,
    number_text,
    one_line,
    table_of,
    taken_over_text,
)
from ghostball.reports.markdown_precision import precision_section
from ghostball.reports.markdown_predictability import predictability_section
from ghostball.reports.markdown_scaling import scaling_section
from ghostball.reports.markdown_scene import scene_section
from ghostball.reports.outcome import BAD, bad_cases
from ghostball.reports.shots import NUMBERS_KEY, cell_text, legend_text, rest_error
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.verdict import (
    RestError,
    Verdict,
    is_own_measure,
    rest_error_standing,
    verdict_of,
)
from ghostball.validation.results.store import INDEPENDENT, CaseRecord, Results

PHYSICS_CAPTIONS = {
    "physics-deflection": "The 30 degree rule: deflection of a rolling cue ball by a cut",
    "physics-throw": "Throw of the object ball, against cut angle and against side spin",
}
PAPER_CAPTIONS = {
    "paper-figure-1": "Figure 1: a break of 7 balls at four instants",
    "paper-figure-2": "Figure 2: clipping, and the same instants without it",
    "paper-figure-3": "Figure 3: a ball meets a cushion",
    "paper-figure-4": "Figure 4: head-on against slightly skewed",
}
NAMED = 12
"""How many cases that are not right are named at the top."""

UNAVAILABLE = "unavailable here"
"""Stands for the settings of an engine that could not run, which has none."""

SCENE_FIGURES_ADVICE = (
    "Figures of each scene are left out here: `ghostball report --figures` on this folder draws "
    "them, and `report.html` beside this file has charts and a replay of each scene without them."
)

STATES = {
    "running": "it is still running, or was killed",
}
"""What became of a run that isn't complete, where its state alone doesn't say it."""


TRUTH_TEXT = """\
**Closed form**: rest positions, rest time and order of collisions come from formulas, evaluated to
50 digits, that share nothing with any engine; a rest error there is an error.

**Certified**: every event of the shot is proved and every rest position enclosed, by code in ball
arithmetic that shares no formula with `ghostball`. Energy curves are compared with the proved
motion, also where there is a closed form.

**Our engine (not independent)**: the scene has no closed form and isn't proved to its end, so the
others are compared with `ghostball`, also their energy. That is a comparison of codes, not a proof:
`ghostball` is marked *ref* there and can't pass by it, only fail by what needs no truth, such as
energy, and by the part of the shot that is proved.

**Judged** is an outcome that a check limits: where or when the balls rest, or how many and which
collisions there were. Energy that falls as it should, no deep overlap, the first collisions: these
can all be right in a shot that ends wrong, so they alone make no ✓ but a ≈.

Agreement between two engines is never called truth. After a few dozen collisions any two engines
part, since each collision multiplies the smallest difference; that is chaos, not a mistake.
"""


def report_text(
    results: Results,
    whole: Drawn,
    scenes: Mapping[str, Drawn] | None,
    physics: Drawn,
    paper: Drawn,
    ensembles: Mapping[str, PurePosixPath],
    failed: list[FailedPart],
) -> str:
    """Return the report as Markdown.

    Parameters
    ----------
    results : Results
    whole : figures of the whole run
    scenes : figures of each scene, by its name; None where they weren't asked for
    physics : figures of laws of the game, over their closed forms
    paper : the paper's figures
    ensembles : figure of each scene's ensemble, by the scene's name
    failed : list of FailedPart, appended to
        Parts that could not be made: sections say so in their place, and the top names all.
    """

    def section(name: str, *makes: Callable[[], str | list[str]]) -> list[str]:
        parts: list[str] = []
        for make in makes:
            made = attempt(f'section "{name}" of report.md', make, failed)
            if made is None:
                parts.append(f"> {one_line(failed[-1].sentence)}")
            else:
                parts += [made] if isinstance(made, str) else made
        return parts

    parts = [
        "## Verdicts",
        *section("Verdicts", lambda: _verdict_table(results)),
        figure_link("Verdict and largest rest error", whole.get("verdicts")),
        "### Engines over all scenes",
        *section("Engines over all scenes", lambda: engine_table(results)),
        figure_link("Rest errors in the closed-form scenes", whole.get("accuracy")),
        "## What is true here",
        TRUTH_TEXT,
    ]
    parts += section("What the runs counted", lambda: counted_section(results))
    parts += ["## Scenes", SCENE_FIGURES_ADVICE if scenes is None else ""]
    for scene in results.scene_names:
        drawn = {} if scenes is None else scenes.get(scene, {})
        parts += section(scene, partial(scene_section, results, scene, drawn))
    chaos = whole.get("chaos")
    parts += section("Predictability", lambda: predictability_section(results, chaos))
    parts += section("Ensembles", lambda: ensembles_section(results, ensembles))
    if physics:
        parts += ["## Laws of the game, from whole shots"]
        parts += [figure_link(PHYSICS_CAPTIONS[kind], path) for kind, path in physics.items()]
    if paper:
        parts += ["## The paper's figures, remade"]
        parts += [figure_link(PAPER_CAPTIONS[kind], path) for kind, path in paper.items()]
    parts += section("Scaling", lambda: scaling_section(results, whole.get("scaling")))
    parts += section("Precision", lambda: precision_section(results, whole))
    parts += ["## Environment", *section("Environment", lambda: environment_table(results))]
    top = ["# Validation report"]
    top += section(
        "Headline",
        lambda: headline(results),
        lambda: metrics_text(results),
        lambda: taken_over_text(results),
    )
    # Figures and the page were made before; of this text, everything is by now.
    if failed:
        top += [f"> **Not all of this report is here**: {one_line(failed_text(failed))}."]
    text = "\n\n".join(part.strip() for part in [*top, *parts] if part.strip()) + "\n"
    return harmless_markdown(text)


def headline(results: Results) -> str:
    """Return what became of all cases in numbers, with those that are not right by name."""
    verdicts = [verdict_of(case) for case in results.cases]
    passed, failed = verdicts.count(Verdict.PASS), verdicts.count(Verdict.FAIL)
    holding = verdicts.count(Verdict.LIMITS_HOLD)
    crashed = verdicts.count(Verdict.CRASHED)
    unable = verdicts.count(Verdict.NOT_REPRESENTABLE)
    counts = (
        f"{many(len(results.scene_names), 'scene')} on {_engines_text(results)}: "
        f"**{passed} passed, {failed} failed**"
        + (f", **{crashed} did not finish**" if crashed else "")
        + f", {holding} keep their limits without "
        f"their outcome being judged, {unable} not representable, "
        f"{len(verdicts) - passed - holding - failed - crashed - unable} without a verdict."
    )
    if left := unsolved(results):
        counts += f" **{many(left, 'sustained or joint contact')} left unsolved.**"
    if bad := bad_cases(results):
        named = [f"[{case.scene}](#{case.scene}) on `{case.label}`" for case in bad[:NAMED]]
        more = [f"{len(bad) - NAMED} more, in the table"] if len(bad) > NAMED else []
        counts += f"\n\nNot right: {', '.join(named + more)}."
    if results.state == "complete":
        return counts
    why = STATES.get(results.state, results.state)
    return (
        f"> **This run is not complete**: {why}; {len(results.cases)} of "
        f"{many(results.planned, 'case')} are done.\n\n{counts}"
    )


def metrics_text(results: Results) -> str:
    """Say which metrics were measured, where it isn't all, and what that leaves unjudged."""
    measured = results.environment.get("metrics", list(METRICS))
    if len(measured) == len(METRICS):
        return ""
    left_out = sum(len(case.left_out) for case in results.cases)
    were = "was" if left_out == 1 else "were"
    return (
        f"> **Only some metrics were measured**: {', '.join(f'`{name}`' for name in measured)}. "
        f"{many(left_out, 'limit')} on others {were} not judged, so a verdict says nothing "
        "of them."
    )


def _engines_text(results: Results) -> str:
    """Say how many engines there are; one with other settings is no other engine."""
    labels, engines = results.labels, {case.engine for case in results.cases}
    text = many(len(engines), "engine")
    if len(labels) == len(engines):
        return text
    return f"{text} in {many(len(labels), 'configuration')}"


def _verdict_table(results: Results) -> str:
    header = ["scene", *(f"`{label}`" for label in results.labels)]
    rows = [
        [f"[{scene}](#{scene})", *(_verdict_cell(results.case(scene, e)) for e in results.labels)]
        for scene in results.scene_names
    ]
    return f"{table_of(header, rows)}\n\n{key_text(results.cases)}"


def key_text(cases: Iterable[CaseRecord]) -> str:
    """Return what the signs and numbers of a table of verdicts mean."""
    return f"{legend_text(map(verdict_of, cases))}. {NUMBERS_KEY}."


def _verdict_cell(case: CaseRecord | None) -> str:
    text = cell_text(case)
    return f"**{text}**" if verdict_of(case) in BAD else text


def engine_table(results: Results) -> str:
    """Return how each engine did over all scenes."""
    header = [
        "engine",
        "✓",
        "≈",
        "✗",
        "did not finish",
        "not representable",
        "rest error, closed form: median",
        "worst",
        "rest error, against ours: median",
        "counts right",
        "energy difference: median [1]",
        "run time: median",
    ]
    rows = []
    for label in results.labels:
        cases = [case for case in results.cases if case.label == label]
        verdicts = [verdict_of(case) for case in cases]
        errors = independent_errors(results, label)
        others = [
            error
            for case in cases
            if case.truth not in INDEPENDENT
            and rest_error_standing(case) in (RestError.JUDGED, RestError.UNJUDGED)
            and (error := rest_error(case)) is not None
        ]
        rows.append(
            [
                f"`{label}`",
                str(verdicts.count(Verdict.PASS)),
                str(verdicts.count(Verdict.LIMITS_HOLD)),
                str(verdicts.count(Verdict.FAIL)),
                str(verdicts.count(Verdict.CRASHED)),
                str(verdicts.count(Verdict.NOT_REPRESENTABLE)),
                style.format_length(median(errors) if errors else None),
                style.format_length(max(errors) if errors else None),
                style.format_length(median(others) if others else None),
                _counts_right(cases),
                number_text(_median_metric(cases, "energy_difference_max")),
                style.format_time(_median_metric(cases, "wall_time")),
            ]
        )
    return table_of(header, rows)


def _counts_right(cases: Sequence[CaseRecord]) -> str:
    names = ("ball_ball_count_error", "ball_cushion_count_error")
    judged = [
        [case.metrics[name] for name in names]
        for case in cases
        if not is_own_measure(case) and all(case.metrics.get(name) is not None for name in names)
    ]
    right = sum(all(error == 0 for error in errors) for errors in judged)
    return f"{right} of {len(judged)}" if judged else "–"


def _median_metric(cases: Sequence[CaseRecord], name: str) -> float | None:
    values = [
        float(value)
        for case in cases
        if (value := case.metrics.get(name)) is not None and math.isfinite(value)
        if not (METRICS[name].compares and is_own_measure(case))
    ]
    return median(values) if values else None


def counted_section(results: Results) -> str:
    """Say by engine what runs did beyond exact events."""
    rows = [
        [f"`{label}`", words, str(total), where]
        for label, words, total, where in counted_rows(results)
    ]
    if not rows:
        return ""
    header = ["engine", "what", "how often", "where"]
    return f"## What the runs counted\n\n{COUNTED_MEANS}\n\n{table_of(header, rows)}"


def environment_table(results: Results) -> str:
    """Return where and with what a run was made."""
    used = {
        label: UNAVAILABLE if values is None else values
        for label, values in engine_settings(results).items()
    }
    environment = results.environment | {"engine_settings": used}
    return table_of(
        ["what", "value"], [[f"`{k}`", one_line(v)] for k, v in flat_values(environment)]
    )


def engine_settings(results: Results) -> dict[str, dict[str, Any] | None]:
    """Return the settings of each engine as used, by its label; None where it is unavailable.

    `env.json` has them as asked for, where a step may be left to the engine.
    """
    used = {case.label: case.settings for case in reversed(results.cases) if case.outcome == "ran"}
    asked: dict[str, dict[str, Any] | None] = results.environment.get("engine_settings", {})
    return {**asked, **used}


def flat_values(values: Mapping[str, Any]) -> Iterable[tuple[str, str]]:
    """Yield a row for each value, for a mapping one for each of its entries."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from ((f"{key}.{inner}", _plain(entry)) for inner, entry in value.items())
        else:
            yield key, _plain(value)


def _plain(value: Any) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{key}={_plain(entry)}" for key, entry in value.items())
    if isinstance(value, list):
        return ", ".join(map(_plain, value))
    return str(value)

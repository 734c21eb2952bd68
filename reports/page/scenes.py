"""One scene of the page: its replay, charts and tables."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from urllib.parse import quote

import numpy as np
from markupsafe import Markup

from ghostball.model.arrays import FloatArray
from ghostball.model.hashes import bits_hash
from ghostball.reports import style
from ghostball.reports.accuracy import cell_text
from ghostball.reports.failed_parts import FailedPart
from ghostball.reports.page.chart import Axis, Series, draw, linear_axis, log_axis
from ghostball.reports.page.comparison import Comparison, comparison_of
from ghostball.reports.page.rendering import embedded_json, render
from ghostball.reports.page.replay_data import scene_data
from ghostball.reports.page.scene_numbers import (
    COMPARISONS,
    number_heads,
    number_row,
    remarks,
    work_text,
)
from ghostball.reports.shared_tables import COMPARISON_KEY
from ghostball.reports.shots import (
    ERROR_FLOOR,
    Run,
    Shot,
    energy_scale,
    error_curves,
    motion_of_run,
)
from ghostball.reports.words import metric_of
from ghostball.validation.baselines.regression import SceneChange
from ghostball.validation.checks.verdict import verdict_of
from ghostball.validation.diagnose.energy_ledger import ENTRIES, EnergyLedger, ledger_of
from ghostball.validation.results.store import INDEPENDENT, CaseRecord

REPLAY_ID = "replay-"
"""Prefix of the id of an element with a replay's data; the name of the scene follows."""


MARKS = 5
"""Number of markers along the curve of an engine."""


@dataclass(frozen=True)
class ScenePagePart:
    """The part of the page about one scene, and data from its motions for other sections.

    `ledger`: energy ledger of Ghostball's engine.
    `hashes`: hash of the exact events and rest positions of each engine, by label.
    `sheet`: path of the scene's picture, relative to the page.
    `comparison`: comparison of the engines; None without two engines and a reference.
    """

    html: Markup
    ledger: EnergyLedger | None
    hashes: dict[str, str]
    sheet: PurePosixPath | None = None
    comparison: Comparison | None = None


def scene_part(
    shot: Shot, change: SceneChange | None = None, sheet: PurePosixPath | None = None
) -> ScenePagePart:
    """Return the part of the page about a scene; afterwards the page doesn't need the motions.

    `change`: change of the scene since the baselines.
    `sheet`: path of the scene's picture, relative to the page.
    """
    cases = [run.case for run in shot.runs if run.case is not None]
    horizon = next((one.shot_horizon for one in cases if one.shot_horizon is not None), None)
    data = scene_data(shot, horizon=horizon)
    ledgers = _ledgers(shot)
    energy = energy_chart(shot)
    html = render(
        "scene.html",
        name=shot.scene.name,
        title=shot.scene.title,
        tags=shot.scene.tags,
        truth=shot.truth or "none",
        engines=[
            (run.label, run.style.name, swatch_of(shot, run), run)
            for run in shot.runs
            if run.case is not None
        ],
        cell_text=cell_text,
        verdict_of=verdict_of,
        compared_key=COMPARISON_KEY,
        heads=number_heads(cases),
        numbers=[(case.label, number_row(case)) for case in cases],
        remarks=list(remarks(cases)),
        limits=_limits(cases),
        cases=cases,
        balls=[ball.id for ball in shot.scene.balls],
        true_rests=shot.truth_positions,
        known="reference" if shot.truth in INDEPENDENT else "reference (Ghostball's own engine)",
        horizon=horizon,
        ledgers=ledgers,
        entries=[e for e in ENTRIES if any(one.entries and e in one.entries for _, one in ledgers)],
        in_contact=[case.label for case in cases if case.work.get("contact_steps")],
        work=[(case.label, work_text(case)) for case in cases if case.work],
        energy=energy,
        error=error_chart(shot, horizon),
        change=change,
        sheet=None if sheet is None else quote(str(sheet)),
        replay_id=REPLAY_ID + shot.scene.name,
        data=embedded_json(data),
    )
    ours = shot.ours
    hashes = {
        run.label: bits_hash(run.motion.events, run.case.rest_positions)
        for run in shot.runs
        if run.motion is not None and run.case is not None and run.case.rest_positions is not None
    }
    ledger = None if ours is None else dict(ledgers).get(ours.label)
    return ScenePagePart(html, ledger, hashes, sheet, comparison_of(shot, energy))


def failed_scene_part(name: str, failed: FailedPart) -> ScenePagePart:
    """Return a part that shows the error, for a scene whose own part could not be made."""
    return ScenePagePart(render("failed_scene.html", name=name, failed=failed), None, {})


def _limits(cases: Sequence[CaseRecord]) -> dict[tuple[str, str, str], list[tuple[str, ...]]]:
    """Return sign, label and value of each checked engine, by metric, limit and reason."""
    judged: dict[tuple[str, str, str], list[tuple[str, ...]]] = defaultdict(list)
    for case in cases:
        for check in case.checks:
            bound = style.format_quantity(check.limit, check.unit)
            limit = f"{COMPARISONS[check.limit_kind]} {bound}"
            value = style.format_quantity(check.value, check.unit)
            sign = {True: "✓", False: "✗", None: "="}[check.passed]
            judged[check.metric, limit, check.reason].append((sign, case.label, value))
    return judged


def _ledgers(shot: Shot) -> list[tuple[str, EnergyLedger]]:
    return [
        (run.label, ledger_of(shot.scene, run.motion))
        for run in shot.runs
        if run.motion is not None and len(run.motion.times) and np.size(run.motion.positions)
    ]


def dash_of(look: style.EngineStyle) -> str:
    """Return SVG's `stroke-dasharray` of an engine's line; "" for a solid line."""
    return "" if isinstance(look.line, str) else " ".join(f"{part:g}" for part in look.line[1])


def swatch_of(shot: Shot, run: Run) -> tuple[str, str, bool, str]:
    """Return the style of an engine in a legend: colour, dashes, True if broad, sign."""
    sign = "" if run.style.ours else style.SIGNS[run.style.marker]
    return colour_of(shot, run), dash_of(run.style), run.style.ours, sign


def colour_of(shot: Shot, run: Run) -> str:
    """Return the CSS colour of an engine, a property that differs in the light and dark scheme."""
    return f"var(--engine-{shot.runs.index(run)})"


def marks_on(shot: Shot, run: Run, values: FloatArray) -> Series:
    """Return an engine's markers along its curve, at times that differ between engines.

    `values` (k,): values of the curve at the times of the recorded motion.
    """
    times, place = motion_of_run(run).times, shot.drawn.index(run)
    at = (np.arange(MARKS) + (place + 0.5) / len(shot.drawn)) / MARKS * times[-1]
    return Series(
        run.style.name,
        colour_of(shot, run),
        at,
        np.interp(at, times, values),
        marker=style.SIGNS[run.style.marker],
        line=False,
    )


def energy_chart(shot: Shot) -> Markup:
    """Draw the total energy of all balls against time; "" if no engine recorded a motion."""
    if not shot.drawn:
        return Markup()
    unit, name, highest = energy_scale(shot)
    top = 1.05 * highest / unit
    series = [
        Series(
            run.style.name,
            colour_of(shot, run),
            motion_of_run(run).times,
            motion_of_run(run).energy / unit,
            dash_of(run.style),
            broad=run.style.ours and len(shot.drawn) > 1,
        )
        for run in shot.drawn
    ]
    series += [
        marks_on(shot, run, motion_of_run(run).energy / unit)
        for run in shot.drawn
        if not run.style.ours
    ]
    title = f"Total energy against time in scene {shot.scene.name}"
    return draw(title, series, _time_axis(shot), linear_axis(f"energy [{name}]", top))


def error_chart(shot: Shot, horizon: float | None = None) -> Markup:
    """Draw the distance of each engine from Ghostball's result against time.

    Return "" if there is nothing to compare.

    `horizon` [s]: predictability horizon of the shot.
    """
    curves, most = error_curves(shot)
    if not curves:
        return Markup()
    series, partings = [], []
    for run, distance in curves:
        times, colour = motion_of_run(run).times, colour_of(shot, run)
        series.append(Series(run.style.name, colour, times, distance, dash_of(run.style)))
        series.append(marks_on(shot, run, distance))
        parted = metric_of(run.case, "first_divergence_time")
        if parted is not None:
            said = f"{run.style.name}: first wrong collision at {style.format_time(parted)}"
            at = np.interp([parted], times, distance)
            partings.append(
                Series(said, colour, np.array([parted]), at, marker="✕", line=False, titles=[said])
            )
    marks = [] if horizon is None else [(horizon, "horizon")]
    title = f"Largest distance of a ball from Ghostball's result against time in {shot.scene.name}"
    axis = log_axis("distance from Ghostball", ERROR_FLOOR, min(most, 1e3), "m")
    return draw(title, [*series, *partings], _time_axis(shot), axis, marks)


def _time_axis(shot: Shot) -> Axis:
    return linear_axis("time [s]", max(float(motion_of_run(run).times[-1]) for run in shot.drawn))

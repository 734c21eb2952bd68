"""Sections of numbers: errors in ulps, run times, energy ledgers, hashes, horizons, ensembles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.page.chart import Series, draw, log_axis
from ghostball.reports.page.rendering import render
from ghostball.reports.page.scenes import ScenePagePart
from ghostball.reports.shared_tables import (
    ENSEMBLE_HEADS,
    ENSEMBLE_KEY,
    QUANTITY_HEADS,
    ensemble_remarks,
    ensemble_rows,
    quantity_rows,
)
from ghostball.reports.words import metric_of, run_time_text
from ghostball.validation.baselines import Regression
from ghostball.validation.checks.verdict import RestError, rest_error_standing
from ghostball.validation.diagnose.energy_ledger import ENTRIES, EnergyLedger
from ghostball.validation.grading.tolerances import TOLERANCE
from ghostball.validation.results.store import CLOSED_FORM, CaseRecord, Results

SMALLEST_ERROR = 1e-16
"""Smaller errors are rounding and are drawn at this value [m]: a log axis has no 0."""


def closed_forms_html(results: Results) -> Markup:
    """Return the errors in scenes with a closed form, in units of the rounding error."""
    rows = [
        (scene, cases)
        for scene, cases in results.by_scene()
        if any(case is not None and case.truth == CLOSED_FORM for case in cases)
    ]
    return render("closed_forms.html", labels=results.labels, rows=rows)


def cost_html(results: Results) -> Markup:
    """Return the chart of run time against error, with a point for each case with both values."""
    series, least, most = [], math.inf, 0.0
    for k, label in enumerate(results.labels):
        points = [
            (time, max(error, SMALLEST_ERROR), case.scene)
            for case in results.cases
            if case.label == label
            and rest_error_standing(case) in (RestError.JUDGED, RestError.UNJUDGED)
            and (error := metric_of(case, "rest_error_max")) is not None
            and (time := metric_of(case, "wall_time"))
        ]
        if not points:
            continue
        seconds = np.array([point[0] for point in points])
        errors = np.array([point[1] for point in points])
        least, most = min(least, float(seconds.min())), max(most, float(seconds.max()))
        look = style.engine_style(label)
        titles = [
            f"{look.name} in {s}: {style.format_time(t)}, {style.format_length(e)}"
            for t, e, s in points
        ]
        series.append(
            Series(
                look.name,
                f"var(--engine-{k})",
                seconds,
                errors,
                marker=style.SIGNS[look.marker],
                line=False,
                titles=titles,
            )
        )
    chart = Markup()
    if series:
        largest = max(float(np.max(one.y)) for one in series)
        chart = draw(
            "Run time against the largest rest error, one point per case",
            series,
            log_axis("run time", least, most, "s"),
            log_axis("largest rest error", SMALLEST_ERROR, largest, "m"),
        )
    return render("cost.html", chart=chart, series=series)


def horizons_html(results: Results) -> Markup:
    """Return the predictability horizon of each shot, and of each engine in it."""
    shots = {one.scene: one for one in results.cases if one.shot_horizon is not None}
    labels = [
        label
        for label in results.labels
        if any(case.label == label and case.horizon is not None for case in results.cases)
    ]
    rows = []
    for scene in results.scene_names:
        cases = [results.case(scene, label) for label in labels]
        if any(case is not None and case.horizon is not None for case in cases):
            rows.append((scene, cases))
    return render(
        "horizons.html",
        tolerance=style.format_length(TOLERANCE),
        shots=[shots[name] for name in results.scene_names if name in shots],
        labels=labels,
        rows=rows,
    )


def ensembles_html(results: Results) -> Markup:
    """Return the statistical verdicts on ensembles; "" if there are none."""
    if not results.varied:
        return Markup()
    return render(
        "ensembles.html",
        key=ENSEMBLE_KEY,
        header=ENSEMBLE_HEADS,
        rows=list(ensemble_rows(results)),
        remarks=list(ensemble_remarks(results)),
        heads=QUANTITY_HEADS,
        quantities=list(quantity_rows(results)),
    )


def ledgers_html(ledgers: Mapping[str, EnergyLedger]) -> Markup:
    """Return the energy ledger of each scene on Ghostball's engine."""
    known = {scene: one for scene, one in ledgers.items() if one.entries is not None}
    present = [e for e in ENTRIES if any(e in (one.entries or {}) for one in known.values())]
    return render("ledgers.html", ledgers=known, entries=present)


def hashes_html(
    results: Results, scenes: Mapping[str, ScenePagePart], regression: Regression | None
) -> Markup:
    """Return the hash of Ghostball's result in each scene, and the hash of the baseline."""
    rows = []
    for case in _ours(results):
        change = None if regression is None else regression.scene(case.scene)
        stored = scenes[case.scene].hashes.get(case.label, "")
        base = "" if change is None else change.base_hash
        # The comparison may be older than the stored motion, or its run had no motion.
        other = "" if change is None or change.head_hash == stored else change.head_hash
        rows.append((case.scene, stored, base, other))
    return render("hashes.html", rows=rows, compared=any(base for _, _, base, _ in rows))


def timing_html(results: Results) -> Markup:
    """Return the run time of each case, measured once."""
    single = [(scene, [_timed(case) for case in cases]) for scene, cases in results.by_scene()]
    return render("timing.html", labels=results.labels, single=single)


def _timed(case: CaseRecord | None) -> tuple[str, float | None]:
    """Return the run time of a case as text, and as a number for sorting [s]."""
    if case is None:
        return "–", None
    return run_time_text(case, dated=case.reused), case.wall_time


def _ours(results: Results) -> Iterator[CaseRecord]:
    for scene in results.scene_names:
        for case in results.cases:
            ran = case.scene == scene and case.outcome == "ran"
            if ran and style.engine_style(case.label).ours:
                yield case

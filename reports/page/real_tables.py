"""Section of the page: what was measured on real tables, and what each engine makes of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.page.chart import Series, draw, linear_axis
from ghostball.reports.page.rendering import render
from ghostball.reports.words import LIKENESS_KEY, likeness_cell
from ghostball.validation.measured.likeness import Family, Likeness, Measured
from ghostball.validation.results.store import Results
from ghostball.validation.suite.real_tables import load_likenesses


def real_tables_html(results: Results) -> Markup:
    """Return a chart for each family of figures, and how far off each engine is."""
    found = load_likenesses(results.path)
    if not found:
        return Markup()
    families = found[0].families
    charts = [
        (family, _chart(results, found, k))
        for k, family in enumerate(families)
        if any(len(_first_of_each(one.families[k].figures)) > 2 for one in found)
    ]
    rows = [(one.label, [(likeness_cell(f), f.lacks) for f in one.families]) for one in found]
    lacking = [(one.label, f.lacks) for one in found for f in one.families[:1] if f.lacks]
    settings = [
        (one.label, ", ".join(f"{name} = {_text(value)}" for name, value in f.settings.items()))
        for one in found
        for f in one.families[:1]
        if f.settings
    ]
    return render(
        "real_tables.html",
        key=LIKENESS_KEY,
        charts=charts,
        series=_legend(results, found),
        families=families,
        rows=rows,
        lacking=lacking,
        settings=settings,
    )


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def _legend(results: Results, found: Sequence[Likeness]) -> list[tuple[str, str]]:
    shown = [one for one in found if any(family.figures for family in one.families)]
    return [(one.label, _colour(results, one.label)) for one in shown]


def _colour(results: Results, label: str) -> str:
    labels = list(results.labels)
    return f"var(--engine-{labels.index(label)})" if label in labels else "var(--muted)"


def _chart(results: Results, found: Sequence[Likeness], index: int) -> Markup:
    """Draw what was measured with bars of two standard errors, and each engine's curve."""
    drawn = [(one.label, one.families[index]) for one in found if one.families[index].figures]
    measured = _first_of_each(drawn[0][1].figures)
    at, value, error = (
        np.array([getattr(one, name) for one in measured]) for name in ("at", "value", "error")
    )
    bars = [
        Series("two standard errors", "var(--ink)", np.array([x, x]), np.array([y - e, y + e]))
        for x, y, e in zip(at, value, 2.0 * error, strict=True)
    ]
    points = Series("measured", "var(--ink)", at, value, marker="●", line=False)
    curves = [
        Series(
            label,
            _colour(results, label),
            np.array([one.at for one in _first_of_each(family.figures)]),
            np.array([one.played for one in _first_of_each(family.figures)]),
            dash="" if style.engine_style(label).ours else "5 3",
        )
        for label, family in drawn
    ]
    every = np.concatenate([value - 2.0 * error, value + 2.0 * error, *(one.y for one in curves)])
    margin = 0.05 * float(np.ptp(every))
    family: Family = drawn[0][1]
    return draw(
        f"{family.title}: measured, and played",
        [*curves, *bars, points],
        linear_axis(family.against, 1.05 * float(at.max())),
        linear_axis(_short(family), float(every.max()) + margin, float(every.min()) - margin),
    )


def _short(family: Family) -> str:
    """Return what is drawn upwards, in a few words."""
    names = {"cushion": "speed left, of that before", "rolling-pool": "deceleration [m/s²]"}
    return names.get(family.name, family.unit)


def _first_of_each(figures: Sequence[Measured]) -> list[Measured]:
    """Return the first figure at each place: those at the smallest angle."""
    found: dict[float, Measured] = {}
    for one in figures:
        found.setdefault(one.at, one)
    return list(found.values())

"""Section about real tables: measurements, and the results of each engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.page.chart import Series, draw, linear_axis
from ghostball.reports.page.rendering import render
from ghostball.reports.words import AGREEMENT_KEY, agreement_cell
from ghostball.validation.measured.table_agreement import (
    ComparedFigure,
    FigureFamily,
    TableAgreement,
)
from ghostball.validation.results.store import Results
from ghostball.validation.suite.real_tables import load_agreements

SIGNS: Final = ("●", "■", "▲")
"""Plot markers of measured values, one for each quantity of a family."""

_Y_LABELS: Final = {
    "cushion": "speed after / speed before",
    "rolling-pool": "deceleration [m/s²]",
    "banks-pool": "aim position / target position",
    "cushion-snooker": "speed after / speed before",
    "hit-cue-ball": "direction [degrees]",
    "hit-throw": "throw [degrees]",
    "head-on-unequal": "speed / speed before",
    "hit-speeds": "speed / speed before",
    "hit-angle": "direction [degrees]",
    "throw-pool": "throw [degrees]",
    "break-made": "share of breaks",
}
"""Labels of the vertical axes, by family."""

_DIVIDED_BY_X: Final = ("banks-pool", "cushion-snooker")
"""Families with values nearly proportional to x: the chart shows value / x against x."""


def real_tables_html(results: Results) -> Markup:
    """Return charts of the families with over two values of x, and the table of all engines."""
    found = load_agreements(results.path)
    if not found:
        return Markup()
    charts = []
    for k in range(len(found[0].families)):
        drawn = [(one.label, one.families[k]) for one in found if one.families[k].figures]
        if any(len({one.at for one in family.figures}) > 2 for _, family in drawn):
            charts.append((drawn[0][1], _signs(drawn[0][1]), _chart(results, drawn)))
    return render(
        "real_tables.html",
        key=AGREEMENT_KEY,
        charts=charts,
        series=_legend(results, found),
        tables=[(grades, *_table(found, grades=grades)) for grades in (True, False)],
        lacking=_by_engine(found, lambda family: family.lacks),
        settings=_by_engine(found, _settings),
    )


def _table(
    found: Sequence[TableAgreement], *, grades: bool
) -> tuple[list[str], list[tuple[str, list[tuple[str, str]]]]]:
    """Return table heads and rows of the families whose `grades` equals the argument."""
    heads = [family.short for family in found[0].families if family.grades == grades]
    rows = [
        (one.label, [(agreement_cell(f), f.lacks) for f in one.families if f.grades == grades])
        for one in found
    ]
    return heads, rows


def _by_engine(
    found: Sequence[TableAgreement], text_of: Callable[[FigureFamily], str]
) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return, for each engine, every different text once, after the names of its families."""
    said = []
    for one in found:
        families: dict[str, list[str]] = {}
        for family in one.families:
            if text := text_of(family):
                families.setdefault(text, []).append(family.short)
        if families:
            said.append((one.label, [(", ".join(names), text) for text, names in families.items()]))
    return said


def _settings(family: FigureFamily) -> str:
    return ", ".join(f"{name} = {_text(value)}" for name, value in family.settings.items())


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def _legend(results: Results, found: Sequence[TableAgreement]) -> list[tuple[str, str]]:
    shown = [one for one in found if any(family.figures for family in one.families)]
    return [(one.label, _colour(results, one.label)) for one in shown]


def _colour(results: Results, label: str) -> str:
    labels = list(results.labels)
    return f"var(--engine-{labels.index(label)})" if label in labels else "var(--muted)"


def _signs(family: FigureFamily) -> list[tuple[str, str]]:
    """Return the plot marker of each quantity, if the family has several quantities."""
    things = list(_by_quantity(family.figures))
    return list(zip(SIGNS, things, strict=False)) if len(things) > 1 else []


def _chart(results: Results, drawn: Sequence[tuple[str, FigureFamily]]) -> Markup:
    """Return a chart of the measurements, with bars of two standard errors, and the engines."""
    family = drawn[0][1]
    series = [
        _curve(label, _colour(results, label), figures)
        for label, other in drawn
        for figures in _by_quantity(_drawn_figures(other)).values()
    ]
    for sign, measured in zip(SIGNS, _by_quantity(_drawn_figures(family)).values(), strict=False):
        series += _bars(measured)
        series.append(_points(sign, measured))
    every = np.concatenate([one.y for one in series])
    margin = 0.05 * float(np.ptp(every))
    return draw(
        f"{family.title}: measured and simulated",
        series,
        linear_axis(family.against, 1.05 * max(one.at for one in family.figures)),
        linear_axis(
            _Y_LABELS.get(family.name, family.unit),
            float(every.max()) + margin,
            float(every.min()) - margin,
        ),
    )


def _drawn_figures(family: FigureFamily) -> Sequence[ComparedFigure]:
    """Return the figures as drawn: divided by x if the family is in `_DIVIDED_BY_X`."""
    if family.name not in _DIVIDED_BY_X:
        return family.figures
    return [
        one.model_copy(
            update={
                "value": one.value / one.at,
                "error": None if one.error is None else one.error / one.at,
                "played": one.played / one.at,
            }
        )
        for one in family.figures
    ]


def _curve(label: str, colour: str, figures: Sequence[ComparedFigure]) -> Series:
    return Series(
        label,
        colour,
        np.array([one.at for one in figures]),
        np.array([one.played for one in figures]),
        dash="" if style.engine_style(label).ours else "5 3",
    )


def _bars(measured: Sequence[ComparedFigure]) -> list[Series]:
    return [
        Series(
            "two standard errors",
            "var(--ink)",
            np.array([one.at, one.at]),
            one.value + 2.0 * one.error * np.array([-1.0, 1.0]),
        )
        for one in measured
        if one.error is not None
    ]


def _points(sign: str, measured: Sequence[ComparedFigure]) -> Series:
    at, value = (np.array([getattr(one, name) for one in measured]) for name in ("at", "value"))
    titles = [": ".join(filter(None, (one.what, f"{one.value:.4g}"))) for one in measured]
    return Series("measured", "var(--ink)", at, value, marker=sign, line=False, titles=titles)


def _by_quantity(figures: Sequence[ComparedFigure]) -> dict[str, list[ComparedFigure]]:
    """Return the figures of each quantity; if several have the same x, only the first.

    The first figure at an x has the smallest angle. If every figure has its own description, all
    figures belong to one quantity.
    """
    found: dict[str, dict[float, ComparedFigure]] = {}
    alone = len({one.what for one in figures}) == len(figures)
    for one in figures:
        found.setdefault("" if alone else one.what, {}).setdefault(one.at, one)
    return {what: list(places.values()) for what, places in found.items()}

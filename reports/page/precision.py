"""Errors against time over ladders of steps, a chart for each scene, as it was measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from ghostball.reports import style
from ghostball.reports.markdown_precision import precision_section
from ghostball.reports.page.chart import Axis, Series, draw, log_axis
from ghostball.reports.page.curves import dash_of
from ghostball.reports.page.rendering import render
from ghostball.reports.precision_figure import FLOOR
from ghostball.reports.precision_text import legend_text
from ghostball.reports.stored import stored_in
from ghostball.validation.bench import PrecisionMeasurement
from ghostball.validation.bench.precision import PrecisionPoint
from ghostball.validation.results.store import Results

FloatArray = NDArray[np.float64]

SMALLEST_ERROR = FLOOR
"""Where an error of exactly 0 is drawn on an axis that has no 0 [m]."""

MARKERS = {"o": "●", "D": "◆", "^": "▲", "v": "▼", "s": "■", "P": "✚", "X": "✖", "*": "★"}
OPEN = {"●": "○", "◆": "◇", "▲": "△", "▼": "▽", "■": "□", "✚": "✛", "✖": "✕", "★": "☆"}
"""Signs of the page for the markers of figures; the open ones had other collisions than truth."""


def engines_of_page(results: Results) -> list[str]:
    """Return the labels that have a colour on the page, those of the run first."""
    measured = stored_in(results, PrecisionMeasurement)
    others = () if measured is None else (point.engine for point in measured.points)
    return list(dict.fromkeys([*results.labels, *others]))


def precision_html(results: Results, measured: PrecisionMeasurement) -> Markup:
    """Return the charts, and the text and tables of the report in Markdown."""
    labels = engines_of_page(results)
    charts = [
        (scene, _chart([point for point in measured.points if point.scene == scene], labels))
        for scene in dict.fromkeys(point.scene for point in measured.points)
    ]
    engines = dict.fromkeys(point.engine for point in measured.points)
    legend = [
        (
            f"var(--engine-{labels.index(engine)})",
            dash_of(style.engine_style(engine)),
            MARKERS.get(style.engine_style(engine).marker, "●"),
            legend_text(engine, [one for one in measured.curves if one.engine == engine]),
        )
        for engine in engines
    ]
    parts = precision_section(results, {})
    return render("precision.html", charts=charts, legend=legend, parts=parts[1:])


def _chart(points: Sequence[PrecisionPoint], labels: Sequence[str]) -> Markup:
    series = [
        one
        for engine in dict.fromkeys(point.engine for point in points)
        for one in _series([p for p in points if p.engine == engine], labels.index(engine))
    ]
    scene = points[0].scene
    seconds = [point.seconds for point in points]
    x = log_axis("time of a run", min(seconds), max(seconds), "s")
    return draw(f"Largest rest error against time of a run in {scene}", series, x, _errors(points))


def _errors(points: Sequence[PrecisionPoint]) -> Axis:
    least = max(min(point.error_low for point in points), SMALLEST_ERROR)
    most = max(point.error_high for point in points)
    return log_axis("largest rest error", least, max(most, 10.0 * least), "m")


def _series(points: Sequence[PrecisionPoint], k: int) -> Iterator[Series]:
    """Yield an engine's line with its bars, then its points: those of another course are open."""
    look, colour = style.engine_style(points[0].engine), f"var(--engine-{k})"
    x = np.array([point.seconds for point in points])
    y = _shown([point.error for point in points])
    low = _shown([point.error_low for point in points])
    high = _shown([point.error_high for point in points])
    yield Series(look.name, colour, x, y, dash_of(look), low=low, high=high)
    filled = MARKERS.get(look.marker, "●")
    for true_course, sign in ((True, filled), (False, OPEN[filled])):
        mine = np.array([point.true_course is true_course for point in points])
        titles = [_title(point) for point in points if point.true_course is true_course]
        yield Series(look.name, colour, x[mine], y[mine], marker=sign, line=False, titles=titles)


def _shown(errors: Sequence[float]) -> FloatArray:
    """Return errors as they can be drawn on an axis without 0."""
    return np.array([max(error, SMALLEST_ERROR) for error in errors])


def _title(point: PrecisionPoint) -> str:
    other = "" if point.true_course else "; other collisions than the true ones"
    error, seconds = style.format_length(point.error), style.format_time(point.seconds)
    return f"{point.label}: {error} in {seconds}{other}"

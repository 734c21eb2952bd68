"""Errors against time over ladders of steps, a chart for each scene, as it was measured."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from reports import style
from reports.markdown_precision import precision_section
from reports.page.chart import Axis, Series, draw, log_axis
from reports.page.curves import dash_of
from reports.page.rendering import render
from reports.precision_figure import FLOOR
from reports.precision_text import legend_text
from reports.stored import stored_in
from validation.bench import PrecisionMeasurement
from validation.bench.precision import PrecisionPoint
from validation.store import ResultsFolder

SMALLEST_ERROR = FLOOR
"""Where an error of exactly 0 is drawn on an axis that has no 0 [m]."""

MARKERS = {"o": "●", "D": "◆", "^": "▲", "v": "▼", "s": "■", "P": "✚", "X": "✖", "*": "★"}
"""Signs of the page for the markers of figures."""


def engines_of_page(results: ResultsFolder) -> list[str]:
    """Return the labels that have a colour on the page, those of the run first."""
    measured = stored_in(results, PrecisionMeasurement)
    others = () if measured is None else (point.engine for point in measured.points)
    return list(dict.fromkeys([*results.labels, *others]))


def precision_html(results: ResultsFolder, measured: PrecisionMeasurement) -> Markup:
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
        _series([one for one in points if one.engine == engine], labels.index(engine))
        for engine in dict.fromkeys(point.engine for point in points)
    ]
    scene = points[0].scene
    seconds = [point.seconds for point in points]
    x = log_axis("time of a run", min(seconds), max(seconds), "s")
    return draw(f"Largest rest error against time of a run in {scene}", series, x, _errors(points))


def _errors(points: Sequence[PrecisionPoint]) -> Axis:
    least = max(min(point.error_low for point in points), SMALLEST_ERROR)
    most = max(point.error_high for point in points)
    return log_axis("largest rest error", least, max(most, 10.0 * least), "m")


def _series(points: Sequence[PrecisionPoint], k: int) -> Series:
    look = style.engine_style(points[0].engine)
    return Series(
        look.name,
        f"var(--engine-{k})",
        np.array([point.seconds for point in points]),
        np.array([max(point.error, SMALLEST_ERROR) for point in points]),
        dash_of(look),
        marker=MARKERS.get(look.marker, "●"),
        titles=[
            f"{point.label}: {style.format_length(point.error)} in "
            f"{style.format_time(point.seconds)}"
            + ("" if point.true_course else "; other collisions than the true ones")
            for point in points
        ],
        low=np.array([max(point.error_low, SMALLEST_ERROR) for point in points]),
        high=np.array([max(point.error_high, SMALLEST_ERROR) for point in points]),
    )

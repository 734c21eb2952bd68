"""Charts as inline SVG: small, sharp at any size, in the colours of the page's scheme.

Curves are simplified: points whose removal changes a curve invisibly are removed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from markupsafe import Markup

from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.page.rendering import render

Scale = Literal["linear", "log"]

WIDTH, HEIGHT = 560.0, 250.0
LEFT, RIGHT, TOP, BOTTOM = 80.0, 40.0, 10.0, 36.0
"""Size and margins of a chart, in units of its view box; at full width a unit is a pixel.

The last tick of x, such as "100 ms", is centred at the end of the axis. Phones have larger text.
"""

DEVIATION = 0.4
"""Largest distance of a simplified curve from the original one [pixels]."""

MOST_DECADES = 6
"""Largest number of decades with a tick at every decade; above it, some decades get no tick."""


@dataclass(frozen=True, eq=False)
class Series:
    """One curve, or points without a line.

    `colour`: CSS colour, such as "var(--engine-0)".
    `x`, `y` (k,) float64: points; the curve has a gap at each y that is nan.
    `dash`: SVG's `stroke-dasharray`; "" draws a solid line.
    `broad`: draw the curve as a broad band beneath the other curves.
    `marker`: sign at each point; "" draws no sign.
    `titles`: tooltip of each point; empty if the points have no tooltips.
    """

    name: str
    colour: str
    x: FloatArray
    y: FloatArray
    dash: str = ""
    broad: bool = False
    marker: str = ""
    line: bool = True
    titles: Sequence[str] = ()


@dataclass(frozen=True)
class Axis:
    """An axis: label, scale and range; ticks are (value, text)."""

    label: str
    low: float
    high: float
    scale: Scale = "linear"
    ticks: tuple[tuple[float, str], ...] = ()

    def place(self, values: FloatArray) -> FloatArray:
        """Return the positions of values along the axis, from 0 (low end) to 1 (high end)."""
        if self.scale == "log":
            with np.errstate(divide="ignore", invalid="ignore"):
                low, high = math.log10(self.low), math.log10(self.high)
                placed: FloatArray = (np.log10(values) - low) / (high - low)
                return placed
        return (values - self.low) / (self.high - self.low)


def linear_axis(label: str, high: float, low: float = 0.0) -> Axis:
    """Return an axis with about five ticks at round numbers."""
    high = high if high > low else low + 1.0
    step = 10.0 ** math.floor(math.log10((high - low) / 4))
    step *= next(k for k in (1, 2, 2.5, 5, 10) if (high - low) / (k * step) <= 6)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    ticks = tuple((k * step, f"{k * step:.6g}") for k in range(first, last + 1))
    return Axis(label, low, high, "linear", ticks)


def log_axis(label: str, low: float, high: float, unit: Literal["m", "s", ""] = "") -> Axis:
    """Return an axis of whole decades; ticks of lengths and times have units such as mm and µs."""
    first = math.floor(math.log10(low) + 1e-9)
    last = max(math.ceil(math.log10(high) - 1e-9), first + 1)
    step = math.ceil((last - first) / MOST_DECADES)
    text = {"m": style.format_length, "s": style.format_time}.get(unit)
    ticks = tuple(
        (10.0**k, style.power_of_ten(k) if text is None else text(float(f"1e{k}")))
        for k in range(first, last + 1)
        if (k - first) % step == 0
    )
    return Axis(label, 10.0**first, 10.0**last, "log", ticks)


def draw(
    title: str, series: Iterable[Series], x: Axis, y: Axis, marks: Sequence[tuple[float, str]] = ()
) -> Markup:
    """Return a chart as SVG.

    `title`: description of the chart for screen readers.
    `series`: curves; points outside the axes are drawn at the edge.
    `marks`: x value and label of each vertical line.
    """
    wide, high = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def across(values: FloatArray) -> FloatArray:
        return LEFT + wide * np.clip(x.place(values), 0.0, 1.0)

    def down(values: FloatArray) -> FloatArray:
        return TOP + high * (1.0 - np.clip(y.place(values), 0.0, 1.0))

    curves = []
    for one in series:
        at = np.column_stack([across(one.x), down(one.y)])
        curves.append((one, _path(at) if one.line else "", _points(one, at)))
    return render(
        "chart.html",
        title=title,
        width=WIDTH,
        height=HEIGHT,
        box=(LEFT, TOP, wide, high),
        curves=curves,
        x_ticks=[(LEFT + wide * float(x.place(np.array(v))), text) for v, text in x.ticks],
        y_ticks=[(TOP + high * (1.0 - float(y.place(np.array(v)))), text) for v, text in y.ticks],
        x_label=x.label,
        y_label=y.label,
        marks=[
            (LEFT + wide * float(x.place(np.array(at))), word)
            for at, word in marks
            if x.low <= at <= x.high
        ],
    )


def thinned(points: FloatArray, deviation: float) -> FloatArray:
    """Return the points (m, 2) of a simplified curve, chosen from its points (k, 2).

    No removed point is farther than `deviation` from the simplified curve.

    Algorithm of Douglas and Peucker (1973), without recursion.
    """
    across, down = points.T.copy()  # contiguous arrays: most of the time is spent on them
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1]] = True
    open_spans = [(0, len(points) - 1)]
    while open_spans:
        first, last = open_spans.pop()
        if last - first < 2:
            continue
        inner = slice(first + 1, last)
        x, y = across[inner] - across[first], down[inner] - down[first]
        dx, dy = across[last] - across[first], down[last] - down[first]
        length2 = dx * dx + dy * dy
        if length2 > 0.0:
            part = np.clip((x * dx + y * dy) / length2, 0.0, 1.0)
            x, y = x - part * dx, y - part * dy
        squares = x * x + y * y
        worst = int(np.argmax(squares))
        if squares[worst] > deviation * deviation:
            keep[first + 1 + worst] = True
            open_spans += [(first, first + 1 + worst), (first + 1 + worst, last)]
    return points[keep]


def _path(at: FloatArray) -> str:
    """Return the attribute `d` of an SVG path through the points, with a gap at each nan or inf."""
    finite = np.all(np.isfinite(at), axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], finite, [False]]).astype(int)))
    parts = []
    for first, after in zip(edges[::2], edges[1::2], strict=True):
        piece = thinned(at[first:after], DEVIATION)
        parts.append("M" + "L".join(f"{px:.1f} {py:.1f}" for px, py in piece))
    return "".join(parts)


def _points(one: Series, at: FloatArray) -> list[tuple[float, float, str]]:
    if not one.marker:
        return []
    titles = one.titles or [""] * len(at)
    return [
        (float(px), float(py), said)
        for (px, py), said in zip(at, titles, strict=True)
        if math.isfinite(px) and math.isfinite(py)
    ]

"""A column of the board against what an engine's own step costs, with the step that is worth it."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Final

from benchmarks.steps import STEPS, WRONG, StepPoint, StepsMeasurement, error_text, knee
from ghostball.reports import style
from ghostball.validation.board.column import Column

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH: Final = 6.4
PANEL: Final = 3.3
"""Height of the axes [inch]; the legend needs its own."""

LEAST: Final = 1e-17
"""Errors below it are drawn there, 0 among them, where no error is larger."""

NAMES: Final = 64
"""Characters of a line of the legend."""

COLOURS: Final = (
    *("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#7A5C00", "#56B4E9"),
    *("#882255", "#8C8C8C", "#B8A200", "#332288"),
)
MARKERS: Final = "osD^vP*X"
LINES: Final = ("-", "--", "-.", ":", (0, (5, 1)))
"""Of the lines in their order: no two have all three of them."""

UNITS: Final = {
    "m": "how far off [m]",
    "m/s": "fastest inelastic [m/s]",
    "degrees": "short by [degrees]",
}


def draw_steps(measured: StepsMeasurement, column: Column) -> Figure:
    """Draw a line for each engine, and one for all those whose errors are the same."""
    found = measured.of(column.id)
    lines = _same(column, found)
    errors = [one.error for points in found.values() for one in points if one.error]
    floor = max(min(errors, default=1.0) / 10.0, LEAST)
    top = 10.0 * max(errors, default=1.0)
    figure = style.new_figure(WIDTH, PANEL + 0.22 * len(lines))
    axes = figure.subplots()
    axes.set(xscale="log", yscale="log", ylim=(floor / 3.0, 3.0 * top))
    for k, rows in enumerate(lines):
        points, colour = found[rows[0]], COLOURS[k % len(COLOURS)]
        right = [one for one in points if one.error is not None]
        axes.plot(
            [one.steps for one in right],
            [max(one.error or 0.0, floor) for one in right],
            color=colour,
            linestyle=LINES[k % len(LINES)],
            marker=MARKERS[k % len(MARKERS)],
            markersize=5.0,
            linewidth=1.4,
            label=fill(", ".join(map(style.engine_name, rows)), NAMES),
        )
        wrong = [one.steps for one in points if one.kind in WRONG and one.kind != "none"]
        axes.plot(wrong, [top] * len(wrong), linestyle="", marker="x", color=colour)
        worth = knee(column, points)
        if worth is not None:
            at = max(worth.error or 0.0, floor)
            axes.plot(worth.steps, at, "o", markersize=11.0, color=colour, fillstyle="none")
    axes.set_xticks(STEPS, [f"{steps}" for steps in STEPS])
    axes.minorticks_off()
    axes.grid(visible=True)
    lost = any(one.kind in WRONG for row in found.values() for one in row if one.kind != "none")
    axes.set_xlabel(f"steps in a second of play; ringed: worth it{'; × no true shot' * lost}")
    axes.set_ylabel(UNITS.get(column.unit, "share of the energy"))
    if any(one.error is not None and one.error < floor for row in found.values() for one in row):
        axes.annotate("0", (0.01, floor), xycoords=("axes fraction", "data"), va="bottom")
    figure.legend(loc="outside lower center", ncols=1)
    style.set_title(figure, f"{column.title}: error against steps")
    return figure


def _same(column: Column, found: dict[str, list[StepPoint]]) -> list[Sequence[str]]:
    """Return the engines that have an error, or a wrong shot; those with the same ones together."""
    lines: dict[tuple[str, ...], list[str]] = {}
    for row, points in found.items():
        said = tuple(error_text(column, one) for one in points)
        if set(said) != {"lacks it"}:
            lines.setdefault(said, []).append(row)
    return list(lines.values())

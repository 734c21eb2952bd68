"""Quantities of stored measurements over the revisions at which they were measured."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ghostball.engine import GhostballError
from ghostball.reports import style
from ghostball.validation.bench.history import History, Version

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, ROW_HEIGHT, REST_HEIGHT = 9.6, 2.2, 0.9
COLUMNS = 3

MOST_PANELS = 60
"""More are a picture that nobody reads."""

WIDE_RANGE = 30.0
"""Largest over least value from which on an axis is logarithmic."""

_COLOURS = (style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE, style.ORANGE, style.BROWN)
_MARKERS = "osD^vP"


def draw_history(history: History) -> Figure:
    """Draw a panel for each quantity, with a line for each machine.

    Raises
    ------
    GhostballError
        Where there are too many quantities for one picture.
    """
    names = history.quantities
    if len(names) > MOST_PANELS:
        raise GhostballError(
            f"`--plot` draws a panel for each quantity, at most {MOST_PANELS}, and "
            f"`{history.kind}` has {len(names)}. Choose some with `--quantity`, such as "
            f"'{names[0]}'"
        )
    columns = min(COLUMNS, len(names))
    rows = -(-len(names) // columns)
    figure = style.new_figure(WIDTH, REST_HEIGHT + rows * ROW_HEIGHT)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, name in zip(grid, names, strict=False):
        _draw_panel(axes, history, name)
    for axes in grid[len(names) :]:
        axes.set_axis_off()
    if len(history.machines) > 1:
        handles, labels = grid[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    style.set_title(figure, f"Stored measurements over revisions: {history.kind}")
    return figure


def _draw_panel(axes: Axes, history: History, name: str) -> None:
    """Draw one quantity over all versions that have it, in order of time."""
    versions = [version for version in history.versions if name in version.values]
    place = {id(version): k for k, version in enumerate(versions)}
    for k, machine in enumerate(history.machines):
        mine = [version for version in versions if version.machine == machine]
        found = [version.values[name] for version in mine]
        spread = [
            [one.value - (one.value if one.low is None else one.low) for one in found],
            [(one.value if one.high is None else one.high) - one.value for one in found],
        ]
        axes.errorbar(
            [place[id(version)] for version in mine],
            [one.value for one in found],
            yerr=spread,
            color=_COLOURS[k % len(_COLOURS)],
            marker=_MARKERS[k % len(_MARKERS)],
            markersize=4.0,
            linewidth=1.2,
            elinewidth=0.9,
            capsize=2.0,
            label=machine,
        )
    newest = versions[-1].values[name]
    if newest.target is not None:
        axes.axhline(newest.target, color=style.GREY, linewidth=0.9, linestyle=(0.0, (4.0, 2.0)))
        sign = "≤" if newest.target_kind == "at_most" else "≥"
        axes.annotate(
            f"target {sign} {style.format_quantity(newest.target, newest.unit)}",
            (1.0, newest.target),
            xycoords=("axes fraction", "data"),
            ha="right",
            va="bottom",
            fontsize=7,
            color=style.GREY,
        )
    _set_scale(axes, [version.values[name].value for version in versions])
    axes.set_title(name, fontsize=8.5)
    axes.yaxis.set_major_formatter(lambda value, _: style.format_quantity(value, newest.unit))
    axes.yaxis.set_minor_formatter(lambda *_: "")
    axes.set_xticks(range(len(versions)), [tick_text(one) for one in versions], fontsize=7)
    axes.margins(y=0.15)
    axes.set_xlim(-0.5, len(versions) - 0.5)
    axes.grid(visible=True)


def _set_scale(axes: Axes, values: Sequence[float]) -> None:
    positive = [value for value in values if value > 0.0]
    if len(positive) == len(values) and max(positive) > WIDE_RANGE * min(positive):
        axes.set_yscale("log")


def tick_text(version: Version) -> str:
    """Return the revision that was measured and the day, on two lines."""
    return f"{revision_text(version)}\n{version.date[:10]}"


def revision_text(version: Version) -> str:
    """Return the revision that was measured, short; + where files differed from it."""
    return (version.revision[:7] or "unknown") + "+" * version.dirty

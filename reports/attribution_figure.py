"""What the differences are made of: model and step beside each other, with rounding, by engine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from reports import style
from validation.attribution import Attribution, Part, attributions_of
from validation.store import ResultsFolder

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 9.6
ROW = 0.17
"""Height of a scene in an engine's panel [inch]."""

FLOOR = 1e-17
"""Where bars begin [m]: below every rounding."""

MODEL, STEP = style.VERMILLION, style.SKY


def draw_attribution(results: ResultsFolder) -> Figure | None:
    """Draw the parts of each difference of a results folder; None where it has none."""
    return draw_parts(attributions_of(results))


def draw_parts(found: Sequence[Attribution]) -> Figure | None:
    """Draw a panel for each engine, with a row for each scene: its model's part and its step's.

    Parts span fourteen decades and add up as vectors, so they stand beside each other on a
    logarithmic axis: a stack would show the largest one alone.
    """
    divided = [one for one in found if one.model is not None]
    if not divided:
        return None
    labels = list(dict.fromkeys(one.label for one in divided))
    scenes = list(dict.fromkeys(one.scene for one in divided))
    columns = min(4, len(labels))
    rows = -(-len(labels) // columns)
    height = rows * (ROW * len(scenes) + 0.75) + 0.7
    figure = style.new_figure(WIDTH, height)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for axes, label in zip(grid, labels, strict=False):
        _draw_engine(axes, label, scenes, [one for one in divided if one.label == label])
    for axes in grid[len(labels) :]:
        axes.set_axis_off()
    grid[0].set_yticks(range(len(scenes)), scenes, fontsize=7.5)
    grid[0].set_ylim(len(scenes) - 0.4, -0.6)
    grid[0].set_xscale("log")
    grid[0].set_xlim(FLOOR, 2.0)
    style.set_length_ticks(grid[0], 1e-15, 1.0)
    for axes in grid:
        axes.tick_params(axis="x", labelsize=7.0, rotation=45)
    _add_legend(figure)
    style.set_title(figure, "What differences are made of: the model, or the step")
    return figure


def _draw_engine(
    axes: Axes, label: str, scenes: Sequence[str], found: Sequence[Attribution]
) -> None:
    for one in found:
        row = scenes.index(one.scene)
        for part, colour, offset in (
            (one.model, MODEL, -0.2),
            (one.discretisation, STEP, 0.2),
        ):
            if part is not None:
                _draw_part(axes, part, colour, row + offset)
        if one.rounding:
            axes.plot(one.rounding, row, "|", color=style.BLACK, markersize=6, zorder=4)
    axes.set_title(style.engine_name(label), fontsize=8.5)
    axes.tick_params(axis="y", length=0)
    axes.grid(True, axis="x")


def _draw_part(axes: Axes, part: Part, colour: str, y: float) -> None:
    """Draw a part as a bar to its size; pale where it is below its uncertainty."""
    known = part.size > part.uncertainty
    end = max(part.size if known else part.uncertainty, FLOOR)
    axes.barh(
        y, end - FLOOR, left=FLOOR, height=0.36, color=colour, alpha=1.0 if known else 0.3, zorder=2
    )
    if known and np.isfinite(part.uncertainty):
        low = max(part.size - part.uncertainty, FLOOR)
        axes.plot(
            [low, part.size + part.uncertainty], [y, y], color=style.BLACK, linewidth=0.8, zorder=3
        )


def _add_legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D  # noqa: PLC0415
    from matplotlib.patches import Patch  # noqa: PLC0415

    handles = [
        Patch(color=MODEL, label="model"),
        Patch(color=STEP, label="step"),
        Patch(color=style.GREY, alpha=0.3, label="pale: at most, not told from 0"),
        Line2D([], [], color=style.BLACK, linewidth=0.8, label="uncertainty"),
        Line2D(
            [], [], linestyle="none", marker="|", color=style.BLACK, label="an ulp of the input"
        ),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5)

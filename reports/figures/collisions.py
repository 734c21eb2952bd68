"""How many collisions each engine counted, by kind."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ghostball.reports import style
from ghostball.reports.figures._rows import draw_row_notes, row_height, set_row_names
from ghostball.reports.figures.paths import WIDTH
from ghostball.reports.shots import Shot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_collisions(shot: Shot) -> Figure | None:
    """Draw the counts as bars, a panel for each kind of collision that any engine saw.

    None where there was no collision at all, or one alone of several engines could run.
    """
    if shot.one_of_several:
        return None
    kinds: dict[str, None] = {}
    for run in shot.runs:
        if run.case is not None:
            kinds |= dict.fromkeys(k for k, count in run.case.collision_counts.items() if count)
    if not kinds:
        return None
    figure = style.new_figure(WIDTH, row_height(shot) + 0.95)
    grid = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    for axes, kind in zip(grid, sorted(kinds), strict=True):
        _draw_kind(axes, shot, kind)
        axes.tick_params(axis="y", length=0)
    set_row_names(grid[0], shot)
    style.set_title(
        figure,
        f"{shot.scene.name}: collisions counted (dashed: {_truth_name(shot)})",
    )
    return figure


def _draw_kind(axes: Axes, shot: Shot, kind: str) -> None:
    from matplotlib.patheffects import withStroke  # noqa: PLC0415
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415

    for row, run in enumerate(shot.runs):
        if run.case is None or run.case.outcome != "ran":
            continue
        count = run.case.collision_counts.get(kind, 0)
        axes.barh(row, count, height=0.62, color=run.style.colour, zorder=2)
        number = axes.annotate(
            f"{count}",
            (count, row),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=8.5,
            zorder=4,
        )
        # The line of the truth may run through it.
        number.set_path_effects([withStroke(linewidth=3.0, foreground="white")])
    if shot.truth_counts is not None:
        axes.axvline(
            shot.truth_counts.get(kind, 0),
            color=style.BLACK,
            linestyle="--",
            linewidth=0.9,
            zorder=3,
        )
    axes.set_xlim(0.0, 1.18 * max(1.0, axes.get_xlim()[1]))
    axes.set_xlabel(f"{kind} collisions [1]")
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    axes.grid(True, axis="x")
    draw_row_notes(axes, shot)


def _truth_name(shot: Shot) -> str:
    return "no truth known" if shot.truth_counts is None else f"truth, {shot.truth}"

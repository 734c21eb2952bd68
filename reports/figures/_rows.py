"""One row for each engine: what the bar figures share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ghostball.reports import style
from ghostball.reports.shots import Shot

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def row_height(shot: Shot) -> float:
    """Height that the rows of all engines need [inch]."""
    return max(1.0, 0.27 * len(shot.runs))


def set_row_names(axes: Axes, shot: Shot) -> None:
    """Name the rows on the left axis, the first engine on top."""
    axes.set_yticks(range(len(shot.runs)), [run.style.name for run in shot.runs])
    axes.set_ylim(len(shot.runs) - 0.45, -0.55)
    axes.tick_params(axis="y", length=0)


def draw_row_notes(axes: Axes, shot: Shot) -> None:
    """Say in the row of an engine that did not run why there is no bar."""
    for row, run in enumerate(shot.runs):
        if run.case is None or run.case.outcome != "ran":
            axes.text(
                0.012,
                row,
                run.verdict.words,
                transform=axes.get_yaxis_transform(),
                va="center",
                fontsize=8.5,
                fontstyle="italic",
                color=style.GREY,
            )

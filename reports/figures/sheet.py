"""Draw one sheet for each scene, with all engines.

It shows the rest positions, and against time the number of collisions, the energy, and the distance
of the balls from those of Ghostball's engine. Below are the numbers of each engine.
"""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from ghostball.reports import style
from ghostball.reports.accuracy import cell_text
from ghostball.reports.figures._table import View, draw_discs, draw_scale_bar, draw_table
from ghostball.reports.figures.heights import draw_heights, flying
from ghostball.reports.figures.paths import (
    draw_against_time,
    draw_motion,
    is_collinear,
    label_balls,
    line_of,
    median_end,
    view_shown,
)
from ghostball.reports.shots import (
    ERROR_FLOOR,
    Run,
    Shot,
    collision_times,
    energy_scale,
    error_curves,
    legend_text,
    motion_of_run,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WIDTH, HEIGHT = 13.0, 7.0
"""Size of a sheet [inch]; with many engines it is higher, by a row for each."""

MARGIN, TITLE, FOOT = 0.3, 0.66, 0.3
"""Margins to the left, at the top and at the bottom [inch]."""

TABLE_WIDTH, TABLE_HEIGHT = 6.6, 3.45
"""Size of the picture of the table [inch]."""

TIME_LEFT, TIME_WIDTH = 8.15, 4.7
"""Left edge and width of the panels against time [inch]."""

ROW_HEIGHT = 0.215
"""Height of an engine's row of numbers [inch]."""

ROWS = 9
"""Number of rows that fit at the usual height."""

DPI = 110
"""Pixels per inch of a PNG sheet, which is then 1430 pixels wide."""

SAMPLE = (0.3, 0.75)
"""Left and right end of an engine's sample line [inch]."""

COLUMNS = (0.87, 2.35, 5.3, 6.3)
"""Left edges of the name, the accuracy and the two counts [inch]."""

LETTERS = 118
"""Number of letters that fit into a line below the numbers."""

WRONG = "#A84300"
"""Colour of a wrong count, with a contrast of 6.1 : 1 to white."""


def draw_sheet(shot: Shot) -> Figure | None:
    """Return the sheet of a scene, or None if no engine has a motion."""
    if not shot.drawn:
        return None
    notes = _notes(shot)
    height = HEIGHT + ROW_HEIGHT * max(0, len(shot.drawn) + len(notes) - ROWS)
    figure = style.new_figure(WIDTH, height, laid_out=False)
    figure.dpi = DPI

    def place(left: float, top: float, width: float, high: float) -> Axes:
        """Return axes at a distance from the left and the upper edge [inch]."""
        box = (left / WIDTH, 1.0 - (top + high) / height, width / WIDTH, high / height)
        return figure.add_axes(box)

    title = f"{shot.scene.name}: {shot.scene.title}"
    figure.text(0.25 / WIDTH, 1.0 - 0.27 / height, title, fontsize=12, fontweight="bold")
    _draw_cloth(place, shot)
    _draw_numbers(figure, shot, TITLE + TABLE_HEIGHT + 0.3, notes)
    flies = bool(flying(shot).any())
    # Tick labels are below the last panel against time, and below the panel of heights.
    room = (height - TITLE - FOOT - 0.2 * flies) / (3.0 + flies)
    end = 1.02 * median_end(shot)
    panels = (_draw_collisions, _draw_energy, _draw_errors)
    for row, draw in enumerate(panels):
        axes = place(TIME_LEFT, TITLE + row * room, TIME_WIDTH, room - 0.42)
        draw(axes, shot)
        axes.set_xlim(0.0, end)
        axes.grid(visible=True)
        axes.tick_params(labelbottom=row == len(panels) - 1)
    axes.set_xlabel("time [s]")
    if flies:
        axes = place(TIME_LEFT, TITLE + 0.2 + 3.0 * room, TIME_WIDTH, room - 0.42)
        draw_heights(axes, shot, lambda run, _: _curve_look(run, shot.drawn.index(run)))
        _set_title(axes, "Ball heights [mm] against time [s], until all stay on the cloth")
    return figure


def _draw_cloth(place: Any, shot: Shot) -> None:
    """Draw start, paths and rest positions; for balls on one line also x against time."""
    collinear = is_collinear(shot)
    view = view_shown(shot, collinear)
    room = 0.9 if collinear else TABLE_HEIGHT
    axes = place(MARGIN, TITLE, TABLE_WIDTH, room)
    draw_table(axes, shot.scene, view, ticks=False)
    axes.set_anchor("NW")
    draw_scale_bar(axes, view, *_scale(view))
    metres_to_a_point = max((view[1] - view[0]) / TABLE_WIDTH, (view[3] - view[2]) / room) / 72.0
    radii, starts, truth = shot.scene.radii, shot.scene.positions, shot.truth_positions
    draw_discs(axes, starts, radii, facecolors=style.FAINT, edgecolors=style.GREY, zorder=1.5)
    if truth is not None:
        draw_discs(axes, truth, radii, facecolors="none", edgecolors=style.BLACK, zorder=3)
    for order, run in enumerate(shot.drawn):
        if not shot.has_many_balls:
            draw_motion(axes, run, zorder=2 + 0.01 * order, **line_of(run))
        rest = None if run.case is None else run.case.rest_positions
        if rest is not None and not (run.style.ours and truth is not None):
            axes.plot(rest[:, 0], rest[:, 1], zorder=4 + 0.01 * order, **_marker(run))
    if not shot.has_many_balls:
        names = zip((ball.id for ball in shot.scene.balls), starts, radii, strict=True)
        label_balls(axes, list(names), metres_to_a_point, motion_of_run(shot.drawn[0]).positions)
    where = "rest" if shot.end == "rest" else "are at the end"
    _set_title(axes, f"Where the balls {where} (ring: reference; grey disc: start)")
    if collinear:
        beneath = place(
            MARGIN + 0.3, TITLE + room + 0.3, TABLE_WIDTH - 0.3, TABLE_HEIGHT - room - 0.6
        )
        draw_against_time(beneath, shot)


def _draw_collisions(axes: Axes, shot: Shot) -> None:
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415

    most = 0
    for order, run in enumerate(shot.drawn):
        times = collision_times(motion_of_run(run))
        most = max(most, len(times))
        steps = np.concatenate(([0.0], times, [motion_of_run(run).times[-1]]))
        counts = np.minimum(np.arange(len(steps)), len(times))
        axes.step(steps, counts, where="post", **_curve_look(run, order))
    if shot.truth_counts is not None:
        true = sum(shot.truth_counts.values())
        most = max(most, true)
        axes.axhline(true, color=style.BLACK, linestyle=(0.0, (1.0, 2.0)), linewidth=1.0, zorder=3)
    axes.set_ylim(0.0, 1.08 * max(most, 1))
    axes.yaxis.set_major_locator(MaxNLocator(4, integer=True))
    dotted = "" if shot.truth_counts is None else " (dotted: reference total)"
    _set_title(axes, f"Collisions so far{dotted}")


def _draw_energy(axes: Axes, shot: Shot) -> None:
    unit, name, highest = energy_scale(shot)
    for order, run in enumerate(shot.drawn):
        motion = motion_of_run(run)
        axes.plot(motion.times, motion.energy / unit, **_curve_look(run, order))
    axes.set_ylim(0.0, 1.05 * highest / unit or 1.0)
    _set_title(axes, f"Total energy [{name}]")


def _draw_errors(axes: Axes, shot: Shot) -> None:
    """Draw the largest distance of a ball from its position on Ghostball's engine."""
    _set_title(axes, "Largest distance of a ball from Ghostball's result")
    curves, most = error_curves(shot)
    if not curves:
        axes.text(0.5, 0.5, "only one engine", transform=axes.transAxes, ha="center")
        axes.set_yticks([])
        return
    for order, (run, distance) in enumerate(curves):
        axes.plot(motion_of_run(run).times, distance, **_curve_look(run, order))
    axes.set_yscale("log")
    top = min(2.0 * most, 1e3)
    axes.set_ylim(0.7 * ERROR_FLOOR, top)
    exponents = range(-5, 1 + int(np.log10(top)))
    axes.set_yticks(
        [10.0**e for e in exponents], [style.format_length(float(f"1e{e}")) for e in exponents]
    )
    axes.minorticks_off()


def _draw_numbers(figure: Figure, shot: Shot, top: float, notes: Sequence[str]) -> None:
    """Write a row for each engine with a motion: its line and its numbers.

    The rows are on the figure itself, `top` inches below its edge, because creating axes takes
    longer than writing the rows.
    """
    from matplotlib.lines import Line2D  # noqa: PLC0415

    high = figure.get_figheight()
    true = shot.truth_counts
    heads = ("accuracy", "ball-ball", "ball-cushion")

    def write(x: float, row: int, text: str, colour: str = style.BLACK) -> None:
        y = 1.0 - (top + ROW_HEIGHT * row) / high
        figure.text(x / WIDTH, y, text, va="center", fontsize=8.5, color=colour)

    for x, head in zip(COLUMNS[1:], heads, strict=True):
        write(x, 0, head, style.GREY)
    for row, run in enumerate(shot.drawn, start=1):
        y = 1.0 - (top + ROW_HEIGHT * row) / high
        sample = [x / WIDTH for x in SAMPLE]
        figure.add_artist(Line2D(sample, [y, y], **line_of(run)))
        if not run.style.ours:
            figure.add_artist(Line2D([0.5 * sum(sample)], [y], **_marker(run)))
        write(COLUMNS[0], row, run.style.name)
        write(COLUMNS[1], row, cell_text(run.case))
        for x, kind in zip(COLUMNS[2:], heads[1:], strict=True):
            count = 0 if run.case is None else run.case.collision_counts.get(kind, 0)
            right = None if true is None else true.get(kind, 0)
            if right is None or count == right:
                write(x, row, f"{count}" if right is None else f"{count} of {right}")
            else:
                write(x, row, f"{count} of {right} ≠", WRONG)
    for row, note in enumerate(notes, start=len(shot.drawn) + 1):
        write(SAMPLE[0], row, note, style.GREY)


def _notes(shot: Shot) -> list[str]:
    """Return lines of notes: kind of reference, meaning of signs, engines without a motion."""
    slides = "Thick lines: sliding. " * (shot.slides and not shot.has_many_balls)
    signs = legend_text(run.verdict for run in shot.drawn)
    said = [f"Reference: {shot.truth or 'none'}. {slides}{signs}."]
    reasons: dict[str, list[str]] = {}
    for run in shot.runs:
        if run.motion is None:
            reasons.setdefault(run.verdict.words, []).append(run.style.name)
    said += [f"{why}: {'; '.join(names)}" for why, names in reasons.items()]
    return [line for one in said for line in wrap(one, LETTERS, break_on_hyphens=False)]


def _scale(view: View) -> tuple[float, str]:
    """Return a suitable length for the scale bar of a picture [m], and its name."""
    length = 10.0 ** np.floor(np.log10(0.4 * (view[1] - view[0])))
    return float(length), style.format_length(float(length))


def _set_title(axes: Axes, text: str) -> None:
    """Write a title at a fixed height; computing a height takes as long as drawing a panel."""
    axes.set_title(text, y=1.0)


def _curve_look(run: Run, order: int) -> dict[str, Any]:
    """Return the style of a curve; Ghostball's is a band beneath the others."""
    return line_of(run) | {"zorder": 2 + 0.01 * order}


def _marker(run: Run) -> dict[str, Any]:
    return {
        "linestyle": "none",
        "marker": run.style.marker,
        "markersize": 5.5,
        "markerfacecolor": "none",
        "markeredgecolor": run.style.colour,
        "markeredgewidth": 1.2,
    }

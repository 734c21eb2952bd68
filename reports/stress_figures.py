"""Figures of a stress run, each drawn only where the run has what it shows.

They read the `values` of findings, by these names alone, whatever the family:

- `depth` and `missed`, with a kind in the family "grazing": a collision wrongly seen or not seen;
- `energy_error` with `dt`: by how much the energy at the end is off, over the first; also in each
  entry of a list `ladder`, which says how it depends on the step. Without `dt`: of no step;
- `energy_drift` with `collisions`, and `curve`, pairs of both: how an elastic gas keeps its energy;
- `packing`, `state`, `error` and `literature`: p/nkT of a gas, its standard error, the right one;
- `events`, `contact_steps` and `seconds`: lists with a number for each break;
- `speed`, `depth`, `step`, `missed` and `largest_step`, with a `ladder` of `dt` and `missed`: the
  largest step without a miss, and its cliff.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ghostball.reports import style
from ghostball.validation.stress import Finding, StressFolder
from ghostball.validation.stress.tracked import COUNTS, cliffs, has_cliff, ladder_of, storm_counts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

WIDTH = 8.8

EXACT = 1e-17
"""Where an energy error of exactly 0 is drawn: below every rounding."""

_CLIFF_NOTE = ("Steps in ms.", "≥: none of the ladder misses.", "Framed: misses at its own step.")

NOTE_WIDTH = 5.5
"""Width of a figure [inch] that has room for these in one line."""


def draw_miss_rates(folder: StressFolder) -> Figure | None:
    """Draw how often a collision is missed, or seen where there is none, against depth."""
    found = [
        one
        for one in folder.findings
        if one.family == "grazing" and one.values.get("depth") and "missed" in one.values
    ]
    labels = _labels(folder, found)
    if not labels:
        return None
    figure = style.new_figure(WIDTH, 3.9)
    panels = figure.subplots(1, 2, sharey=True)
    titles = ("hits that are missed", "misses that are seen as hits")
    for axes, sign, title in zip(panels, (1.0, -1.0), titles, strict=True):
        for label in labels:
            mine = [one for one in found if one.label == label and sign * one.values["depth"] > 0.0]
            _plot(axes, label, _rates(mine))
        axes.set(xscale="log", xlabel="depth of the path [diameters]", ylim=(-0.04, 1.04))
        _name_powers(axes.xaxis)
        axes.set_title(title, fontsize=9)
        axes.grid(visible=True)
    panels[0].set_ylabel("part of the shots")
    panels[0].yaxis.set_major_formatter(lambda part, _: f"{100.0 * part:.0f} %")
    _add_legend(figure, panels)
    style.set_title(figure, "Grazing shots that are judged wrongly, against how they graze")
    return figure


def _rates(found: Sequence[Finding]) -> list[tuple[float, float]]:
    """Return depth, of each decade, and the part of the shots there that were wrong."""
    decades: dict[int, list[bool]] = {}
    for one in found:
        decade = round(math.log10(abs(one.values["depth"])))
        decades.setdefault(decade, []).append(bool(one.values["missed"]))
    return [(10.0**decade, sum(wrong) / len(wrong)) for decade, wrong in sorted(decades.items())]


def draw_energy_errors(folder: StressFolder) -> Figure | None:
    """Draw by how much the energy is off, against the step of an engine and against collisions.

    Each trial with a ladder of steps has a panel, in which an engine without steps is a level line;
    all that is known against collisions is in one.
    """
    trials = list(
        dict.fromkeys(
            (one.family, one.trial) for one in folder.findings if len(energy_against_step(one)) > 1
        )
    )
    against = [one for one in folder.findings if energy_against_collisions(one)]
    if not trials and not against:
        return None
    figure = style.new_figure(WIDTH, 4.1)
    grid = figure.subplots(1, len(trials) + bool(against), sharey=True, squeeze=False)[0]
    for axes in grid:
        axes.set(xscale="log", yscale="log")
        _name_powers(axes.xaxis, axes.yaxis)
        axes.grid(visible=True)
    for axes, trial in zip(grid, trials, strict=False):
        _draw_ladders(axes, [one for one in folder.findings if (one.family, one.trial) == trial])
        axes.set_title(trial[1].replace("-", " "), fontsize=9)
    for one in against:
        points = energy_against_collisions(one)
        _plot(grid[-1], one.label, [(x, max(y, EXACT)) for x, y in points])
    if against:
        grid[-1].set_xlabel("collisions")
        grid[-1].set_title("against collisions", fontsize=9)
    grid[0].set_ylabel("energy error, over the first energy [1]")
    grid[0].set_ylim(bottom=EXACT / 3.0)
    _add_legend(figure, grid)
    style.set_title(figure, "Error of the energy")
    return figure


def _draw_ladders(axes: Axes, found: Sequence[Finding]) -> None:
    """Draw the energy error of each engine against its step; of one without steps a level line."""
    for one in found:
        _plot(axes, one.label, [(x, max(y, EXACT)) for x, y in energy_against_step(one)])
    for one in found:
        if _is_number(one.values.get("energy_error")) and "dt" not in one.values:
            look = style.engine_style(one.label)
            axes.axhline(
                max(one.values["energy_error"], EXACT),
                color=look.colour,
                linestyle=look.line,
                linewidth=look.line_width,
                alpha=look.line_alpha,
                label=look.name,
            )
    axes.set_xlabel("step [s]")


def energy_against_step(one: Finding) -> list[tuple[float, float]]:
    """Return steps [s] and what a finding says of the energy error at each, in order."""
    points = {
        float(entry["dt"]): float(entry["energy_error"])
        for entry in [one.values, *ladder_of(one)]
        if _is_number(entry.get("dt")) and _is_number(entry.get("energy_error"))
    }
    return sorted(points.items())


def energy_against_collisions(one: Finding) -> list[tuple[float, float]]:
    """Return numbers of collisions and by how much the energy has drifted at each, in order."""
    points = {}
    if _is_number(one.values.get("energy_drift")) and _is_number(one.values.get("collisions")):
        points[float(one.values["collisions"])] = abs(float(one.values["energy_drift"]))
    curve = one.values.get("curve")
    for pair in curve if isinstance(curve, list) else []:
        points[float(pair[0])] = abs(float(pair[1]))
    return sorted(points.items())


def draw_equation_of_state(folder: StressFolder) -> Figure | None:
    """Draw by how much p/nkT of elastic gases is off the literature's, with standard errors."""
    found = [
        one
        for one in folder.findings
        if all(_is_number(one.values.get(n)) for n in ("packing", "state", "error", "literature"))
    ]
    if not found:
        return None
    figure = style.new_figure(WIDTH, 3.6)
    axes = figure.subplots()
    axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    for label in _labels(folder, found):
        look = style.engine_style(label)
        mine = [one.values for one in found if one.label == label]
        axes.errorbar(
            [values["packing"] for values in mine],
            [values["state"] / values["literature"] - 1.0 for values in mine],
            yerr=[values["error"] / values["literature"] for values in mine],
            color=look.colour,
            linestyle="none",
            marker=look.marker,
            markersize=4.0,
            capsize=2.0,
            label=look.name,
        )
    axes.set(xlabel="part of the area that discs cover [1]", ylabel="p/nkT over the right one, - 1")
    axes.grid(visible=True)
    _add_legend(figure, [axes])
    style.set_title(figure, "Equation of state of hard discs, with standard errors")
    return figure


def draw_storms(folder: StressFolder) -> Figure | None:
    """Draw how many breaks need more than so many events, contact steps and seconds."""
    counts = {label: of for label in folder.run.labels if (of := storm_counts(folder, label))}
    most = max((len(of["events"]) for of in counts.values()), default=0)
    # An engine that played a handful of them has no distribution to show.
    counts = {label: of for label, of in counts.items() if len(of["events"]) >= most / 10.0}
    if not counts:
        return None
    figure = style.new_figure(WIDTH, 3.7)
    panels = figure.subplots(1, len(COUNTS), sharey=True)
    for axes, (name, text) in zip(panels, COUNTS.items(), strict=True):
        for label, of in counts.items():
            values = np.sort(of[name])
            above = 1.0 - np.arange(len(values)) / len(values)
            look = style.engine_style(label)
            shown = values > 0.0
            axes.step(
                values[shown],
                above[shown],
                where="post",
                color=look.colour,
                label=f"{look.name}, {len(values)} breaks",
            )
        axes.set(xscale="log", yscale="log", xlabel=text)
        _name_powers(axes.xaxis, axes.yaxis)
        axes.grid(visible=True)
    panels[0].set_ylabel("part of the breaks that need as many")
    _add_legend(figure, panels)
    style.set_title(figure, "What random breaks need")
    return figure


def draw_cliffs(folder: StressFolder) -> Figure | None:
    """Draw for each engine that steps the largest step without a miss, by speed and depth."""
    from matplotlib.colors import LogNorm  # noqa: PLC0415

    maps = {label: of for label in folder.run.labels if (of := cliffs(folder, label))}
    if not maps:
        return None
    shown = [one for of in maps.values() for one in of]
    speeds = sorted({one.values["speed"] for one in shown})
    depths = sorted({one.values["depth"] for one in shown}, reverse=True)
    steps = [rung["dt"] for one in shown for rung in ladder_of(one)]
    columns = min(3, len(maps))
    rows = -(-len(maps) // columns)
    width = 0.9 + columns * max(2.2, 0.62 * len(speeds))
    note = (" " if width >= NOTE_WIDTH else "\n").join(_CLIFF_NOTE)
    height = 1.0 + rows * (0.75 + 0.34 * len(depths)) + 0.16 * note.count("\n")
    figure = style.new_figure(width, height)
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    norm = LogNorm(min(steps), max(steps))
    for axes, (label, found) in zip(grid.ravel(), maps.items(), strict=False):
        _draw_map(axes, found, speeds, depths, norm)
        own = found[0].values["step"]
        name = style.engine_name(label)
        axes.set_title(f"{name}\nown step {style.format_time(own)}", fontsize=8.5)
    for axes in grid.ravel()[len(maps) :]:
        axes.set_axis_off()
    for axes in grid[:, 0]:
        axes.set_ylabel("depth [diameters]")
    for axes in grid.ravel()[max(0, len(maps) - columns) : len(maps)]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("speed [m/s]")
    figure.supxlabel(note, fontsize=8.5)
    style.set_title(figure, "Largest step without a miss")
    return figure


def _draw_map(
    axes: Axes,
    found: Sequence[Finding],
    speeds: Sequence[float],
    depths: Sequence[float],
    norm: Callable[[float], Any],
) -> None:
    from matplotlib import colormaps  # noqa: PLC0415
    from matplotlib.patches import Rectangle  # noqa: PLC0415

    colours = colormaps["cividis"]
    for one in found:
        column, row = speeds.index(one.values["speed"]), depths.index(one.values["depth"])
        step = one.values["largest_step"]
        shade = 0.0 if step is None else float(norm(step))
        axes.add_patch(
            Rectangle(
                (column - 0.5, row - 0.5), 1.0, 1.0, facecolor=colours(shade), edgecolor="white"
            )
        )
        if one.values["missed"]:
            axes.add_patch(
                Rectangle(
                    (column - 0.46, row - 0.44),
                    0.92,
                    0.88,
                    fill=False,
                    edgecolor=style.VERMILLION,
                    linewidth=2.0,
                    zorder=3,
                )
            )
        axes.text(
            column,
            row,
            _step_text(one),
            ha="center",
            va="center",
            fontsize=8,
            color="white" if shade < 0.55 else style.BLACK,
        )
    axes.set_xlim(-0.5, len(speeds) - 0.5)
    axes.set_ylim(len(depths) - 0.5, -0.5)
    axes.set_xticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
    axes.set_yticks(range(len(depths)), [f"{depth:g}" for depth in depths])
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)


def _step_text(one: Finding) -> str:
    step = one.values["largest_step"]
    if step is None:
        return "none"
    number = f"{1e3 * step:.0f}" if step >= 0.01 else f"{1e3 * step:.2g}"
    return number if has_cliff(one) else f"≥ {number}"


FIGURES: dict[str, Callable[[StressFolder], Figure | None]] = {
    "miss-rate": draw_miss_rates,
    "energy": draw_energy_errors,
    "equation-of-state": draw_equation_of_state,
    "storms": draw_storms,
    "cliffs": draw_cliffs,
}
"""All figures, by the name of their files."""


def _name_powers(*axes: Axis) -> None:
    """Write powers of ten at the ticks of logarithmic axes, and nothing between them."""
    for axis in axes:
        axis.set_major_formatter(lambda x, _: style.power_of_ten(round(math.log10(x))))
        axis.set_minor_formatter(lambda _x, _: "")


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and math.isfinite(value)


def _labels(folder: StressFolder, found: Sequence[Finding]) -> list[str]:
    there = {one.label for one in found}
    return [label for label in folder.run.labels if label in there]


def _plot(axes: Axes, label: str, points: Sequence[tuple[float, float]]) -> None:
    if not points:
        return
    look = style.engine_style(label)
    axes.plot(
        [x for x, _ in points],
        [y for _, y in points],
        color=look.colour,
        linestyle=look.line,
        linewidth=look.line_width,
        alpha=look.line_alpha,
        marker=look.marker,
        markersize=4.0,
        zorder=2 if look.ours else 3,
        label=look.name,
    )


def _add_legend(figure: Figure, panels: Sequence[Axes]) -> None:
    found: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    figure.legend([*found.values()], [*found], loc="outside lower center", ncols=4)

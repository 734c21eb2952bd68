"""How the members of an ensemble end: clouds of rest positions, collision counts, energy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import Scene
from ghostball.reports import style
from ghostball.reports.figures._table import View, aspect_of, draw_table, view_of
from ghostball.validation.ensembles import (
    ENERGY_PARTS,
    REFERENCE,
    EnsembleRecord,
    Ensembles,
    Members,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

FloatArray = NDArray[np.float64]

WIDTH = 9.6
COLUMNS = 3
KINDS = ("ball-ball", "ball-cushion")
BAND = (5.0, 95.0)
"""Percent of the members between which a band or a thin bar reaches."""

QUARTILES = (25.0, 50.0, 75.0)
PARTS_HIGH = {"counts": 0.85, "energy": 2.9}
"""Height of what is the same for any number of engines [inch]."""

ROW = 0.235
"""Height of an engine's row of counts [inch]."""


@dataclass(frozen=True, eq=False)
class _Run:
    """One engine's ensemble with its look."""

    record: EnsembleRecord
    members: Members

    @property
    def style(self) -> style.EngineStyle:
        return style.engine_style(self.record.label)


def draw_ensemble(ensembles: Ensembles, scene: str) -> Figure | None:
    """Draw how the members of one scene's ensembles end; None where no member came to its end."""
    runs = [
        _Run(record, members)
        for record in ensembles.of(scene).values()
        if len(members := ensembles.members(record))
    ]
    if not runs:
        return None
    shot = runs[0].record.load_scene()
    ours = next((run for run in runs if run.record.label == REFERENCE), None)
    view = _view(shot, runs if ours is None else [ours])
    rows = -(-len(runs) // COLUMNS)
    columns = min(COLUMNS, max(2, len(runs)))  # one alone would fill a page
    clouds = rows * (WIDTH / columns * min(aspect_of(view), 1.0) + 0.25) + 0.35
    counts = PARTS_HIGH["counts"] + ROW * len(runs)
    heights = [clouds, counts, PARTS_HIGH["energy"]]
    figure = style.new_figure(WIDTH, sum(heights))
    top, middle, bottom = figure.subfigures(3, 1, squeeze=False, height_ratios=heights)[:, 0]
    _draw_clouds(top, shot, runs, ours, view, (rows, columns))
    _draw_counts(middle, runs, ours)
    _draw_energy(bottom, runs, ours)
    return figure


def _view(scene: Scene, runs: Sequence[_Run]) -> View:
    # A ball that one engine lost far away must not shrink the others' clouds to a dot.
    ends = np.concatenate([run.members.rest_positions.reshape(-1, 2) for run in runs])
    return view_of(scene, ends, needed=ends)


def _draw_clouds(
    part: SubFigure,
    scene: Scene,
    runs: Sequence[_Run],
    ours: _Run | None,
    view: View,
    shape: tuple[int, int],
) -> None:
    grid = part.subplots(*shape, squeeze=False).ravel()
    for axes, run in zip(grid, runs, strict=False):
        draw_table(axes, scene, view, ticks=False)
        if ours is not None and run is not ours:
            _scatter(axes, ours, style.FAINT, 2.0)
        _scatter(axes, run, run.style.colour, 3.0)
        axes.set_title(run.style.name, fontsize=9.5)
        axes.set_title(_ended_text(run), fontsize=8.5, fontweight="normal", loc="right")
    for axes in grid[len(runs) :]:
        axes.set_axis_off()
    table = scene.table
    size = "" if table is None else f"; table {table.length:g} m × {table.width:g} m"
    count = max(len(run.members) for run in runs)
    style.set_title(part, f"{scene.name}: where all balls of {count} perturbed shots end{size}")
    if ours is not None and len(runs) > 1:
        part.supxlabel(
            f"Grey beneath: the same shots in {ours.style.name}", fontsize=8.5, color=style.GREY
        )


def _scatter(axes: Axes, run: _Run, colour: str, zorder: float) -> None:
    ends = run.members.rest_positions.reshape(-1, 2)
    # So that a cloud is neither a blot nor dust.
    area = float(np.clip(2_500.0 / len(ends), 1.2, 9.0))
    axes.scatter(
        ends[:, 0], ends[:, 1], s=area, c=colour, alpha=0.55, linewidths=0.0, zorder=zorder
    )


def _ended_text(run: _Run) -> str:
    without = len(run.record.failed) + len(run.record.stopped)
    return f"{without} without an end" if without else ""


def _draw_counts(part: SubFigure, runs: Sequence[_Run], ours: _Run | None) -> None:
    """Draw a bar for each engine and kind: band thin, quartiles thick, the median as a mark."""
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415

    grid = part.subplots(1, len(KINDS), sharey=True)
    for kind, (axes, name) in enumerate(zip(grid, KINDS, strict=True)):
        if ours is not None:
            first, _, last = np.percentile(ours.members.counts[:, kind], QUARTILES)
            axes.axvspan(first, last, color=style.BLACK, alpha=0.08, linewidth=0, zorder=0)
        for row, run in enumerate(runs):
            counts = run.members.counts[:, kind]
            low, high = np.percentile(counts, BAND)
            first, median, last = np.percentile(counts, QUARTILES)
            look = {"color": run.style.colour, "solid_capstyle": "butt", "zorder": 2}
            axes.plot([low, high], [row, row], linewidth=1.2, **look)
            axes.plot([first, last], [row, row], linewidth=5.0, alpha=0.55, **look)
            axes.plot(
                [median],
                [row],
                marker=run.style.marker,
                color=run.style.colour,
                markeredgecolor="white",
                markeredgewidth=0.7,
                markersize=6.0,
                zorder=3,
            )
        axes.set_title(f"{name} collisions")
        # Where nothing collides, the axis would be one of rounding.
        left, right = axes.get_xlim()
        axes.set_xlim(min(left, np.floor(left + 0.5) - 0.5), max(right, np.ceil(right - 0.5) + 0.5))
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
        axes.grid(True, axis="x")
        axes.tick_params(axis="y", length=0)
    grid[0].set_yticks(range(len(runs)), [run.style.name for run in runs])
    grid[0].set_ylim(len(runs) - 0.4, -0.6)
    band = "" if ours is None else f". Grey: the thick bar of {ours.style.name}"
    part.supxlabel(
        f"collisions in a shot [1]. Mark: median; thick: half of the shots; thin: 90 %{band}",
        fontsize=9.0,
    )


def _draw_energy(part: SubFigure, runs: Sequence[_Run], ours: _Run | None) -> None:
    axes = part.subplots()
    scale = runs[0].record.energy_initial or 1.0
    times = runs[0].record.times
    for order, run in enumerate(runs):
        energy = run.members.energy / scale
        low, high = np.percentile(energy, BAND, axis=0)
        median = np.median(energy, axis=0)
        look = run.style
        if run is ours:
            axes.fill_between(times, low, high, color=look.colour, alpha=0.14, linewidth=0)
        else:
            for edge in (low, high):
                axes.plot(times, edge, color=look.colour, linewidth=0.6, alpha=0.45, zorder=2)
        axes.plot(
            times,
            median,
            color=look.colour,
            linestyle=look.line,
            linewidth=2.2 if run is ours else 1.3,
            zorder=3 + 0.01 * order,
            label=look.name,
        )
    for instant in np.array(ENERGY_PARTS) * times[-1]:
        axes.axvline(instant, color=style.GREY, linestyle=":", linewidth=0.7, zorder=1)
    axes.set_xlim(0.0, float(times[-1]) or 1.0)
    highest = max(float(np.median(run.members.energy, axis=0).max()) for run in runs) / scale
    axes.set_ylim(0.0, 1.05 * min(max(highest, 1.0), 1.8))
    axes.set_xlabel("time [s]")
    axes.set_ylabel("energy / initial energy [1]")
    axes.set_title(
        f"Energy: medians, and the middle {BAND[1] - BAND[0]:.0f} % of the shots "
        "(dotted: instants that are compared)"
    )
    axes.grid(True)
    part.legend(loc="outside lower center", ncols=5, handlelength=3.2)

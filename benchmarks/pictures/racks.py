"""Draw the distribution of the run times of random racks, from a committed measurement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from benchmarks.racks import RacksMeasurement, RackTimes
from ghostball.reports import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 8.8, 4.6

MARKERS = {"median": "o", "mean": "D", "p99": "^", "greatest": "s"}
FIGURE_NAMES = {"p99": "99th percentile", "greatest": "slowest"}


def draw_racks(measured: RacksMeasurement) -> Figure:
    """Draw the cumulative distribution of the run times of each engine."""
    figure = style.new_figure(WIDTH, HEIGHT)
    axes = figure.subplots()
    for one in measured.engines:
        if one.seconds:
            _draw(axes, one)
    for name, marker in MARKERS.items():
        axes.plot(
            [],
            [],
            linestyle="",
            marker=marker,
            color=style.GREY,
            label=FIGURE_NAMES.get(name, name),
        )
    axes.set(xscale="log", ylim=(0.0, 1.05))
    axes.set(xlabel="run time of a rack [s]", ylabel="part of the racks [1]")
    axes.grid(visible=True)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    title = "Run times of random racks, half of them frozen: cumulative distribution"
    style.set_title(figure, f"{title} ({measured.where})")
    return figure


def _draw(axes: Axes, one: RackTimes) -> None:
    """Draw the distribution of an engine, with median, mean, 99th percentile and maximum."""
    figures = one.figures
    look = style.engine_style(one.engine)
    seconds = np.sort(one.seconds)
    part = np.arange(1, len(seconds) + 1) / len(seconds)
    label = f"{look.name}, {len(seconds)} racks"
    width = 2.0 if look.ours else 1.3
    axes.step(seconds, part, where="post", color=look.colour, linewidth=width, label=label)
    for name, marker in MARKERS.items():
        value = getattr(figures, name)
        height = np.count_nonzero(seconds <= value) / len(seconds)
        axes.plot([value], [height], marker=marker, color=look.colour, markersize=5.5, zorder=4)
        axes.annotate(
            style.format_time(value),
            (value, height),
            xytext=(-7.0, 3.0) if name == "p99" else (7.0, -9.0),  # away from the slowest's label
            textcoords="offset points",
            ha="right" if name == "p99" else "left",
            fontsize=7.5,
            color=look.colour,
        )

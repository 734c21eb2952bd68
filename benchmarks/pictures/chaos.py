"""How neighbouring shots part, and that the tangent map says so beforehand (the paper, 4.2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.pictures.neighbours import Neighbours, neighbours_of
from ghostball.reports import style
from ghostball.validation.grading.tolerances import TOLERANCE
from ghostball.validation.results.store import Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 9.6, 4.6

COLOURS = (style.VERMILLION, style.BLUE, style.GREEN, style.PURPLE)
"""Of the sizes of what the shots begin with, the largest first."""

_LOWEST = 1e-16
"""Least distance that is drawn [m]."""


def draw_chaos(results: Results) -> Figure | None:
    """Draw the distance of neighbouring shots against time; None where no scene is chaotic."""
    cases = {case.scene: case for case in results.cases if "chaos" in case.tags}
    shots = [(neighbours_of(case.load_scene()), case.shot_horizon) for case in cases.values()]
    if not shots:
        return None
    figure = style.new_figure(WIDTH, HEIGHT)
    panels = figure.subplots(1, len(shots), sharey=True, squeeze=False)[0]
    for axes, (shot, horizon) in zip(panels, shots, strict=True):
        _draw_panel(axes, shot, horizon)
    panels[0].set_ylabel("largest distance of a ball from its twin [m]")
    figure.legend(*_legend(panels[0]), loc="outside lower center", ncols=3, fontsize=8)
    style.set_title(
        figure, "Shots that begin almost alike: measured, and by the tangent map (dotted)"
    )
    return figure


def _draw_panel(axes: Axes, shot: Neighbours, horizon: float | None) -> None:
    ends = [separation.apart[-1] for separation in shot.separations]
    for separation, colour in zip(shot.separations, COLOURS, strict=False):
        label = f"{separation.size:g} m/s faster"
        axes.plot(shot.times, _shown(separation.apart), color=colour, linewidth=1.5, label=label)
        axes.plot(
            shot.times, _shown(separation.predicted), color=colour, linewidth=1.1, linestyle=":"
        )
    noise = 32.0 * 2.0**-53 * shot.growth
    axes.fill_between(
        shot.times,
        _LOWEST,
        np.maximum(noise, _LOWEST),
        color=style.FAINT,
        alpha=0.6,
        linewidth=0.0,
        label="within 32 roundings of our engine",
    )
    axes.axhline(TOLERANCE, color=style.GREY, linewidth=0.8, linestyle=(0.0, (4.0, 2.0)))
    if horizon is not None:
        axes.axvline(
            horizon,
            color=style.BLACK,
            linewidth=1.0,
            label=f"predictability horizon, for {style.format_length(TOLERANCE)}",
        )
        axes.annotate(
            f"{horizon:.2f} s",
            (horizon, _LOWEST),
            xytext=(3.0, 4.0),
            textcoords="offset points",
            fontsize=8,
        )
    axes.set(yscale="log", xlabel="time [s]", xlim=(0.0, shot.rest_time))
    axes.set_ylim(_LOWEST, max(30.0, 2.0 * max(ends)))
    axes.set_title(shot.scene, fontsize=9)
    axes.grid(visible=True)


def _shown(distances: Any) -> Any:
    """Return distances with nothing where there is none: a logarithm has no 0."""
    return np.where(distances > 0.0, distances, np.nan)


def _legend(axes: Axes) -> tuple[list[Any], list[str]]:
    handles, labels = axes.get_legend_handles_labels()
    return list(handles), [str(label) for label in labels]

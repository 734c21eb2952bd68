"""How the energy of all balls falls, and by how much each engine's differs from ours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ghostball.reports import style
from ghostball.reports.figures.paths import WIDTH
from ghostball.reports.shots import Run, Shot
from ghostball.validation.results.store import Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

DIFFERENCE_FLOOR = 1e-16
"""Smallest relative difference drawn: below it is rounding."""

UNITS = ((1e6, "MJ"), (1e3, "kJ"), (1.0, "J"))
"""Units of energy with the smallest one that they are for [J]; balls may be as heavy as cars."""

POINTS = 500
"""Instants at which two engines are compared."""


def draw_energy(shot: Shot) -> Figure | None:
    """Draw total energy against time, above its difference from our engine's.

    None where no engine has a motion.
    """
    if not shot.drawn:
        return None
    compared = shot.ours is not None and len(shot.drawn) > 1
    heights = [2.6, 1.9] if compared else [3.0]
    figure = style.new_figure(WIDTH, sum(heights) + 1.3)
    grid = figure.subplots(
        len(heights), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights}
    )[:, 0]
    _draw_total(grid[0], shot)
    if compared:
        _draw_difference(grid[1], shot)
    grid[-1].set_xlabel("time [s]")
    grid[-1].set_xlim(0.0, _end(shot))
    handles, _ = grid[0].get_legend_handles_labels()
    figure.legend(handles=handles, loc="outside lower center", ncols=5, handlelength=3.2)
    return figure


def _draw_total(axes: Axes, shot: Shot) -> None:
    # A band that others are drawn upon says little where there are no others.
    alone = len(shot.drawn) == 1
    unit, name = _unit(shot)
    for order, run in enumerate(shot.drawn):
        motion = _motion(run)
        look = run.style
        axes.plot(
            motion.times,
            motion.energy / unit,
            label=look.name,
            color=look.colour,
            linestyle=look.line,
            linewidth=1.3 if alone else look.line_width,
            alpha=1.0 if alone else look.line_alpha,
            zorder=2 + 0.01 * order,
        )
    # An engine that explodes must not flatten the others.
    highest = max(float(np.nanmax(_motion(run).energy)) for run in shot.drawn)
    axes.set_ylim(bottom=0.0, top=1.08 * min(highest, 1.8 * _start_energy(shot)) / unit)
    axes.set_ylabel(f"energy [{name}]")
    axes.set_title(f"{shot.scene.name}: kinetic energy of all balls, translation and rotation")
    axes.grid(True)


def _draw_difference(axes: Axes, shot: Shot) -> None:
    assert shot.ours is not None
    ours = _motion(shot.ours)
    times = np.linspace(0.0, _end(shot), POINTS)
    scale = _start_energy(shot)
    unit, name = _unit(shot)
    reference = np.interp(times, ours.times, ours.energy)
    for order, run in enumerate(shot.drawn):
        if run is shot.ours:
            continue
        motion = _motion(run)
        difference = np.abs(np.interp(times, motion.times, motion.energy) - reference) / scale
        axes.plot(
            times,
            np.maximum(difference, DIFFERENCE_FLOOR),
            color=run.style.colour,
            linestyle=run.style.line,
            linewidth=1.0,
            zorder=2 + 0.01 * order,
        )
    axes.set_yscale("log")
    axes.set_ylim(DIFFERENCE_FLOOR / 2.0, 3.0)
    exponents = range(-16, 1, 4)
    axes.set_yticks([10.0**e for e in exponents], [style.power_of_ten(e) for e in exponents])
    axes.minorticks_off()
    axes.set_ylabel("|difference| / E₀ [1]")
    axes.set_title(
        f"Difference from {shot.ours.style.name}, as a part of the initial energy "
        f"E₀ = {scale / unit:.4g} {name}"
    )
    axes.grid(True)


def _motion(run: Run) -> Motion:
    assert run.motion is not None
    return run.motion


def _start_energy(shot: Shot) -> float:
    return float(_motion(shot.drawn[0]).energy[0]) or 1.0


def _unit(shot: Shot) -> tuple[float, str]:
    """Return the unit of energy [J] that suits a shot, and its name."""
    energy = _start_energy(shot)
    return next(((unit, name) for unit, name in UNITS if energy >= unit), UNITS[-1])


def _end(shot: Shot) -> float:
    """When to stop the axis [s]: one engine that never rests must not squeeze the others."""
    ends = [float(_motion(run).times[-1]) for run in shot.drawn]
    ours = float(_motion(shot.ours).times[-1]) if shot.ours is not None else 0.0
    return 1.03 * max(ours, float(np.median(ends)))

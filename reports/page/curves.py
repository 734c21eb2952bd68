"""The charts of one scene: energy against time, and how far engines are from ours meanwhile."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.motions import (
    ERROR_FLOOR,
    distance_from,
    energy_scale,
    largest,
    motion_of_run,
)
from ghostball.reports.page.chart import Axis, Series, draw, linear_axis, log_axis
from ghostball.reports.shots import Run, Shot


def dash_of(look: style.EngineStyle) -> str:
    """Return an engine's line as SVG's `stroke-dasharray`; "" is a whole line."""
    return "" if isinstance(look.line, str) else " ".join(f"{part:g}" for part in look.line[1])


def colour_of(shot: Shot, run: Run) -> str:
    """Return an engine's colour as CSS: it differs between light and dark."""
    return f"var(--engine-{shot.runs.index(run)})"


def energy_chart(shot: Shot) -> Markup:
    """Draw the energy of all balls against time; "" where no engine has a motion."""
    if not shot.drawn:
        return Markup()
    unit, name, highest = energy_scale(shot)
    top = 1.05 * highest / unit
    series = [
        Series(
            run.style.name,
            colour_of(shot, run),
            motion_of_run(run).times,
            motion_of_run(run).energy / unit,
            dash_of(run.style),
            broad=run.style.ours and len(shot.drawn) > 1,
        )
        for run in shot.drawn
    ]
    title = f"Energy of all balls against time in scene {shot.scene.name}"
    return draw(title, series, _time_axis(shot), linear_axis(f"energy [{name}]", top))


def error_chart(shot: Shot, horizon: float | None = None) -> Markup:
    """Draw how far the balls of each engine are from ours; "" where there is nothing to compare.

    `horizon` [s]: until when the shot can be predicted.
    """
    ours = shot.ours
    others = [run for run in shot.drawn if not run.style.ours]
    if ours is None or not others:
        return Markup()
    reference = motion_of_run(ours)
    series, partings, most = [], [], 10.0 * ERROR_FLOOR
    for run in others:
        motion = motion_of_run(run)
        distance = distance_from(reference, motion)
        most = max(most, largest(distance))
        colour = colour_of(shot, run)
        drawn = np.maximum(distance, ERROR_FLOOR)
        series.append(Series(run.style.name, colour, motion.times, drawn, dash_of(run.style)))
        parted = run.metric("first_divergence_time")
        if parted is not None:
            said = f"{run.style.name}: first other collision at {style.format_time(parted)}"
            at = np.interp([parted], motion.times, drawn)
            partings.append(
                Series(said, colour, np.array([parted]), at, marker="✕", line=False, titles=[said])
            )
    marks = [] if horizon is None else [(horizon, "horizon")]
    title = f"Largest distance of a ball from our engine's against time in {shot.scene.name}"
    axis = log_axis("distance from ours", ERROR_FLOOR, min(most, 1e3), "m")
    return draw(title, [*series, *partings], _time_axis(shot), axis, marks)


def _time_axis(shot: Shot) -> Axis:
    return linear_axis("time [s]", max(float(motion_of_run(run).times[-1]) for run in shot.drawn))

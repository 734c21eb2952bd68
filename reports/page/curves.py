"""The charts of one scene: energy against time, and how far engines are from ours as it goes on."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from ghostball.reports import style
from ghostball.reports.figures.energy import UNITS
from ghostball.reports.page.chart import Axis, Mark, Series, draw, linear_axis, log_axis
from ghostball.reports.shots import Run, Shot
from ghostball.validation.results.store import Motion

FloatArray = NDArray[np.float64]

ERROR_FLOOR = 1e-5
"""Smallest distance drawn [m].

Frames are joined by straight lines, which run beside a ball that slows down:
0.01 mm for frames of 20 ms on a common cloth, ten times that where it slides.
"""


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
    # An engine that blew up has no energy to scale by, and one that explodes must not flatten all.
    start = max(_largest(_motion(run).energy[:1]) for run in shot.drawn)
    highest = max(_largest(_motion(run).energy) for run in shot.drawn)
    unit, name = next(
        ((scale, name) for scale, name in UNITS if start >= scale), (UNITS[-1][0], UNITS[-1][1])
    )
    top = 1.05 * min(highest, 1.8 * start) / unit
    series = [
        Series(
            run.style.name,
            colour_of(shot, run),
            _motion(run).times,
            _motion(run).energy / unit,
            dash_of(run.style),
            broad=run.style.ours and len(shot.drawn) > 1,
        )
        for run in shot.drawn
    ]
    title = f"Energy of all balls against time in scene {shot.scene.name}"
    return draw(title, series, _time_axis(shot), linear_axis(f"energy [{name}]", top))


def error_chart(shot: Shot, horizon: float | None = None) -> Markup:
    """Draw how far the balls of each engine are from ours; "" where there is nothing to compare.

    Parameters
    ----------
    shot : Shot
    horizon : float [s], optional
        Until when the shot can be predicted.
    """
    ours = shot.ours
    others = [run for run in shot.drawn if not run.style.ours]
    if ours is None or not others:
        return Markup()
    reference = _motion(ours)
    series, partings, largest = [], [], 10.0 * ERROR_FLOOR
    for run in others:
        motion = _motion(run)
        apart = distance_from(reference, motion)
        largest = max(largest, _largest(apart))
        colour = colour_of(shot, run)
        drawn = np.maximum(apart, ERROR_FLOOR)
        series.append(Series(run.style.name, colour, motion.times, drawn, dash_of(run.style)))
        parted = run.metric("first_divergence_time")
        if parted is not None:
            said = f"{run.style.name}: first other collision at {style.format_time(parted)}"
            at = np.interp([parted], motion.times, drawn)
            partings.append(
                Series(said, colour, np.array([parted]), at, marker="✕", line=False, titles=[said])
            )
    marks = [] if horizon is None else [Mark(horizon, "horizon")]
    title = f"Largest distance of a ball from our engine's against time in {shot.scene.name}"
    axis = log_axis("distance from ours", ERROR_FLOOR, min(largest, 1e3), "m")
    return draw(title, [*series, *partings], _time_axis(shot), axis, marks)


def distance_from(reference: Motion, motion: Motion) -> FloatArray:
    """Return the largest distance of a ball from an exact motion, (k,) [m], at `motion.times`.

    In the plane of the table; the exact motion is taken as it is between its stored states, not
    along chords: balls slow down evenly there, which a cubic with these ends and slopes says to the
    last bit but for rounding.
    """
    if len(reference.times) == 1:  # nothing moves in the exact motion
        return _apart(motion, reference.positions[:, :, :2])
    at, span = reference.times, np.diff(reference.times)
    t = np.minimum(motion.times, at[-1])
    row = np.clip(np.searchsorted(at, t, side="right") - 1, 0, len(span) - 1)
    h = span[row][:, np.newaxis, np.newaxis]
    s = ((t - at[row]) / span[row])[:, np.newaxis, np.newaxis]
    p, v = reference.positions[:, :, :2], reference.velocities[:, :, :2]
    # The state before an event is stored one double earlier, so no span holds a jump but that one.
    with np.errstate(invalid="ignore", over="ignore"):  # where a motion isn't finite
        place = (
            (1.0 + 2.0 * s) * (1.0 - s) ** 2 * p[row]
            + s * (1.0 - s) ** 2 * h * v[row]
            + s**2 * (3.0 - 2.0 * s) * p[row + 1]
            - s**2 * (1.0 - s) * h * v[row + 1]
        )
    return _apart(motion, place)


def _apart(motion: Motion, places: FloatArray) -> FloatArray:
    with np.errstate(invalid="ignore", over="ignore"):  # where a motion isn't finite
        apart: FloatArray = np.linalg.norm(motion.positions[:, :, :2] - places, axis=2).max(axis=1)
    return apart


def _largest(values: FloatArray) -> float:
    """Return the largest finite value, 0 where there is none."""
    return float(np.max(values[np.isfinite(values)], initial=0.0))


def _time_axis(shot: Shot) -> Axis:
    return linear_axis("time [s]", max(float(_motion(run).times[-1]) for run in shot.drawn))


def _motion(run: Run) -> Motion:
    assert run.motion is not None  # `Shot.drawn` holds no other
    return run.motion

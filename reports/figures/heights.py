"""Draw balls in flight: height against time, and a shot from the side."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.shots import Run, Shot, motion_of_run

if TYPE_CHECKING:
    from matplotlib.axes import Axes


FLIES_FROM = 1e-4
"""Smallest height above the cloth of a ball in flight [m]; smaller heights are numerical noise."""


CORNERS = 600
"""Number of points of a curve."""


def heights_of(run: Run, radii: FloatArray) -> FloatArray:
    """Return the height of the lowest point of each ball above the cloth, (k, n) [m]."""
    return motion_of_run(run).positions[:, :, 2] - radii


def flying(shot: Shot) -> NDArray[np.bool_]:
    """Return which balls are in flight at some time on some engine, (n,) bool."""
    found = np.zeros(len(shot.scene.balls), dtype=np.bool_)
    for run in shot.drawn if shot.scene.physics.airborne else ():
        found |= np.any(heights_of(run, shot.scene.radii) > FLIES_FROM, axis=0)
    return found


def part_in_flight(shot: Shot) -> float:
    """Return the time of the last landing on the engine that is drawn first [s]."""
    run = shot.drawn[0]
    high = np.any(heights_of(run, shot.scene.radii) > FLIES_FROM, axis=1)
    times = motion_of_run(run).times
    last = int(np.flatnonzero(high)[-1]) if high.any() else 0
    return float(times[min(last + 1, len(times) - 1)])


def draw_heights(axes: Axes, shot: Shot, looks: Callable[[Run, int], Mapping[str, Any]]) -> None:
    """Draw the height of each ball against time while a ball flies.

    `looks`: function that returns the style of a line for an engine and a ball.
    """
    for run in shot.drawn:
        for ball in np.flatnonzero(flying(shot)).tolist():
            t, (_, _, z) = _curve(run, ball, part_in_flight(shot))
            axes.plot(t, 1e3 * (z - shot.scene.radii[ball]), **looks(run, ball))
    axes.axhline(0.0, color=style.GREY, linewidth=0.8)
    axes.set_xlim(0.0, 1.08 * part_in_flight(shot))
    axes.grid(visible=True)


def _curve(run: Run, ball: int, end: float) -> tuple[FloatArray, FloatArray]:
    """Return times (k,) [s] up to slightly after `end`, and the positions of a ball, (3, k) [m].

    In an exact motion, positions between stored states are interpolated: a flight is a parabola.
    """
    motion = motion_of_run(run)
    known, places = motion.times, motion.positions[:, ball].T
    inside = known <= 1.1 * end
    if motion.phases is None or len(known) == 1:
        return known[inside], places[:, inside]
    t = np.union1d(known[inside], np.linspace(0.0, min(1.1 * end, known[-1]), CORNERS))
    row = np.clip(np.searchsorted(known, t, side="right") - 1, 0, len(known) - 2)
    h = known[row + 1] - known[row]
    u = (t - known[row]) / h
    # Distance from the chord of a parabola, from the change of its slope.
    slopes = motion.velocities[:, ball].T
    bow = 0.5 * h * u * (1.0 - u) * (slopes[:, row] - slopes[:, row + 1])
    return t, places[:, row] + u * (places[:, row + 1] - places[:, row]) + bow


def draw_side(axes: Axes, shot: Shot, look: Callable[[Run], Mapping[str, Any]]) -> None:
    """Draw a side view: the paths of flying balls, and the other balls at their starts."""
    from matplotlib.patches import Circle  # noqa: PLC0415

    end, radii = part_in_flight(shot), shot.scene.radii
    flies = flying(shot)
    for run in shot.drawn:
        for k, ball in enumerate(np.flatnonzero(flies).tolist()):
            _, (x, _, z) = _curve(run, ball, end)
            axes.plot(x, z, **{**look(run), **({"label": None} if k else {})})
    left, right = axes.get_xlim()
    for ball, (x, _, z) in enumerate(shot.scene.positions):
        if left - 0.5 <= x <= right + 0.5:
            filled = style.FAINT if flies[ball] else style.GREY
            axes.add_patch(Circle((x, z), radii[ball], facecolor=filled, edgecolor=style.BLACK))
    axes.axhline(0.0, color=style.BLACK, linewidth=1.0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x [m]", ylabel="height of the centres [m]")
    axes.set_title("side view, until the ball stays on the cloth", fontsize=9)

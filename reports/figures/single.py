"""Draw a single run: initial positions, paths and rest positions of its balls."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ghostball.model import Scene
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.figures._table import View, aspect_of, draw_ball, draw_table
from ghostball.reports.figures.heights import draw_heights, flying
from ghostball.reports.figures.paths import (
    WIDTH,
    draw_against_time,
    draw_motion,
    is_collinear,
    label_balls,
    scale_of,
    view_shown,
)
from ghostball.reports.shots import Shot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


FEW = 8
"""Up to this many balls, names are beside the balls; with more, inside them."""

SHORT = 3
"""Number of letters that fit inside a ball."""

BALL_COLOURS = (
    *(style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE, style.ORANGE, style.BROWN),
    *("#332288", "#882255", "#117733", "#88A020", "#3F3F3F", "#AA4466"),
)
"""Colours of balls, dark enough for lines on the cloth and for white names inside the balls."""

LEGIBLE = 8.0
"""Smallest diameter of a ball with a legible name inside [pt]."""


def draw_single(shot: Shot) -> Figure:
    """Draw the paths of a shot with a single run, on axes in metres.

    If balls stay on one line, their paths hide each other, so a second panel shows x against time.
    """
    collinear = is_collinear(shot)
    view = view_shown(shot, collinear)
    height = float(np.clip((WIDTH - 0.8) * aspect_of(view), 1.0, 5.0))
    flies = bool(flying(shot).any())
    rows = [height, *[3.2] * collinear, *[2.0] * flies]
    figure = style.new_figure(WIDTH, sum(rows) + 0.5 * len(rows) + 0.6)
    axes = figure.subplots(len(rows), 1, squeeze=False, gridspec_kw={"height_ratios": rows})[:, 0]
    _draw_on_table(axes[0], shot, view, height)
    if collinear:
        draw_against_time(axes[1], shot, ball_colours(len(shot.scene.balls)))
    if flies:
        _draw_heights(axes[-1], shot)
    (run,) = shot.drawn
    at_end = "at rest" if shot.end == "rest" else "at the end"
    style.set_title(figure, f"{shot.scene.name} on {run.style.name}")
    paths = "paths (thick: sliding)" if shot.slides else "paths"
    said = f"Open discs: start. Lines: {paths}. Filled discs: {at_end}."
    figure.supxlabel(
        " ".join(filter(None, [said, _naming(shot.scene), _outside(shot, view)])),
        fontsize=8.5,
        color=style.GREY,
    )
    return figure


def _draw_heights(axes: Axes, shot: Shot) -> None:
    colours, names = ball_colours(len(shot.scene.balls)), _names(shot.scene)
    draw_heights(axes, shot, lambda _, ball: {"color": colours[ball], "label": names[ball]})
    axes.set(xlabel="time [s]", ylabel="height [mm]")
    axes.legend(fontsize=8.0)


def _draw_on_table(axes: Axes, shot: Shot, view: View, height: float) -> None:
    (run,) = shot.drawn
    assert run.motion is not None
    assert run.case is not None
    assert run.case.rest_positions is not None  # it ran
    draw_table(axes, shot.scene, view)
    names, radii = _names(shot.scene), shot.scene.radii
    width = 1.0 if len(names) <= FEW else 0.6
    colours = ball_colours(len(names))
    draw_motion(axes, run, colours=colours, linewidth=width, alpha=0.8)
    starts, ends = shot.scene.positions, run.case.rest_positions
    for ball, name in enumerate(names):
        look = {"facecolor": "white", "edgecolor": colours[ball], "linewidth": 1.0}
        draw_ball(axes, starts[ball], radii[ball], zorder=3, **look)
        look = {"facecolor": colours[ball], "edgecolor": "white", "linewidth": 0.5}
        draw_ball(axes, ends[ball], radii[ball], zorder=4, **look)
        if len(names) > FEW and 2.0 * radii[ball] / (view[1] - view[0]) * WIDTH * 72.0 >= LEGIBLE:
            _write_within(axes, name, starts[ball], style.BLACK, zorder=3.5)
            _write_within(axes, name, ends[ball], "white", zorder=5)
    if len(names) <= FEW:
        beside = [
            (name, centre, radii[ball])
            for ball, name in enumerate(names)
            for centre in _separate(starts[ball], ends[ball], radii[ball])
        ]
        label_balls(axes, beside, scale_of(view, height), run.motion.positions)


def ball_colours(count: int) -> list[str]:
    """Return a colour for each ball; with more balls than colours, colours repeat."""
    return [BALL_COLOURS[ball % len(BALL_COLOURS)] for ball in range(count)]


def _names(scene: Scene) -> list[str]:
    """Return the names of the balls in the picture: their ids, or numbers if the ids are long."""
    ids = [ball.id for ball in scene.balls]
    if len(ids) <= FEW or max(map(len, ids)) <= SHORT:
        return ids
    return [str(number) for number in range(1, len(ids) + 1)]


def _naming(scene: Scene) -> str:
    ids = [ball.id for ball in scene.balls]
    return "" if _names(scene) == ids else "Numbers: ball order in the scene, from 1."


def _outside(shot: Shot, view: View) -> str:
    """Return a note with the balls that end outside the picture; "" if there are none."""
    (run,) = shot.drawn
    assert run.case is not None
    assert run.case.rest_positions is not None  # it ran
    left, right, bottom, top = view
    x, y = run.case.rest_positions[:, 0], run.case.rest_positions[:, 1]
    inside = (left <= x) & (x <= right) & (bottom <= y) & (y <= top)
    gone = [name for name, seen in zip(_names(shot.scene), inside, strict=True) if not seen]
    return f"Not shown: {', '.join(gone)}." if gone else ""


def _separate(start: FloatArray, end: FloatArray, radius: float) -> list[FloatArray]:
    """Return the positions of a ball's name: start and end, or one position if they are close."""
    return [start] if float(np.hypot(*(end - start)[:2])) < 2.0 * radius else [start, end]


def _write_within(axes: Axes, name: str, centre: FloatArray, colour: str, zorder: float) -> None:
    axes.text(
        centre[0],
        centre[1],
        name,
        ha="center",
        va="center",
        fontsize=5.5,
        color=colour,
        zorder=zorder,
        clip_on=True,
    )

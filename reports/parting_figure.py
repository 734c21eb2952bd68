"""Draw the first wrong collision of a shot: the picture of `ghostball explain --plot`."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ghostball.model import EventKind, Result
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.figures._table import View, aspect_of, draw_ball, draw_table, view_of
from ghostball.reports.plot import write_picture
from ghostball.validation.diagnose.explanation import Explanation
from ghostball.validation.grading.event_logs import Event

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


WIDTH = 9.6
TRAIL_TIMES = 601
"""Number of points of a trail; the trail is then accurate to a millimetre."""

CLOSE_UP = 3.2
"""Half the smallest width of the close-up, in radii of the largest ball."""

FARTHEST = 10.0
"""Half the largest width of the close-up, in radii; with more, no detail would be visible."""

ROOM = 1.15
"""Size of the close-up, relative to the smallest one that contains the balls."""

TRUE_LOOK: dict[str, Any] = {"color": style.BLACK, "linewidth": 4.0, "alpha": 0.25, "zorder": 2}


def plot_explanation(explanation: Explanation, path: str | Path) -> Path:
    """Write a picture of both shots at the first wrong collision: the table, and a close-up.

    `path`: file to write; its ending, .png, .svg or .pdf, sets the format.
    """
    return write_picture(path, lambda target: style.save_one(draw_explanation(explanation), target))


def draw_explanation(explanation: Explanation) -> Figure:
    """Draw both shots up to the first wrong collision, or up to their ends."""
    t = _instant(explanation)
    scene, look = explanation.scene, style.engine_style(explanation.label)
    runs = (explanation.known.result, explanation.result)
    trails = [run.sample(np.linspace(0.0, t, TRAIL_TIMES)).positions for run in runs]
    view = view_of(scene, *trails, needed=trails[0][-1])
    height = float(np.clip(0.64 * (WIDTH - 1.0) * aspect_of(view), 2.4, 5.0))
    figure = style.new_figure(WIDTH, height + 1.5)
    left, right = figure.subplots(1, 2, width_ratios=[1.9, 1.0])
    close = _close_up(explanation, trails)
    for axes, shown in ((left, view), (right, close)):
        draw_table(axes, scene, shown)
        _draw_shots(axes, explanation, trails)
    right.set_ylabel("")
    for event, run, mark, _ in _marks(explanation):
        x, y = _point(explanation, run, event)
        left.plot(x, y, **mark, markersize=9.0, zorder=6)
        right.plot(x, y, **mark, markersize=15.0, zorder=6)
    _name_balls(right, explanation, trails, close)
    left.set_title(f"at t = {t:.6g} s", fontsize=9.5)
    right.set_title("close-up", fontsize=9.5)
    _add_legend(figure, explanation)
    style.set_title(figure, _title(explanation, look.name))
    return figure


def _instant(explanation: Explanation) -> float:
    """Return the time of the first wrong collision, or the end of both shots [s]."""
    if explanation.parting is not None:
        return explanation.parting.t
    return max(explanation.known.result.rest_time, explanation.result.rest_time)


def _title(explanation: Explanation, engine: str) -> str:
    parting = explanation.parting
    if parting is None:
        return f"{explanation.scene.name}: {engine} and the reference have the same collisions"
    scene = explanation.scene
    true, other = (
        "nothing more" if one is None else one.describe(scene)
        for one in (parting.true, parting.other)
    )
    return f"{scene.name}: reference: {true}; {engine}: {other}"


def _draw_shots(axes: Axes, explanation: Explanation, trails: list[FloatArray]) -> None:
    """Draw trails and balls of both shots; the reference has rings and a grey band."""
    scene, look = explanation.scene, style.engine_style(explanation.label)
    for ball, radius in enumerate(scene.radii):
        axes.plot(*trails[0][:, ball, :2].T, solid_capstyle="butt", **TRUE_LOOK)
        axes.plot(*trails[1][:, ball, :2].T, color=look.colour, linewidth=1.1, zorder=3)
        disc = {"facecolor": look.colour, "alpha": 0.3, "linewidth": 0.0, "zorder": 3.5}
        draw_ball(axes, trails[1][-1, ball], radius, **disc)
        ring = {"fill": False, "edgecolor": style.BLACK, "linewidth": 1.2, "zorder": 4}
        draw_ball(axes, trails[0][-1, ball], radius, **ring)
        edge = {"fill": False, "edgecolor": look.colour, "linewidth": 1.0, "zorder": 4.1}
        draw_ball(axes, trails[1][-1, ball], radius, linestyle="--", **edge)


def _marks(explanation: Explanation) -> Iterator[tuple[Event, Result, dict[str, Any], str]]:
    """Yield each first wrong collision with its result, plot marker and legend text."""
    if explanation.parting is None:
        return
    look, parting = style.engine_style(explanation.label), explanation.parting
    truth = {"marker": "+", "color": style.BLACK, "markeredgewidth": 1.8}
    if parting.true is not None:
        yield parting.true, explanation.known.result, truth, "collision in the reference"
    if parting.other is not None:
        other = truth | {"marker": "x", "color": look.colour}
        yield parting.other, explanation.result, other, f"collision in {look.name}"


def _point(explanation: Explanation, run: Result, one: Event) -> FloatArray:
    """Return the contact point of a collision, (2,) [m]."""
    scene = explanation.scene
    centres = run.sample([min(one.t, run.rest_time)]).positions[0, :, :2]
    if one.kind is EventKind.BALL_BALL:
        a, b = scene.radii[one.a], scene.radii[one.b]
        between: FloatArray = (b * centres[one.a] + a * centres[one.b]) / (a + b)
        return between
    assert scene.table is not None
    inward, _ = scene.table.facing(one.b, *centres[one.a].tolist())
    touch: FloatArray = centres[one.a] - scene.radii[one.a] * np.array(inward)
    return touch


def _close_up(explanation: Explanation, trails: list[FloatArray]) -> View:
    """Return the view of the close-up: the first collision, or the ball with the largest error.

    It contains the balls of both collisions, unless they are too far apart.
    """
    scene, parting = explanation.scene, explanation.parting
    reach = CLOSE_UP * float(scene.radii.max())
    if parting is None:
        ball = int(np.argmax(explanation.rest_distances))
        x, y = 0.5 * (trails[0][-1, ball, :2] + trails[1][-1, ball, :2])
        reach = max(reach, 0.7 * float(explanation.rest_distances[ball]))
    else:
        run = explanation.known.result if parting.first is parting.true else explanation.result
        x, y = _point(explanation, run, parting.first)
        both = (one for one in (parting.true, parting.other) if one is not None)
        concerned = {ball for one in both for ball in one.balls}
        for trail, ball in product(trails, sorted(concerned)):
            from_there = np.abs(trail[-1, ball, :2] - (x, y)).max() + scene.radii[ball]
            if ROOM * from_there <= FARTHEST * float(scene.radii.max()):
                reach = max(reach, ROOM * float(from_there))
    return float(x) - reach, float(x) + reach, float(y) - reach, float(y) + reach


def _name_balls(axes: Axes, explanation: Explanation, trails: list[FloatArray], view: View) -> None:
    from matplotlib.patheffects import withStroke  # noqa: PLC0415

    left, right, bottom, top = view
    colours = (style.BLACK, style.engine_style(explanation.label).colour)
    for ball, one in enumerate(explanation.scene.balls):
        ends = [trail[-1, ball, :2] for trail in trails]
        # If both have the same position, one name is enough.
        separate = float(np.hypot(*(ends[1] - ends[0]))) > one.radius
        for (x, y), colour in zip(ends if separate else ends[:1], colours, strict=False):
            if left < x < right and bottom < y < top:
                text = axes.text(
                    x, y, one.id, fontsize=8.5, color=colour, ha="center", va="center", zorder=7
                )
                text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


def _add_legend(figure: Figure, explanation: Explanation) -> None:
    from matplotlib.lines import Line2D  # noqa: PLC0415

    look = style.engine_style(explanation.label)
    disc: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 9}
    filled: dict[str, Any] = {"markerfacecolor": (look.colour, 0.3), "markeredgecolor": look.colour}
    handles = [
        Line2D([], [], label=f"reference ({explanation.known.kind})", **TRUE_LOOK),
        Line2D([], [], color=look.colour, linewidth=1.1, label=look.name),
        Line2D([], [], label="ball in the reference", color=style.BLACK, fillstyle="none", **disc),
        Line2D([], [], label=f"ball in {look.name}", **filled, **disc),
    ]
    handles += [
        Line2D([], [], linestyle="none", markersize=9, label=where, **mark)  # named in the title
        for _, _, mark, where in _marks(explanation)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)

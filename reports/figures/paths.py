"""Draw paths of balls, with sliding parts marked, for all pictures of shots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ghostball.model import Phase
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.figures._table import View, draw_ball, draw_table, view_of
from ghostball.reports.shots import Run, Shot, motion_of_run, rest_error_text
from ghostball.validation.checks.verdict import RestError

if TYPE_CHECKING:
    from matplotlib.axes import Axes


WIDTH = 8.8
"""Width of a figure [inch]: text stays readable where a README shows it 900 pixels wide."""

STRIP = 0.22
"""Half the height of the picture if all motion is along x [m]."""

LABEL_SIZE = 8.0
"""Font size of the names of balls [pt]."""

LETTER_WIDTH = 0.62
"""Mean width of a letter, relative to the font size."""


SLIDING_WIDER = 1.2
"""Added to a line's width where the ball slides [pt]."""

SLIDING_DARKER = 1.5
"""Factor on a line's opacity where the ball slides."""


def draw_against_time(axes: Axes, shot: Shot, colours: Sequence[str] | None = None) -> None:
    """Draw x of every ball against time, one line for each ball and engine.

    `colours`: colours of the balls, instead of those of the engines.
    """
    # Ghostball's line is a band beneath the other lines; a single run gets a normal line.
    alone = {"linewidth": 1.2, "alpha": 1.0} if len(shot.drawn) == 1 else {}
    for order, run in enumerate(shot.drawn):
        look = {"zorder": 2 + 0.01 * order, **line_of(run), **alone}
        draw_motion(axes, run, against_time=True, colours=colours, **look)
    axes.set_xlim(0.0, 1.02 * median_end(shot))
    axes.set_ylim(*_range_of_x(shot))
    axes.set_xlabel("time [s]")
    axes.set_title("x of ball centres [m] against time", y=1.0)
    axes.grid(True)


def _range_of_x(shot: Shot) -> tuple[float, float]:
    """Return the range of x of all balls, within the view, for the chart against time."""
    left, right, _, _ = view_shown(shot, collinear=True)
    x = np.concatenate([motion_of_run(run).positions[:, :, 0].ravel() for run in shot.drawn])
    x = x[(left <= x) & (x <= right)]
    margin = 2.0 * float(shot.scene.radii.max())
    return max(left, float(x.min()) - margin), min(right, float(x.max()) + margin)


def draw_panel(axes: Axes, shot: Shot, run: Run, view: View) -> None:
    """Draw one engine's paths, and its rest positions with those of the reference."""
    assert run.motion is not None
    assert run.case is not None
    draw_table(axes, shot.scene, view, ticks=False)
    draw_motion(axes, run, color=run.style.colour, linewidth=0.6, alpha=0.45, zorder=2)
    rest, truth = run.case.rest_positions, shot.truth_positions
    radii = shot.scene.radii
    for ball in range(len(shot.scene.balls)):
        if rest is not None:
            look = {"facecolor": run.style.colour, "edgecolor": "white", "linewidth": 0.4}
            draw_ball(axes, rest[ball], radii[ball], alpha=0.85, zorder=3, **look)
        if truth is not None:
            look = {"fill": False, "edgecolor": style.BLACK, "linewidth": 0.9}
            draw_ball(axes, truth[ball], radii[ball], zorder=5, **look)
        if rest is not None and truth is not None:
            pair = np.stack([truth[ball], rest[ball]])
            axes.plot(pair[:, 0], pair[:, 1], color=style.BLACK, linewidth=0.7, zorder=4)
    axes.set_title(run.style.name, fontsize=9.5, color=style.BLACK)
    axes.set_title(_error_text(run, shot), fontsize=8.5, fontweight="normal", loc="right")


def line_of(run: Run) -> dict[str, Any]:
    """Return the style of an engine's line; Ghostball's is a band beneath the others."""
    look = run.style
    return {
        "color": look.colour,
        "linestyle": look.line,
        "linewidth": look.line_width,
        "alpha": look.line_alpha,
        "solid_capstyle": "butt" if look.ours else "round",
    }


def scale_of(view: View, height: float) -> float:
    """Return the scale [m/pt] of a picture of `view` that is at most `height` inches high."""
    left, right, bottom, top = view
    return max((right - left) / (WIDTH - 0.8), (top - bottom) / height) / 72.0


def label_balls(
    axes: Axes,
    balls: Sequence[tuple[str, FloatArray, float]],
    metres_to_a_point: float,
    paths: FloatArray,
) -> None:
    """Write each ball's name beside it, away from other names and balls and, if possible, paths.

    `balls`: name, centre [m] and radius [m] of each ball.
    `metres_to_a_point`: scale of the picture [m/pt], to estimate the size of a name.
    `paths` (..., 3) float64 [m]: points of the drawn paths.
    """
    from matplotlib.patheffects import withStroke  # noqa: PLC0415

    discs = [_box(centre, (0.0, 0.0), radius, radius) for _, centre, radius in balls]
    taken: list[FloatArray] = []
    for name, centre, radius in balls:
        half_width = 0.5 * LABEL_SIZE * LETTER_WIDTH * len(name) * metres_to_a_point
        half_height = 0.6 * LABEL_SIZE * metres_to_a_point
        away = radius + 3.0 * metres_to_a_point
        places = [
            (0.0, away + half_height),
            (0.0, -away - half_height),
            (-away - half_width, 0.0),
            (away + half_width, 0.0),
        ]
        boxes = [_box(centre, place, half_width, half_height) for place in places]
        free = [i for i, box in enumerate(boxes) if not _overlaps(box, discs + taken)] or [0]
        chosen = min(free, key=lambda i: _points_within(boxes[i], paths))
        taken.append(boxes[chosen])
        text = axes.text(
            centre[0] + places[chosen][0],
            centre[1] + places[chosen][1],
            name,
            ha="center",
            va="center",
            fontsize=LABEL_SIZE,
            color=style.GREY,
            zorder=6,
        )
        text.set_path_effects([withStroke(linewidth=2.5, foreground=style.CLOTH)])


def _box(
    centre: FloatArray, offset: tuple[float, float], half_width: float, half_height: float
) -> FloatArray:
    """Return left, right, bottom, top of a box at an offset from a centre, (4,) [m]."""
    x, y = centre[0] + offset[0], centre[1] + offset[1]
    return np.array([x - half_width, x + half_width, y - half_height, y + half_height])


def _points_within(box: FloatArray, points: FloatArray) -> int:
    left, right, bottom, top = box
    x, y = points[..., 0], points[..., 1]
    return int(np.count_nonzero((left < x) & (x < right) & (bottom < y) & (y < top)))


def _overlaps(box: FloatArray, others: Sequence[FloatArray]) -> bool:
    left, right, bottom, top = box
    return any(
        left < other[1] and other[0] < right and bottom < other[3] and other[2] < top
        for other in others
    )


def _error_text(run: Run, shot: Shot) -> str:
    if run.standing is RestError.OWN:
        return "the reference"
    found = None if run.case is None else run.case.accuracy
    if run.standing is RestError.CHAOTIC and found is not None and found.at is not None:
        return f"wrong collisions from t = {style.format_time(found.at)} on"
    # In tables, brackets mean that no limit judges the error; pictures leave them out.
    error = rest_error_text(run.case).strip("()")
    return f"{shot.end} position error: {error or 'unknown'}"


def is_collinear(shot: Shot) -> bool:
    """Return whether all of several balls stay on one line along x, where paths hide each other."""
    first = motion_of_run(shot.drawn[0])
    return bool(np.ptp(first.positions[:, :, 1]) < 1e-6) and len(shot.scene.balls) > 1


def view_shown(shot: Shot, collinear: bool) -> View:
    """Return the part of the cloth to show; for motion along x, a strip around it."""
    truth = shot.truth_positions
    needed = shot.scene.positions if truth is None else truth
    view = view_of(shot.scene, *(motion_of_run(run).positions for run in shot.drawn), needed=needed)
    if not collinear:
        return view
    left, right, bottom, top = view
    middle = float(shot.scene.positions[0, 1])
    return left, right, max(bottom, middle - STRIP), min(top, middle + STRIP)


def median_end(shot: Shot) -> float:
    """Return the median end time of the runs [s], so that one endless run doesn't set the scale."""
    return float(np.median([motion_of_run(run).times[-1] for run in shot.drawn])) or 1.0


def draw_motion(
    axes: Axes,
    run: Run,
    *,
    against_time: bool = False,
    colours: Sequence[str] | None = None,
    **look: Any,
) -> None:
    """Draw the paths of all balls of a run; sliding parts have the style of `sliding_look`.

    `run`: a run with a motion.
    `against_time`: draw x against time rather than y against x.
    `colours`: colours of the paths by ball, instead of one colour in `look`.
    `**look`: arguments of matplotlib's `plot`, with at least `linewidth` and `alpha`.
    """
    motion = run.motion
    assert motion is not None
    for ball in range(motion.positions.shape[1]):
        if colours is not None:
            look["color"] = colours[ball]
        x, y = motion.positions[:, ball, 0], motion.positions[:, ball, 1]
        line = np.column_stack((motion.times, x) if against_time else (x, y))
        if motion.phases is None:
            axes.plot(*line.T, **look)
            continue
        for slides, part in parts_of(line, motion.phases[:, ball] == Phase.SLIDING):
            # Rounded ends of two parts would overlap and show through each other.
            ends = {"solid_capstyle": "butt"}
            axes.plot(*part.T, **(look | ends | (sliding_look(look) if slides else {})))


def sliding_look(look: dict[str, Any]) -> dict[str, Any]:
    """Return the changes of a line's style where the ball slides: wider and darker.

    Dashes would hide a slide of a few centimetres, and the colour already identifies the engine.
    """
    return {
        "linewidth": look["linewidth"] + SLIDING_WIDER,
        "alpha": min(SLIDING_DARKER * look["alpha"], 1.0),
    }


def parts_of(line: FloatArray, slides: NDArray[np.bool_]) -> Iterator[tuple[bool, FloatArray]]:
    """Yield two parts of a line, rolling and sliding: True for sliding, and its points (m, 2).

    `line` (k, 2) float64: points.
    `slides` (k,) bool: whether the ball slides after each point.

    The stretches of a part are separated by NaN, where matplotlib interrupts the line, so each part
    is a single line. Neighbouring stretches share a point, so there is no gap between them.
    """
    changes = np.flatnonzero(np.diff(slides[:-1])) + 1
    bounds = [0, *changes.tolist(), len(line) - 1]
    for wanted in (False, True):
        stretches = [
            np.vstack((line[start : end + 1], np.full((1, line.shape[1]), np.nan)))
            for start, end in pairwise(bounds)
            if slides[start] == wanted
        ]
        if stretches:
            yield wanted, np.concatenate(stretches)[:-1]

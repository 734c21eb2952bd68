"""Where the balls went: the paths of all engines on the table, and where they came to rest."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ghostball.reports import style
from ghostball.reports.figures._phases import draw_motion, sliding_look
from ghostball.reports.figures._table import View, aspect_of, draw_ball, draw_table, view_of
from ghostball.reports.shots import Run, Shot, rest_error_text
from ghostball.validation.checks.verdict import RestError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

WIDTH = 8.8
"""Width of a figure [inch]: text stays readable where a README shows it 900 pixels wide."""

PATH_LENGTH_SHOWN = 50.0
"""Total path drawn in a panel of many balls [m]: more is a scribble."""


STRIP = 0.22
"""Half the width of what is shown of the cloth where all motion is along x [m]."""

LABEL_SIZE = 8.0
"""Of the names of balls [pt]."""

LETTER_WIDTH = 0.62
"""Mean width of a letter over the size of the font."""

LETTERS_IN_A_LINE = 110
"""How many fit beneath a picture."""


def draw_paths(shot: Shot) -> Figure | None:
    """Draw the paths of a scene; None where no engine has a motion.

    A few balls: all engines over each other. Balls that stay on one line get their position
    against time as well, since their paths hide each other. Many balls that don't: a panel for each
    engine.
    """
    if not shot.drawn:
        return None
    if shot.crowded and not is_collinear(shot):
        return _draw_panels(shot)
    return _draw_overlay(shot)


def _draw_overlay(shot: Shot) -> Figure:
    collinear = is_collinear(shot)
    view = view_shown(shot, collinear)
    height = float(np.clip((WIDTH - 0.8) * aspect_of(view), 1.0, 5.0))
    rows = [height, 3.2] if collinear else [height]
    figure = style.new_figure(WIDTH, sum(rows) + 0.5 * len(rows) + 0.4 + 0.2 * _legend_rows(shot))
    axes = figure.subplots(len(rows), 1, squeeze=False, gridspec_kw={"height_ratios": rows})[:, 0]
    _draw_on_table(axes[0], shot, view, height)
    # What a box of fixed proportions leaves of its place is above it: the layout counts on the
    # labels beneath.
    axes[0].set_anchor("S")
    if collinear:
        draw_against_time(axes[1], shot)
    _add_legend(figure, shot)
    what = "paths and rest positions" if shot.end == "rest" else "paths and final positions"
    style.set_title(figure, f"{shot.scene.name}: {what} by engine (grey discs: start)")
    return figure


def _draw_on_table(axes: Axes, shot: Shot, view: View, height: float) -> None:
    draw_table(axes, shot.scene, view)
    radii = shot.scene.radii
    for ball, start in enumerate(shot.scene.positions):
        look = {"facecolor": style.FAINT, "edgecolor": style.GREY, "linewidth": 0.8, "zorder": 1.5}
        draw_ball(axes, start, radii[ball], **look)
    for order, run in enumerate(shot.drawn):
        draw_motion(axes, run, zorder=2 + 0.01 * order, **_line(run))
    _draw_rest(axes, shot)
    names = [(ball.id, i) for i, ball in enumerate(shot.scene.balls)]
    at = [(name, shot.scene.positions[i], radii[i]) for name, i in names]
    label_balls(axes, at, scale_of(view, height), _seen(shot.drawn[0]))


def _draw_rest(axes: Axes, shot: Shot) -> None:
    """Truth as a ring to scale; each engine as its marker at the centre."""
    truth = shot.truth_positions
    if truth is not None:
        for ball, centre in enumerate(truth):
            look = {"fill": False, "edgecolor": style.BLACK, "linewidth": 1.6, "zorder": 3}
            draw_ball(axes, centre, shot.scene.radii[ball], **look)
    for order, run in enumerate(shot.drawn):
        rest = run.case.rest_positions if run.case is not None else None
        if rest is not None and not run.style.ours:
            axes.plot(rest[:, 0], rest[:, 1], zorder=4 + 0.01 * order, **_marker(run))


def draw_against_time(axes: Axes, shot: Shot) -> None:
    """Draw x of every ball against time, one line for each ball and engine."""
    # A band that others are drawn upon would hide what a single run shows.
    alone = {"linewidth": 1.2, "alpha": 1.0} if len(shot.drawn) == 1 else {}
    for order, run in enumerate(shot.drawn):
        look = {"zorder": 2 + 0.01 * order, **_line(run), **alone}
        draw_motion(axes, run, against_time=True, **look)
    axes.set_xlim(0.0, 1.02 * _median_end(shot))
    axes.set_ylim(*_range_of_x(shot))
    axes.set_xlabel("time [s]")
    axes.set_ylabel("x of the centre [m]")
    axes.set_title("The same against time")
    axes.grid(True)


def _range_of_x(shot: Shot) -> tuple[float, float]:
    """Return the part of x to show against time: where balls are, within the picture above it."""
    left, right, _, _ = view_shown(shot, collinear=True)
    x = np.concatenate([_seen(run)[:, :, 0].ravel() for run in shot.drawn])
    x = x[(left <= x) & (x <= right)]
    margin = 2.0 * float(shot.scene.radii.max())
    return max(left, float(x.min()) - margin), min(right, float(x.max()) + margin)


def _draw_panels(shot: Shot) -> Figure:
    # Without a table, balls roll out of the picture of where they started.
    view = view_of(shot.scene, _ends(shot), needed=_ends(shot))
    runs = shot.drawn
    columns = min(3, len(runs))
    rows = -(-len(runs) // columns)
    width = (WIDTH + 0.8) / columns
    figure = style.new_figure(WIDTH + 0.8, rows * (width * aspect_of(view) + 0.22) + 0.65)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    t_shown = _time_shown(runs[0])
    for axes, run in zip(grid, runs, strict=False):
        draw_panel(axes, shot, run, view, t_shown)
    for axes in grid[len(runs) :]:
        axes.set_axis_off()
    table = shot.scene.table
    size = "" if table is None else f"; table {table.length:g} m × {table.width:g} m"
    end = "at rest" if shot.end == "rest" else "at the end"
    paths = "Lines: paths" if t_shown is None else f"Lines: paths of the first {t_shown:.2g} s"
    paths += ", thick where a ball slides.\n" if shot.slides else ". "
    style.set_title(figure, f"{shot.scene.name}: {len(shot.scene.balls)} balls {end}{size}")
    figure.supxlabel(
        f"{paths}Filled: {end} in that engine. Rings: the truth. Bars join the same ball. "
        f"Number: largest {shot.end} error (in brackets: not judged).",
        fontsize=8.5,
        color=style.GREY,
    )
    return figure


def draw_panel(axes: Axes, shot: Shot, run: Run, view: View, t_shown: float | None) -> None:
    """Draw one engine's paths, until `t_shown` [s], and its rest positions against the truth."""
    assert run.motion is not None
    assert run.case is not None
    draw_table(axes, shot.scene, view, ticks=False)
    until = len(run.motion.times)
    if t_shown is not None:
        until = int(np.searchsorted(run.motion.times, t_shown, side="right"))
    draw_motion(axes, run, until=until, color=run.style.colour, linewidth=0.6, alpha=0.45, zorder=2)
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


def _add_legend(figure: Figure, shot: Shot) -> None:
    from matplotlib.lines import Line2D  # noqa: PLC0415

    handles = []
    for run in shot.runs:
        if run.motion is None:
            continue
        look = _line(run)
        if not run.style.ours:
            look |= {key: value for key, value in _marker(run).items() if key != "linestyle"}
        handles.append(Line2D([], [], label=f"{run.style.name}: {_error_text(run, shot)}", **look))
        if run.slides:
            look = _line(run) | sliding_look(_line(run))
            label = f"{run.style.name}, where a ball slides"
            handles.append(Line2D([], [], label=label, **look))
    place = "rests" if shot.end == "rest" else "is at the end"
    key = (
        f"black ring: where the ball {place} in truth; numbers: largest {shot.end} error "
        "(in brackets: not judged)"
    )
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=3,
        handlelength=3.2,
        columnspacing=1.6,
        title="\n".join([key, *_absent(shot)]),
        title_fontsize=8.5,
    ).get_title().set_multialignment("center")


def _absent(shot: Shot) -> list[str]:
    """Say which engines have no path, and why: a line for each reason, folded."""
    reasons: dict[str, list[str]] = {}
    for run in shot.runs:
        if run.motion is None:
            reasons.setdefault(run.verdict.words, []).append(run.style.name)
    return [
        line
        for why, names in reasons.items()
        for line in wrap(f"{why}: {'; '.join(names)}", LETTERS_IN_A_LINE, break_on_hyphens=False)
    ]


def _legend_rows(shot: Shot) -> int:
    entries = sum(1 + run.slides for run in shot.drawn)
    return -(-entries // 3) + 1 + len(_absent(shot))


def _line(run: Run) -> dict[str, Any]:
    look = run.style
    return {
        "color": look.colour,
        "linestyle": look.line,
        "linewidth": look.line_width,
        "alpha": look.line_alpha,
        "solid_capstyle": "butt" if look.ours else "round",
    }


def _marker(run: Run) -> dict[str, Any]:
    return {
        "linestyle": "none",
        "marker": run.style.marker,
        "markersize": 5.5,
        "markerfacecolor": "none",
        "markeredgecolor": run.style.colour,
        "markeredgewidth": 1.2,
    }


def scale_of(view: View, height: float) -> float:
    """Return the metres to a point of a picture of `view` that is at most `height` inches high."""
    left, right, bottom, top = view
    return max((right - left) / (WIDTH - 0.8), (top - bottom) / height) / 72.0


def label_balls(
    axes: Axes,
    balls: Sequence[tuple[str, FloatArray, float]],
    metres_to_a_point: float,
    paths: FloatArray,
) -> None:
    """Write the names of balls beside them: off other names and balls, and off paths where it can.

    Parameters
    ----------
    axes : Axes
    balls : sequence of (name, centre [m], radius [m])
    metres_to_a_point : float
        Scale of the picture, to estimate how much room a name takes.
    paths : (..., 3) float64 [m]
        Points of the paths that are drawn.
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
    return rest_error_text(run.case) or f"no {shot.end} error known"


def _seen(run: Run) -> FloatArray:
    assert run.motion is not None
    return run.motion.positions


def is_collinear(shot: Shot) -> bool:
    """Whether several balls move, and all along x: their paths hide each other."""
    first = shot.drawn[0].motion
    assert first is not None
    return bool(np.ptp(first.positions[:, :, 1]) < 1e-6) and len(shot.scene.balls) > 1


def view_shown(shot: Shot, collinear: bool) -> View:
    """Return what of the cloth to show; of a motion along x, a strip around it."""
    view = view_of(shot.scene, *(_seen(run) for run in shot.drawn), needed=_ends(shot))
    if not collinear:
        return view
    left, right, bottom, top = view
    middle = float(shot.scene.positions[0, 1])
    return left, right, max(bottom, middle - STRIP), min(top, middle + STRIP)


def _ends(shot: Shot) -> FloatArray:
    """Return where the balls end in truth, (n, 3) [m], or start where that isn't known."""
    truth = shot.truth_positions
    return shot.scene.positions if truth is None else truth


def _median_end(shot: Shot) -> float:
    """Return when the middle one of the runs ends [s]."""
    return float(np.median([run.motion.times[-1] for run in shot.drawn if run.motion is not None]))


def _time_shown(run: Run) -> float | None:
    """Until when the paths of all balls together stay drawable [s]; None is "to the end"."""
    assert run.motion is not None
    steps = np.linalg.norm(np.diff(run.motion.positions, axis=0), axis=2).sum(axis=1)
    total = np.cumsum(steps)
    if total[-1] <= PATH_LENGTH_SHOWN:
        return None
    return float(run.motion.times[1 + np.searchsorted(total, PATH_LENGTH_SHOWN)])

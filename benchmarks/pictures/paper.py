"""Draw Figures 1 to 4 of the paper from stored motions.

Figure 1: a break of 7 balls at four times. Figure 2: two examples of overlapping balls ("clipping"
in the paper), beside the same times on Ghostball's engine. Figure 3: a cushion collision. Figure 4:
a head-on collision and a slightly skewed one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.pictures.shots import our_shot, recorded
from ghostball.model import EventKind
from ghostball.model.arrays import FloatArray
from ghostball.reports import style
from ghostball.reports.figures._table import (
    View,
    aspect_of,
    draw_ball,
    draw_scale_bar,
    draw_table,
    view_of,
)
from ghostball.reports.shots import Run, Shot, motion_of_run
from ghostball.validation.results.store import Motion, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


BREAK = "break-7"
BIG_BREAK = "break-16"
WALL = "wall-bounce"
HEAD_ON = "figure4-head-on"
SKEWED = "figure4-skewed"
CLIPPING_ENGINE = "paper-discrete"

BALL_COLOURS = (
    style.YELLOW,
    style.BLUE,
    style.VERMILLION,
    style.PURPLE,
    style.ORANGE,
    style.GREEN,
    style.SKY,
)
CUE_COLOUR = "#FFFFFF"

WIDTH = 8.8


@dataclass(frozen=True)
class Overlap:
    """Overlap of balls `a` and `b` at time `t` [s]; `length` [m] is its depth."""

    t: float
    a: int
    b: int
    length: float


def draw_figure_1(results: Results) -> Figure:
    """Draw the break of 7 balls at four times."""
    shot, ours = our_shot(results, BREAK)
    motion = motion_of_run(ours)
    struck = _first_time(motion, EventKind.BALL_BALL)
    end = float(motion.times[-1])
    instants = (
        ("(a)", 0.5 * struck, "the cue ball moves toward the rack"),
        ("(b)", struck + 0.04, "immediately after it has struck"),
        ("(c)", struck + 0.40, "shortly after: the balls move apart"),
        ("(d)", end, "every ball at rest"),
    )
    view = view_of(shot.scene)
    figure = style.new_figure(WIDTH, WIDTH * aspect_of(view) + 0.95)
    for axes, (letter, t, what) in zip(figure.subplots(2, 2).ravel(), instants, strict=True):
        draw_table(axes, shot.scene, view, ticks=False)
        _draw_instant(axes, shot, motion, t, trail=0.25)
        axes.set_title(f"{letter} t = {t:.2f} s: {what}", fontsize=9)
    style.set_title(figure, f"Figure 1 of the paper: a break of 7 balls, {ours.style.name}")
    _set_note(figure, f"{_table_size(shot)}. Lines: the last 0.25 s of each path.")
    return figure


def draw_figure_2(results: Results) -> Figure:
    """Draw two overlaps on the paper's first algorithm, and Ghostball's engine at those times."""
    examples = _clippings(results)
    figure = style.new_figure(WIDTH, 3.3 * len(examples) + 0.5)
    grid = figure.subplots(len(examples), 2, squeeze=False)
    for row, (shot, clipped, ours, overlap) in zip(grid, examples, strict=True):
        for axes, run in zip(row, (clipped, ours), strict=True):
            _draw_close_up(axes, shot, run, overlap)
    style.set_title(figure, "Figure 2 of the paper: clipping, and the same instant without it")
    _set_note(
        figure,
        "Close-ups around the same two balls at the same time. Hatched: where balls overlap.",
    )
    return figure


def draw_figure_3(results: Results) -> Figure:
    """Draw the cushion collision at three times."""
    shot, ours = our_shot(results, WALL)
    motion = motion_of_run(ours)
    contact = _first_time(motion, EventKind.BALL_CUSHION)
    lead = min(0.45, 0.8 * contact)
    instants = (
        ("(a)", contact - lead, "toward the cushion and up"),
        ("(b)", contact, "its x velocity has flipped"),
        ("(c)", contact + lead, "away and up"),
    )
    view = _close_view(motion, contact - lead, contact + lead, margin=0.16)
    figure = style.new_figure(WIDTH, (WIDTH / 3.0) * aspect_of(view) + 1.0)
    for axes, (letter, t, what) in zip(figure.subplots(1, 3), instants, strict=True):
        draw_table(axes, shot.scene, view, ticks=False)
        _draw_instant(axes, shot, motion, t, trail=2.0 * lead, arrows=0.25)
        draw_scale_bar(axes, view, 0.1, "0.1 m")
        axes.set_title(f"{letter} {t:.2f} s: {what}", fontsize=9)
    style.set_title(figure, f"Figure 3 of the paper: a ball meets a cushion, {ours.style.name}")
    _set_note(figure, "Arrows: velocity just after that time. Lines: the path up to that time.")
    return figure


def draw_figure_4(results: Results) -> Figure:
    """Draw the head-on and the slightly skewed collision, before and after."""
    found = [our_shot(results, name) for name in (HEAD_ON, SKEWED)]
    views = []
    for _, ours in found:
        motion = motion_of_run(ours)
        contact = _first_time(motion, EventKind.BALL_BALL)
        views.append(_close_view(motion, contact - 0.25, contact + 0.7, margin=0.08))
    lefts, rights, bottoms, tops = zip(*views, strict=True)
    view = min(lefts), max(rights), min(bottoms), max(tops)
    cue, target = found[1][0].scene.positions[:2]
    offset = style.format_length(float(abs(cue[1] - target[1])))
    figure = style.new_figure(WIDTH, WIDTH * aspect_of(view) + 1.25)
    grid = figure.subplots(2, 2)
    cases = (("(a)", "(b)", "head-on"), ("(c)", "(d)", "slightly skewed"))
    for row, (shot, ours), (before, after, what) in zip(grid, found, cases, strict=True):
        motion = motion_of_run(ours)
        contact = _first_time(motion, EventKind.BALL_BALL)
        instants = ((row[0], before, "before", -0.25), (row[1], after, "after", 0.3))
        for axes, letter, when, dt in instants:
            draw_table(axes, shot.scene, view, ticks=False)
            _draw_instant(axes, shot, motion, contact + dt, trail=0.5, arrows=0.35)
            draw_scale_bar(axes, view, 0.1, "0.1 m")
            axes.set_title(f"{letter} {what}: {abs(dt):g} s {when} the collision", fontsize=9)
    change = f"the effect of an offset of {offset}"
    style.set_title(figure, f"Figure 4 of the paper: {change}, {found[0][1].style.name}")
    _set_note(figure, "Arrows: velocity. Lines: the last 0.5 s of each path.")
    return figure


PAPER_FIGURES: dict[str, Callable[[Results], Figure]] = {
    "paper-figure-1": draw_figure_1,
    "paper-figure-2": draw_figure_2,
    "paper-figure-3": draw_figure_3,
    "paper-figure-4": draw_figure_4,
}


def overlaps(shot: Shot, motion: Motion) -> list[Overlap]:
    """Return all overlaps of two balls at the stored times, the largest first."""
    found = [
        Overlap(float(t), a, b, length)
        for t, centres in zip(motion.times, motion.positions, strict=True)
        for a, b, length in _overlaps_at(shot.scene.radii, centres)
    ]
    return sorted(found, key=lambda overlap: -overlap.length)


def _overlaps_at(radii: FloatArray, centres: FloatArray) -> Iterator[tuple[int, int, float]]:
    """Yield the indices of each pair of overlapping balls, and the depth of the overlap [m]."""
    first, second = np.triu_indices(len(radii), k=1)
    distance = np.linalg.norm(centres[first] - centres[second], axis=1)
    length = radii[first] + radii[second] - distance
    for pair in np.flatnonzero(length > 0.0):
        yield int(first[pair]), int(second[pair]), float(length[pair])


def _clippings(results: Results) -> list[tuple[Shot, Run, Run, Overlap]]:
    """Return two large overlaps of different pairs, from different breaks if both are stored.

    Each comes with its shot, the run with the overlap, and the run of Ghostball's engine.
    """
    found = []
    for name in (name for name in (BREAK, BIG_BREAK) if name in results.scene_names):
        shot, ours = our_shot(results, name)
        clipped = next(run for run in shot.drawn if run.label == CLIPPING_ENGINE)
        largest: dict[tuple[int, int], Overlap] = {}
        for overlap in overlaps(shot, motion_of_run(clipped)):
            largest.setdefault((overlap.a, overlap.b), overlap)
        found.append([(shot, clipped, ours, overlap) for overlap in largest.values()])
    return [found[0][0], found[1][0]] if len(found) > 1 else found[0][:2]


def _draw_close_up(axes: Axes, shot: Shot, run: Run, overlap: Overlap) -> None:
    motion = motion_of_run(run)
    radius = float(shot.scene.radii.max())
    centres = _positions_at(motion, overlap.t)
    a, b = centres[overlap.a], centres[overlap.b]
    middle, half = 0.5 * (a + b), max(5.0 * radius, 0.75 * float(np.linalg.norm(a - b)))
    view = (
        float(middle[0] - 1.45 * half),
        float(middle[0] + 1.45 * half),
        float(middle[1] - half),
        float(middle[1] + half),
    )
    draw_table(axes, shot.scene, view, ticks=False)
    _draw_balls(axes, shot, centres, alpha=0.9)
    radii = shot.scene.radii
    largest = 0.0
    for i, j, length in _overlaps_at(radii, centres):
        largest = max(largest, length)
        _draw_lens(axes, centres[i], centres[j], radii[i], radii[j])
    draw_scale_bar(axes, view, 0.05, "50 mm")
    gap = float(np.linalg.norm(a - b)) - radii[overlap.a] - radii[overlap.b]
    if largest > 0.0:
        state = f"overlap {style.format_length(largest)}"
    else:
        state = f"no overlap, gap {style.format_length(gap)}"
    axes.set_title(
        f"{run.style.name}, {shot.scene.name}, t = {overlap.t:.3f} s: {state}", fontsize=9
    )


def _draw_lens(axes: Axes, a: FloatArray, b: FloatArray, radius_a: float, radius_b: float) -> None:
    """Fill the intersection of two overlapping discs."""
    from matplotlib.patches import Circle  # noqa: PLC0415

    clip = Circle((float(a[0]), float(a[1])), radius_a, transform=axes.transData)
    lens = Circle(
        (float(b[0]), float(b[1])),
        radius_b,
        facecolor=style.VERMILLION,
        edgecolor=style.BLACK,
        hatch="////",
        linewidth=0.0,
        zorder=6,
    )
    axes.add_patch(lens)
    lens.set_clip_path(clip)


def _draw_instant(
    axes: Axes, shot: Shot, motion: Motion, t: float, *, trail: float, arrows: float = 0.0
) -> None:
    """Draw the balls at a time, the last `trail` [s] of their paths, and velocities as arrows.

    `arrows` [s]: length of an arrow divided by the speed; 0 draws none.
    """
    centres = _positions_at(motion, t)
    since = (motion.times > t - trail) & (motion.times < t)
    start = _positions_at(motion, max(0.0, t - trail))
    for ball in range(len(centres)):
        path = np.concatenate([start[ball : ball + 1], motion.positions[since, ball]])
        path = np.concatenate([path, centres[ball : ball + 1]])
        axes.plot(path[:, 0], path[:, 1], color=style.GREY, linewidth=1.0, alpha=0.7, zorder=2)
    _draw_balls(axes, shot, centres)
    if arrows > 0.0:
        velocities = _velocities_after(motion, t)
        for centre, velocity in zip(centres, velocities, strict=True):
            if np.linalg.norm(velocity) > 1e-9:
                tip = centre + arrows * velocity
                axes.annotate(
                    "",
                    (tip[0], tip[1]),
                    xytext=(centre[0], centre[1]),
                    arrowprops={"arrowstyle": "-|>", "color": style.BLACK, "linewidth": 1.3},
                    annotation_clip=False,
                    zorder=5,
                )


def _draw_balls(axes: Axes, shot: Shot, centres: FloatArray, alpha: float = 1.0) -> None:
    for ball, centre in enumerate(centres):
        is_cue = shot.scene.balls[ball].id == "cue" or ball == 0
        colour = CUE_COLOUR if is_cue else BALL_COLOURS[(ball - 1) % len(BALL_COLOURS)]
        look = {"facecolor": colour, "edgecolor": style.BLACK, "linewidth": 0.8, "alpha": alpha}
        draw_ball(axes, centre, float(shot.scene.radii[ball]), zorder=4, **look)


def _table_size(shot: Shot) -> str:
    table = shot.scene.table
    return "No table" if table is None else f"Table {table.length:g} m × {table.width:g} m"


def _first_time(motion: Motion, kind: EventKind) -> float:
    of_kind = motion.events["t"][motion.events["kind"] == kind]
    return float(of_kind[0]) if len(of_kind) else float(motion.times[-1])


def _positions_at(motion: Motion, t: float) -> FloatArray:
    """Return the centres at time t, (n, 3) [m]."""
    centres: FloatArray = recorded(motion).sample(np.array([t])).positions[0]
    return centres


def _velocities_after(motion: Motion, t: float) -> FloatArray:
    """Return the velocities at the first stored time from t on, (n, 3) [m/s]."""
    index = min(int(np.searchsorted(motion.times, t)), len(motion.times) - 1)
    velocities: FloatArray = motion.velocities[index]
    return velocities


def _close_view(motion: Motion, t0: float, t1: float, margin: float) -> View:
    within = motion.positions[(motion.times >= t0) & (motion.times <= t1), :, :2].reshape(-1, 2)
    low, high = within.min(axis=0) - margin, within.max(axis=0) + margin
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _set_note(figure: Figure, text: str) -> None:
    figure.supxlabel(text, fontsize=8.5, color=style.GREY)

"""The paper's Figures 1 to 4 again, from stored motions: what it showed, now exact.

Figure 1: a break of 7 at four instants. Figure 2: two examples of clipping, beside the same
instants on our engine. Figure 3: a cushion collision. Figure 4: head-on against slightly skewed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import EventKind
from ghostball.reports import style
from ghostball.reports.figures._table import (
    View,
    aspect_of,
    draw_ball,
    draw_scale_bar,
    draw_table,
    view_of,
)
from ghostball.reports.shots import Run, Shot, load_shot
from ghostball.validation.results.store import Motion, Results

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]

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
    """Two balls inside each other: when, which, and by how much [m]."""

    t: float
    a: int
    b: int
    depth: float


def draw_figure_1(results: Results) -> Figure | None:
    """Draw the break of 7 at four instants; None where our engine's motion isn't stored."""
    shot = _ours(results, BREAK)
    if shot is None:
        return None
    motion = _motion(shot)
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
    style.set_title(figure, f"Figure 1 of the paper: a break of 7 balls, {_name(shot)}")
    _set_note(figure, f"{_table_size(shot)}. Lines: the last 0.25 s of each path.")
    return figure


def draw_figure_2(results: Results) -> Figure | None:
    """Draw two clipped instants of the paper's first algorithm, and ours at the same instants.

    None where no break holds the motions of both.
    """
    examples = _clippings(results)
    if not examples:
        return None
    figure = style.new_figure(WIDTH, 3.3 * len(examples) + 0.5)
    grid = figure.subplots(len(examples), 2, squeeze=False)
    for row, (shot, clipped, overlap) in zip(grid, examples, strict=True):
        for axes, run in zip(row, (clipped, shot.ours), strict=True):
            assert run is not None
            _draw_close_up(axes, shot, run, overlap)
    style.set_title(figure, "Figure 2 of the paper: clipping, and the same instant without it")
    _set_note(
        figure,
        "Close-ups around the same two balls at the same time. Hatched: where balls overlap.",
    )
    return figure


def draw_figure_3(results: Results) -> Figure | None:
    """Draw the cushion collision at three instants; None where it isn't stored."""
    shot = _ours(results, WALL)
    if shot is None:
        return None
    motion = _motion(shot)
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
    style.set_title(figure, f"Figure 3 of the paper: a ball meets a cushion, {_name(shot)}")
    _set_note(figure, "Arrows: velocity after the instant. Lines: the path so far.")
    return figure


def draw_figure_4(results: Results) -> Figure | None:
    """Draw head-on and slightly skewed, before and after; None where one isn't stored."""
    shots = [_ours(results, name) for name in (HEAD_ON, SKEWED)]
    found = [shot for shot in shots if shot is not None]
    if len(found) < len(shots):
        return None
    views = []
    for shot in found:
        contact = _first_time(_motion(shot), EventKind.BALL_BALL)
        views.append(_close_view(_motion(shot), contact - 0.25, contact + 0.7, margin=0.08))
    view = _common(views)
    cue, target = found[1].scene.positions[:2]
    offset = style.format_length(float(abs(cue[1] - target[1])))
    figure = style.new_figure(WIDTH, WIDTH * aspect_of(view) + 1.25)
    grid = figure.subplots(2, 2)
    cases = (("(a)", "(b)", "head-on"), ("(c)", "(d)", "slightly skewed"))
    for row, shot, (before, after, what) in zip(grid, found, cases, strict=True):
        motion = _motion(shot)
        contact = _first_time(motion, EventKind.BALL_BALL)
        instants = ((row[0], before, "before", -0.25), (row[1], after, "after", 0.3))
        for axes, letter, when, dt in instants:
            draw_table(axes, shot.scene, view, ticks=False)
            _draw_instant(axes, shot, motion, contact + dt, trail=0.5, arrows=0.35)
            draw_scale_bar(axes, view, 0.1, "0.1 m")
            axes.set_title(f"{letter} {what}: {abs(dt):g} s {when} the hit", fontsize=9)
    change = f"what {offset} off centre changes"
    style.set_title(figure, f"Figure 4 of the paper: {change}, {_name(found[0])}")
    _set_note(figure, "Arrows: velocity. Lines: the last 0.5 s of each path.")
    return figure


PAPER_FIGURES: dict[str, Callable[[Results], Figure | None]] = {
    "paper-figure-1": draw_figure_1,
    "paper-figure-2": draw_figure_2,
    "paper-figure-3": draw_figure_3,
    "paper-figure-4": draw_figure_4,
}


def overlaps(shot: Shot, motion: Motion) -> list[Overlap]:
    """Return every stored instant at which two balls are inside each other, deepest first."""
    radii = shot.scene.radii
    first, second = np.triu_indices(len(radii), k=1)
    apart = np.linalg.norm(motion.positions[:, first] - motion.positions[:, second], axis=2)
    depth = radii[first] + radii[second] - apart
    when, pair = np.nonzero(depth > 0.0)
    order = np.argsort(-depth[when, pair], kind="stable")
    return [
        Overlap(float(motion.times[k]), int(first[p]), int(second[p]), float(depth[k, p]))
        for k, p in zip(when[order], pair[order], strict=True)
    ]


def _clippings(results: Results) -> list[tuple[Shot, Run, Overlap]]:
    """Return two deep overlaps of different pairs, from different breaks where there are two."""
    found: list[tuple[Shot, Run, Overlap]] = []
    for name in (BREAK, BIG_BREAK):
        shot = _ours(results, name)
        if shot is None:
            continue
        clipped = next((run for run in shot.drawn if run.label == CLIPPING_ENGINE), None)
        if clipped is None or clipped.motion is None:
            continue
        deepest: dict[tuple[int, int], Overlap] = {}
        for overlap in overlaps(shot, clipped.motion):
            deepest.setdefault((overlap.a, overlap.b), overlap)
        found += [(shot, clipped, overlap) for overlap in list(deepest.values())[:2]]
    breaks = {shot.scene.name for shot, _, _ in found}
    if len(breaks) > 1:
        found = [found[0], next(e for e in found if e[0] is not found[0][0])]
    return found[:2]


def _draw_close_up(axes: Axes, shot: Shot, run: Run, overlap: Overlap) -> None:
    motion = run.motion
    assert motion is not None
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
    deepest = 0.0
    radii = shot.scene.radii
    for i in range(len(radii)):
        for j in range(i + 1, len(radii)):
            depth = radii[i] + radii[j] - float(np.linalg.norm(centres[i] - centres[j]))
            if depth > 0.0:
                deepest = max(deepest, depth)
                _draw_lens(axes, centres[i], centres[j], radii[i], radii[j])
    draw_scale_bar(axes, view, 0.05, "50 mm")
    gap = float(np.linalg.norm(a - b)) - radii[overlap.a] - radii[overlap.b]
    if deepest > 0.0:
        state = f"overlap {style.format_length(deepest)}"
    else:
        state = f"no overlap, gap {style.format_length(gap)}"
    axes.set_title(
        f"{run.style.name}, {shot.scene.name}, t = {overlap.t:.3f} s: {state}", fontsize=9
    )


def _draw_lens(axes: Axes, a: FloatArray, b: FloatArray, radius_a: float, radius_b: float) -> None:
    """Fill what two overlapping discs share."""
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
    """Draw the balls at an instant, the last `trail` seconds of path, and velocities x `arrows`."""
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


def _ours(results: Results, name: str) -> Shot | None:
    """Return a scene where it is stored with our engine's motion."""
    if name not in results.scene_names:
        return None
    shot = load_shot(results, name)
    return shot if shot.ours is not None else None


def _motion(shot: Shot) -> Motion:
    assert shot.ours is not None
    assert shot.ours.motion is not None
    return shot.ours.motion


def _name(shot: Shot) -> str:
    assert shot.ours is not None
    return shot.ours.style.name


def _table_size(shot: Shot) -> str:
    table = shot.scene.table
    return "No table" if table is None else f"Table {table.length:g} m × {table.width:g} m"


def _first_time(motion: Motion, kind: EventKind) -> float:
    of_kind = motion.events["t"][motion.events["kind"] == kind]
    return float(of_kind[0]) if len(of_kind) else float(motion.times[-1])


def _positions_at(motion: Motion, t: float) -> FloatArray:
    """Return the centres at t, (n, 3) [m]: stored instants exactly, else straight between."""
    balls = range(motion.positions.shape[1])
    return np.array(
        [[np.interp(t, motion.times, motion.positions[:, b, k]) for k in range(3)] for b in balls]
    )


def _velocities_after(motion: Motion, t: float) -> FloatArray:
    """Return the velocities at the first stored instant at or after t, (n, 3) [m/s]."""
    index = min(int(np.searchsorted(motion.times, t)), len(motion.times) - 1)
    velocities: FloatArray = motion.velocities[index]
    return velocities


def _close_view(motion: Motion, t0: float, t1: float, margin: float) -> View:
    within = motion.positions[(motion.times >= t0) & (motion.times <= t1), :, :2].reshape(-1, 2)
    low, high = within.min(axis=0) - margin, within.max(axis=0) + margin
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _common(views: list[View]) -> View:
    lefts, rights, bottoms, tops = zip(*views, strict=True)
    return min(lefts), max(rights), min(bottoms), max(tops)


def _set_note(figure: Figure, text: str) -> None:
    figure.supxlabel(text, fontsize=8.5, color=style.GREY)

"""A shot as a moving picture: what `ghostball run --plot shot.gif` writes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ghostball.model import GhostballError, Result
from ghostball.reports import style
from ghostball.reports.figures._table import aspect_of, draw_discs, draw_table, view_of
from ghostball.reports.figures.single import FEW, ball_colours

FILMS = (".gif", ".mp4")
"""Endings of films; one says the format."""

WIDTH = 6.4
"""Width of a film [inch]."""

FRAMES_A_SECOND = 25

LONGEST = 12.0
"""How long a film takes at most [s]: a longer shot is shown faster, and the film says so."""


def film_result(result: Result, path: Path) -> None:
    """Write a shot as a film of its balls on the table, in colours of their own.

    `result`: with a motion.
    `path`: where to write; its ending, .gif or .mp4, is the format.
    """
    from matplotlib.animation import FFMpegWriter, PillowWriter  # noqa: PLC0415

    mp4 = path.suffix.lower() == ".mp4"
    if mp4 and not FFMpegWriter.isAvailable():
        raise GhostballError(
            f"{path}: a film as MP4 needs ffmpeg on the PATH. Install it (Debian, Ubuntu: apt "
            "install ffmpeg), or write a .gif"
        )
    speed = max(1.0, result.rest_time / LONGEST)
    frames = 2 + int(result.rest_time / speed * FRAMES_A_SECOND)
    times = np.linspace(0.0, result.rest_time, frames)
    positions = result.sample(times).positions
    scene = result.scene
    view = view_of(scene, positions[[0, -1]], needed=positions[0])
    figure = style.new_figure(WIDTH, WIDTH * min(aspect_of(view), 1.2), laid_out=False)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    draw_table(axes, scene, view, ticks=False)
    colours = ball_colours(len(scene.balls))
    discs = draw_discs(axes, positions[0], scene.radii, facecolors=colours, edgecolors="white")
    names = [ball.id for ball in scene.balls] if len(scene.balls) <= FEW else []
    texts = [
        axes.text(0.0, 0.0, name, ha="center", va="bottom", fontsize=7.5, clip_on=True)
        for name in names
    ]
    faster = f" ({speed:.2g} times as fast)" if speed > 1.0 else ""
    clock = figure.text(0.04, 0.9, "", fontsize=9)
    writer = (FFMpegWriter if mp4 else PillowWriter)(fps=FRAMES_A_SECOND)
    with writer.saving(figure, str(path), dpi=100):
        for t, places in zip(times, positions, strict=True):
            discs.set_offsets(places[:, :2])
            for text, place, radius in zip(texts, places, scene.radii, strict=False):
                text.set_position((place[0], place[1] + 1.1 * radius))
            clock.set_text(f"{t:.2f} s{faster}")
            writer.grab_frame()

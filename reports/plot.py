"""Draw one result without a results folder, or film it: what `ghostball run --plot` writes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ghostball.model import GhostballError, Result
from ghostball.reports import style
from ghostball.reports.figures._table import aspect_of, draw_discs, draw_table, view_of
from ghostball.reports.figures.single import FEW, ball_colours, draw_single
from ghostball.reports.shots import Run, Shot
from ghostball.validation.results.records import CaseRecord, status_name
from ghostball.validation.runs.sampling import motion_of

ENDINGS = (".png", ".svg", ".pdf")


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
    faster = f" ({speed:.2g} × speed)" if speed > 1.0 else ""
    clock = figure.text(0.04, 0.9, "", fontsize=9)
    writer = (FFMpegWriter if mp4 else PillowWriter)(fps=FRAMES_A_SECOND)
    with writer.saving(figure, str(path), dpi=100):
        for t, places in zip(times, positions, strict=True):
            discs.set_offsets(places[:, :2])
            for text, place, radius in zip(texts, places, scene.radii, strict=False):
                text.set_position((place[0], place[1] + 1.1 * radius))
            clock.set_text(f"{t:.2f} s{faster}")
            writer.grab_frame()


def plot_result(result: Result, path: str | Path) -> Path:
    """Draw the paths and rest positions of one run.

    `result`: recorded with `record="trajectory"`.
    `path`: where to write; its ending, .png, .svg or .pdf, is the format; .gif and .mp4 are films.
    """
    if result.events is None:
        raise GhostballError(
            f"engine `{result.engine}` recorded no motion, so there is nothing to draw. Call "
            'simulate(scene, record="trajectory")'
        )
    case = CaseRecord(
        scene=result.scene.name,
        title=result.scene.title,
        tags=result.scene.tags,
        definition=result.scene.model_dump(mode="json", by_alias=True),
        label=result.engine,
        engine=result.engine,
        outcome="ran",
        status=status_name(result.status),
        rest_positions=result.rest_positions,
        rest_time=result.rest_time,
        collision_counts=dict(result.collision_counts),
    )
    shot = Shot(result.scene, (Run(result.engine, case, motion_of(result)),))

    def draw(target: Path) -> None:
        if target.suffix.lower() in FILMS:
            film_result(result, target)
        else:
            style.save_one(draw_single(shot), target)

    return write_picture(path, draw, ENDINGS + FILMS)


def write_picture(
    path: str | Path, write: Callable[[Path], None], endings: Sequence[str] = ENDINGS
) -> Path:
    """Let a picture be written, whose ending says the format.

    Raises `GhostballError` where the ending is another, or the file can't be written.
    """
    target = Path(path)
    if target.suffix.lower() not in endings:
        raise GhostballError(
            f"`path` must end in {', '.join(endings)}, got {target.name!r}: the ending says the "
            "format"
        )
    with style.drawing():
        try:
            write(target)
        except OSError as error:
            raise GhostballError(
                f"{target}: can't write the picture: {error.strerror or error}. Choose another file"
            ) from error
    return target

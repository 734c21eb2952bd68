"""Draw one result as a picture or a film, without a results folder.

>>> from ghostball import film, find_scene, plot, simulate
>>> result = simulate(find_scene("break-7"), record="trajectory")
>>> plot(result, "break.png")
PosixPath('break.png')
>>> film(result, "break.gif")
PosixPath('break.gif')
"""

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
"""Endings of pictures; the ending sets the format."""

FILMS = (".gif", ".mp4")
"""Endings of films; the ending sets the format."""

WIDTH = 6.4
"""Width of a film [inch]."""

STRIP = 0.3
"""Height of the strip above the table, for the clock [inch]."""

FRAMES_A_SECOND = 25

LONGEST = 12.0
"""Longest duration of a film [s]: a longer shot is shown faster, and the film says so."""


def plot(result: Result, path: str | Path) -> Path:
    """Draw the paths and rest positions of a result.

    Parameters
    ----------
    result : Result
        Result of any engine, with a motion: `simulate(scene, record="trajectory")`.
    path : str or Path
        File to write; its ending, .png, .svg or .pdf, sets the format.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    GhostballError
        If the result has no motion, if the ending is none of these, or if the file can't be
        written.
    """
    shot = _shot_of(result)
    return write_picture(path, lambda target: style.save_one(draw_single(shot), target))


def film(result: Result, path: str | Path) -> Path:
    """Write a film of a result: the balls move on the table, at their true speed.

    A shot longer than 12 s is shown faster; the clock in the film shows the factor.

    Parameters
    ----------
    result : Result
        Result of any engine, with a motion: `simulate(scene, record="trajectory")`.
    path : str or Path
        File to write; its ending, .gif or .mp4, sets the format. MP4 needs ffmpeg.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    GhostballError
        If the result has no motion, if the ending is none of these, if ffmpeg is missing, or if
        the file can't be written.
    """
    _shot_of(result)
    return write_picture(path, lambda target: _film(result, target), FILMS)


def plot_result(result: Result, path: str | Path) -> Path:
    """Write a picture or a film, according to the ending of `path`; see `plot` and `film`."""
    return (film if is_film(path) else plot)(result, path)


def is_film(path: str | Path) -> bool:
    """Return True if the ending of `path` is that of a film."""
    return Path(path).suffix.lower() in FILMS


def _shot_of(result: Result) -> Shot:
    """Return a result as a shot with one run, for figures.

    Raises `GhostballError` if the result has no motion.
    """
    if result.trajectory is None:
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
    return Shot(result.scene, (Run(result.engine, case, motion_of(result)),))


def _film(result: Result, path: Path) -> None:
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
    high = WIDTH * min(aspect_of(view), 1.2)
    figure = style.new_figure(WIDTH, high + STRIP, laid_out=False)
    # The clock has a strip of its own: in the picture it would hide a pocket, or a ball.
    axes = figure.add_axes((0.0, 0.0, 1.0, high / (high + STRIP)))
    draw_table(axes, scene, view, ticks=False)
    colours = ball_colours(len(scene.balls))
    discs = draw_discs(axes, positions[0], scene.radii, facecolors=colours, edgecolors="white")
    names = [ball.id for ball in scene.balls] if len(scene.balls) <= FEW else []
    texts = [
        axes.text(0.0, 0.0, name, ha="center", va="bottom", fontsize=7.5, clip_on=True)
        for name in names
    ]
    faster = f" ({speed:.2g} × speed)" if speed > 1.0 else ""
    middle = 1.0 - 0.5 * STRIP / (high + STRIP)
    figure.text(0.02, middle, scene.name, fontsize=9, fontweight="bold", va="center")
    clock = figure.text(0.98, middle, "", fontsize=9, ha="right", va="center")
    writer = (FFMpegWriter if mp4 else PillowWriter)(fps=FRAMES_A_SECOND)
    with writer.saving(figure, str(path), dpi=100):
        for t, places in zip(times, positions, strict=True):
            discs.set_offsets(places[:, :2])
            for text, place, radius in zip(texts, places, scene.radii, strict=False):
                text.set_position((place[0], place[1] + 1.1 * radius))
            clock.set_text(f"{t:.2f} s{faster}")
            writer.grab_frame()


def write_picture(
    path: str | Path, write: Callable[[Path], None], endings: Sequence[str] = ENDINGS
) -> Path:
    """Call `write` with the path of a picture or a film; its ending sets the format.

    Raises `GhostballError` if the ending is none of `endings`, or if the file can't be written.
    """
    target = Path(path)
    if target.suffix.lower() not in endings:
        raise GhostballError(
            f"`path` must end in {', '.join(endings)}, got {target.name!r}: the ending sets the "
            f"format{_other_function(target)}"
        )
    with style.drawing():
        try:
            write(target)
        except OSError as error:
            raise GhostballError(
                f"{target}: can't write the picture: {error.strerror or error}. Choose another file"
            ) from error
    return target


def _other_function(path: Path) -> str:
    """Return a hint to use `film` or `plot` if the file has an ending of the other function."""
    if is_film(path):
        return ". Call `film` for a film"
    return ". Call `plot` for a picture" if path.suffix.lower() in ENDINGS else ""

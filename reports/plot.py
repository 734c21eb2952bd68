"""Draw one result without a results folder: what `ghostball run --plot` writes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ghostball.model import GhostballError, Result
from ghostball.reports import style
from ghostball.reports.figures.single import draw_single
from ghostball.reports.film import FILMS, film_result
from ghostball.reports.shots import Run, Shot
from ghostball.validation.results.records import CaseRecord, status_name
from ghostball.validation.runs.sampling import motion_of

ENDINGS = (".png", ".svg", ".pdf")


def plot_result(result: Result, path: str | Path) -> Path:
    """Draw the paths and rest positions of one run.

    `result`: recorded with `record="trajectory"`.
    `path`: where to write; its ending, .png, .svg or .pdf, is the format; .gif and .mp4 are films.
    """
    if result.events is None:
        raise GhostballError(
            f"engine `{result.engine}` recorded no motion to draw. Call "
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

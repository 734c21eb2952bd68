"""Write the report of a results folder: `report.html`, and pictures beside it.

The pictures are a sheet for each scene (`NAME-sheet`). The page is complete without them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import closing
from functools import lru_cache, partial
from pathlib import Path, PurePosixPath
from typing import Literal

from ghostball.model import GhostballError
from ghostball.model.text_files import write_whole
from ghostball.reference_adapters.output import harmless
from ghostball.reports import style
from ghostball.reports.failed_parts import FailedPart, IncompleteReportError, attempt
from ghostball.reports.figures import draw_sheet
from ghostball.reports.page import ScenePagePart, failed_scene_part, page_text, scene_part
from ghostball.reports.shots import Shot, load_shot
from ghostball.validation.baselines import Regression, load_regression
from ghostball.validation.parallel.pool import Progress, run_tasks
from ghostball.validation.results.store import Results

FIGURES = "figures"
PAGE = "report.html"
ENDINGS = tuple(f".{ending}" for ending in style.FORMATS)

SHEET = "-sheet"
"""End of the file name of a sheet, after the name of the scene."""

PART = f"part of {PAGE} on scene "
"""Start of the name of a task, before the name of the scene whose part and sheet it makes."""

CASES_WORTH_A_PROCESS = 100
"""Number of cases without pictures that take as long as starting another process."""

FIGURE = "figure "
"""Start of the name of a figure in messages, before its file name without the ending."""

Pictures = Literal["png", "svg", "none"]
"""Pictures to draw: PNG, PNG and SVG, or none."""

_Answer = tuple[ScenePagePart | Exception, list[FailedPart]]
"""Result of a task: the part, or the error that stops the report; and the failed parts."""


class ReportError(GhostballError):
    """A report that can't be written."""


def write_report(
    results_dir: str | Path,
    *,
    progress: Progress[str] | None = None,
    jobs: int = 1,
    figures: Pictures = "png",
) -> Path:
    """Write `report.html` and `figures/`, only from the files in a results folder.

    `results_dir`: a folder that the suite wrote.
    `progress`: called with the number of finished parts, the number of all parts, and the name of
        the last finished part.
    `jobs`: largest number of processes. With more than one, protect a script with `if __name__ ==
        "__main__"`.
    `figures`: draw a sheet of each scene as PNG, as PNG and SVG, or not at all. Sheets of an
        earlier report that aren't drawn again are removed.

    Returns the path of `report.html`, which is replaced only when everything is finished.

    Raises `ReportError` if there is nothing to report, or if the report can't be written. Raises
    `IncompleteReportError` after writing, if a bug prevented some parts.
    """
    _load.cache_clear()
    results, regression = _load(Path(results_dir))
    if not results.cases:
        raise ReportError(
            f"{results.path}: contains no results, so there is nothing to report. Run `ghostball "
            "validate` again"
        )
    failed: list[FailedPart] = []
    try:
        (results.path / FIGURES).mkdir(exist_ok=True)
        parts: dict[str, ScenePagePart] = {}
        tasks = [PART + name for name in results.scene_names]
        if figures == "none":
            jobs = min(jobs, len(tasks) * len(results.labels) // CASES_WORTH_A_PROCESS)
        work = partial(_make, results.path, figures)
        with closing(run_tasks(tasks, max(jobs, 1), work)) as finished:
            for number, done in enumerate(finished, start=1):
                made, wrong = done.or_else(_crashed)
                if isinstance(made, Exception):
                    raise made
                failed += wrong
                parts[done.task.removeprefix(PART)] = made
                if progress is not None:
                    progress(number, len(tasks), done.task)
        report = results.path / PAGE
        # Without control characters, which would act on a terminal that shows the file.
        page = harmless(page_text(results, parts, regression, failed)).encode()
        write_whole(report, page)
        sheets = [part.sheet for part in parts.values() if part.sheet is not None]
        _remove_stale(results.path, sheets, figures)
    except OSError as error:
        raise _cannot_write(results.path, error) from error
    if failed:
        raise IncompleteReportError(report, failed)
    return report


def _cannot_write(path: Path, error: OSError) -> ReportError:
    return ReportError(
        f"{error.filename or path}: can't write the report: {error.strerror or error}. "
        "Copy the results to a writable folder, and make the report from there"
    )


def _make(path: Path, figures: Pictures, task: str) -> _Answer:
    """Make a scene's part of the page; if this fails, a part that shows the error."""
    name, failed = task.removeprefix(PART), list[FailedPart]()
    try:
        made = attempt(task, partial(_scene_part, path, figures, name, failed), failed)
    except (GhostballError, OSError) as error:  # the user can fix the cause
        return error, failed
    return failed_scene_part(name, failed[-1]) if made is None else made, failed


@lru_cache(maxsize=1)
def _load(path: Path) -> tuple[Results, Regression | None]:
    """Read a results folder, once in each process: the cases, and the changes since baselines."""
    results = Results.open(path)
    return results, load_regression(results.path)


def _crashed(task: str, reason: str) -> _Answer:
    failed = FailedPart(task, reason, reason)
    return failed_scene_part(task.removeprefix(PART), failed), [failed]


def _scene_part(
    path: Path, figures: Pictures, name: str, failed: list[FailedPart]
) -> ScenePagePart:
    results, regression = _load(path)
    shot = load_shot(results, name)
    sheet = None
    if figures != "none":
        endings = style.FORMATS if figures == "svg" else style.FORMATS[:1]
        sheet = _drawn(path / FIGURES / f"{name}{SHEET}", shot, endings, failed)
    change = None if regression is None else regression.scene(name)
    return scene_part(shot, change, sheet)


def _drawn(
    stem: Path, shot: Shot, endings: Sequence[str], failed: list[FailedPart]
) -> PurePosixPath | None:
    """Draw and write a sheet; return its PNG, relative to the page, or None without a sheet."""

    def drawn() -> bool:
        figure = draw_sheet(shot)
        if figure is None:
            return False
        try:
            style.save_figure(figure, stem, endings=endings)
        except OSError as error:
            raise _cannot_write(stem, error) from error
        return True

    picture = PurePosixPath(FIGURES, f"{stem.name}.{endings[0]}")
    with style.drawing():
        return picture if attempt(FIGURE + stem.name, drawn, failed) else None


def _remove_stale(folder: Path, drawn: Iterable[PurePosixPath], figures: Pictures) -> None:
    """Remove sheets of an earlier report; files with other names stay."""
    kept = {path.stem for path in drawn}
    for path in (folder / FIGURES).iterdir():
        ours = path.stem.endswith(SHEET)
        stale = path.stem not in kept or (path.suffix == ".svg" and figures != "svg")
        if path.suffix in ENDINGS and ours and stale:
            path.unlink()

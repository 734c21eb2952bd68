"""Write the report of a results folder: `report.html`, and pictures beside it.

The page is whole without the pictures: a sheet for each scene (`NAME-sheet`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Literal

from ghostball.model import GhostballError
from ghostball.reference_adapters.output import harmless
from ghostball.reports import style
from ghostball.reports.figures import draw_sheet
from ghostball.reports.guarded import FailedPart, IncompleteReportError, attempt
from ghostball.reports.page import ScenePart, failed_scene_part, page_text, scene_part
from ghostball.reports.shots import load_shot
from ghostball.validation.baselines import Regression, load_regression
from ghostball.validation.parallel.pool import Progress, run_tasks
from ghostball.validation.results.files import write_whole
from ghostball.validation.results.store import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURES = "figures"
PAGE = "report.html"
ENDINGS = tuple(f".{ending}" for ending in style.FORMATS)

SHEET = "-sheet"
"""What stands after a scene's name in the file of its sheet."""

PART = f"part of {PAGE} on scene "
"""What a task calls a scene's part of the page and its sheet, before the scene's name."""

FIGURE = "figure "
"""What is said of a figure that can't be made, before its file without the ending."""

Pictures = Literal["png", "svg", "none"]
"""Which pictures are drawn: PNG, SVG beside it, or none at all."""

_Answer = tuple[ScenePart | Exception, list[FailedPart]]
"""What came of a task or why all ends here, and what could not be made."""


class ReportError(GhostballError):
    """A report that can't be written."""


@dataclass(frozen=True)
class Source:
    """What a report is made of: the cases, and what changed."""

    results: Results
    regression: Regression | None
    figures: Pictures

    @classmethod
    def load(cls, path: str | Path, figures: Pictures) -> Source:
        """Read a results folder; errors are those of its parts."""
        results = Results.open(path)
        return cls(results, load_regression(results.path), figures)


def write_report(
    results_dir: str | Path,
    *,
    progress: Progress[str] | None = None,
    jobs: int = 1,
    figures: Pictures = "png",
) -> Path:
    """Write `report.html` and `figures/`, from what a results folder holds alone.

    Parameters
    ----------
    results_dir : path
        A folder that the suite wrote.
    progress : callable, optional
        Called with how many parts are done, of how many, and which was the last.
    jobs : int
        Processes that make it. With more than one, guard a script with `if __name__ == "__main__"`.
    figures : "png", "svg" or "none"
        Draw a sheet of each scene as PNG, as PNG and SVG, or not at all. What an earlier report
        drew and this one doesn't is removed.

    Returns
    -------
    Path
        Of `report.html`, which is replaced only once all is made.

    Raises
    ------
    GhostballError
        Where the folder holds no results, they are damaged, or nothing can be written.
    IncompleteReportError
        Where a section or a figure could not be made. All else is written by then.
    """
    source = Source.load(results_dir, figures)
    results = source.results
    if not results.cases:
        raise ReportError(
            f"{results.path}: holds no case, so there is nothing to report. Run the suite again"
        )
    tasks = [PART + name for name in results.scene_names]
    parts: dict[str, ScenePart] = {}
    failed: list[FailedPart] = []
    try:
        (results.path / FIGURES).mkdir(exist_ok=True)
        for done, (task, made) in enumerate(_make_all(source, tasks, jobs, failed), start=1):
            parts[task.removeprefix(PART)] = made
            if progress is not None:
                progress(done, len(tasks), task)
        report = results.path / PAGE
        page = page_text(results, parts, source.regression, failed)
        write_whole(report, harmless(page))  # what engines say may steer a terminal
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
        "Copy the results to a folder that can be written, and report on that"
    )


def _make_all(
    source: Source, tasks: Sequence[str], jobs: int, failed: list[FailedPart]
) -> Iterator[tuple[str, ScenePart]]:
    """Make what every task asks for; yield each as it is done."""
    work = (
        partial(_answer, source)
        if jobs <= 1
        else partial(_make_in_worker, source.results.path, source.figures)
    )
    with closing(run_tasks(tasks, max(jobs, 1), work)) as finished:
        for done in finished:
            made, wrong = done.or_else(_died)
            if isinstance(made, Exception):
                raise made
            failed += wrong
            yield done.task, made


def _answer(source: Source, task: str) -> _Answer:
    failed: list[FailedPart] = []
    try:
        return _make(source, task, failed), failed
    except (GhostballError, OSError) as error:  # whoever asked can mend it
        return error, failed


def _make_in_worker(path: Path, figures: Pictures, task: str) -> _Answer:
    try:
        return _answer(_load_once(path, figures), task)
    except GhostballError as error:  # it was sound when this one was started
        return error, []


def _died(task: str, reason: str) -> _Answer:
    failed = FailedPart(task, reason, reason)
    return failed_scene_part(task.removeprefix(PART), failed), [failed]


@lru_cache(maxsize=1)
def _load_once(path: Path, figures: Pictures) -> Source:
    return Source.load(path, figures)


def _make(source: Source, task: str, failed: list[FailedPart]) -> ScenePart:
    name = task.removeprefix(PART)
    made = attempt(task, partial(_scene_part, source, name, failed), failed)
    return failed_scene_part(name, failed[-1]) if made is None else made


def _scene_part(source: Source, name: str, failed: list[FailedPart]) -> ScenePart:
    shot = load_shot(source.results, name)
    sheet = None
    if source.figures != "none":
        sheet = _drawn(source, name + SHEET, partial(draw_sheet, shot), failed)
    change = None if source.regression is None else source.regression.scene(name)
    return scene_part(shot, change, sheet)


def _drawn(
    source: Source,
    name: str,
    draw: Callable[[], Figure | None],
    failed: list[FailedPart],
) -> PurePosixPath | None:
    """Draw a figure and write it; return its PNG, relative to the page, or None without one."""
    endings = style.FORMATS if source.figures == "svg" else style.FORMATS[:1]
    stem = source.results.path / FIGURES / name

    def drawn() -> bool:
        figure = draw()
        if figure is None:
            return False
        try:
            style.save_figure(figure, stem, endings=endings)
        except OSError as error:
            raise _cannot_write(stem, error) from error
        return True

    with style.drawing():
        if not attempt(FIGURE + name, drawn, failed):
            return None
    return PurePosixPath(FIGURES, f"{name}.{endings[0]}")


def _remove_stale(folder: Path, drawn: Iterable[PurePosixPath], figures: Pictures) -> None:
    """Remove pictures that an earlier report left; what somebody else put there stays."""
    kept = {path.stem for path in drawn}
    for path in (folder / FIGURES).iterdir():
        ours = path.stem.endswith(SHEET)
        stale = path.stem not in kept or (path.suffix == ".svg" and figures != "svg")
        if path.suffix in ENDINGS and ours and stale:
            path.unlink()

"""Write the report of a results folder: every figure as PNG and SVG, and `report.md`."""

from __future__ import annotations

import logging
import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import lru_cache, partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from engine import GhostballError
from reports import style
from reports.attribution_figure import draw_attribution
from reports.chaos_figure import draw_chaos
from reports.figures import SCENE_FIGURES, draw_accuracy, draw_ensemble, draw_verdicts
from reports.markdown import report_text
from reports.markdown_parts import Drawn
from reports.paper_figures import PAPER_FIGURES
from reports.physics_figures import PHYSICS_FIGURES
from reports.precision_figure import draw_precision, draw_precision_work
from reports.scaling_figure import draw_scaling
from reports.shots import load_shot
from validation.ensembles import Ensembles
from validation.store import ResultsFolder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOGGER = logging.getLogger("ghostball.reports")

FIGURES = "figures"
REPORT = "report.md"
ENDINGS = tuple(f".{ending}" for ending in style.FORMATS)

WHOLE = "the whole run"
"""What a task calls the figures that belong to no scene; no scene's name has a space."""

ENSEMBLE = "ensemble of "
"""What a task calls the figure of a scene's ensemble, before the scene's name."""

Progress = Callable[[int, int, str], None]
"""Called with how many parts are done, of how many, and which was the last."""

WHOLE_FIGURES: dict[str, Callable[[ResultsFolder], Figure | None]] = {
    "verdicts": draw_verdicts,
    "accuracy": draw_accuracy,
    "chaos": draw_chaos,
    "scaling": draw_scaling,
    "precision": draw_precision,
    "precision-work": draw_precision_work,
    "attribution": draw_attribution,
    **PHYSICS_FIGURES,
    **PAPER_FIGURES,
}


class ReportError(GhostballError):
    """A report that can't be written."""


def write_report(
    results_dir: str | Path, *, progress: Progress | None = None, jobs: int = 1
) -> Path:
    """Write `report.md` and `figures/` into a results folder, from what is stored there alone.

    Parameters
    ----------
    results_dir : path
        A folder that the suite wrote.
    progress : callable, optional
        Called after each part with the number done, the number of all, and the part's name.
    jobs : int
        Processes that draw. With more than one, guard a script with `if __name__ == "__main__"`.

    Returns
    -------
    Path
        The report, replaced only once every figure is there.

    Raises
    ------
    GhostballError
        Where the folder holds no results, they are damaged, or nothing can be written.
    """
    results = ResultsFolder.load(results_dir)
    if not results.cases:
        raise ReportError(
            f"{results.path}: holds no case, so there is nothing to report. Run the suite again"
        )
    if results.cut_short:
        _LOGGER.warning(
            "%s: the last line is cut short, for the run was killed while it wrote; it is left out",
            results.cut_short,
        )
    ensembles = Ensembles.load(results.path)
    perturbed = [] if ensembles is None else [ENSEMBLE + name for name in ensembles.run.scenes]
    tasks = [WHOLE, *results.scene_names, *perturbed]
    drawn: dict[str, Drawn] = {}
    try:
        (results.path / FIGURES).mkdir(exist_ok=True)
        for done, (task, figures) in enumerate(_draw_all(results, tasks, jobs), start=1):
            drawn[task] = figures
            if progress is not None:
                progress(done, len(tasks), task)
        whole = drawn.pop(WHOLE)
        physics, paper = (
            {kind: path for kind, path in whole.items() if kind in kinds}
            for kinds in (PHYSICS_FIGURES, PAPER_FIGURES)
        )
        clouds = {
            task.removeprefix(ENSEMBLE): path
            for task in perturbed
            for path in drawn.pop(task).values()
        }
        text = report_text(results, whole, drawn, physics, paper, clouds)
        report = results.path / REPORT
        part = report.with_name(REPORT + ".part")
        part.write_text(text, encoding="utf-8")
        part.replace(report)
        _remove_stale(results.path, [whole, clouds, *drawn.values()])
    except OSError as error:
        raise ReportError(
            f"{error.filename or results.path}: can't write the report: {error.strerror or error}. "
            "Copy the results to a folder that can be written, and report on that"
        ) from error
    return report


def _draw_all(results: ResultsFolder, tasks: list[str], jobs: int) -> Iterator[tuple[str, Drawn]]:
    """Draw the figures of every task; yield each as it is done."""
    if jobs <= 1:
        for task in tasks:
            yield task, _draw_task(results, task)
        return
    # Not fork: whoever calls may have threads, and a progress bar is one.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(tasks)), mp_context=context) as pool:
        waiting = {pool.submit(_draw_in_worker, results.path, task): task for task in tasks}
        try:
            for future in as_completed(waiting):
                yield waiting[future], future.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _draw_in_worker(path: Path, task: str) -> Drawn:
    return _draw_task(_load_once(path), task)


@lru_cache(maxsize=1)
def _load_once(path: Path) -> ResultsFolder:
    return ResultsFolder.load(path)


def _draw_task(results: ResultsFolder, task: str) -> Drawn:
    if task == WHOLE:
        made = ((kind, draw, results) for kind, draw in WHOLE_FIGURES.items())
        return _save_all(results.path, "", made)
    if task.startswith(ENSEMBLE):
        name = task.removeprefix(ENSEMBLE)
        ensembles = Ensembles.load(results.path)
        assert ensembles is not None  # they gave the task its name
        return _save_all(
            results.path, f"{name}-", [("ensemble", partial(draw_ensemble, ensembles), name)]
        )
    shot = load_shot(results, task)
    return _save_all(
        results.path, f"{task}-", ((kind, draw, shot) for kind, draw in SCENE_FIGURES.items())
    )


def _save_all(
    folder: Path, prefix: str, made: Iterable[tuple[str, Callable[..., Figure | None], object]]
) -> Drawn:
    written: dict[str, PurePosixPath] = {}
    for kind, draw, subject in made:
        with style.drawing():
            figure = draw(subject)
            if figure is not None:
                stem = PurePosixPath(FIGURES, prefix + kind)
                style.save_figure(figure, folder / stem)
                written[kind] = stem
    return written


def _remove_stale(folder: Path, drawn: Iterable[Drawn]) -> None:
    """Remove figures that an earlier report left: `figures/` is the report's own."""
    kept = {path.name + ending for one in drawn for path in one.values() for ending in ENDINGS}
    for path in (folder / FIGURES).iterdir():
        if path.suffix in ENDINGS and path.name not in kept:
            path.unlink()

"""Write the report of a results folder: figures as PNG and SVG, `report.md` and `report.html`."""

from __future__ import annotations

import logging
import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
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
from reports.page import ScenePart, page_text, scene_part
from reports.paper_figures import PAPER_FIGURES
from reports.physics_figures import PHYSICS_FIGURES
from reports.precision_figure import draw_precision, draw_precision_work
from reports.scaling_figure import draw_scaling
from reports.shots import load_shot
from validation.ensembles import Ensembles
from validation.files import write_all_whole
from validation.predictability import Predictability, predictability_in
from validation.regression import Regression, load_regression
from validation.store import ResultsFolder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOGGER = logging.getLogger("ghostball.reports")

FIGURES = "figures"
REPORT = "report.md"
PAGE = "report.html"
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


@dataclass(frozen=True)
class Source:
    """What a report is made of: the cases, how far shots can be predicted, and what changed."""

    results: ResultsFolder
    predictability: dict[str, Predictability]
    regression: Regression | None

    @classmethod
    def load(cls, path: str | Path) -> Source:
        """Read a results folder; errors are those of its parts."""
        results = ResultsFolder.load(path)
        known = {one.scene: one for one in predictability_in(results)}
        return cls(results, known, load_regression(results.path))


def write_report(
    results_dir: str | Path, *, progress: Progress | None = None, jobs: int = 1
) -> Path:
    """Write `report.html`, `report.md` and `figures/`, from what a results folder holds alone.

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
        Of `report.md`; `report.html` lies beside it. Both are replaced only once all is made.

    Raises
    ------
    GhostballError
        Where the folder holds no results, they are damaged, or nothing can be written.
    """
    source = Source.load(results_dir)
    results = source.results
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
    parts: dict[str, ScenePart] = {}
    try:
        (results.path / FIGURES).mkdir(exist_ok=True)
        for done, (task, figures, part) in enumerate(_draw_all(source, tasks, jobs), start=1):
            drawn[task] = figures
            if part is not None:
                parts[task] = part
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
        page = page_text(results, parts, source.regression)
        report = results.path / REPORT
        write_all_whole({report.with_name(PAGE): page, report: text})
        _remove_stale(results.path, [whole, clouds, *drawn.values()])
    except OSError as error:
        raise ReportError(
            f"{error.filename or results.path}: can't write the report: {error.strerror or error}. "
            "Copy the results to a folder that can be written, and report on that"
        ) from error
    return report


def _draw_all(
    source: Source, tasks: list[str], jobs: int
) -> Iterator[tuple[str, Drawn, ScenePart | None]]:
    """Draw every task, of a scene also its part of the page; yield each as it is done."""
    if jobs <= 1:
        for task in tasks:
            yield task, *_draw_task(source, task)
        return
    # Not fork: whoever calls may have threads, and a progress bar is one.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(tasks)), mp_context=context) as pool:
        waiting = {pool.submit(_draw_in_worker, source.results.path, task): task for task in tasks}
        try:
            for future in as_completed(waiting):
                yield waiting[future], *future.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _draw_in_worker(path: Path, task: str) -> tuple[Drawn, ScenePart | None]:
    return _draw_task(_load_once(path), task)


@lru_cache(maxsize=1)
def _load_once(path: Path) -> Source:
    return Source.load(path)


def _draw_task(source: Source, task: str) -> tuple[Drawn, ScenePart | None]:
    results = source.results
    if task == WHOLE:
        made = ((kind, draw, results) for kind, draw in WHOLE_FIGURES.items())
        return _save_all(results.path, "", made), None
    if task.startswith(ENSEMBLE):
        name = task.removeprefix(ENSEMBLE)
        ensembles = Ensembles.load(results.path)
        assert ensembles is not None  # they gave the task its name
        drawn = _save_all(
            results.path, f"{name}-", [("ensemble", partial(draw_ensemble, ensembles), name)]
        )
        return drawn, None
    shot = load_shot(results, task)
    figures = ((kind, draw, shot) for kind, draw in SCENE_FIGURES.items())
    change = None if source.regression is None else source.regression.scene(task)
    part = scene_part(shot, source.predictability.get(task), change)
    return _save_all(results.path, f"{task}-", figures), part


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

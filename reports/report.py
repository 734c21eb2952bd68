"""Write the report of a results folder: `report.html`, `report.md`, and figures as PNG and SVG.

The page draws its own charts and needs no figure. Those of the whole run are few and always drawn;
those of each scene, four a scene, take most of a minute for all shipped scenes, and wait until
somebody asks for them.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from ghostball.engine import GhostballError
from ghostball.reports import style
from ghostball.reports.chaos_figure import draw_chaos
from ghostball.reports.figures import SCENE_FIGURES, draw_accuracy, draw_ensemble, draw_verdicts
from ghostball.reports.guarded import FailedPart, IncompleteReportError, attempt
from ghostball.reports.markdown import report_text
from ghostball.reports.markdown_parts import Drawn
from ghostball.reports.page import ScenePart, failed_scene_part, page_text, scene_part
from ghostball.reports.paper_figures import PAPER_FIGURES
from ghostball.reports.physics_figures import PHYSICS_FIGURES
from ghostball.reports.precision_figure import draw_precision, draw_precision_work
from ghostball.reports.scaling_figure import draw_scaling
from ghostball.reports.shots import load_shot
from ghostball.validation.baselines import Regression, load_regression
from ghostball.validation.diagnose.predictability import Predictability, predictability_in
from ghostball.validation.ensembles import Ensembles
from ghostball.validation.results.files import write_all_whole
from ghostball.validation.results.store import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURES = "figures"
REPORT = "report.md"
PAGE = "report.html"
ENDINGS = tuple(f".{ending}" for ending in style.FORMATS)

WHOLE = "figure "
"""What a task calls a figure of the whole run, before its kind; no scene's name has a space."""

ENSEMBLE = "ensemble of "
"""What a task calls the figure of a scene's ensemble, before the scene's name."""

PICTURES = "figures of "
"""What a task calls the figures of a scene, before the scene's name."""

Progress = Callable[[int, int, str], None]
"""Called with how many parts are done, of how many, and which was the last."""

WHOLE_FIGURES: dict[str, Callable[[Results], Figure | None]] = {
    "verdicts": draw_verdicts,
    "accuracy": draw_accuracy,
    "chaos": draw_chaos,
    "scaling": draw_scaling,
    "precision": draw_precision,
    "precision-work": draw_precision_work,
    **PHYSICS_FIGURES,
    **PAPER_FIGURES,
}


class ReportError(GhostballError):
    """A report that can't be written."""


@dataclass(frozen=True)
class Source:
    """What a report is made of: the cases, how far shots can be predicted, and what changed."""

    results: Results
    predictability: dict[str, Predictability]
    regression: Regression | None

    @classmethod
    def load(cls, path: str | Path) -> Source:
        """Read a results folder; errors are those of its parts."""
        results = Results.open(path)
        known = {one.scene: one for one in predictability_in(results)}
        return cls(results, known, load_regression(results.path))


def write_report(
    results_dir: str | Path,
    *,
    progress: Progress | None = None,
    jobs: int = 1,
    figures: bool = False,
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
    figures : bool
        Whether to draw also the figures of each scene, which `report.html` doesn't need. Without,
        those of an earlier report are removed.

    Returns
    -------
    Path
        Of `report.md`; `report.html` lies beside it. Both are replaced only once all is made.

    Raises
    ------
    GhostballError
        Where the folder holds no results, they are damaged, or nothing can be written.
    IncompleteReportError
        Where a section or a figure could not be made. All else is written by then.
    """
    source = Source.load(results_dir)
    results = source.results
    if not results.cases:
        raise ReportError(
            f"{results.path}: holds no case, so there is nothing to report. Run the suite again"
        )
    ensembles = Ensembles.load(results.path)
    perturbed = () if ensembles is None else ensembles.run.scenes
    tasks = [*(WHOLE + kind for kind in WHOLE_FIGURES), *(ENSEMBLE + name for name in perturbed)]
    if figures:
        tasks += [PICTURES + name for name in results.scene_names]
    drawn: dict[str, Drawn] = {}
    parts: dict[str, ScenePart] = {}
    failed: list[FailedPart] = []
    count = len(tasks) + len(results.scene_names)
    try:
        (results.path / FIGURES).mkdir(exist_ok=True)
        for done, (task, made) in enumerate(_make_all(source, tasks, jobs, failed), start=1):
            if isinstance(made, ScenePart):
                parts[task] = made
            else:
                drawn[task] = made
            if progress is not None:
                progress(done, count, task)
        # In the table's order, in whichever the processes drew them.
        whole = {
            kind: path
            for figure in WHOLE_FIGURES
            for kind, path in drawn.get(WHOLE + figure, {}).items()
        }
        physics, paper = (
            {kind: path for kind, path in whole.items() if kind in kinds}
            for kinds in (PHYSICS_FIGURES, PAPER_FIGURES)
        )
        clouds = {
            name: path for name in perturbed for path in drawn.get(ENSEMBLE + name, {}).values()
        }
        pictures = (
            {name: drawn.get(PICTURES + name, {}) for name in results.scene_names}
            if figures
            else None
        )
        page = page_text(results, parts, source.regression, failed)
        text = report_text(results, whole, pictures, physics, paper, clouds, failed)
        report = results.path / REPORT
        write_all_whole({report.with_name(PAGE): page, report: text})
        _remove_stale(results.path, drawn.values())
    except OSError as error:
        raise ReportError(
            f"{error.filename or results.path}: can't write the report: {error.strerror or error}. "
            "Copy the results to a folder that can be written, and report on that"
        ) from error
    if failed:
        raise IncompleteReportError(report, failed)
    return report


def _make_all(
    source: Source, tasks: list[str], jobs: int, failed: list[FailedPart]
) -> Iterator[tuple[str, Drawn | ScenePart]]:
    """Draw the figures of every task, and make every scene's part; yield each as it is done.

    With more than one process the others draw the figures, and this one makes the page meanwhile:
    that alone needs no matplotlib.
    """
    if jobs <= 1 or not tasks:
        for task in tasks:
            yield task, _draw_task(source, task, failed)
        yield from _scene_parts(source, failed)
        return
    # Not fork: whoever calls may have threads, and a progress bar is one.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(tasks)), mp_context=context) as pool:
        path = source.results.path
        waiting = {pool.submit(_draw_in_worker, path, task): task for task in tasks}
        try:
            yield from _scene_parts(source, failed)
            for future in as_completed(waiting):
                task = waiting[future]
                part = f"process that draws {task}"
                made = attempt(part, future.result, failed, writes=True)
                figures, wrong = ({}, []) if made is None else made
                failed += wrong
                yield task, figures
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _scene_parts(source: Source, failed: list[FailedPart]) -> Iterator[tuple[str, ScenePart]]:
    """Yield each scene's part of the page; where it can't be made, one that says so."""
    for name in source.results.scene_names:
        make = partial(_scene_part, source, name)
        made = attempt(f"part of {PAGE} on scene {name}", make, failed)
        yield name, failed_scene_part(name, failed[-1]) if made is None else made


def _scene_part(source: Source, name: str) -> ScenePart:
    change = None if source.regression is None else source.regression.scene(name)
    return scene_part(load_shot(source.results, name), source.predictability.get(name), change)


def _draw_in_worker(path: Path, task: str) -> tuple[Drawn, list[FailedPart]]:
    failed: list[FailedPart] = []
    return _draw_task(_load_once(path), task, failed), failed


@lru_cache(maxsize=1)
def _load_once(path: Path) -> Source:
    return Source.load(path)


def _draw_task(source: Source, task: str, failed: list[FailedPart]) -> Drawn:
    results = source.results
    if task.startswith(WHOLE):
        kind = task.removeprefix(WHOLE)
        return _save_all(results.path, "", [(kind, WHOLE_FIGURES[kind], results)], failed)
    if task.startswith(ENSEMBLE):
        name = task.removeprefix(ENSEMBLE)
        ensembles = Ensembles.load(results.path)
        assert ensembles is not None  # they gave the task its name
        draw = partial(draw_ensemble, ensembles)
        return _save_all(results.path, f"{name}-", [("ensemble", draw, name)], failed)
    name = task.removeprefix(PICTURES)
    shot = attempt(task, partial(load_shot, results, name), failed)
    if shot is None:
        return {}
    figures = ((kind, draw, shot) for kind, draw in SCENE_FIGURES.items())
    return _save_all(results.path, f"{name}-", figures, failed)


def _save_all(
    folder: Path,
    prefix: str,
    made: Iterable[tuple[str, Callable[..., Figure | None], Any]],
    failed: list[FailedPart],
) -> Drawn:
    written: dict[str, PurePosixPath] = {}
    for kind, draw, subject in made:
        part, stem = f"figure {prefix}{kind}", PurePosixPath(FIGURES, prefix + kind)
        with style.drawing():
            figure = attempt(part, partial(draw, subject), failed)
            if figure is None:
                continue
            save = partial(style.save_figure, figure, folder / stem)
            if attempt(part, save, failed, writes=True):
                written[kind] = stem
    return written


def _remove_stale(folder: Path, drawn: Iterable[Drawn]) -> None:
    """Remove figures that an earlier report left; what somebody else put there stays."""
    kept = {path.name for one in drawn for path in one.values()}
    of_a_scene = tuple(f"-{kind}" for kind in (*SCENE_FIGURES, "ensemble"))
    for path in (folder / FIGURES).iterdir():
        ours = path.stem in WHOLE_FIGURES or path.stem.endswith(of_a_scene)
        if path.suffix in ENDINGS and ours and path.stem not in kept:
            path.unlink()

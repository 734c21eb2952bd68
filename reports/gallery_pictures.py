"""The few pictures that the README shows, made from one results folder by one command."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ghostball.engine import GhostballError
from ghostball.reports import style
from ghostball.reports.chaos_figure import draw_chaos
from ghostball.reports.figures._table import aspect_of, view_of
from ghostball.reports.figures.paths import WIDTH, draw_panel
from ghostball.reports.figures.summary import accuracy_errors, draw_accuracy_on, draw_verdicts
from ghostball.reports.paper_figures import PAPER_FIGURES
from ghostball.reports.physics_figures import PHYSICS_FIGURES
from ghostball.reports.precision_figure import draw_precision_or_committed
from ghostball.reports.racks_figure import draw_racks_or_committed
from ghostball.reports.scaling_figure import draw_scaling_or_committed
from ghostball.reports.shots import Shot, load_shot
from ghostball.validation.results.store import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HERO_SCENES = ("break-16", "break-8", "break-7")
"""The first of these that is stored is the hero's break."""

HERO_ENGINES = (
    "ghostball",
    "pymunk:mode=landed",
    "pybullet:mode=landed",
    "paper-continuous",
    "pymunk",
    "pybullet",
)
"""Engines of the hero's panels, in rows of three."""

HERO_COLUMNS = 3


def draw_hero(results: Results) -> Figure | None:
    """Draw what the project is about: one break on several engines, above all engines' errors.

    None where no break, or no closed-form scene, is stored.
    """
    shot = _hero_shot(results)
    errors = accuracy_errors(results)
    if shot is None or not errors:
        return None
    runs = [run for label in HERO_ENGINES for run in shot.drawn if run.label == label]
    rows = -(-len(runs) // HERO_COLUMNS)
    view = view_of(shot.scene)
    panels = rows * ((WIDTH / HERO_COLUMNS) * aspect_of(view) + 0.25) + 0.3
    dots = 1.2 + 0.27 * len(errors)
    figure = style.new_figure(WIDTH, panels + dots)
    parts: Any = figure.subfigures(2, 1, height_ratios=[panels, dots])
    upper, lower = parts
    grid = upper.subplots(rows, HERO_COLUMNS, squeeze=False).ravel()
    for axes, run in zip(grid, runs, strict=False):
        draw_panel(axes, shot, run, view, None)
    for axes in grid[len(runs) :]:
        axes.set_axis_off()
    style.set_title(
        upper,
        f"One break of {len(shot.scene.balls)} balls: rest positions, and the largest distance "
        "from ghostball's (rings)",
    )
    draw_accuracy_on(lower.subplots(), errors)
    return figure


def _hero_shot(results: Results) -> Shot | None:
    name = next((name for name in HERO_SCENES if name in results.scene_names), None)
    if name is None:
        return None
    shot = load_shot(results, name)
    return shot if shot.ours is not None else None


GALLERY: dict[str, Callable[[Results], Figure | None]] = {
    "hero": draw_hero,
    "verdicts": draw_verdicts,
    **PHYSICS_FIGURES,
    **PAPER_FIGURES,
}


OPTIONAL: dict[str, Callable[[Results], Figure | None]] = {
    "chaos": draw_chaos,
    "scaling": draw_scaling_or_committed,
    "racks": draw_racks_or_committed,
    "precision": draw_precision_or_committed,
}
"""Pictures of measurements, which results need not have."""


def write_gallery(results_dir: str | Path, gallery_dir: str | Path) -> list[Path]:
    """Write the pictures of the README, as PNG and SVG; return the files written.

    Each carries, as its description, the revision at which the results were computed.

    Raises
    ------
    GhostballError
        Where the folder holds no results, lacks a scene that a picture needs, or nothing can be
        written.
    """
    results = Results.open(results_dir)
    folder = Path(gallery_dir)
    git = results.environment.get("git") or {"revision": "unknown", "dirty": False}
    revision = git["revision"] + ", with changes" * git["dirty"]
    with style.drawing():
        figures = {name: _drawn(results, name) for name in GALLERY}
        measured = {name: draw(results) for name, draw in OPTIONAL.items()}
        figures |= {name: figure for name, figure in measured.items() if figure is not None}
        try:
            folder.mkdir(parents=True, exist_ok=True)
            saved = [
                style.save_figure(figure, folder / name, revision)
                for name, figure in figures.items()
            ]
        except OSError as error:
            raise GhostballError(
                f"{folder}: can't write the gallery: {error.strerror or error}. Choose another "
                "folder"
            ) from error
    return [path for paths in saved for path in paths]


def _drawn(results: Results, name: str) -> Figure:
    figure = GALLERY[name](results)
    if figure is None:
        raise GhostballError(
            f'{results.path}: the picture "{name}" needs scenes or engines that these results '
            "lack. Run the full suite on every engine"
        )
    return figure

"""The few pictures that the README shows, made from one results folder by one command."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from engine import GhostballError
from reports import style
from reports.figures._table import aspect_of, view_of
from reports.figures.paths import WIDTH, draw_panel
from reports.figures.summary import accuracy_errors, draw_accuracy_on, draw_verdicts
from reports.paper_figures import PAPER_FIGURES
from reports.shots import Shot, load_shot
from validation.store import ResultsFolder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HERO_SCENES = ("break-16", "break-8", "break-7")
"""The first of these that is stored is the hero's break."""

HERO_ENGINES = ("ghostball", "pymunk", "pybullet", "paper-continuous", "paper-discrete")
"""Which engines the hero shows, three of them at most."""

HERO_PANELS = 3


def draw_hero(results: ResultsFolder) -> Figure | None:
    """Draw what the project is about: one break on three engines, above all engines' errors.

    None where no break, or no closed-form scene, is stored.
    """
    shot = _hero_shot(results)
    errors = accuracy_errors(results)
    if shot is None or not errors:
        return None
    runs = [run for label in HERO_ENGINES for run in shot.drawn if run.label == label]
    runs = runs[:HERO_PANELS]
    view = view_of(shot.scene)
    panels = (WIDTH / len(runs)) * aspect_of(view) + 0.5
    dots = 0.5 + 0.3 * len(errors)
    figure = style.new_figure(WIDTH, panels + dots + 1.0)
    upper, lower = figure.subfigures(2, 1, height_ratios=[panels, dots + 0.75])
    for axes, run in zip(upper.subplots(1, len(runs), squeeze=False)[0], runs, strict=True):
        draw_panel(axes, shot, run, view, None)
    style.set_title(
        upper,
        f"The same break of {len(shot.scene.balls)} balls on {len(runs)} engines "
        "(rings: where ghostball's balls rest)",
    )
    draw_accuracy_on(lower.subplots(), errors)
    return figure


def _hero_shot(results: ResultsFolder) -> Shot | None:
    name = next((name for name in HERO_SCENES if name in results.scene_names), None)
    if name is None:
        return None
    shot = load_shot(results, name)
    return shot if shot.ours is not None else None


GALLERY: dict[str, Callable[[ResultsFolder], Figure | None]] = {
    "hero": draw_hero,
    "verdicts": draw_verdicts,
    **PAPER_FIGURES,
}


def write_gallery(results_dir: str | Path, gallery_dir: str | Path) -> list[Path]:
    """Write the pictures of the README, as PNG and SVG; return the files written.

    Raises
    ------
    GhostballError
        Where the folder holds no results, lacks a scene that a picture needs, or nothing can be
        written.
    """
    results = ResultsFolder.load(results_dir)
    folder = Path(gallery_dir)
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, draw in GALLERY.items():
            with style.drawing():
                figure = draw(results)
                if figure is None:
                    raise GhostballError(
                        f'{results.path}: the picture "{name}" needs scenes or engines that these '
                        "results lack. Run the full suite on every engine"
                    )
                written += style.save_figure(figure, folder / name)
    except OSError as error:
        raise GhostballError(
            f"{folder}: can't write the gallery: {error.strerror or error}. Choose another folder"
        ) from error
    return written

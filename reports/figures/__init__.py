"""Figures of one scene, one module for each kind; and of the whole run, in `summary`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ghostball.reports.figures.collisions import draw_collisions
from ghostball.reports.figures.energy import draw_energy
from ghostball.reports.figures.ensembles import draw_ensemble
from ghostball.reports.figures.errors import draw_errors
from ghostball.reports.figures.paths import draw_paths
from ghostball.reports.figures.summary import draw_accuracy, draw_verdicts
from ghostball.reports.shots import Shot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCENE_FIGURES: dict[str, Callable[[Shot], Figure | None]] = {
    "paths": draw_paths,
    "errors": draw_errors,
    "energy": draw_energy,
    "collisions": draw_collisions,
}
"""Figures of one scene by kind, in the order of the report."""

__all__ = [
    "SCENE_FIGURES",
    "draw_accuracy",
    "draw_collisions",
    "draw_energy",
    "draw_ensemble",
    "draw_errors",
    "draw_paths",
    "draw_verdicts",
]

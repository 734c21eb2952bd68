"""Pictures: a sheet of each scene, one run alone, ensembles; and of the whole run, in `summary`."""

from ghostball.reports.figures.ensembles import draw_ensemble
from ghostball.reports.figures.sheet import draw_sheet
from ghostball.reports.figures.single import draw_single

__all__ = ["draw_ensemble", "draw_sheet", "draw_single"]

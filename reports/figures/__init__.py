"""Pictures: a sheet of each scene, and one run alone."""

from ghostball.reports.figures.sheet import draw_sheet
from ghostball.reports.figures.single import draw_single

__all__ = ["draw_sheet", "draw_single"]

"""Pictures of shots: a sheet for each scene, and single runs."""

from ghostball.reports.figures.sheet import draw_sheet
from ghostball.reports.figures.single import draw_single

__all__ = ["draw_sheet", "draw_single"]

"""The page: `report.html`, one file with everything in it, from a results folder alone."""

from ghostball.reports.page.page import page_text
from ghostball.reports.page.scenes import ScenePart, failed_scene_part, scene_part

__all__ = ["ScenePart", "failed_scene_part", "page_text", "scene_part"]

"""The page of a report: `report.html`, one complete file, made from a results folder."""

from ghostball.reports.page.page import page_text
from ghostball.reports.page.scenes import ScenePart, failed_scene_part, scene_part

__all__ = ["ScenePart", "failed_scene_part", "page_text", "scene_part"]

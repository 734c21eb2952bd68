"""The page of a report: `report.html`, one complete file, made from a results folder."""

from ghostball.reports.page.page import page_text
from ghostball.reports.page.scenes import ScenePagePart, failed_scene_part, scene_part

__all__ = ["ScenePagePart", "failed_scene_part", "page_text", "scene_part"]

"""Section of the changed scenes: baseline and new result side by side, and their differences."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from ghostball.model import Scene
from ghostball.reports.figures._table import view_of
from ghostball.reports.page.rendering import render
from ghostball.validation.baselines import Regression
from ghostball.validation.baselines.regression import SceneChange
from ghostball.validation.results.store import CaseRecord, Results

Place = tuple[float, float, float]
"""Position of the centre of a ball [m]."""

MOVED = ("wrong collisions", "worse", "changed", "better")
"""Classes of change that always get their own view. Other changes get a view only if they fail."""


def changed_html(results: Results, regression: Regression | None) -> Markup:
    """Return the changed and failed scenes, with baseline and new result; "" if there are none."""
    if regression is None:
        return Markup()
    return Markup("").join(_changed(results, one) for one in regression.scenes if has_part(one))


def has_part(change: SceneChange) -> bool:
    """Return whether a scene has its own view, the target of links "#change=NAME"."""
    return change.change in MOVED or change.failed


def _changed(results: Results, change: SceneChange) -> Markup:
    case = next((one for one in results.cases if one.scene == change.scene), None)
    return render(
        "changed.html",
        change=change,
        in_page=case is not None,
        rests=_rests(case, change),
        ends=None if case is None else _ends(case, change),
        moved=(*change.metrics, *change.counters),
    )


def _ends(case: CaseRecord, change: SceneChange) -> dict[str, Any] | None:
    """Return the picture of both results: the view, the table, and rest positions [m] by ball."""
    if change.rest_base is None or change.rest_head is None:
        return None
    return picture_of(case.load_scene(), change.rest_base, change.rest_head)


def picture_of(scene: Scene, base: Sequence[Place], head: Sequence[Place]) -> dict[str, Any]:
    """Return the picture of two results; a ball with a nan isn't drawn."""
    shown = [k for k, pair in enumerate(zip(base, head, strict=True)) if np.all(np.isfinite(pair))]
    both = np.array([[base[k] for k in shown], [head[k] for k in shown]])
    left, right, bottom, top = view_of(scene, both, needed=both[1])
    return {
        "box": (left, -top, right - left, top - bottom),
        "table": scene.table,
        "balls": [(scene.balls[k], base[k], head[k]) for k in shown],
    }


def _rests(case: CaseRecord | None, change: SceneChange) -> list[tuple[str, Place, Place, float]]:
    """Return each ball with its rest position in the baseline and now, and their distance [m]."""
    if change.rest_base is None or change.rest_head is None:
        return []
    names = [str(k) for k in range(len(change.rest_head))]
    if case is not None:
        names = [str(ball["id"]) for ball in case.definition["balls"]]
    places = zip(names, change.rest_base, change.rest_head, strict=True)
    return [(name, base, head, math.dist(base, head)) for name, base, head in places]

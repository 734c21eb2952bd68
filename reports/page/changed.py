"""Each scene that changed: base and head side by side, and what differs in numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.figures._table import view_of
from ghostball.reports.outcome import kind_text
from ghostball.reports.page.rendering import render
from ghostball.reports.words import quantity_text
from ghostball.validation.baselines import Regression
from ghostball.validation.baselines.regression import Quantity, SceneChange
from ghostball.validation.results.store import CaseRecord, Results

MOVED = ("worse", "results-changed", "better")
"""Changes that get a view of their own; of the others, what fails has one."""


@dataclass(frozen=True)
class Moved:
    """A number on both sides: what was expected, what is there, by how much they differ."""

    name: str
    base: str
    head: str
    difference: str
    band: str = ""
    sign: str = ""
    why: str = ""


def changed_html(results: Results, regression: Regression | None) -> Markup:
    """Return each scene that changed or fails, with base and head; "" where none does."""
    if regression is None:
        return Markup()
    return Markup("").join(_changed(results, one) for one in regression.scenes if has_part(one))


def has_part(change: SceneChange) -> bool:
    """Say whether a scene has a view of its own, which "#change=NAME" leads to."""
    return change.change in MOVED or change.failed


def _changed(results: Results, change: SceneChange) -> Markup:
    case = next((one for one in results.cases if one.scene == change.scene), None)
    quantities = [*change.metrics, *change.counters]
    moved = [_moved(one) for one in quantities if one.base != one.head or not one.within]
    return render(
        "changed.html",
        change=change,
        kind=kind_text(change),
        in_page=case is not None,
        rests=_rests(case, change),
        ends=None if case is None else _ends(case, change),
        moved=moved,
        still=len(quantities) - len(moved),
    )


def _ends(case: CaseRecord, change: SceneChange) -> dict[str, Any] | None:
    """Return what a picture of both ends shows: the view, the table, each ball's places [m]."""
    if change.rest_base is None or change.rest_head is None:
        return None
    scene = case.load_scene()
    both = np.array([change.rest_base, change.rest_head])
    left, right, bottom, top = view_of(scene, both, needed=both[1])
    places = zip(scene.balls, change.rest_base, change.rest_head, strict=True)
    return {
        "box": (left, -top, right - left, top - bottom),
        "table": scene.table,
        "balls": [(ball, base, head) for ball, base, head in places],
    }


def _rests(case: CaseRecord | None, change: SceneChange) -> list[Moved]:
    if change.rest_base is None or change.rest_head is None:
        return []
    names = [str(k) for k in range(len(change.rest_head))]
    if case is not None:
        names = [str(ball["id"]) for ball in case.definition["balls"]]
    return [
        Moved(
            f"ball {name}",
            _place(base),
            _place(head),
            style.format_length(math.dist(base, head)),
        )
        for name, base, head in zip(names, change.rest_base, change.rest_head, strict=True)
    ]


def _place(position: tuple[float, float, float]) -> str:
    return f"({position[0]!r}, {position[1]!r}) m"


def _moved(one: Quantity) -> Moved:
    difference = "–"
    if one.base is not None and one.head is not None:
        signed = one.head - one.base
        difference = ("+" if signed >= 0 else "−") + quantity_text(abs(signed), one.unit)
    low = "" if one.low is None else f"from {quantity_text(one.low, one.unit)}"
    high = "" if one.high is None else f"to {quantity_text(one.high, one.unit)}"
    band = " ".join(part for part in (low, high) if part)
    sign = "✓" if one.within else {"error": "✗", "warn": "!", "off": "○"}[one.level]
    return Moved(
        one.name,
        _value(one.base, one.unit),
        _value(one.head, one.unit),
        difference,
        band,
        sign,
        one.why,
    )


def _value(value: float | None, unit: str) -> str:
    return "–" if value is None else quantity_text(value, unit)

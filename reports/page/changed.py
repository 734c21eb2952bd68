"""Each scene that changed: base and head side by side, and what differs in numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from ghostball.reports import style
from ghostball.reports.outcome import kind_text
from ghostball.reports.page.rendering import embedded_json, render
from ghostball.reports.page.scenes import REPLAY_ID
from ghostball.reports.words import quantity_text
from ghostball.validation.baselines import Regression
from ghostball.validation.baselines.regression import Quantity, SceneChange
from ghostball.validation.results.store import CaseRecord, Results

COMPARE_ID = "compare-"
"""What stands before a scene's name in the id of its comparison's data."""

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
    data = None if case is None else _compared(change)
    quantities = [*change.metrics, *change.counters]
    moved = [_moved(one) for one in quantities if one.base != one.head or not one.within]
    return render(
        "changed.html",
        change=change,
        kind=kind_text(change),
        in_page=case is not None,
        rests=_rests(case, change),
        moved=moved,
        still=len(quantities) - len(moved),
        compare_id=COMPARE_ID + change.scene,
        data=None if data is None else embedded_json(data),
    )


def _compared(change: SceneChange) -> dict[str, Any] | None:
    """Return what the comparison shows: where the balls end in both."""
    if change.rest_base is None or change.rest_head is None:
        return None
    # The scene itself is in the page already, with its replay.
    return {
        "replay": REPLAY_ID + change.scene,
        "rest_base": [list(place[:2]) for place in change.rest_base],
        "rest_head": [list(place[:2]) for place in change.rest_head],
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

"""Changes of rest position errors between a baseline and a run, as text and as a text chart.

The page of a CI service can't show a picture from the run, but it can show text:

    draw-shot  ───────────────────○──●──────   162 mm -> 191 mm
               1 nm      1 µm      1 mm      1 m
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ghostball.reports import style
from ghostball.reports.accuracy import UP_TO_ROUNDING
from ghostball.validation.baselines.regression import Regression, SceneChange

WIDTH = 48
"""Width of the axis [characters]."""

SHOTS = 12
"""Largest number of shots in the chart."""

_BEFORE, _NOW, _BOTH = "○", "●", "◉"


def error_text(change: SceneChange) -> str:
    """Return the rest error: "3.4 mm -> 28 mm", or "28 mm" if both texts agree; "" if unknown."""
    if change.base_error is None or change.head_error is None:
        return ""
    before = UP_TO_ROUNDING if change.base_is_exact else style.format_length(change.base_error)
    now = UP_TO_ROUNDING if change.head_is_exact else style.format_length(change.head_error)
    return now if before == now else f"{before} -> {now}"


def is_shifted(change: SceneChange) -> bool:
    """Return whether the rest error is known in both runs, and differs."""
    return None not in (change.base_error, change.head_error) and (
        change.base_error != change.head_error
    )


def growth(change: SceneChange) -> float:
    """Return the logarithm of the factor by which the rest error grew; 0 if unknown."""
    if not is_shifted(change):
        return 0.0
    return _log(change.head_error or 0.0) - _log(change.base_error or 0.0)


def shifted(regression: Regression) -> list[SceneChange]:
    """Return the scenes with a different rest error, sorted by the growth of the error."""
    return sorted(filter(is_shifted, regression.scenes), key=lambda one: -growth(one))


def drawn(changes: Sequence[SceneChange]) -> str:
    """Return the chart of scenes with different rest errors; "" if there are none."""
    shown = [(one, _log(one.base_error or 0.0), _log(one.head_error or 0.0)) for one in changes]
    shown = shown[:SHOTS]
    if not shown:
        return ""
    first = math.floor(min(min(before, now) for _, before, now in shown))
    decades = max(1, math.ceil(max(max(before, now) for _, before, now in shown)) - first)
    names = max(len(one.scene) for one, _, _ in shown)
    lines = []
    for one, *logs in shown:
        before, now = (round((log - first) / decades * (WIDTH - 1)) for log in logs)
        axis = ["·"] * WIDTH
        for k in range(min(before, now), max(before, now)):
            axis[k] = "━"
        axis[before], axis[now] = _BEFORE, _NOW
        if before == now:
            axis[now] = _BOTH
        lines.append(f"{one.scene:<{names}}  {''.join(axis)}  {error_text(one)}")
    ends = style.format_length(10.0**first), style.format_length(10.0 ** (first + decades))
    gap = " " * max(1, WIDTH - len(ends[0]) - len(ends[1]))
    lines.append(f"{'':<{names}}  {ends[0]}{gap}{ends[1]}")
    key = f"{_BEFORE} before, {_NOW} now: the largest rest error"
    more = f"; {len(changes) - SHOTS} more changed less" if len(changes) > SHOTS else ""
    return "\n".join([*lines, "", key + more])


_LEAST = 1e-18
"""Position of an error of 0 on the axis [m]."""


def _log(value: float) -> float:
    return math.log10(max(value, _LEAST))

"""How far shots ended from the reference result, before and now, drawn in text.

On the page of a CI no other picture can be shown that isn't on the web already.

    draw-shot  ───────────────────○──●──────   162 mm -> 191 mm
               1 nm      1 µm      1 mm      1 m
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ghostball.reports import style
from ghostball.validation.baselines.regression import Regression, SceneChange

WIDTH = 48
"""Characters of the axis."""

SHOTS = 12
"""More shots than this are no picture any more."""

_BEFORE, _NOW, _BOTH = "○", "●", "◉"


def error_text(change: SceneChange) -> str:
    """Return the rest error: "3.4 mm -> 28 mm", or "28 mm" if both read the same; "" if unknown."""
    if change.base_error is None or change.head_error is None:
        return ""
    before, now = (style.format_length(one) for one in (change.base_error, change.head_error))
    return now if before == now else f"{before} -> {now}"


def is_shifted(change: SceneChange) -> bool:
    """Whether the rest error is known on both sides, and differs."""
    return None not in (change.base_error, change.head_error) and (
        change.base_error != change.head_error
    )


def growth(change: SceneChange) -> float:
    """Return by which factor the rest error grew, as a logarithm; 0 where that isn't known."""
    if not is_shifted(change):
        return 0.0
    return _log(change.head_error or 0.0) - _log(change.base_error or 0.0)


def shifted(regression: Regression) -> list[SceneChange]:
    """Return the scenes whose rest error differs, those first whose error grew by most."""
    return sorted(filter(is_shifted, regression.scenes), key=lambda one: -growth(one))


def drawn(changes: Sequence[SceneChange]) -> str:
    """Return the picture of scenes whose rest errors differ; "" where there is nothing to draw."""
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
"""What an error of nothing is drawn as [m]."""


def _log(value: float) -> float:
    return math.log10(max(value, _LEAST))

"""How far shots ended off the truth before and now, drawn in text.

On the page of a CI no other picture can be shown that isn't on the web already.

    draw-shot  ───────────────────○──●──────   162 mm -> 191 mm
               1 nm      1 µm      1 mm      1 m
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ghostball.reports import style
from ghostball.validation.baselines.regression import Regression, SceneChange

WIDTH = 48
"""Characters of the axis."""

SHOTS = 12
"""More shots than this are no picture any more."""

_BEFORE, _NOW, _BOTH = "○", "●", "◉"


@dataclass(frozen=True)
class Shift:
    """How far a shot ended off its true end [m], before and now."""

    scene: str
    before: float
    now: float

    @classmethod
    def of(cls, change: SceneChange) -> Shift | None:
        """Return that of a scene, moved or not; None where either is not known."""
        one = change.rest_error
        if one is None or one.base is None or one.head is None:
            return None
        return cls(change.scene, float(one.base), float(one.head))

    @property
    def words(self) -> str:
        """Say it in words: "3.4 mm -> 28 mm", or "28 mm" where both read the same."""
        before, now = style.format_length(self.before), style.format_length(self.now)
        return now if before == now else f"{before} -> {now}"

    @property
    def size(self) -> float:
        """By which factor it moved, as a logarithm; positive where it got worse."""
        return _log(self.now) - _log(self.before)


def shifts_of(regression: Regression) -> list[Shift]:
    """Return the shots whose distance from the truth moved, those first that got worse by most."""
    found = [shift for change in regression.scenes if (shift := shift_of(change)) is not None]
    return sorted(found, key=lambda one: -one.size)


def shift_of(change: SceneChange) -> Shift | None:
    """Return how far a shot ended off the truth; None where that is not known, or did not move."""
    shift = Shift.of(change)
    return None if shift is None or shift.before == shift.now else shift


def drawn(shifts: Sequence[Shift]) -> str:
    """Return the picture; "" where there is nothing to draw."""
    shown = list(shifts[:SHOTS])
    if not shown:
        return ""
    logs = [_log(value) for one in shown for value in (one.before, one.now)]
    first = math.floor(min(logs))
    decades = max(1, math.ceil(max(logs)) - first)
    names = max(len(one.scene) for one in shown)

    def at(value: float) -> int:
        return round((_log(value) - first) / decades * (WIDTH - 1))

    lines = []
    for one in shown:
        before, now = at(one.before), at(one.now)
        axis = ["·"] * WIDTH
        for k in range(min(before, now), max(before, now)):
            axis[k] = "━"
        axis[before], axis[now] = _BEFORE, _NOW
        if before == now:
            axis[now] = _BOTH
        lines.append(f"{one.scene:<{names}}  {''.join(axis)}  {one.words}")
    ends = style.format_length(10.0**first), style.format_length(10.0 ** (first + decades))
    gap = " " * max(1, WIDTH - len(ends[0]) - len(ends[1]))
    lines.append(f"{'':<{names}}  {ends[0]}{gap}{ends[1]}")
    key = f"{_BEFORE} before, {_NOW} now: distance from the true end, the farthest ball's"
    more = f"; {len(shifts) - SHOTS} more moved less" if len(shifts) > SHOTS else ""
    return "\n".join([*lines, "", key + more])


_LEAST = 1e-18
"""What an error of nothing is drawn as [m]."""


def _log(value: float) -> float:
    return math.log10(max(value, _LEAST))

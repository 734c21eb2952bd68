"""What each engine's time step buys in the scenes of the precision measurement, as Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.measurements import committed
from docs.tables import table
from ghostball.reports.precision import is_finest
from ghostball.reports.style import format_length, format_time
from ghostball.validation.precision.points import PrecisionMeasurement, PrecisionPoint, knee_of

HEADS = ("engine", "recommended step", "error there", "longest step", "shortest step")


def page() -> str:
    """Return a table for each scene; errors are those of the worst phase of a step."""
    measured = committed(PrecisionMeasurement)
    if measured is None:
        return "Nothing was measured yet: `ghostball engines --steps --out DIR` does so."
    parts = [f"Measured on {measured.where}; a machine's speed changes neither errors nor steps."]
    points = [one for one in measured.points if one.step is not None]
    for scene, title in dict.fromkeys((one.scene, one.title) for one in points):
        mine = [one for one in points if one.scene == scene]
        engines = dict.fromkeys(one.engine for one in mine)
        rows = (_row([one for one in mine if one.engine == engine]) for engine in engines)
        parts += [f"## {scene}", f"{title}.", table(HEADS, rows)]
    return "\n\n".join(parts)


def _row(points: Sequence[PrecisionPoint]) -> tuple[str, ...]:
    """Return a row of the table; `points`: of one engine on one scene, the longest step first."""
    ends = (f"{_error(one)} at {_step(one)}" for one in (points[0], points[-1]))
    knee = knee_of(points)
    if knee is None:
        return f"`{points[0].engine}`", "no step", "–", *ends
    more = " or shorter" if is_finest(knee, points) else ""
    return f"`{points[0].engine}`", _step(knee) + more, _error(knee), *ends


def _error(point: PrecisionPoint) -> str:
    return format_length(point.error_high) if point.same_events else "wrong collisions"


def _step(point: PrecisionPoint) -> str:
    return format_time(point.step)

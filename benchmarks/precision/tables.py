"""Errors against time as tables for the eye: what each engine reaches, and in which time."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from benchmarks.precision.measure import TARGETS
from benchmarks.precision.points import PrecisionMeasurement, PrecisionPoint, Reach, best_of
from ghostball.reports import style

QUICK_SAYS = "A trial at tiny sizes (--smoke): these times mean nothing, and no target is judged."

LEGEND = (
    "Times are of the simulation alone, the least of all samples. A time counts where all finer "
    "steps are as near, from every phase of the step; not reached: no step that was run is. "
    "The least error is that of the worst phase of the best step."
)

LEAST_ERROR = "least error (worst phase)"
"""Heads the column that `best_text` fills."""


def reach_heading(target: float) -> str:
    """Return the heading of a column: "to 1 mm"."""
    return f"to {style.format_length(target)}"


def reach_text(reach: Reach) -> str:
    """Return a time, or that no step that was run is so near."""
    return "not reached" if reach.seconds is None else style.format_time(reach.seconds)


def best_text(points: Sequence[PrecisionPoint]) -> str:
    """Return the least error of an engine and the time it took: "1.37 nm in 24 ms"."""
    best = best_of(points)
    return f"{style.format_length(best.error_high)} in {style.format_time(best.seconds)}"


def precision_tables(measured: PrecisionMeasurement) -> RenderableType:
    """Return, scene by scene, the time of each engine for each accuracy."""
    parts: list[RenderableType] = []
    if measured.quick:
        parts.append(Text(QUICK_SAYS, style="yellow"))
    parts += [_scene(measured, scene) for scene in dict.fromkeys(p.scene for p in measured.points)]
    parts.append(Text(LEGEND))
    parts += [Text(f"{o.scene}, {o.engine}: left out: {o.why}") for o in measured.left_out]
    return Group(*parts)


def _scene(measured: PrecisionMeasurement, scene: str) -> Table:
    points = [point for point in measured.points if point.scene == scene]
    title = escape(f"{scene} ({points[0].truth}): {points[0].title}")
    table = Table(
        box=box.SIMPLE_HEAD, pad_edge=False, title=title, title_justify="left", title_style="bold"
    )
    table.add_column("engine", no_wrap=True)
    for target in TARGETS:
        table.add_column(reach_heading(target), justify="right", no_wrap=True)
    table.add_column(LEAST_ERROR, justify="right", no_wrap=True)
    for curve in (one for one in measured.curves if one.scene == scene):
        mine = [point for point in points if point.engine == curve.engine]
        table.add_row(escape(curve.engine), *map(reach_text, curve.reach), best_text(mine))
    return table

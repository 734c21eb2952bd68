"""Errors against time as tables for the eye: what each engine reaches, and in which time."""

from __future__ import annotations

from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from ghostball._bench_tables import QUICK_SAYS
from ghostball.reports.precision_text import (
    LEAST_ERROR,
    LEGEND,
    best_text,
    order_text,
    reach_heading,
    reach_text,
)
from ghostball.validation.bench import PrecisionMeasurement
from ghostball.validation.bench.precision import TARGETS


def precision_tables(measured: PrecisionMeasurement) -> RenderableType:
    """Return, scene by scene, the order of each engine and its time for each accuracy."""
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
    table.add_column("order", justify="right", no_wrap=True)
    for target in TARGETS:
        table.add_column(reach_heading(target), justify="right", no_wrap=True)
    table.add_column(LEAST_ERROR, justify="right", no_wrap=True)
    table.add_column("its order")
    for curve in (one for one in measured.curves if one.scene == scene):
        mine = [point for point in points if point.engine == curve.engine]
        table.add_row(
            escape(curve.engine),
            order_text(curve),
            *(reach_text(one) for one in curve.reach),
            best_text(mine),
            escape(curve.order_note),
        )
    return table

"""Measurements of speed and accuracy as tables for the eye."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from statistics import median

from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from benchmarks.accuracy import AccuracyMeasurement, Distribution
from benchmarks.precision.tables import QUICK_SAYS
from benchmarks.racks import RacksMeasurement
from benchmarks.skips import COUNTERS, SkipRow, SkipsMeasurement
from benchmarks.speed import QUANTITIES, Row, Target, TargetsMeasurement, target_of
from ghostball.engine.running.skips import BUILT_IN, Skip
from ghostball.reports.style import format_quantity, format_time

OUTCOMES = {"absent": "absent", "not-representable": "can't", "failed": "failed"}


def targets_tables(measured: TargetsMeasurement) -> RenderableType:
    """Return our engine's workloads with their targets."""
    parts: list[RenderableType] = []
    if measured.quick:
        parts.append(Text(QUICK_SAYS, style="yellow"))
    parts.append(_ours(measured.rows))
    parts.append(Text(_headline(measured)))
    return Group(*parts)


def racks_tables(measured: RacksMeasurement) -> RenderableType:
    """Return each engine's figures over the racks, or why it has none."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("engine", no_wrap=True)
    for heading in ("racks", "median", "mean", "99 %", "slowest"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("why not")
    for one in measured.engines:
        figures = asdict(one.figures).values() if one.figures else [None] * 4
        times = (format_time(seconds) for seconds in figures)
        outcome = OUTCOMES.get(one.outcome, "")
        said = f"{outcome}: {one.detail}" if outcome else ""
        name = escape(f"{one.engine} {one.version}".strip())
        table.add_row(name, str(len(one.seconds)), *times, escape(said))
    return Group(Text(QUICK_SAYS, style="yellow"), table) if measured.quick else table


def accuracy_tables(measured: AccuracyMeasurement) -> RenderableType:
    """Return how exact our engine is over many random shots, and the shots worth a look."""
    counts = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    counts.add_column(f"{measured.shots} shots from number {measured.first}", no_wrap=True)
    counts.add_column("shots", justify="right")
    for title, kinds in (("proof", measured.endings), ("graded", measured.extents)):
        for name, count in kinds.items():
            counts.add_row(f"{title}: {name}", str(count))
    spread = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    spread.add_column("quantity", no_wrap=True)
    for heading in ("values", "median", "99 %", "greatest"):
        spread.add_column(heading, justify="right", no_wrap=True)
    spread.add_row("quality factor of a shot", *_spread_cells(measured.quality_factor))
    spread.add_row("error of an event's time [ulps]", *_spread_cells(measured.time_error_ulps))
    said = (
        f"{measured.events} events proved: {measured.missing} not found, {measured.invented} "
        f"invented; {measured.swapped} in another order, {measured.negligible} below rounding"
    )
    parts: list[RenderableType] = [counts, spread, Text(said)]
    for title, rows in (("breaks a limit", measured.faulty), ("worst", measured.worst[:3])):
        for row in rows:
            quality = "–" if row.quality_factor is None else f"{row.quality_factor:.3g}"
            why = f"; {'; '.join(row.faults)}" if row.faults else ""
            parts.append(Text(f"{title}: quality factor {quality}{why}: {row.again}"))
    return Group(*parts)


def _spread_cells(spread: Distribution) -> list[str]:
    values = (spread.median, spread.p99, spread.greatest)
    return [str(spread.count), *("–" if value is None else f"{value:.3g}" for value in values)]


def verdict_text(target: Target, median: float, met: bool | None) -> str:
    """Return met or missed, and by how much of the limit; nothing where it isn't judged."""
    if met is None:
        return ""
    if met and median <= 0.0:
        return "[green]met[/]"
    by = abs(100.0 * target.margin(median))
    size = f"{by:.0f} %" if by < 1000.0 else f"{by / 100.0 + 1.0:.0f} times"
    return f"[green]met[/], {size} better" if met else f"[bold red]missed[/] by {size}"


def _ours(rows: Sequence[Row]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("workload", no_wrap=True)
    table.add_column("quantity")
    for heading in ("median", "least", "greatest", "target"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    before = ""
    for row in rows:
        target = target_of(row.workload, row.quantity)
        limit, verdict = "", ""
        if target is not None:
            sign = "≤" if target.kind == "at_most" else "≥"
            limit = f"{sign} {format_quantity(target.limit, row.unit)}"
            verdict = verdict_text(target, row.median, row.met)
        table.add_row(
            escape(row.workload) if row.workload != before else "",
            QUANTITIES[row.quantity].meaning,
            *(format_quantity(value, row.unit) for value in (row.median, row.least, row.greatest)),
            limit,
            verdict,
        )
        before = row.workload
    return table


def _headline(measured: TargetsMeasurement) -> str:
    judged = [row.met for row in measured.rows if row.met is not None]
    environment = measured.environment
    where = f"{environment['cpu']}, {environment['cores']} cores"
    return f"{judged.count(True)} of {len(judged)} targets met; medians of up to " + (
        f"{measured.rounds} rounds, on {where}"
    )


def skips_tables(measured: SkipsMeasurement) -> RenderableType:
    """Return each scene's skips, off and on; then, for each skip, what it came to."""
    scenes = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    scenes.add_column("scene", no_wrap=True)
    scenes.add_column("skip", no_wrap=True)
    for heading in ("on", "off", "off / on", *COUNTERS):
        scenes.add_column(heading.replace("_", " "), justify="right", no_wrap=True)
    scenes.add_column("answer")
    before = ""
    for row in measured.rows:
        scenes.add_row(
            escape(row.scene) if row.scene != before else "",
            row.skip,
            format_time(row.seconds_on),
            format_time(row.seconds_off),
            f"{row.seconds_off / row.seconds_on:.2f}",
            *(_change(row.work_on[name], row.work_off[name]) for name in COUNTERS),
            _answer(row),
        )
        before = row.scene
    return Group(scenes, _skips_summary(measured))


def _change(on: int, off: int) -> str:
    return f"{on}" if on == off else f"{on} → {off}"


def _answer(row: SkipRow) -> str:
    if row.equality == "differs":
        return f"[bold red]differs[/]: {row.detail}"
    return row.equality + (f": {row.detail}" if row.detail else "")


def _skips_summary(measured: SkipsMeasurement) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("skip", no_wrap=True)
    for heading in ("used in", "same bits", "rounding", "differs", "off / on", "bounds, off / on"):
        table.add_column(heading, justify="right")
    table.add_column("it leaves out")
    for skip in Skip:
        rows = [row for row in measured.rows if row.skip == skip]
        verdicts = [row.equality for row in rows]
        off, on = (
            sum(row.work_off["bounds"] for row in rows),
            sum(r.work_on["bounds"] for r in rows),
        )
        table.add_row(
            skip,
            "not measured" if skip in BUILT_IN else f"{len(rows)} of {len(measured.unused)}",
            *(str(verdicts.count(name)) for name in ("same bits", "rounding", "differs")),
            f"{median(r.seconds_off / r.seconds_on for r in rows):.2f}" if rows else "",
            f"{off / on:.2f}" if on else "",
            skip.leaves_out,
        )
    return table

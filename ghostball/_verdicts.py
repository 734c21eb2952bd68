"""The verdicts of a run for the terminal: scenes against engines, engines over all, failures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from statistics import median

from rich import box
from rich.console import Console, Group, RenderableType
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

from ghostball.reports import style
from ghostball.reports.figures.summary import independent_errors
from ghostball.reports.shots import NUMBERS_KEY, cell_text, legend_text
from ghostball.validation.checks.verdict import Verdict, unfinished_text, verdict_of
from ghostball.validation.results.store import CaseRecord, Check, Results

COLOURS = {
    Verdict.PASS: "green",
    Verdict.LIMITS_HOLD: "yellow",
    Verdict.FAIL: "bold red",
    Verdict.CRASHED: "bold red",
    Verdict.UNAVAILABLE: "yellow",
}
FAILURES_SHOWN = 20
"""More than this many lines of failures would push the tables off the screen."""

UNLIMITED = 100_000
"""Columns; a table of any size is measured within them."""

KEY = (
    f"[dim]{legend_text(Verdict)}.\n{NUMBERS_KEY}. Median and worst: scenes with a closed form[/]\n"
)

COMPARISONS = {"at_most": "at most", "at_least": "at least", "equals": "exactly"}


def verdict_tables(results: Results, console: Console) -> RenderableType:
    """Return what `console` has room for: the matrix of verdicts, the engines, the failures."""
    parts: list[RenderableType] = []
    matrix = _matrix(results)
    unlimited = console.options.update_width(UNLIMITED)
    if Measurement.get(console, unlimited, matrix).maximum <= console.width:
        parts.append(matrix)
    return Group(*parts, _engines(results), KEY, *_failures(results.cases))


def colour_of(case: CaseRecord) -> str:
    """Return the style in which the verdict on a case is shown."""
    return COLOURS.get(verdict_of(case), "default")


def _matrix(results: Results) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("scene", no_wrap=True)
    for label in results.labels:
        table.add_column(style.engine_name(label).replace(", ", "\n"), no_wrap=True)
    for scene in results.scene_names:
        table.add_row(scene, *(_cell(results.case(scene, label)) for label in results.labels))
    return table


def _cell(case: CaseRecord | None) -> str:
    return "" if case is None else f"[{colour_of(case)}]{cell_text(case)}[/]"


def _engines(results: Results) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("engine", no_wrap=True)
    for heading in (
        "✓",
        "≈",
        "✗",
        "!",
        "ref",
        "○",
        "–",
        "median\nerror",
        "worst\nerror",
        "median\ntime",
    ):
        table.add_column(heading, justify="right", no_wrap=True, vertical="bottom")
    for label in results.labels:
        cases = [case for case in results.cases if case.label == label]
        verdicts = [verdict_of(case) for case in cases]
        unable = verdicts.count(Verdict.NOT_REPRESENTABLE) + verdicts.count(Verdict.UNAVAILABLE)
        errors = independent_errors(results, label)
        times = [case.wall_time for case in cases if case.wall_time is not None]
        table.add_row(
            escape(label),
            str(verdicts.count(Verdict.PASS)),
            str(verdicts.count(Verdict.LIMITS_HOLD)),
            *(_alarming(verdicts.count(bad)) for bad in (Verdict.FAIL, Verdict.CRASHED)),
            str(verdicts.count(Verdict.REFERENCE)),
            str(verdicts.count(Verdict.SHOWN)),
            str(unable),
            style.format_length(median(errors) if errors else None),
            style.format_length(max(errors) if errors else None),
            style.format_time(median(times) if times else None),
        )
    return table


def _alarming(count: int) -> str:
    return f"[bold red]{count}[/]" if count else "0"


def _failures(cases: Iterable[CaseRecord]) -> Sequence[str]:
    lines = []
    for case in cases:
        where = escape(f"{case.scene} on {case.label}")
        if verdict_of(case) is Verdict.CRASHED:
            lines.append(f"[bold red]did not finish[/] {where}: {escape(unfinished_text(case))}")
        lines += [
            f"[bold red]failed[/]  {where}: {escape(_sentence(check))}"
            for check in case.checks
            if check.passed is False
        ]
    more = len(lines) - FAILURES_SHOWN
    return [*lines[:FAILURES_SHOWN], f"... and {more} more, in the report"] if more > 0 else lines


def _sentence(check: Check) -> str:
    unit = "" if check.unit == "1" else f" {check.unit}"
    got = f"is {_number(check.value)}{unit}" if check.value is not None else "has no value"
    limit = f"must be {COMPARISONS[check.limit_kind]} {_number(check.limit)}{unit}"
    return f"`{check.metric}` {limit}, {got}" + (f" ({check.note})" if check.note else "")


def _number(value: float) -> str:
    return f"{value:.3g}" if isinstance(value, float) and math.isfinite(value) else str(value)

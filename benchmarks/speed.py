"""How fast our engine is beside its targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from functools import partial
from statistics import median
from typing import Annotated, Literal

import typer
from rich.console import Group, RenderableType

from benchmarks.frame import Repeats, benchmark, report
from benchmarks.measurements import Shown, table_of
from benchmarks.workloads import WORKLOADS, Workload
from ghostball.reports.style import format_quantity
from ghostball.validation.results.measurement import MeasurementError, Record
from ghostball.validation.runs.interleave import Task, interleave

MEANINGS: Mapping[str, str] = {
    "kernel": "the simulation alone",
    "call": "the whole call of simulate()",
    "call_extra": "the whole call, over that",
    "per_event": "the simulation alone, per event",
    "collisions_per_second": "impacts of two balls in a second",
    "scene_of_16": "`Scene.from_arrays` of 16 balls",
    "scene_of_balls": "`Scene(balls=...)` of 16 `Ball` objects",
    "first_call_extra": "the first call of simulate() on a scene of 16 balls, over the simulation",
    "begun": "from arrays of 100 000 balls until their simulation has begun",
    "slide": "the simulation alone of a slide in air, and the roll after it",
    "over_no_air": "that over the same without air",
    "first_shot": "from the start of the process to the end of a shot",
    "every_variant": "what `make validate` needs of the kernels, compiled in two processes",
    "import": "`from ghostball.engine import simulate` in a new process",
}
"""Of each quantity that rows may have."""

UNITS = {"collisions_per_second": "1/s", "over_no_air": "1"}
"""Of quantities that aren't in seconds."""

AT_LEAST = ("collisions_per_second",)
"""Quantities of which more is better."""


class Row(Record):
    """One quantity of one workload, in SI units; `target` is None where nothing was aimed at."""

    workload: str
    quantity: str
    median: float
    least: float
    greatest: float
    samples: int
    target: float | None = None

    @classmethod
    def of(cls, load: Workload, quantity: str, values: Sequence[float]) -> Row:
        """Return the row of what was measured of a workload."""
        return cls(
            workload=load.name,
            quantity=quantity,
            median=median(values),
            least=min(values),
            greatest=max(values),
            samples=len(values),
            target=load.targets.get(quantity),
        )

    @property
    def met(self) -> bool | None:
        """Whether the median keeps to the target; None without one."""
        if self.target is None:
            return None
        return (self.median >= self.target) == (self.quantity in AT_LEAST)

    @property
    def cells(self) -> tuple[str, ...]:
        """It as cells of the table."""
        unit = UNITS.get(self.quantity, "s")
        values = (format_quantity(x, unit) for x in (self.median, self.least, self.greatest))
        limit = verdict = ""
        if self.target is not None:
            sign = "≥" if self.quantity in AT_LEAST else "≤"
            limit = f"{sign} {format_quantity(self.target, unit)}"
            by = f"{100.0 * abs(self.median / self.target - 1.0):.0f} %"
            verdict = f"[green]met[/], {by} better" if self.met else f"[bold red]missed[/] by {by}"
        return self.workload, MEANINGS[self.quantity], *values, limit, verdict


class TargetsMeasurement(Shown):
    """What `python -m benchmarks targets` measured."""

    kind: Literal["targets"] = "targets"
    rows: tuple[Row, ...]

    def row(self, workload: str, quantity: str) -> Row | None:
        """Return a row, or None where it wasn't measured."""
        found = (r for r in self.rows if (r.workload, r.quantity) == (workload, quantity))
        return next(found, None)

    @property
    def table(self) -> RenderableType:
        """Our engine's workloads with their targets."""
        heads = ("workload", "quantity", "median", "least", "greatest", "target", "verdict")
        judged = [row.met for row in self.rows if row.met is not None]
        return Group(
            table_of(heads, (row.cells for row in self.rows), left=("quantity", "verdict")),
            f"{judged.count(True)} of {len(judged)} targets met; medians of up to {self.rounds} "
            f"rounds, on {self.environment['cpu']}, {self.environment['cores']} cores",
        )


@benchmark
def targets(
    wanted: Annotated[
        list[str] | None,
        typer.Argument(metavar="GLOB", help="Only workloads that match, such as 'gas-*'."),
    ] = None,
    repeats: Repeats = 15,
) -> TargetsMeasurement:
    """Measure our engine against its targets, some four minutes; a missed one is no failure."""
    return measure_targets(chosen_workloads(wanted or ()), rounds=repeats)


def measure_targets(workloads: Sequence[Workload], *, rounds: int) -> TargetsMeasurement:
    """Measure workloads, interleaved; at most `rounds` samples of each."""
    tasks = [Task(load.name, partial(load.prepare, False), load.most) for load in workloads]
    found = interleave(tasks, rounds, report)
    rows = (
        Row.of(load, quantity, values)
        for load in workloads
        for quantity, values in found[load.name].items()
    )
    return TargetsMeasurement(rounds=rounds, rows=tuple(rows))


def chosen_workloads(patterns: Sequence[str]) -> list[Workload]:
    """Return the workloads whose name matches a pattern, such as "gas-*"; all without a pattern."""
    found = [
        load
        for name, load in WORKLOADS.items()
        if not patterns or any(fnmatchcase(name, pattern) for pattern in patterns)
    ]
    if not found:
        raise MeasurementError(
            f"what is measured must match a workload, got {' '.join(patterns)!r}. There are: "
            f"{', '.join(WORKLOADS)}"
        )
    return found

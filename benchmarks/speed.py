"""Speed of Ghostball's engine, compared with its targets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from functools import partial
from statistics import median
from typing import Annotated, Literal

import typer
from rich.console import Group, RenderableType

from benchmarks.commands import Repeats, benchmark, report_progress
from benchmarks.measurements import BenchmarkMeasurement, table_of
from benchmarks.workloads import WORKLOADS, Workload
from ghostball.reports.style import format_quantity
from ghostball.validation.results.measurement import MeasurementError, Record
from ghostball.validation.runs.interleave import Task, interleave

MEANINGS: Mapping[str, str] = {
    "kernel": "the simulation alone",
    "call": "the whole call of simulate()",
    "call_extra": "the call of simulate() minus the simulation",
    "per_event": "the simulation alone, per event",
    "collisions_per_second": "ball-ball collisions per second",
    "scene_of_16": "`Scene.from_arrays` with 16 balls",
    "scene_of_balls": "`Scene(balls=...)` with 16 `Ball` objects",
    "first_call_extra": "the first call of simulate() with 16 balls, minus the simulation",
    "begun": "`Scene.from_arrays` with 100 000 balls, and the start of their simulation",
    "slide": "the simulation alone of a slide with air drag, and the roll after it",
    "over_no_air": "the time of the slide and the roll, divided by the time without air drag",
    "first_shot": "from the start of the process to the end of a shot",
    "every_variant": "compiling the kernels for `make validate`, in two processes",
    "import": "`from ghostball.engine import simulate` in a new process",
}
"""The quantities of rows, in words."""

UNITS = {"collisions_per_second": "1/s", "over_no_air": "1"}
"""Units of the quantities that aren't in seconds."""

LARGER_IS_BETTER = ("collisions_per_second",)
"""Quantities with targets that are lower limits."""


class TargetRow(Record):
    """One quantity of one workload, in SI units; `target` is None if there is none."""

    workload: str
    quantity: str
    median: float
    least: float
    greatest: float
    samples: int
    target: float | None = None

    @classmethod
    def of(cls, load: Workload, quantity: str, values: Sequence[float]) -> TargetRow:
        """Return the row for the measured values of a quantity of a workload."""
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
        """Whether the median meets the target; None without a target."""
        if self.target is None:
            return None
        return (self.median >= self.target) == (self.quantity in LARGER_IS_BETTER)

    @property
    def cells(self) -> tuple[str, ...]:
        """Cells of the table."""
        unit = UNITS.get(self.quantity, "s")
        values = (format_quantity(x, unit) for x in (self.median, self.least, self.greatest))
        limit = verdict = ""
        if self.target is not None:
            sign = "≥" if self.quantity in LARGER_IS_BETTER else "≤"
            limit = f"{sign} {format_quantity(self.target, unit)}"
            by = f"{100.0 * abs(self.median / self.target - 1.0):.0f} %"
            verdict = f"[green]met[/], {by} better" if self.met else f"[bold red]missed[/] by {by}"
        return self.workload, MEANINGS[self.quantity], *values, limit, verdict


class TargetsMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks targets`."""

    kind: Literal["targets"] = "targets"
    rows: tuple[TargetRow, ...]

    def row(self, workload: str, quantity: str) -> TargetRow | None:
        """Return the row of a quantity of a workload, or None if it wasn't measured."""
        found = (r for r in self.rows if (r.workload, r.quantity) == (workload, quantity))
        return next(found, None)

    @property
    def table(self) -> RenderableType:
        """Table of the measured quantities with their targets."""
        heads = ("workload", "quantity", "median", "smallest", "largest", "target", "verdict")
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
    """Compare the speed of Ghostball's engine with its targets.

    Takes about four minutes. A missed target doesn't change the exit status.
    """
    return measure_targets(chosen_workloads(wanted or ()), rounds=repeats)


def measure_targets(workloads: Sequence[Workload], *, rounds: int) -> TargetsMeasurement:
    """Measure workloads alternately, with at most `rounds` samples of each."""
    tasks = [Task(load.name, partial(load.prepare, False), load.most) for load in workloads]
    found = interleave(tasks, rounds, report_progress)
    rows = (
        TargetRow.of(load, quantity, values)
        for load in workloads
        for quantity, values in found[load.name].items()
    )
    return TargetsMeasurement(rounds=rounds, rows=tuple(rows))


def chosen_workloads(patterns: Sequence[str]) -> list[Workload]:
    """Return the workloads whose name matches a pattern, such as "gas-*"; all without a pattern.

    Raises `MeasurementError` if no name matches.
    """
    found = [
        load
        for name, load in WORKLOADS.items()
        if not patterns or any(fnmatchcase(name, pattern) for pattern in patterns)
    ]
    if not found:
        raise MeasurementError(
            f"GLOB must match a workload, got {' '.join(patterns)!r}. The workloads are "
            f"{', '.join(WORKLOADS)}"
        )
    return found

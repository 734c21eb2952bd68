"""Run times of racks with uneven gaps, and with impacts that last, beside racks with even gaps.

A rack with one gap is easy: a few balls take most of the speed. Racks on real tables are uneven,
and have more collisions.
"""

from __future__ import annotations

import time
from functools import partial
from statistics import median
from typing import Final, Literal

import numpy as np
from rich.console import RenderableType

from benchmarks.breaks import starts_of
from benchmarks.commands import Repeats, benchmark, report_progress
from benchmarks.measurements import BenchmarkMeasurement, Distribution, table_of
from benchmarks.scenes import racks_made_uneven, random_rack, run
from ghostball.engine import simulate_starts
from ghostball.model import POOL_BALL_RADIUS, Scene
from ghostball.reports.style import format_time
from ghostball.validation.results.measurement import Record
from ghostball.validation.runs.interleave import Sampler, Task, interleave

RACKS = 300
"""Number of racks that are timed one by one."""

BREAKS = 3_000
"""Number of breaks that are simulated as arrays, on one processor."""

KINDS: Final = {
    "even": "gaps all equal",
    "uneven": "gaps uneven",
    "lasting": "gaps uneven, impacts that last",
}


class RacksOfKind(Record):
    """Times of racks of one kind, see `KINDS`.

    `seconds` [s]: time of the simulation alone for each rack, the median of the rounds.
    `per_break` [s]: for each round, the mean time of a break if many are simulated as arrays.
    `events`: mean number of events of these breaks.
    """

    kind: str
    seconds: tuple[float, ...]
    per_break: tuple[float, ...]
    events: float


class UnevenMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks uneven`; the rows have the order of `KINDS`."""

    kind: Literal["uneven"] = "uneven"
    kinds: tuple[RacksOfKind, ...]

    @property
    def table(self) -> RenderableType:
        """Table with a row for each kind of racks."""
        heads = ("racks", "median", "mean", "99 %", "slowest", "as arrays", "ratio", "mean events")
        rows = []
        for one in self.kinds:
            found = Distribution.of(one.seconds)
            times = map(format_time, (found.median, found.mean, found.p99, found.greatest))
            each = format_time(median(one.per_break))
            ratio = f"{self.ratio(one.kind):.2f}"
            rows.append((KINDS[one.kind], *times, each, ratio, f"{one.events:.0f}"))
        return table_of(heads, rows)

    def ratio(self, kind: str) -> float:
        """Return `per_break` divided by that of even gaps, the median of the rounds."""
        of_kind, even = (self.of(name).per_break for name in (kind, "even"))
        return median(one / other for one, other in zip(of_kind, even, strict=True))

    def of(self, kind: str) -> RacksOfKind:
        """Return the times of racks of a kind."""
        return next(one for one in self.kinds if one.kind == kind)


@benchmark
def uneven(repeats: Repeats = 7) -> UnevenMeasurement:
    """Time racks with uneven gaps, and impacts that last, beside racks with even gaps."""
    events: dict[str, float] = {}
    tasks = [Task(kind, partial(_prepared, kind, events)) for kind in KINDS]
    found = interleave(tasks, repeats, report_progress)
    kinds = [
        RacksOfKind(
            kind=kind,
            seconds=tuple(_rounded(median(found[kind][f"rack-{k}"])) for k in range(RACKS)),
            per_break=tuple(map(_rounded, found[kind]["break"])),
            events=events[kind],
        )
        for kind in KINDS
    ]
    return UnevenMeasurement(rounds=repeats, kinds=tuple(kinds))


def _rounded(seconds: float) -> float:
    return float(f"{seconds:.4g}")


def _prepared(kind: str, events: dict[str, float]) -> Sampler:
    """Return the sampler of a kind of racks, and store their mean number of events."""
    scene = random_rack(0)
    if kind == "lasting":
        physics = scene.physics.model_copy(update={"impacts": "compliant"})
        scene = scene.model_copy(update={"physics": physics})
    starts, velocities = starts_of(0, BREAKS)
    if kind != "even":
        apart = np.linalg.norm(starts[:, 2] - starts[:, 1], axis=1)
        gaps = apart - 2.0 * POOL_BALL_RADIUS
        starts[:, 1:] = racks_made_uneven(starts[:, 1:], gaps, np.random.default_rng(0))
    spins = scene.angular_velocities
    play = partial(simulate_starts, scene, starts, velocities, spins, threads=1)
    events[kind] = float(np.mean(play().events))
    scenes = [
        Scene.from_arrays(x, v, spins, name=kind, table=scene.table, physics=scene.physics)
        for x, v in zip(starts[:RACKS], velocities[:RACKS], strict=True)
    ]
    for one in scenes:
        run(one)

    def sample() -> dict[str, float]:
        times = {f"rack-{k}": run(one).wall_time for k, one in enumerate(scenes)}
        began = time.perf_counter()
        play()
        return times | {"break": (time.perf_counter() - began) / BREAKS}

    return sample

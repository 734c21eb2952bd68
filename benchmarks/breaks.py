"""Time of a million random breaks, from drawing the initial states until all balls rest."""

from __future__ import annotations

import time
from functools import partial
from typing import Literal

import numpy as np
from rich.console import RenderableType

from benchmarks.commands import Count, benchmark, with_progress
from benchmarks.measurements import BenchmarkMeasurement, table_of
from benchmarks.scenes import (
    FASTEST,
    LARGEST_ANGLE,
    LARGEST_GAP,
    LARGEST_OFFSET,
    POOL_TABLE,
    SLOWEST,
    rack_places,
    random_rack,
)
from ghostball.engine import simulate_starts
from ghostball.engine.batch import STATUSES, workers_of
from ghostball.model import POOL_BALL_RADIUS, Status
from ghostball.model.arrays import FloatArray
from ghostball.reports.style import format_time

BREAKS = 1_000_000
"""Number of breaks of a whole measurement."""

BATCH_SIZE = 20_000
"""Number of breaks that are drawn and simulated at a time."""


class BreaksMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks breaks`, made once; see `starts_of`.

    `seconds` [s]: wall time for drawing, checking and simulating all breaks.
    `processor_seconds` [s]: processor time of the same work.
    """

    kind: Literal["breaks"] = "breaks"
    breaks: int
    threads: int
    seconds: float
    processor_seconds: float
    events: int
    most_events: int
    not_at_rest: int

    @property
    def table(self) -> RenderableType:
        """Table with one row."""
        heads = ("breaks", "threads", "time", "per break", "mean events", "most", "not at rest")
        each = format_time(self.seconds / self.breaks)
        counts = (self.events / self.breaks, self.most_events, self.not_at_rest)
        events, most, unfinished = (f"{count:g}" for count in counts)
        row = (str(self.threads), format_time(self.seconds), each, events, most, unfinished)
        return table_of(heads, [(str(self.breaks), *row)])


def starts_of(part: int, count: int) -> tuple[FloatArray, FloatArray]:
    """Return the initial positions and velocities of `count` breaks, (count, 16, 2) [m], [m/s].

    They have the distribution of `random_rack`: loose and frozen racks alternate. `part` is the
    seed.
    """
    chance = np.random.default_rng(part)
    speed = chance.uniform(SLOWEST, FASTEST, count)
    aim = chance.uniform(-LARGEST_ANGLE, LARGEST_ANGLE, count)
    gap = chance.uniform(0.0, LARGEST_GAP, count)
    gap[1::2] = 0.0
    offset = chance.uniform(-LARGEST_OFFSET, LARGEST_OFFSET, count) * POOL_BALL_RADIUS
    positions, velocities = np.zeros((2, count, 16, 2))
    positions[:, 0, 0] = 0.25 * POOL_TABLE.length
    positions[:, 0, 1] = POOL_TABLE.width / 2.0 + offset
    positions[:, 1:] = rack_places(gap)
    velocities[:, 0, 0], velocities[:, 0, 1] = speed * np.cos(aim), speed * np.sin(aim)
    return positions, velocities


@benchmark
def breaks(count: Count = BREAKS) -> BreaksMeasurement:
    """Time a million random breaks with the full physics of pool, on all cores."""
    scene = random_rack(0)
    play = partial(simulate_starts, scene, angular_velocities=scene.angular_velocities)
    play(*starts_of(0, 2))  # compiles the kernels if necessary
    events = most = unfinished = 0
    began, began_work = time.perf_counter(), time.process_time()
    for first in with_progress(range(0, count, BATCH_SIZE), lambda first: f"breaks from {first}"):
        batch = play(*starts_of(first // BATCH_SIZE, min(BATCH_SIZE, count - first)))
        events, most = events + int(batch.events.sum()), max(most, int(batch.events.max()))
        unfinished += int(np.sum(batch.status != STATUSES.index(Status.REST)))
    return BreaksMeasurement(
        breaks=count,
        threads=workers_of(None),
        seconds=float(f"{time.perf_counter() - began:.4g}"),
        processor_seconds=float(f"{time.process_time() - began_work:.4g}"),
        events=events,
        most_events=most,
        not_at_rest=unfinished,
    )

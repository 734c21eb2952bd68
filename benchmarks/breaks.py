"""A million random breaks, from the drawing of their starts to the last ball at rest."""

from __future__ import annotations

import time
from functools import partial
from typing import Literal

import numpy as np
from rich.console import RenderableType

from benchmarks.frame import Count, benchmark, counted
from benchmarks.measurements import Shown, table_of
from benchmarks.scenes import (
    FARTHEST,
    FASTEST,
    LOOSEST,
    POOL_TABLE,
    SLOWEST,
    WIDEST_AIM,
    rack_places,
    random_rack,
)
from ghostball.engine import simulate_starts
from ghostball.engine.batch import STATUSES, workers_of
from ghostball.model import POOL_BALL_RADIUS, Status
from ghostball.model.arrays import FloatArray
from ghostball.reports.style import format_time

BREAKS = 1_000_000
"""Breaks of a whole measurement."""

AT_ONCE = 20_000
"""Breaks that are drawn and played at a time."""


class BreaksMeasurement(Shown):
    """What `python -m benchmarks breaks` measured, once; see `starts_of`."""

    kind: Literal["breaks"] = "breaks"
    breaks: int
    threads: int
    seconds: float  # all of it: starts drawn, checked and played
    processor_seconds: float
    events: int
    most_events: int
    not_at_rest: int

    @property
    def table(self) -> RenderableType:
        """It as one row."""
        heads = ("breaks", "threads", "in all", "a break", "mean events", "most", "not at rest")
        each = format_time(self.seconds / self.breaks)
        counts = (self.events / self.breaks, self.most_events, self.not_at_rest)
        events, most, unfinished = (f"{count:g}" for count in counts)
        row = (str(self.threads), format_time(self.seconds), each, events, most, unfinished)
        return table_of(heads, [(str(self.breaks), *row)])


def starts_of(part: int, count: int) -> tuple[FloatArray, FloatArray]:
    """Return how `count` breaks begin: positions and velocities, (count, 16, 2) [m], [m/s].

    As `random_rack` draws them: loose racks and frozen ones take turns. The same part has the same
    breaks.
    """
    chance = np.random.default_rng(part)
    speed = chance.uniform(SLOWEST, FASTEST, count)
    aim = chance.uniform(-WIDEST_AIM, WIDEST_AIM, count)
    gap = chance.uniform(0.0, LOOSEST, count)
    gap[1::2] = 0.0
    offset = chance.uniform(-FARTHEST, FARTHEST, count) * POOL_BALL_RADIUS
    positions, velocities = np.zeros((2, count, 16, 2))
    positions[:, 0, 0] = 0.25 * POOL_TABLE.length
    positions[:, 0, 1] = POOL_TABLE.width / 2.0 + offset
    positions[:, 1:] = rack_places(gap)
    velocities[:, 0, 0], velocities[:, 0, 1] = speed * np.cos(aim), speed * np.sin(aim)
    return positions, velocities


@benchmark
def breaks(count: Count = BREAKS) -> BreaksMeasurement:
    """Play a million random breaks with all of pool's physics, on all cores, and time it all."""
    scene = random_rack(0)
    play = partial(simulate_starts, scene, angular_velocities=scene.angular_velocities)
    play(*starts_of(0, 2))  # compiles, where nothing is yet
    events = most = unfinished = 0
    began, began_work = time.perf_counter(), time.process_time()
    for first in counted(range(0, count, AT_ONCE), lambda first: f"breaks from {first}"):
        batch = play(*starts_of(first // AT_ONCE, min(AT_ONCE, count - first)))
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

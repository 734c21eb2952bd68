"""Time of many strokes given as arrays, beside the same shots given as velocities and spins."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from statistics import median
from typing import Literal, get_args

import numpy as np
from rich.console import Group, RenderableType

from benchmarks.commands import Count, Repeats, benchmark, report_progress
from benchmarks.measurements import BenchmarkMeasurement, table_of
from ghostball.engine import Batch, Strokes, simulate_starts
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.model.scene.initial_states import struck_motions
from ghostball.reports.style import format_quantity
from ghostball.validation.results.measurement import Record
from ghostball.validation.runs.interleave import Sampler, Task, interleave

SHOTS = 100_000
"""Number of shots of a whole measurement."""

PLACES = {"cue": (0.6, 0.635), "a": (1.8, 0.9), "b": (1.4, 0.4), "c": (2.1, 0.5)}
"""Positions of the four balls [m]."""

NOISE = {"speed": 0.1, "direction": 0.002, "offset_left": 0.02, "offset_up": 0.02}
"""Standard deviations of the errors of the strokes [m/s, rad, radii, radii]."""

Way = Literal["strokes", "velocities and spins"]
WAYS: tuple[Way, ...] = get_args(Way)


class StrokesRow(Record):
    """One way to give the shots.

    `seconds`: time of the whole call, with outcomes [s], the minimum of all rounds.
    `per_start`: processor time per shot of a call that stops every shot after one event [s], the
        minimum of all rounds: for drawing, converting, checking, one event, and the results.
    """

    way: Way
    seconds: float
    per_start: float


class StrokesMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks strokes`; the first row is for strokes.

    `ratio`: time for strokes divided by the time for velocities, the median of the rounds.
    """

    kind: Literal["strokes"] = "strokes"
    shots: int
    ratio: float
    rows: tuple[StrokesRow, ...]

    @property
    def table(self) -> RenderableType:
        """Table with the time of each way."""
        cells = (
            (row.way, format_quantity(row.seconds, "s"), format_quantity(row.per_start, "s"))
            for row in self.rows
        )
        return Group(
            table_of(("given", f"{self.shots} shots", "processor time per start"), cells),
            f"strokes over velocities and spins: {self.ratio:.2f}",
        )


@benchmark
def strokes(repeats: Repeats = 15, count: Count = SHOTS) -> StrokesMeasurement:
    """Measure strokes on a table with four balls and pockets, given as arrays with noise."""
    tasks = [Task(way, partial(prepare, way, count)) for way in WAYS]
    found = interleave(tasks, repeats, report_progress)
    rows = [
        StrokesRow(way=way, **{name: min(values) for name, values in found[way].items()})
        for way in WAYS
    ]
    pairs = zip(*(found[way]["seconds"] for way in WAYS), strict=True)
    ratio = median(first / second for first, second in pairs)
    return StrokesMeasurement(rounds=repeats, shots=count, ratio=ratio, rows=tuple(rows))


def prepare(way: Way, count: int) -> Sampler:
    """Prepare the shots in one way."""
    play = shots_in(way, count)

    def sample() -> dict[str, float]:
        began = time.perf_counter()
        play(10**6)
        seconds, began = time.perf_counter() - began, time.process_time()
        play(1)
        return {"seconds": seconds, "per_start": (time.process_time() - began) / count}

    sample()
    return sample


def shots_in(way: Way, count: int) -> Callable[[int], Batch]:
    """Return a function that simulates the shots, each up to the given number of events."""
    chance = np.random.default_rng(1)
    speeds, directions = chance.uniform(0.5, 6.0, count), chance.uniform(-0.6, 0.6, count)
    scene = Scene(
        name="strokes",
        table=Table.model_validate("wpa-9ft"),
        physics=Physics(preset="pool"),
        balls=[Ball(id=name, position=place) for name, place in PLACES.items()],
    )
    given = Strokes(speeds, directions, noise=NOISE, seed=1)
    if way == "strokes":
        return lambda most: simulate_starts(scene, strokes=given, max_events=most)
    drawn = given.drawn(scene)
    velocities, spins = np.zeros((count, 4, 3)), np.zeros((count, 4, 3))
    velocities[:, 0], spins[:, 0] = struck_motions(scene, 0, drawn.cue, drawn.aims)
    return lambda most: simulate_starts(scene, None, velocities, spins, max_events=most)

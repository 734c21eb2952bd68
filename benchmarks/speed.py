"""How fast our engine is: each workload builds its scenes, and samples them once a round."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from statistics import median
from typing import Any, Literal, NamedTuple

import numpy as np
from rich.console import Group, RenderableType

from benchmarks.calls import (
    RACKS,
    prepare_air,
    prepare_building,
    prepare_many,
    prepare_processes,
    prepare_tied,
)
from benchmarks.measurements import Shown, table_of
from benchmarks.processes import prepare_cold_start, prepare_start
from benchmarks.scenes import ROLLING, racked_break, table_gas
from benchmarks.timing import run
from ghostball.engine import simulate_sweep
from ghostball.model import POOL_BALL_RADIUS, Scene
from ghostball.reports.style import format_quantity
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.results.measurement import MeasurementError, Record
from ghostball.validation.runs.interleave import Sampler, Task, interleave
from ghostball.validation.scenes.gases import FRICTIONLESS, FULL_CLOTH, ball_at, packed_gas
from ghostball.validation.scenes.library import find_scene

SHIPPED = (
    "break-16",
    "break-16@8",
    "break-8",
    "break-7",
    "pool-break-9",
    "frozen-break",
    "galperin-3",
    "push",
)
"""Shipped scenes, measured for themselves; SCENE@SPEED sets the first ball's speed [m/s]."""

SWEPT = "half-ball-cut"
"""The shipped scene of two balls that the sweep shoots."""

RUNS = 15
"""How often a sample runs a shipped scene: one run takes too short a time."""

GAS_PACKING, CLOTH_PACKING = 0.6, 0.3
"""The part of the area that balls cover, of elastic gases and of balls on cloth."""

MELTING = 20.0
"""Collisions of each ball after which nothing is left of the lattice of the start."""


class Quantity(NamedTuple):
    """The unit of a quantity, and what it means in words."""

    unit: str
    meaning: str


QUANTITIES: Mapping[str, Quantity] = {
    "kernel": Quantity("s", "the simulation alone"),
    "call": Quantity("s", "the whole call of simulate()"),
    "call_extra": Quantity("s", "the whole call, over that"),
    "per_event": Quantity("s", "the simulation alone, per event"),
    "collisions_per_second": Quantity("1/s", "impacts of two balls in a second"),
    "shots_per_second": Quantity("1/s", "shots in a second, one thread"),
    "two_threads": Quantity("1", "shots in a second, two threads over one"),
    "threads_over_processes": Quantity("1", "shots in a second, two threads over two processes"),
    "many_extra": Quantity(
        "s", "`simulate_many`, a scene that was played before, over the simulation alone"
    ),
    "starts_extra": Quantity("s", "`simulate_starts`, a start, over the simulation alone"),
    "scene_of_16": Quantity("s", "`Scene.from_arrays` of 16 balls"),
    "begun": Quantity("s", "from arrays of 100 000 balls until their simulation has begun"),
    "slide": Quantity("s", "the simulation alone of a slide in air, and the roll after it"),
    "over_no_air": Quantity("1", "that over the same without air"),
    "first_shot": Quantity("s", "from the start of the process to the end of a shot"),
    "every_variant": Quantity(
        "s", "what `make validate` needs of the kernels, compiled in two processes"
    ),
    "import": Quantity("s", "`import ghostball.engine` in a new process"),
}
"""By the name that rows have."""


TARGETS: Mapping[tuple[str, str], float] = {
    ("break-pool", "kernel"): 30e-6,
    ("break-pool", "per_event"): 280e-9,
    ("break-pool", "call_extra"): 8e-6,
    ("break-paper", "per_event"): 400e-9,
    ("gas-16", "per_event"): 180e-9,
    ("gas-1000", "collisions_per_second"): 1.3e6,
    ("gas-10000", "collisions_per_second"): 1.0e6,
    ("gas-100000", "collisions_per_second"): 0.5e6,
    ("cloth-10000", "per_event"): 1.2e-6,
    ("sweep", "shots_per_second"): 400e3,
    ("sweep", "threads_over_processes"): 0.95,
    ("many", "many_extra"): 5e-6,
    ("many", "starts_extra"): 30e-6,
    ("scenes", "scene_of_16"): 30e-6,
    ("scenes", "begun"): 2.0,
    ("tied", "per_event"): 3e-6,
    ("air", "over_no_air"): 6.0,
    ("start", "first_shot"): 1.0,
    ("start", "import"): 0.3,
    ("cold-start", "first_shot"): 10.0,
    ("cold-start", "every_variant"): 40.0,
}
"""Limits on the median of a quantity of a workload: at most so much, but for `AT_LEAST`."""

AT_LEAST = ("collisions_per_second", "shots_per_second", "threads_over_processes")
"""Quantities of which more is better."""


@dataclass(frozen=True)
class Workload:
    """One workload: its name, what it is, how a sample of it is prepared.

    `prepare`: takes whether sizes are tiny: then it shows that all runs, and times nothing.
    `most`: see `Task`.
    """

    name: str
    title: str
    prepare: Callable[[bool], Sampler]
    most: int | None = None


class Row(Record):
    """One quantity of one workload, in SI units; `met` is None where nothing was aimed at."""

    workload: str
    title: str
    quantity: str
    unit: str
    median: float
    least: float
    greatest: float
    samples: int
    target: float | None = None
    met: bool | None = None

    @classmethod
    def of(cls, load: Workload, quantity: str, values: Sequence[float]) -> Row:
        """Return the row of what was measured of a workload."""
        unit, middle = QUANTITIES[quantity].unit, median(values)
        target = TARGETS.get((load.name, quantity))
        return cls(
            workload=load.name,
            title=load.title,
            quantity=quantity,
            unit=unit,
            median=middle,
            least=min(values),
            greatest=max(values),
            samples=len(values),
            target=target,
            met=None if target is None else (middle >= target) == (quantity in AT_LEAST),
        )

    @property
    def verdict(self) -> str:
        """Met or missed, and by how much of the limit; "" where nothing was aimed at."""
        if self.target is None:
            return ""
        by = f"{abs(self.median / self.target - 1.0):.0%}".replace("%", " %")
        return f"[green]met[/], {by} better" if self.met else f"[bold red]missed[/] by {by}"


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
        cells = []
        for row in self.rows:
            sign = "≥" if row.quantity in AT_LEAST else "≤"
            limit = "" if row.target is None else f"{sign} {format_quantity(row.target, row.unit)}"
            spread = (row.median, row.least, row.greatest)
            shown = (format_quantity(value, row.unit) for value in spread)
            meaning = QUANTITIES[row.quantity].meaning
            cells.append((row.workload, meaning, *shown, limit, row.verdict))
        heads = ("workload", "quantity", "median", "least", "greatest", "target", "verdict")
        judged = [row.met for row in self.rows if row.met is not None]
        return Group(
            table_of(heads, cells, left=("quantity", "verdict")),
            f"{judged.count(True)} of {len(judged)} targets met; medians of up to {self.rounds} "
            f"rounds, on {self.environment['cpu']}, {self.environment['cores']} cores",
        )


def measure_targets(
    workloads: Sequence[Workload], *, rounds: int, progress: Progress[str] | None = None
) -> TargetsMeasurement:
    """Measure workloads, interleaved; at most `rounds` samples of each."""
    tasks = [Task(load.name, partial(load.prepare, False), load.most) for load in workloads]
    found = interleave(tasks, rounds, progress)
    rows = (
        Row.of(load, quantity, values)
        for load in workloads
        for quantity, values in found[load.name].items()
    )
    return TargetsMeasurement(rounds=rounds, rows=tuple(rows))


def chosen_workloads(patterns: Sequence[str]) -> tuple[Workload, ...]:
    """Return the workloads whose name matches a pattern, such as "gas-*"; all without a pattern."""
    if not patterns:
        return WORKLOADS
    chosen = tuple(
        load for load in WORKLOADS if any(fnmatchcase(load.name, one) for one in patterns)
    )
    if not chosen:
        names = ", ".join(load.name for load in WORKLOADS)
        raise MeasurementError(
            f"what is measured must match a workload, got {' '.join(patterns)!r}. There are: "
            f"{names}"
        )
    return chosen


def shipped_scene(name: str) -> Scene:
    """Return a shipped scene, its first ball sped up where the name says so."""
    name, _, speed = name.partition("@")
    scene = find_scene(name)
    if not speed:
        return scene
    cue = scene.balls[0]
    factor = float(speed) / cue.speed
    faster = cue.model_copy(update={"velocity": tuple(factor * v for v in cue.velocity)})
    return scene.model_copy(update={"balls": (faster, *scene.balls[1:])})


def continued(scene: Scene) -> Scene:
    """Return a scene of rolling balls as it is when it ends: a lattice is a gas by then."""
    state = run(scene).final_state
    states = zip(
        scene.balls, state.positions[0].tolist(), state.velocities[0].tolist(), strict=True
    )
    moved = tuple(ball_at(ball.id, tuple(place), tuple(speed)) for ball, place, speed in states)
    return Scene(**{**dict(scene), "balls": moved})


def _sampler_of(scenes: Sequence[Scene], runs: int = 1) -> Sampler:
    """Return what samples scenes: medians over them, each run so often."""
    for scene in scenes:  # laid out, and whatever it needs compiled
        run(scene)

    def sample() -> dict[str, float]:
        walls, calls, per_event, rates = [], [], [], []
        for scene in scenes:
            for _ in range(runs):
                began = time.perf_counter()
                result = run(scene)
                calls.append(time.perf_counter() - began)
                walls.append(result.wall_time)
                per_event.append(result.wall_time / max(result.work["events"], 1))
                rates.append(result.collision_counts["ball-ball"] / result.wall_time)
        return {
            "kernel": median(walls),
            "call": median(calls),
            "call_extra": median(call - wall for call, wall in zip(calls, walls, strict=True)),
            "per_event": median(per_event),
            "collisions_per_second": median(rates),
        }

    return sample


def _prepare_breaks(physics: dict[str, Any], fast: bool) -> Sampler:
    return _sampler_of([racked_break(seed, physics) for seed in range(2 if fast else 100)])


def _prepare_table_gas(fast: bool) -> Sampler:
    return _sampler_of([table_gas(16, 2.0 if fast else 500.0)])


def _prepare_gas(count: int, fast: bool) -> Sampler:
    """Prepare a melted elastic gas.

    How long it runs hangs on how often a ball meets another: Enskog's rate of hard discs,
    2 sqrt(pi) n D g sqrt(k T / m), with the contact value g = (1 - 7 x / 16) / (1 - x)^2 of
    Henderson (1975), x the part covered, at 1 m/s for each component of a velocity.
    """
    contact = (1.0 - 7.0 * GAS_PACKING / 16.0) / (1.0 - GAS_PACKING) ** 2
    rate = 4.0 * GAS_PACKING * contact / (math.sqrt(math.pi) * POOL_BALL_RADIUS)  # [1/s]
    lasts = (2.0 if fast else MELTING) / rate
    gas = packed_gas(min(count, 20) if fast else count, GAS_PACKING, FRICTIONLESS, t_max=lasts)
    return _sampler_of([continued(gas)])


def _prepare_cloth(fast: bool) -> Sampler:
    return _sampler_of([packed_gas(20 if fast else 10_000, CLOTH_PACKING, FULL_CLOTH)])


def _prepare_sweep(fast: bool) -> Sampler:
    scene, shots = find_scene(SWEPT), 20 if fast else 100_000
    chance = np.random.default_rng(0)
    cue, target = scene.positions[:2, :2]
    across, along = target[1] - cue[1], target[0] - cue[0]
    reach = float(scene.radii[:2].sum() / np.hypot(along, across))
    speeds = chance.uniform(0.5, 2.0, shots)
    angles = np.arctan2(across, along) + np.arcsin(reach) * chance.uniform(-1.0, 1.0, shots)

    def shoot(threads: int) -> float:
        began = time.perf_counter()
        simulate_sweep(scene, speeds, angles, threads=threads)
        return time.perf_counter() - began

    def sample() -> dict[str, float]:
        one = shoot(1)
        measured = {"shots_per_second": shots / one}
        if two is not None:
            both = shoot(2)
            measured |= {"two_threads": one / both, "threads_over_processes": two() / both}
        return measured

    simulate_sweep(scene, speeds, angles, threads=1)
    several = (os.cpu_count() or 1) > 1
    two = prepare_processes(scene, speeds, angles) if several else None
    return sample


def _prepare_shipped(name: str, fast: bool) -> Sampler:
    return _sampler_of([shipped_scene(name)], 1 if fast else RUNS)


def _gas(count: int, most: int | None = None) -> Workload:
    title = f"elastic gas of {count} balls, packing {GAS_PACKING}"
    return Workload(f"gas-{count}", title, partial(_prepare_gas, count), most)


WORKLOADS: tuple[Workload, ...] = (
    Workload(
        "break-pool",
        "break of 16 with all of pool's physics, random racks",
        partial(_prepare_breaks, FULL_CLOTH),
    ),
    Workload(
        "break-paper",
        "break of 16 with the paper's physics, random racks",
        partial(_prepare_breaks, ROLLING),
    ),
    Workload("gas-16", "elastic gas of 16 balls on a pool table", _prepare_table_gas),
    _gas(1_000),
    _gas(10_000, most=7),
    _gas(100_000, most=3),
    Workload(
        "cloth-10000",
        f"10000 balls with all of pool's physics, packing {CLOTH_PACKING}, until they rest",
        _prepare_cloth,
        most=5,
    ),
    Workload("sweep", "simulate_sweep of two-ball shots", _prepare_sweep),
    Workload("many", f"{RACKS} random racks, half frozen, by one call", prepare_many, most=5),
    Workload("scenes", "scenes made of arrays", prepare_building, most=5),
    Workload("tied", "16 000 balls that roll alike and stop at one instant", prepare_tied, most=5),
    Workload("air", "random slides of one ball on pool cloth in air", prepare_air),
    Workload("start", "a new process, kernels in the cache", prepare_start, most=5),
    Workload("cold-start", "a new process that compiles its kernels", prepare_cold_start, most=1),
    *(
        Workload(f"scene:{name}", f"shipped scene {name}", partial(_prepare_shipped, name))
        for name in SHIPPED
    ),
)

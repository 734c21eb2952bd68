"""How fast our engine is: each workload builds its scenes, and samples them once a round."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from statistics import median
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict

from benchmarks.measurements import Measurement, measured_where
from benchmarks.processes import sample_cold_start, sample_start
from benchmarks.running import BenchError, after, collision_rate, run, until
from benchmarks.scenes import ROLLING, racked_break, table_gas
from benchmarks.timing import Clock, Sampler, Samples, Task, take_turns
from ghostball.engine import Scene, simulate_sweep
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.scenes.gases import FRICTIONLESS, FULL_CLOTH, packed_gas
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
    "first_shot": Quantity("s", "from the start of the process to the end of a shot"),
    "every_variant": Quantity(
        "s", "what `make validate` needs of the kernels, compiled in two processes"
    ),
    "import": Quantity("s", "`import ghostball.engine` in a new process"),
}
"""By the name that rows have."""


@dataclass(frozen=True)
class Target:
    """A limit on the median of one quantity of one workload, in SI units."""

    workload: str
    quantity: str
    kind: Literal["at_most", "at_least"]
    limit: float

    def met(self, value: float) -> bool:
        """Whether a measured value keeps it."""
        return value <= self.limit if self.kind == "at_most" else value >= self.limit

    def margin(self, value: float) -> float:
        """How much better than the limit a value is, as a part of the limit; negative if worse."""
        better = self.limit - value if self.kind == "at_most" else value - self.limit
        return better / self.limit


TARGETS: tuple[Target, ...] = (
    Target("break-pool", "kernel", "at_most", 30e-6),
    Target("break-pool", "per_event", "at_most", 280e-9),
    Target("break-pool", "call_extra", "at_most", 25e-6),
    Target("break-paper", "per_event", "at_most", 400e-9),
    Target("gas-16", "per_event", "at_most", 180e-9),
    Target("gas-1000", "collisions_per_second", "at_least", 1.3e6),
    Target("gas-10000", "collisions_per_second", "at_least", 1.0e6),
    Target("gas-100000", "collisions_per_second", "at_least", 0.5e6),
    Target("cloth-10000", "per_event", "at_most", 1.2e-6),
    Target("sweep", "shots_per_second", "at_least", 400e3),
    Target("sweep", "two_threads", "at_least", 1.9),
    Target("start", "first_shot", "at_most", 1.0),
    Target("start", "import", "at_most", 0.3),
    Target("cold-start", "first_shot", "at_most", 10.0),
    Target("cold-start", "every_variant", "at_most", 40.0),
)


def target_of(workload: str, quantity: str) -> Target | None:
    """Return the target of a quantity, or None where there is none."""
    found = (t for t in TARGETS if (t.workload, t.quantity) == (workload, quantity))
    return next(found, None)


@dataclass(frozen=True)
class Workload:
    """One workload: its name, what it is, how a sample of it is prepared.

    Attributes
    ----------
    name, title : str
    prepare : callable
        Takes whether sizes are tiny: then it shows that all runs, and times nothing.
    most : int or None
        See `Task`.
    """

    name: str
    title: str
    prepare: Callable[[bool], Sampler]
    most: int | None = None


class Row(BaseModel):
    """One quantity of one workload, in SI units; `met` is None where nothing was aimed at."""

    model_config = ConfigDict(frozen=True, extra="forbid")

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


class TargetsMeasurement(Measurement):
    """What `python -m benchmarks targets` measured."""

    kind: Literal["targets"] = "targets"
    rows: tuple[Row, ...]

    @property
    def anything(self) -> bool:
        """Whether any row was measured."""
        return bool(self.rows)

    def row(self, workload: str, quantity: str) -> Row | None:
        """Return a row, or None where it wasn't measured."""
        found = (r for r in self.rows if (r.workload, r.quantity) == (workload, quantity))
        return next(found, None)


def measure_targets(
    workloads: Sequence[Workload],
    *,
    rounds: int,
    quick: bool = False,
    clock: Clock = time.perf_counter,
    progress: Progress[str] | None = None,
) -> TargetsMeasurement:
    """Measure workloads by turns; Ctrl-C keeps what was measured.

    Parameters
    ----------
    workloads : sequence of Workload
    rounds : int
        At most as many samples of each.
    quick : bool
        A trial at tiny sizes: no target is judged.
    clock, progress
        As for `take_turns`.
    """
    environment = measured_where()
    tasks = [Task(load.name, partial(load.prepare, quick), load.most) for load in workloads]
    samples = take_turns(tasks, rounds, clock=clock, progress=progress)
    return TargetsMeasurement(
        environment=environment,
        rounds=rounds,
        quick=quick,
        interrupted=samples.interrupted,
        rows=tuple(row for load in workloads for row in _rows(load, samples, judged=not quick)),
    )


def _rows(load: Workload, samples: Samples, *, judged: bool) -> Iterator[Row]:
    for quantity, spread in samples.spreads(load.name).items():
        target = target_of(load.name, quantity)
        yield Row(
            workload=load.name,
            title=load.title,
            quantity=quantity,
            unit=QUANTITIES[quantity].unit,
            median=spread.median,
            least=spread.least,
            greatest=spread.greatest,
            samples=spread.samples,
            target=target.limit if target else None,
            met=target.met(spread.median) if target and judged else None,
        )


def chosen_workloads(patterns: Sequence[str]) -> tuple[Workload, ...]:
    """Return the workloads whose name matches any of some patterns, such as "gas-*"; none is all.

    Raises
    ------
    BenchError
        Where none matches.
    """
    if not patterns:
        return WORKLOADS
    chosen = tuple(
        load for load in WORKLOADS if any(fnmatchcase(load.name, one) for one in patterns)
    )
    if not chosen:
        names = ", ".join(load.name for load in WORKLOADS)
        raise BenchError(
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


def _sampler_of(scenes: Sequence[Scene], runs: int = 1) -> Sampler:
    """Return what samples scenes: medians over them, each run so often."""
    for scene in scenes:  # laid out, and whatever it needs compiled
        run(scene)

    def sample(clock: Clock) -> dict[str, float]:
        walls, calls, per_event, rates = [], [], [], []
        for scene in scenes:
            for _ in range(runs):
                began = clock()
                result = run(scene)
                calls.append(clock() - began)
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


def _prepare_breaks(physics: dict[str, Any], quick: bool) -> Sampler:
    return _sampler_of([racked_break(seed, physics) for seed in range(2 if quick else 100)])


def _prepare_table_gas(quick: bool) -> Sampler:
    return _sampler_of([table_gas(16, 2.0 if quick else 500.0)])


def _prepare_gas(count: int, quick: bool) -> Sampler:
    """Prepare a melted elastic gas."""
    each = 1.0 / collision_rate(GAS_PACKING)  # seconds between two collisions of a ball
    lasts = (2.0 if quick else MELTING) * each
    gas = packed_gas(min(count, 20) if quick else count, GAS_PACKING, FRICTIONLESS, t_max=lasts)
    return _sampler_of([until(after(gas), lasts)])


def _prepare_cloth(quick: bool) -> Sampler:
    return _sampler_of([packed_gas(20 if quick else 10_000, CLOTH_PACKING, FULL_CLOTH)])


def _prepare_sweep(quick: bool) -> Sampler:
    scene, shots = find_scene(SWEPT), 20 if quick else 100_000
    chance = np.random.default_rng(0)
    cue, target = scene.positions[:2, :2]
    across, along = target[1] - cue[1], target[0] - cue[0]
    reach = float(scene.radii[:2].sum() / np.hypot(along, across))
    speeds = chance.uniform(0.5, 2.0, shots)
    angles = np.arctan2(across, along) + np.arcsin(reach) * chance.uniform(-1.0, 1.0, shots)

    def shoot(threads: int, clock: Clock) -> float:
        began = clock()
        simulate_sweep(scene, speeds, angles, threads=threads)
        return clock() - began

    def sample(clock: Clock) -> dict[str, float]:
        one = shoot(1, clock)
        measured = {"shots_per_second": shots / one}
        if (os.cpu_count() or 1) > 1:
            measured["two_threads"] = one / shoot(2, clock)
        return measured

    simulate_sweep(scene, speeds, angles, threads=1)
    return sample


def _prepare_shipped(name: str, quick: bool) -> Sampler:
    return _sampler_of([shipped_scene(name)], 1 if quick else RUNS)


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
    Workload("start", "a new process, kernels in the cache", sample_start, most=5),
    Workload("cold-start", "a new process that compiles its kernels", sample_cold_start, most=1),
    *(
        Workload(f"scene:{name}", f"shipped scene {name}", partial(_prepare_shipped, name))
        for name in SHIPPED
    ),
)

"""The workloads that `speed` times. Each workload is prepared once, and sampled in each round."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from statistics import median

import numpy as np

from benchmarks.processes import prepare_cold_start, prepare_start
from benchmarks.scenes import POOL_TABLE, random_rack, run
from ghostball.engine.running.calls import Limits, Shots, shots_of
from ghostball.engine.running.from_scene import layout_of
from ghostball.engine.running.threads import rows_of_starts, run_tasks, tasks_of
from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Scene, Table
from ghostball.validation.runs.interleave import Sampler
from ghostball.validation.scenes.gases import FRICTIONLESS, ball_at, packed_gas
from ghostball.validation.scenes.library import find_scene

SHIPPED = ("break-16", "break-16@8", "pool-break-9", "galperin-3")
"""Shipped scenes with run times that the documentation quotes; SCENE@SPEED sets the speed of the
first ball [m/s].
"""

RUNS = 15
"""Number of runs of a shipped scene in a sample, because one run is too short to time."""

SLIDES = 10_000
"""Number of slides of one ball."""

DRAG = 0.0041
"""Drag coefficient k of a pool ball in air [1/m], as in the shipped scene `air-slides`."""

GAS_PACKING = 0.6
"""Part of the area that the balls of a gas cover."""

MELTING_COLLISIONS = 20.0
"""Number of collisions of each ball after which the initial lattice has become a gas."""

Prepare = Callable[[bool], Sampler]
"""Function that prepares a workload; True asks for tiny sizes, for a quick test."""


@dataclass(frozen=True)
class Workload:
    """One workload.

    `prepare`: returns the sampler.
    `targets`: upper limits of medians, by quantity; lower limits for `speed.LARGER_IS_BETTER`.
    `most`: largest number of samples, see `Task`.
    """

    name: str
    prepare: Prepare
    targets: Mapping[str, float] = field(default_factory=dict)
    most: int | None = None


WORKLOADS: dict[str, Workload] = {}


def workload(
    name: str, targets: Mapping[str, float] | None = None, most: int | None = None
) -> Callable[[Prepare], Prepare]:
    """Return a decorator that registers a function as the preparation of a workload."""

    def register(prepare: Prepare) -> Prepare:
        WORKLOADS[name] = Workload(name, prepare, targets or {}, most)
        return prepare

    return register


def shipped_scene(name: str) -> Scene:
    """Return a shipped scene by its name or by SCENE@SPEED; see `SHIPPED`."""
    name, _, speed = name.partition("@")
    scene = find_scene(name)
    if not speed:
        return scene
    cue = scene.balls[0]
    factor = float(speed) / cue.speed
    faster = cue.model_copy(update={"velocity": tuple(factor * v for v in cue.velocity)})
    return scene.model_copy(update={"balls": (faster, *scene.balls[1:])})


def continued(scene: Scene) -> Scene:
    """Return a scene that starts with the final state of `scene`; all balls roll."""
    state = run(scene).final_state
    states = zip(
        scene.balls, state.positions[0].tolist(), state.velocities[0].tolist(), strict=True
    )
    moved = tuple(ball_at(ball.id, tuple(place), tuple(speed)) for ball, place, speed in states)
    return Scene(**{**dict(scene), "balls": moved})


def seconds_of(what: Callable[[], object]) -> float:
    """Return the time of a call [s]."""
    began = time.perf_counter()
    what()
    return time.perf_counter() - began


def sampler_of(scenes: Sequence[Scene], runs: int = 1) -> Sampler:
    """Return a sampler that runs each scene `runs` times; a sample has medians over all runs."""
    for scene in scenes:  # so that the kernels are compiled and the layouts cached
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


@workload("loose-racks", {"kernel": 30e-6, "per_event": 280e-9, "call_extra": 8e-6})
def prepare_racks(fast: bool) -> Sampler:
    """Prepare breaks of loose racks with the full physics of pool."""
    return sampler_of([random_rack(2 * k) for k in range(2 if fast else 100)])


def prepare_gas(count: int, fast: bool) -> Sampler:
    """Prepare an elastic gas of `count` balls that starts as a lattice and is run until it melts.

    The duration follows from the collision rate of hard discs (Enskog),
    2 sqrt(pi) n D g sqrt(k T / m), with the contact value g = (1 - 7 x / 16) / (1 - x)^2 of
    Henderson (1975). x is the covered part of the area, and each velocity component is 1 m/s (rms).
    """
    contact = (1.0 - 7.0 * GAS_PACKING / 16.0) / (1.0 - GAS_PACKING) ** 2
    rate = 4.0 * GAS_PACKING * contact / (math.sqrt(math.pi) * POOL_BALL_RADIUS)  # [1/s]
    duration = (2.0 if fast else MELTING_COLLISIONS) / rate
    gas = packed_gas(min(count, 20) if fast else count, GAS_PACKING, FRICTIONLESS, t_max=duration)
    return sampler_of([continued(gas)])


for count, rate, most in ((1_000, 1.3e6, None), (10_000, 1.0e6, 7), (100_000, 0.5e6, 3)):
    workload(f"gas-{count}", {"collisions_per_second": rate}, most)(partial(prepare_gas, count))


SCENE_TARGETS = {
    "scene_of_16": 30e-6,
    "scene_of_balls": 200e-6,
    "first_call_extra": 100e-6,
    "begun": 2.0,
}


@workload("scenes", SCENE_TARGETS, most=5)
def prepare_building(fast: bool) -> Sampler:
    """Prepare the building of scenes: with 16 balls, and with 100 000 balls and a short run."""
    rack = random_rack(0)
    large = 100 if fast else 100_000
    apart, columns = 3.0 * POOL_BALL_RADIUS, math.ceil(math.sqrt(large))
    places = (np.stack(np.divmod(np.arange(large), columns), axis=1) + 1.0) * apart
    side, moves = (columns + 2) * apart, np.full((large, 2), 0.1)
    table, physics = Table(length=side, width=side), Physics(**FRICTIONLESS)

    def build() -> Scene:
        return Scene.from_arrays(
            rack.positions, rack.velocities, name="rack", table=POOL_TABLE, physics=rack.physics
        )

    def build_of_balls() -> Scene:
        return Scene(name="rack", table=POOL_TABLE, physics=rack.physics, balls=rack.balls)

    def first_call_extra() -> float:
        scene, began = build_of_balls(), time.perf_counter()
        wall = run(scene).wall_time
        return time.perf_counter() - began - wall

    def begin() -> None:
        run(Scene.from_arrays(places, moves, name="gas", table=table, physics=physics, t_max=1e-9))

    def sample() -> dict[str, float]:
        times = range(1 if fast else 50)
        return {
            "scene_of_16": median(seconds_of(build) for _ in times),
            "scene_of_balls": median(seconds_of(build_of_balls) for _ in times),
            "first_call_extra": median(first_call_extra() for _ in times),
            "begun": seconds_of(begin),
        }

    sample()
    return sample


@workload("air", {"over_no_air": 6.0})
def prepare_air(fast: bool) -> Sampler:
    """Prepare slides of one ball with and without air drag; one kernel call runs all slides."""
    chance, number = np.random.default_rng(0), 3 if fast else SLIDES
    velocities, places = np.zeros((number, 1, 3)), np.zeros((number, 1, 3))
    velocities[:, 0, 0] = chance.uniform(0.5, 8.0, number)
    places[:, 0, 2] = POOL_BALL_RADIUS
    spins = chance.uniform(-100.0, 100.0, (number, 1, 3))
    slides = [
        Scene(
            name="slide",
            balls=[Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0))],
            physics=Physics(preset="pool", air_drag=drag),
        )
        for drag in (0.0, DRAG)
    ]

    def time_of(scene: Scene) -> float:
        starts = rows_of_starts(scene, np.arange(1), places, velocities, spins, np.ones(1, bool))
        shots = shots_of(number, 1, 1)
        played = Shots(starts, shots.clocks, shots.counts, shots.ends)
        shares = tasks_of(layout_of(scene), number, 1)
        return seconds_of(lambda: run_tasks(shares, played, Limits(10**6, 10**9), 1)) / number

    def sample() -> dict[str, float]:
        without, with_air = map(time_of, slides)
        return {"over_no_air": with_air / without, "slide": with_air}

    sample()
    return sample


workload("start", {"first_shot": 1.0, "import": 0.3}, most=5)(prepare_start)
workload("cold-start", {"first_shot": 10.0, "every_variant": 40.0}, most=1)(prepare_cold_start)


def prepare_shipped(name: str, fast: bool) -> Sampler:
    """Prepare a shipped scene."""
    return sampler_of([shipped_scene(name)], 1 if fast else RUNS)


for name in SHIPPED:
    workload(f"scene:{name}")(partial(prepare_shipped, name))

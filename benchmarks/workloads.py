"""What is measured of our engine: each workload builds its scenes and samples them once a round."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import mean, median
from typing import Any

import numpy as np

from benchmarks.processes import sample_cold_start, sample_start
from benchmarks.running import bytes_per_ball, run, until
from benchmarks.scenes import ROLLING, random_rack, table_gas
from benchmarks.sizes import PACKING, Size, break_scenes, gas_scene, rack_scenes
from benchmarks.timing import Clock, Figures, Sampler, Task
from ghostball.engine import EventKind, Physics, Scene, simulate_sweep
from ghostball.validation.scenes.gases import FULL_CLOTH, packed_gas
from ghostball.validation.scenes.library import find_scene

CLOTH_PACKING = 0.3
"""Of the balls on cloth, which run until all of them rest."""

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

PASSES = 3
"""How often racks are run in one sample: of each the median counts, so that a moment in which the
machine does something else isn't taken for a slow rack."""

PUSHED = (0.001, 0.4)
"""From when to when a ball's topspin pushes another [s]: without an event, by contact steps only.
It begins with the first step, which finds who touches whom."""

AROUND = 1e-6
"""How long before, and after, its first impact the run of a frozen rack ends [s]."""


@dataclass(frozen=True)
class Workload:
    """One workload: its name, what it is, how a sample of it is prepared.

    Attributes
    ----------
    name, title : str
    prepare : callable
        Takes a `Size`.
    most : int or None
        See `Task`.
    """

    name: str
    title: str
    prepare: Callable[[Size], Sampler]
    most: int | None = None

    def task(self, size: Size) -> Task:
        """Return it as something to be measured by turns."""
        return Task(self.name, partial(self.prepare, size), self.most)


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


def _prepare_breaks(physics: dict[str, Any], size: Size) -> Sampler:
    scenes = _warm(break_scenes(physics, size))

    def sample(clock: Clock) -> dict[str, float]:
        walls, extras, per_event = [], [], []
        for scene in scenes:
            began = clock()
            result = run(scene)
            extras.append(clock() - began - result.wall_time)
            walls.append(result.wall_time)
            per_event.append(result.wall_time / result.work["events"])
        return {
            "kernel": median(walls),
            "kernel_mean": mean(walls),
            "kernel_slowest": max(walls),
            "per_event": median(per_event),
            "call_extra": median(extras),
            "first_call_extra": median(_first_extra(scene, clock) for scene in scenes),
        }

    return sample


def _first_extra(scene: Scene, clock: Clock) -> float:
    fresh = Scene.model_validate(scene)  # a copy of pydantic's would be checked in the call
    began = clock()
    wall = run(fresh).wall_time
    return clock() - began - wall


def _prepare_racks(size: Size) -> Sampler:
    scenes = _warm(rack_scenes(size))

    def sample(clock: Clock) -> dict[str, float]:
        shots = [[_called(scene, clock) for scene in scenes] for _ in range(PASSES)]
        walls = [median(wall for _, wall, _ in turns) for turns in zip(*shots, strict=True)]
        figures = Figures.of(walls)
        measured = {
            "kernel": figures.median,
            "kernel_mean": figures.mean,
            "kernel_p99": figures.p99,
            "kernel_slowest": figures.slowest,
        }
        every = [shot for turn in shots for shot in turn]
        free = [shot for shot in every if shot[0]["contact_steps"] == 0]
        held = [shot for shot in every if shot[0]["contact_steps"] > 0]
        for name, some in (("free_call_extra", free), ("contact_call_extra", held)):
            if some:
                measured[name] = median(extra for _, _, extra in some)
        bare = [wall / work["events"] for work, wall, _ in free if work["joint_impacts"] == 0]
        if bare:
            measured["free_per_event"] = median(bare)
        return measured

    return sample


def _called(scene: Scene, clock: Clock) -> tuple[Mapping[str, int], float, float]:
    """Run a scene; return its work, the time of the kernel, and what the call took over it."""
    began = clock()
    result = run(scene)
    took = clock() - began
    return result.work, result.wall_time, took - result.wall_time


def _prepare_contact_steps(size: Size) -> Sampler:
    pushed = find_scene("push")
    scene = Scene(
        name="push", table=pushed.table, balls=pushed.balls, physics=Physics(preset="pool")
    )
    return _per("contact_steps", "per_contact_step", scene, PUSHED, size)


def _prepare_joint_impacts(size: Size) -> Sampler:
    scene = random_rack(1)
    events = run(scene, record="events").events
    assert events is not None
    (first,) = events["t"][events["kind"] == EventKind.BALL_BALL][:1].tolist()
    return _per("joint_impacts", "per_joint_impact", scene, (first - AROUND, first + AROUND), size)


def _per(
    counter: str, quantity: str, scene: Scene, ends: tuple[float, float], size: Size
) -> Sampler:
    """Sample the time of one piece of work: the difference of two runs over that of a counter."""
    shorter, longer = _warm([until(scene, end) for end in ends])
    count = run(longer).work[counter] - run(shorter).work[counter]

    def wall(part: Scene) -> float:
        return median(run(part).wall_time for _ in range(size.runs))

    def sample(_: Clock) -> dict[str, float]:
        return {quantity: (wall(longer) - wall(shorter)) / count}

    return sample


def _prepare_recorded_breaks(size: Size) -> Sampler:
    scenes = _warm(break_scenes(FULL_CLOTH, size))
    for scene in scenes:
        run(scene, record="events")

    def sample(clock: Clock) -> dict[str, float]:
        calls, walls, ratios = [], [], []
        for scene in scenes:
            plain = run(scene).wall_time
            began = clock()
            wall = run(scene, record="events").wall_time
            calls.append(clock() - began - wall)
            walls.append(wall)
            ratios.append(wall / plain)
        return {
            "kernel": median(walls),
            "events_extra": median(ratios) - 1.0,
            "call_extra": median(calls),
        }

    return sample


def _prepare_table_gas(size: Size) -> Sampler:
    (scene,) = _warm([table_gas(16, size.gas_time)])

    def sample(_: Clock) -> dict[str, float]:
        result = run(scene)
        return {
            "per_event": result.wall_time / result.work["events"],
            "collisions_per_second": result.collision_counts["ball-ball"] / result.wall_time,
        }

    return sample


def _prepare_gas(count: int, size: Size) -> Sampler:
    (scene,) = _warm([gas_scene(count, size)])
    memory = bytes_per_ball(scene)

    def sample(_: Clock) -> dict[str, float]:
        result = run(scene)
        return {
            "collisions_per_second": result.collision_counts["ball-ball"] / result.wall_time,
            "per_event": result.wall_time / result.work["events"],
            "bytes_per_ball": memory,
        }

    return sample


def _prepare_cloth(size: Size) -> Sampler:
    (scene,) = _warm([packed_gas(min(10_000, size.most_balls), CLOTH_PACKING, FULL_CLOTH)])

    def sample(_: Clock) -> dict[str, float]:
        result = run(scene)
        return {"per_event": result.wall_time / result.work["events"], "kernel": result.wall_time}

    return sample


def _prepare_sweep(size: Size) -> Sampler:
    scene = find_scene(SWEPT)
    chance = np.random.default_rng(0)
    cue, target = scene.positions[:2, :2]
    across, along = target[1] - cue[1], target[0] - cue[0]
    reach = float(scene.radii[:2].sum() / np.hypot(along, across))
    speeds = chance.uniform(0.5, 2.0, size.shots)
    angles = np.arctan2(across, along) + np.arcsin(reach) * chance.uniform(-1.0, 1.0, size.shots)

    def shoot(threads: int, clock: Clock) -> float:
        began = clock()
        simulate_sweep(scene, speeds, angles, threads=threads)
        return clock() - began

    def sample(clock: Clock) -> dict[str, float]:
        one = shoot(1, clock)
        measured = {"shots_per_second": size.shots / one}
        if (os.cpu_count() or 1) > 1:
            measured["two_threads"] = one / shoot(2, clock)
        return measured

    simulate_sweep(scene, speeds, angles, threads=1)
    return sample


def _prepare_shipped(name: str, size: Size) -> Sampler:
    (scene,) = _warm([shipped_scene(name)])

    def sample(clock: Clock) -> dict[str, float]:
        walls, calls = [], []
        events = 1
        for _ in range(size.runs):
            began = clock()
            result = run(scene)
            calls.append(clock() - began)
            walls.append(result.wall_time)
            events = result.work["events"]
        wall = median(walls)
        return {"kernel": wall, "call": median(calls), "per_event": wall / events}

    return sample


def _warm(scenes: Sequence[Scene]) -> Sequence[Scene]:
    """Compile what scenes need, and lay them out, by running each once."""
    for scene in scenes:
        run(scene)
    return scenes


def _gas(count: int, most: int | None = None) -> Workload:
    title = f"elastic gas of {count} balls, packing {PACKING}"
    return Workload(f"gas-{count}", title, partial(_prepare_gas, count), most)


WORKLOADS: tuple[Workload, ...] = (
    Workload(
        "break-pool",
        "break of 16 with all of pool's physics, random racks",
        partial(_prepare_breaks, FULL_CLOTH),
    ),
    Workload(
        "break-pool-events",
        "the same breaks, every event recorded",
        _prepare_recorded_breaks,
    ),
    Workload(
        "break-paper",
        "break of 16 with the paper's physics, random racks",
        partial(_prepare_breaks, ROLLING),
    ),
    Workload(
        "racks",
        "random racks with all of pool's physics, half of them loose and half frozen",
        _prepare_racks,
    ),
    Workload(
        "contact-step", "a ball that pushes another, all of pool's physics", _prepare_contact_steps
    ),
    Workload(
        "joint-impact", "the first impact of a frozen rack of 15, with all", _prepare_joint_impacts
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

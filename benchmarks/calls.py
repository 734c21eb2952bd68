"""What a shot costs beside its kernel, and kernels where they were slow: samplers of `speed`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from statistics import median

import numpy as np
from numpy.typing import NDArray

from benchmarks.scenes import POOL_TABLE, random_rack
from benchmarks.timing import run
from ghostball.engine import simulate_many, simulate_starts, simulate_sweep
from ghostball.engine.running.room import Limits, Shots, shots_of
from ghostball.engine.running.threads import rows_of_starts, run_sweep
from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Scene, Table
from ghostball.validation.runs.interleave import Sampler
from ghostball.validation.scenes.gases import FRICTIONLESS

RACKS = 1_000
"""Scenes that `simulate_many` plays, and starts that `simulate_starts` does."""

SLIDES = 10_000
"""Slides of one ball."""

DRAG = 0.0041
"""k of a pool ball in air [1/m], as in the shipped `air-slides`."""


def prepare_many(fast: bool) -> Sampler:
    """Sample `simulate_many` and `simulate_starts` on racks, beside the kernel alone."""
    scenes = [random_rack(number) for number in range(4 if fast else RACKS)]
    starts = [np.array([getattr(scene, name) for scene in scenes]) for name in _STARTS]

    def sample() -> dict[str, float]:
        kernel = sum(run(scene).wall_time for scene in scenes)
        many = _time_of(lambda: simulate_many(scenes, threads=1))
        begun = _time_of(lambda: simulate_starts(scenes[0], *starts, threads=1))
        return {
            "many_extra": (many - kernel) / len(scenes),
            "starts_extra": (begun - kernel) / len(scenes),
        }

    sample()
    return sample


_STARTS = ("positions", "velocities", "angular_velocities")


def prepare_building(fast: bool) -> Sampler:
    """Sample how long a scene takes to be made, of 16 balls, and of 100 000 until it has begun."""
    rack = random_rack(0)
    large = 100 if fast else 100_000
    columns = math.ceil(math.sqrt(large))
    places = np.stack(np.divmod(np.arange(large), columns), axis=1) + 0.5
    places *= 3.0 * POOL_BALL_RADIUS
    table = Table(length=float(places.max() + 0.1), width=float(places.max() + 0.1))
    physics = Physics(**FRICTIONLESS)

    def build() -> Scene:
        return Scene.from_arrays(
            rack.positions, rack.velocities, name="rack", table=POOL_TABLE, physics=rack.physics
        )

    def begin() -> None:
        moves = np.full((large, 2), 0.1)
        run(Scene.from_arrays(places, moves, name="gas", table=table, physics=physics, t_max=1e-9))

    def sample() -> dict[str, float]:
        return {
            "scene_of_16": median(_time_of(build) for _ in range(1 if fast else 50)),
            "begun": _time_of(begin),
        }

    sample()
    return sample


def prepare_tied(fast: bool) -> Sampler:
    """Sample balls that all roll alike, far from each other, and stop at one instant."""
    count = 100 if fast else 16_000
    columns = math.ceil(math.sqrt(count))
    places = (np.stack(np.divmod(np.arange(count), columns), axis=1) + 1.0) * 0.2
    side = 0.2 * (columns + 2)
    scene = Scene.from_arrays(
        places,
        np.full((count, 2), (0.05, 0.0)),
        name="tied",
        table=Table(length=side, width=side),
        physics=Physics(preset="paper"),
    )
    run(scene)

    def sample() -> dict[str, float]:
        result = run(scene)
        return {"per_event": result.wall_time / result.work["events"]}

    return sample


def prepare_air(fast: bool) -> Sampler:
    """Sample slides of one ball in air, and the same without: all by one call of the kernel."""
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
        return _time_of(lambda: run_sweep(scene, 0, played, Limits(10**6, 10**9), 1)) / number

    def sample() -> dict[str, float]:
        without, with_air = map(time_of, slides)
        return {"over_no_air": with_air / without, "slide": with_air}

    sample()
    return sample


def prepare_processes(
    scene: Scene, speeds: NDArray[np.float64], angles: NDArray[np.float64]
) -> Callable[[], float]:
    """Return what has two processes sweep half of some shots each, and returns how long it took.

    As fast as the machine lets two run [s]: the best of some rounds, of which the first may have
    both halves in one process, or load its kernel.
    """
    halves = zip(np.array_split(speeds, 2), np.array_split(angles, 2), strict=True)
    shares = [(scene, *half) for half in halves]

    def sweep() -> float:
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            return min(max(pool.map(_sweep, shares)) for _ in range(_ROUNDS))

    return sweep


_ROUNDS = 4


def _sweep(share: tuple[Scene, NDArray[np.float64], NDArray[np.float64]]) -> float:
    return _time_of(lambda: simulate_sweep(*share, threads=1))


def _time_of(what: Callable[[], object]) -> float:
    """Return how long a call takes [s]."""
    began = time.perf_counter()
    what()
    return time.perf_counter() - began

"""Measures how far run times of the same code differ on a machine, and sets thresholds from it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from statistics import median

import validation
from engine import Scene
from validation.baselines.player import playing
from validation.baselines.timing import (
    ROUNDS,
    RUNS,
    MachineTimes,
    SceneTimes,
)
from validation.bench.measurements import machine_name, measured_where

PROCESSES = 5
"""Processes that run the same code by turns: memory lies elsewhere in each, and that costs time."""

MARGIN = 2.0
"""A threshold is so many times as far from 1 as the largest difference that noise made."""

LEAST_THRESHOLD = 1.05
"""What is slower by less than this is no regression worth a build, however quiet the machine."""

Progress = Callable[[int, int, str], None]


def calibrate(
    scenes: Sequence[Scene],
    *,
    processes: int = PROCESSES,
    rounds: int = ROUNDS,
    progress: Progress | None = None,
) -> MachineTimes:
    """Time the same code in several processes by turns; how far they differ is the noise.

    Parameters
    ----------
    scenes : sequence of Scene
    processes : int
        At least 2.
    rounds : int
        Samples of each scene in each process.
    progress : callable, optional

    Raises
    ------
    NotComparableError
        Where a process ends.
    KeyboardInterrupt
        Half a calibration is none.
    """
    root = Path(validation.__file__).resolve().parent.parent
    samples: dict[str, list[list[float]]] = {
        scene.name: [[] for _ in range(processes)] for scene in scenes
    }
    with ExitStack() as stack:
        place = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        paths = {}
        for number, scene in enumerate(scenes):
            paths[scene.name] = place / f"{number}.toml"
            scene.save(paths[scene.name])
        players = [
            stack.enter_context(playing(f"process {number + 1}", root))
            for number in range(processes)
        ]
        for turn in range(rounds):
            for name, path in paths.items():
                order = range(processes)
                for number in order if turn % 2 == 0 else reversed(order):
                    samples[name][number].append(players[number].seconds(path, RUNS))
            if progress is not None:
                progress(turn + 1, rounds, f"round {turn + 1}")
    environment = measured_where()
    return MachineTimes(
        machine=machine_name(environment),
        environment=_without_none(environment),
        processes=processes,
        scenes={name: times_of(taken) for name, taken in samples.items()},
    )


def times_of(samples: Sequence[Sequence[float]]) -> SceneTimes:
    """Return what samples of one scene in several processes [s] say of its time and its noise."""
    # Samples of one process have its place in memory in common: only processes are independent.
    medians = [median(taken) for taken in samples]
    noise = max(medians) / min(medians)
    return SceneTimes(
        median=median(medians),
        low=min(medians),
        high=max(medians),
        samples=sum(map(len, samples)),
        noise=noise,
        threshold=max(LEAST_THRESHOLD, 1.0 + MARGIN * (noise - 1.0)),
    )


def _without_none(environment: dict[str, object]) -> dict[str, object]:
    """Return an environment without what TOML has no word for."""
    plain: dict[str, object] = {}
    for name, value in environment.items():
        if isinstance(value, dict):
            plain[name] = _without_none(value)
        elif value is not None:
            plain[name] = value
    return plain

"""Measure by turns: every task once, then every task again, so that a slow moment hits all."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import mean, median

import numpy as np

from ghostball.validation.parallel.pool import Progress

Clock = Callable[[], float]
"""Returns seconds since some instant; `time.perf_counter`, or a fake one in tests."""

Sampler = Callable[[Clock], Mapping[str, float]]
"""Does the work once and returns what it measured, by quantity, in SI units."""


@dataclass(frozen=True)
class Spread:
    """What repeated measurements of one quantity came to."""

    median: float
    least: float
    greatest: float
    samples: int

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        """Return the spread of at least one value."""
        return cls(median(values), min(values), max(values), len(values))


@dataclass(frozen=True)
class Figures:
    """What is told of the times of many scenes: whoever runs them all pays the mean.

    Attributes
    ----------
    median, mean, p99, slowest : float
        `p99` is the least of the values that 99 % of them don't exceed.
    """

    median: float
    mean: float
    p99: float
    slowest: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Figures:
        """Return the figures of at least one value."""
        p99 = float(np.quantile(values, 0.99, method="inverted_cdf"))
        return cls(median(values), mean(values), p99, max(values))


@dataclass(frozen=True)
class Task:
    """Something to be measured again and again.

    Attributes
    ----------
    name : str
    prepare : callable
        Builds, compiles and warms up whatever the measurement should not include; called once.
    most : int or None
        Samples that are enough, for what takes long; spread over all rounds.
    """

    name: str
    prepare: Callable[[], Sampler]
    most: int | None = None

    def due(self, turn: int, rounds: int) -> bool:
        """Whether it is measured in this round, of so many."""
        if self.most is None or self.most >= rounds:
            return True
        return (turn + 1) * self.most // rounds > turn * self.most // rounds


@dataclass
class Samples:
    """What was measured until the end, or an interrupt: values by task and quantity."""

    values: dict[str, dict[str, list[float]]] = field(default_factory=dict)
    interrupted: bool = False

    def spreads(self, task: str) -> dict[str, Spread]:
        """Return the spread of each quantity of a task; none where it was never measured."""
        measured = self.values.get(task, {})
        return {quantity: Spread.of(values) for quantity, values in measured.items()}


def take_turns(
    tasks: Sequence[Task],
    rounds: int,
    *,
    clock: Clock = time.perf_counter,
    progress: Progress[str] | None = None,
) -> Samples:
    """Sample tasks round by round, each prepared when its first turn comes.

    Ctrl-C ends it early and keeps what was measured.

    Parameters
    ----------
    tasks : sequence of Task
    rounds : int
    clock : callable
        Handed to each sampler.
    progress : callable, optional
        Called after each preparation and each sample.
    """
    planned = len(tasks) + sum(task.due(turn, rounds) for task in tasks for turn in range(rounds))
    found, done = Samples(), 0

    def one_more(last: str) -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, planned, last)

    try:
        samplers: dict[str, Sampler] = {}
        for turn in range(rounds):
            for task in tasks:
                if not task.due(turn, rounds):
                    continue
                if task.name not in samplers:
                    samplers[task.name] = task.prepare()
                    one_more(f"preparing {task.name}")
                sample = samplers[task.name](clock)
                kept = found.values.setdefault(task.name, {})
                for quantity, value in sample.items():
                    kept.setdefault(quantity, []).append(value)
                one_more(task.name)
    except KeyboardInterrupt:
        found.interrupted = True
    return found

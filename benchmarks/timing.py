"""The timer of all benchmarks: it interleaves what is compared, so that a slow moment slows all."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from statistics import mean, median

import numpy as np

from benchmarks.measurements import BenchError
from ghostball.engine import simulate
from ghostball.model import Record, Result, Scene, Status
from ghostball.validation.parallel.pool import Progress

Sampler = Callable[[], Mapping[str, float]]
"""Does the work once and returns what it measured, by quantity, in SI units."""


@dataclass(frozen=True)
class Task:
    """Something to be measured again and again.

    `prepare`: builds, compiles and warms up what the measurement should not include; called once.
    `most`: samples that are enough, for what takes long; spread over all rounds.
    """

    name: str
    prepare: Callable[[], Sampler]
    most: int | None = None

    def due(self, turn: int, rounds: int) -> bool:
        """Whether it is measured in this round, of so many."""
        if self.most is None or self.most >= rounds:
            return True
        return (turn + 1) * self.most // rounds > turn * self.most // rounds


def interleave(
    tasks: Sequence[Task], rounds: int, progress: Progress[str] | None = None
) -> dict[str, dict[str, list[float]]]:
    """Sample tasks round by round, each prepared when its first turn comes.

    Returns the values of each task, by quantity.
    """
    due = [task for turn in range(rounds) for task in tasks if task.due(turn, rounds)]
    samplers: dict[str, Sampler] = {}
    found: dict[str, dict[str, list[float]]] = {task.name: {} for task in tasks}
    for done, task in enumerate(due, 1):
        if task.name not in samplers:
            samplers[task.name] = task.prepare()
        for quantity, value in samplers[task.name]().items():
            found[task.name].setdefault(quantity, []).append(value)
        if progress is not None:
            progress(done, len(due), task.name)
    return found


@dataclass(frozen=True)
class Figures:
    """What is said of the times of many scenes: whoever runs them all pays the mean.

    `median`, `mean`, `p99`, `slowest`: `p99` is the least of the values that 99 % of them don't
    exceed.
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


def run(scene: Scene, *, record: Record = "rest", no_skip: Collection[str] = ()) -> Result:
    """Simulate `scene` to its natural end; arguments as for `simulate`."""
    result = simulate(scene, record=record, no_skip=no_skip)
    if result.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    if not result.status.complete:
        raise BenchError(
            f'scene "{scene.name}" did not end by itself: {result.status.value}: {result.reason}. '
            "Its time would mean nothing"
        )
    return result

"""Interleave the measurements of several tasks, so that a slow moment affects all of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ghostball.validation.parallel.pool import Progress

Sampler = Callable[[], Mapping[str, float]]
"""Does the work once and returns the measured values, by quantity, in SI units."""


@dataclass(frozen=True)
class Task:
    """A task to be measured repeatedly.

    `prepare`: builds, compiles and warms up whatever the measurement must not include; called once.
    `most`: largest number of samples, for slow tasks; they are spread over all rounds.
    """

    name: str
    prepare: Callable[[], Sampler]
    most: int | None = None

    def due(self, turn: int, rounds: int) -> bool:
        """Return True if the task is measured in round `turn` of `rounds`."""
        if self.most is None or self.most >= rounds:
            return True
        return (turn + 1) * self.most // rounds > turn * self.most // rounds


def interleave(
    tasks: Sequence[Task], rounds: int, progress: Progress[str] | None = None
) -> dict[str, dict[str, list[float]]]:
    """Sample tasks round by round; each is prepared just before its first sample.

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

"""Storms: random breaks over the whole physics, of which none may get stuck."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ghostball.model import Result, SampledTrajectory, Scene, UnsupportedSceneError
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.runs.steps import with_setting
from ghostball.validation.stress.invariants import FloatArray, faults_in, instants, measured
from ghostball.validation.stress.random_breaks import random_break
from ghostball.validation.stress.trial import Family, Suite, Trial, Verdict, play

MOST_EVENTS = 100_000
"""Events and contact steps of a break: four times the most that any of 100 000 needs.

That is 22 476, of break 39225, measured by playing them all; a test plays that one."""

LOOKS = 32
"""Instants at which each break is looked at, beside its end."""

DENSE = 50
"""Each break of a number that this divides is looked at everywhere instead."""

BETWEEN = 5
"""Instants between two events, where a break is looked at everywhere."""

FOREIGN_T_MAX = 2.0
"""How much of a break other engines play [s]."""

COUNTED = ("events", "contact_steps", "seconds")
"""What is kept of each break."""


@dataclass(frozen=True)
class Breaks(Trial):
    """Random breaks in a row, by number.

    Our engine plays them all to rest. Of other engines, that need seconds for one, each plays the
    first 2 s of the first one that it can represent.
    """

    name: str
    first: int
    count: int
    limit: ClassVar[float] = 300.0

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Play the breaks and judge each.

        Raises
        ------
        UnsupportedSceneError
            Where the engine can represent none of them.
        """
        if "max_events" in type(engine.settings).model_fields:
            engine = with_setting(engine, "max_events", MOST_EVENTS)
        numbers = range(self.first, self.first + self.count)
        if engine.name == OURS:
            verdicts = [judged(number, random_break(number), engine) for number in numbers]
        else:
            verdicts = [_first_that_it_can_play(engine, numbers)]
        values: dict[str, Any] = {
            name: [one.values[name] for one in verdicts if one.values] for name in COUNTED
        }
        values["everywhere"] = sum(number % DENSE == 0 for number in numbers[: len(verdicts)])
        return Verdict.of_all(verdicts, values)

    def examples(self) -> Iterator[Scene]:
        """Yield breaks with every variant of the kernels that is needed."""
        yield from map(random_break, range(self.first, self.first + min(self.count, 40)))


def judged(number: int, scene: Scene, engine: ReferenceEngine) -> Verdict:
    """Play a break and judge it."""
    result = play(engine, scene)
    if isinstance(result, Verdict):
        return result
    found = measured(result, looks(result, everywhere=number % DENSE == 0))
    faults = faults_in(found)
    depth = max(value for name, (value, _) in found.items() if "overlap" in name)
    if not depth < float(scene.radii.min()):
        faults.append("a ball has left the table, or is within another")
    assert result.events is not None
    events = int(result.work.get("events", len(result.events)))
    steps = int(result.work.get("contact_steps", 0))
    # Of breaks that all hold, the one with most to do came nearest to a storm.
    hard = (events + steps) / MOST_EVENTS
    far = 1.0 + depth + found.get("rise of the energy [1]", (0.0, 0.0))[0]
    counts = (events, steps, float(f"{result.wall_time:.3g}"))
    values = dict(zip(COUNTED, counts, strict=True))
    return Verdict.of(scene, faults, far if faults else hard, values)


def _first_that_it_can_play(engine: ReferenceEngine, numbers: range) -> Verdict:
    """Judge the first seconds of the first of these breaks that an engine can represent."""
    lacks: dict[str, None] = {}
    for number in numbers:
        scene = random_break(number).model_copy(update={"t_max": FOREIGN_T_MAX})
        try:
            return judged(number, scene, engine)
        except UnsupportedSceneError as error:
            lacks.update(dict.fromkeys(error.features))
    raise UnsupportedSceneError(engine.name, tuple(lacks))


def looks(result: Result, everywhere: bool) -> FloatArray:
    """Return the instants at which a break is looked at, (k,) [s], its end among them.

    Everywhere: at all events, just before each, and in between. Else at events evenly picked of
    all, where it may just have gone wrong. A run that consists of frames: at these.
    """
    if isinstance(result.trajectory, SampledTrajectory):
        return instants(result)
    if everywhere:
        times = instants(result, BETWEEN)
        before = np.nextafter(times[times > 0.0], 0.0)
        return np.sort(np.append(times, before))
    times = instants(result, 0)
    picked = np.linspace(0, len(times) - 1, LOOKS + 1).astype(np.int64)
    return times[np.unique(picked)]


def _trials(suite: Suite) -> Iterator[Trial]:
    size, chunks = (250, 2) if suite == "quick" else (1000, 100)
    for first in range(0, size * chunks, size):
        yield Breaks(f"breaks-{first:05d}-{first + size - 1:05d}", first, size)


FAMILY = Family(
    "storms",
    "Random breaks",
    "Whatever the break, the laws and the frictions: it ends by itself within "
    f"{MOST_EVENTS} events and contact steps, energy never rises, and no ball overlaps another or "
    "a cushion: exact motion by no more than rounding and what a sustained contact may be off by, "
    "that of an engine that steps by no more than the law allows its step. Each break is looked at "
    f"at {LOOKS} events and its end, every {DENSE}th at all events and between. Other engines than "
    "ours play 2 s of one break of each trial.",
    _trials,
)

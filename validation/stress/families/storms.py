"""Storms: random breaks over the whole physics, of which none may get stuck."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ghostball.engine import Result, Scene, UnsupportedSceneError
from ghostball.engine.trajectory import SampledTrajectory, energy_of
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.runs.steps import with_setting
from ghostball.validation.stress.family import Family
from ghostball.validation.stress.judges import (
    FloatArray,
    energy_rise,
    instants,
    is_exact,
    overlap_limit,
    overlaps,
    rise_limit,
    unsolved,
)
from ghostball.validation.stress.random_breaks import random_break
from ghostball.validation.stress.trial import Suite, Trial, Verdict, graded_severity, play

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


class Worst(NamedTuple):
    """The worst of one break, overlap [m] and rise of energy over the first; and their limits."""

    depth: float
    rise: float
    deepest: float
    most_rise: float


@dataclass(frozen=True)
class Breaks(Trial):
    """Random breaks in a row, by number.

    Our engine plays them all to rest. Of other engines, that need seconds for one, each plays the
    first 2 s of the first one that it can represent.

    Attributes
    ----------
    name : str
    first, count : int
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
        found = _Found()
        if "max_events" in type(engine.settings).model_fields:
            engine = with_setting(engine, "max_events", MOST_EVENTS)
        if engine.name == OURS:
            for number in range(self.first, self.first + self.count):
                found.add(number, random_break(number), engine)
        else:
            self._add_one(found, engine)
        return found.verdict()

    def _add_one(self, found: _Found, engine: ReferenceEngine) -> None:
        lacks: dict[str, None] = {}
        for number in range(self.first, self.first + self.count):
            scene = random_break(number).model_copy(update={"t_max": FOREIGN_T_MAX})
            try:
                found.add(number, scene, engine)
            except UnsupportedSceneError as error:
                lacks.update(dict.fromkeys(error.features))
            else:
                return
        raise UnsupportedSceneError(engine.name, tuple(lacks))

    def examples(self) -> Iterator[Scene]:
        """Yield breaks with every variant of the kernels that is needed."""
        yield from map(random_break, range(self.first, self.first + min(self.count, 40)))


class _Found:
    """What was found in the breaks so far."""

    def __init__(self) -> None:
        self._faults: list[str] = []
        self._worst: tuple[float, Scene | None] = (-1.0, None)
        self._broken = 0
        self._played = 0
        self._dense = 0
        self._counts: dict[str, list[Any]] = {"events": [], "contact_steps": [], "seconds": []}

    def add(self, number: int, scene: Scene, engine: ReferenceEngine) -> None:
        """Play a break and judge it."""
        played = play(engine, scene)
        self._played += 1
        if isinstance(played, Verdict):
            self._note(scene, played.faults, played.severity)
            return
        everywhere = number % DENSE == 0
        self._dense += everywhere
        worst = worst_of(played, looks(played, everywhere))
        faults = faults_of(played, worst)
        events = played.work.get("events", len(played.events) if played.events is not None else 0)
        self._counts["events"].append(int(events))
        self._counts["contact_steps"].append(int(played.work.get("contact_steps", 0)))
        self._counts["seconds"].append(float(f"{played.wall_time:.3g}"))
        # Of breaks that all hold, the one with most to do came nearest to a storm.
        hard = (events + played.work.get("contact_steps", 0)) / MOST_EVENTS
        far = 1.0 + max(worst.depth, 0.0) + worst.rise
        self._note(scene, faults, graded_severity(far if faults else hard, bool(faults)))

    def _note(self, scene: Scene, faults: tuple[str, ...], severity: float) -> None:
        self._faults += [f"{scene.name}: {fault}" for fault in faults]
        self._broken += bool(faults)
        if severity > self._worst[0]:
            self._worst = (severity, scene)

    def verdict(self) -> Verdict:
        """Return the verdict on all of them; the worst one's scene stands for them."""
        severity, scene = self._worst
        values = {**self._counts, "everywhere": self._dense}
        return Verdict(tuple(self._faults), scene, severity, self._played, self._broken, values)


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


def worst_of(result: Result, times: FloatArray) -> Worst:
    """Return the worst of a break at the given instants, and what may be there."""
    states = result.sample(times)
    exact = is_exact(result)  # of one that steps the law judged energy and overlaps of balls
    return Worst(
        float(overlaps(result.scene, states.positions)[:, 0 if exact else 1 :].max()),
        energy_rise(energy_of(result.scene, states).total) if exact else 0.0,
        overlap_limit(result, states.positions),
        rise_limit(result),
    )


def faults_of(result: Result, worst: Worst) -> tuple[str, ...]:
    """Return what is wrong with a break."""
    faults = []
    if not worst.depth <= worst.deepest:  # nor where it is NaN
        faults.append(f"balls overlap each other or a cushion by {worst.depth:.3g} m")
    if not worst.rise <= worst.most_rise:
        faults.append(f"the energy rises by {worst.rise:.3g} of the first")
    if unsolved(result):
        faults.append(f"{unsolved(result)} contact steps or joint impacts are left unsolved")
    if not worst.depth < float(result.scene.radii.min()):
        faults.append("a ball has left the table, or is within another")
    return tuple(faults)


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
    "that of an engine that steps by no more than the law allows its step. Looked at at "
    f" {LOOKS} events and the end, and every {DENSE}th break at all events and between. Other "
    "engines than ours play 2 s of one break of each trial.",
    _trials,
)

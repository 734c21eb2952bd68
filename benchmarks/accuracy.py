"""Our engine on thousands of random shots, each proved and graded: how exact it is, in numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, Literal, Never

import numpy as np
from pydantic import BaseModel, ConfigDict

from benchmarks.measurements import Measurement, measured_where
from benchmarks.running import BenchError
from ghostball.engine import Status, simulate
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.validation.checks.violations import faults_of
from ghostball.validation.grading.grading import grade
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.parallel.pool import Progress, run_tasks
from ghostball.validation.scenes.random_shots import random_shot

SHOTS = 10_000
"""Shots of a whole measurement: some two minutes in two processes."""

JOBS = 2

WORST = 10
"""Shots of the greatest quality factors that are kept."""

PROOF = CertifiedSettings(time_limit=60.0, max_events=5_000)
"""How far a shot is proved: a few elastic ones have thousands of events."""

MAX_EVENTS = 10_000
"""Events and contact steps after which our engine's run of a shot is given up, which is a fault."""

_VARIED = 80
"""Shots that need every variant of the kernels between them."""


class ShotRow(BaseModel):
    """One shot that is worth a look, with its scene.

    `faults` are the limits of every scene that it breaks; `again` is the command that grades it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    number: int
    ending: str
    extent: str
    events: int
    quality_factor: float | None
    time_error_ulps: float | None
    faults: tuple[str, ...]
    again: str
    scene: dict[str, Any]


class Distribution(BaseModel):
    """How one quantity is spread over many values; None where there are none."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    count: int
    median: float | None = None
    p99: float | None = None
    greatest: float | None = None

    @classmethod
    def of(cls, values: Sequence[float]) -> Distribution:
        """Return the distribution of some values."""
        if not len(values):
            return cls(count=0)
        middle, high, most = np.quantile(values, (0.5, 0.99, 1.0), method="inverted_cdf").tolist()
        return cls(count=len(values), median=middle, p99=high, greatest=most)


class AccuracyMeasurement(Measurement):
    """What `python -m benchmarks accuracy` measured.

    `endings` counts the shots by how their proof ended, `extents` by how much of them is graded;
    `quality_factor` is over shots, `time_error_ulps` over all their events. `events` were proved
    and compared, `missing` and `invented` of them are wrong. `faulty` and `worst` name shots.
    """

    kind: Literal["accuracy"] = "accuracy"
    first: int
    shots: int
    endings: dict[str, int]
    extents: dict[str, int]
    events: int
    missing: int
    invented: int
    swapped: int
    negligible: int
    quality_factor: Distribution
    time_error_ulps: Distribution
    faulty: tuple[ShotRow, ...]
    worst: tuple[ShotRow, ...]

    @property
    def anything(self) -> bool:
        """Whether a shot was graded before an interrupt."""
        return self.shots > 0


@dataclass(frozen=True)
class _Graded:
    """What came of one shot."""

    number: int
    ending: str
    extent: str
    events: int
    missing: int
    invented: int
    swapped: int
    negligible: int
    quality_factor: float | None
    time_errors: list[float]
    faults: tuple[str, ...]

    def row(self) -> ShotRow:
        """Return it with its scene."""
        return ShotRow(
            number=self.number,
            ending=self.ending,
            extent=self.extent,
            events=self.events,
            quality_factor=self.quality_factor,
            time_error_ulps=max(self.time_errors, default=None),
            faults=self.faults,
            again=f"python -m benchmarks accuracy --first {self.number} --shots 1",
            scene=random_shot(self.number).model_dump(mode="json", by_alias=True),
        )


@dataclass
class _Tally:
    """What came of all shots so far; rows are made of few of them only."""

    counts: Counter[str] = field(default_factory=Counter)
    endings: Counter[str] = field(default_factory=Counter)
    extents: Counter[str] = field(default_factory=Counter)
    qualities: list[float] = field(default_factory=list)
    time_errors: list[float] = field(default_factory=list)
    faulty: list[_Graded] = field(default_factory=list)
    worst: list[_Graded] = field(default_factory=list)

    def add(self, shot: _Graded) -> None:
        self.counts["shots"] += 1
        for name in ("events", "missing", "invented", "swapped", "negligible"):
            self.counts[name] += getattr(shot, name)
        self.endings[shot.ending] += 1
        self.extents[shot.extent] += 1
        self.time_errors += shot.time_errors
        if shot.faults:
            self.faulty.append(shot)
        if shot.quality_factor is not None:
            self.qualities.append(shot.quality_factor)
            self.worst.append(shot)
            self.worst.sort(key=lambda one: (-(one.quality_factor or 0.0), one.number))
            del self.worst[WORST:]

    def measurement(self, first: int, *, interrupted: bool) -> AccuracyMeasurement:
        return AccuracyMeasurement(
            environment=measured_where(),
            rounds=1,
            interrupted=interrupted,
            first=first,
            shots=self.counts["shots"],
            endings=dict(sorted(self.endings.items())),
            extents=dict(sorted(self.extents.items())),
            events=self.counts["events"],
            missing=self.counts["missing"],
            invented=self.counts["invented"],
            swapped=self.counts["swapped"],
            negligible=self.counts["negligible"],
            quality_factor=Distribution.of(self.qualities),
            time_error_ulps=Distribution.of(self.time_errors),
            faulty=tuple(s.row() for s in sorted(self.faulty, key=lambda one: one.number)),
            worst=tuple(shot.row() for shot in self.worst),
        )


def measure_accuracy(
    shots: int = SHOTS, *, first: int = 0, jobs: int = JOBS, progress: Progress[str] | None = None
) -> AccuracyMeasurement:
    """Simulate, prove and grade random shots; Ctrl-C keeps those that are done.

    Parameters
    ----------
    shots : int
        How many.
    first : int
        The number of the first one; see `random_shot`.
    jobs : int
        Processes; 1 runs everything in this one.
    progress : callable, optional
        Called with how many shots are done.

    Raises
    ------
    BenchError
        Where a number is wrong, or a process dies.
    """
    for name, value, least in (("shots", shots, 1), ("first", first, 0), ("jobs", jobs, 1)):
        if value < least:
            raise BenchError(f"`{name}` must be at least {least}, got {value}")
    numbers = range(first, first + shots)
    compile_kernels((random_shot(number) for number in numbers[:_VARIED]), jobs)
    tally, interrupted = _Tally(), False
    try:
        with closing(run_tasks(numbers, jobs, _grade_shot)) as answers:
            for count, done in enumerate(answers, start=1):
                tally.add(done.or_else(_died))
                if progress is not None:
                    progress(count, shots, f"shot {done.task}")
    except KeyboardInterrupt:
        interrupted = True
    return tally.measurement(first, interrupted=interrupted)


def _died(number: int, reason: str) -> Never:
    raise BenchError(f"the measurement of shot {number}: {reason}")


def _grade_shot(number: int) -> _Graded:
    scene = random_shot(number)
    result = simulate(scene, record="trajectory", max_events=MAX_EVENTS)
    if result.status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    # Not kept on the disk: thousands of them would push out those of the shipped scenes.
    proof = certify(scene, PROOF, motion=True, cached=False)
    graded = grade(result, proof)
    faults = faults_of(graded, scene)
    if not result.status.complete:
        faults += (f"our engine stopped early: {result.status.value}",)
    return _Graded(
        number=number,
        ending=proof.ending,
        extent=graded.extent,
        events=graded.events,
        missing=len(graded.missing),
        invented=len(graded.invented),
        swapped=graded.swapped,
        negligible=graded.negligible,
        quality_factor=graded.quality_factor,
        time_errors=graded.time_errors.tolist(),
        faults=faults,
    )

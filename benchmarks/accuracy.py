"""Our engine on thousands of random shots, each proved and graded: how exact it is, in numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from typing import Any, Literal, Never

import numpy as np
from pydantic import Field, computed_field
from rich.console import Group, RenderableType
from rich.text import Text

from benchmarks.measurements import Shown, table_of
from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.validation.checks.law import faults_of
from ghostball.validation.grading.grading import grade
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.parallel.pool import Progress, run_tasks
from ghostball.validation.results.measurement import MeasurementError, Record
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene

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


class Shot(Record):
    """What came of one shot.

    `faults` are the limits of every scene that it breaks. `missing` and `invented` of its events
    are wrong.
    """

    number: int
    ending: str
    extent: str
    events: int
    missing: int = Field(0, exclude=True)
    invented: int = Field(0, exclude=True)
    swapped: int = Field(0, exclude=True)
    negligible: int = Field(0, exclude=True)
    quality_factor: float | None
    time_errors: tuple[float, ...] = Field((), exclude=True)
    faults: tuple[str, ...]

    @computed_field
    def again(self) -> str:
        """Return the command that grades it."""
        return f"python -m benchmarks accuracy --first {self.number} --shots 1"

    @computed_field
    def scene(self) -> dict[str, Any]:
        """Return the scene, as its file has it."""
        return shot_of(self.number).model_dump(mode="json", by_alias=True)


class Distribution(Record):
    """How one quantity is spread over many values; None where there are none."""

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

    @property
    def cells(self) -> tuple[str, ...]:
        """It as cells of a table."""
        values = (self.median, self.p99, self.greatest)
        return str(self.count), *("–" if value is None else f"{value:.3g}" for value in values)


class AccuracyMeasurement(Shown):
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
    faulty: tuple[Shot, ...]
    worst: tuple[Shot, ...]

    @classmethod
    def of(cls, first: int, shots: Sequence[Shot]) -> AccuracyMeasurement:
        """Return what came of all shots."""
        graded = [shot for shot in shots if shot.quality_factor is not None]
        graded.sort(key=lambda shot: (-(shot.quality_factor or 0.0), shot.number))
        times = [error for shot in shots for error in shot.time_errors]
        return cls(
            first=first,
            shots=len(shots),
            endings=Counter(sorted(shot.ending for shot in shots)),
            extents=Counter(sorted(shot.extent for shot in shots)),
            events=sum(shot.events for shot in shots),
            missing=sum(shot.missing for shot in shots),
            invented=sum(shot.invented for shot in shots),
            swapped=sum(shot.swapped for shot in shots),
            negligible=sum(shot.negligible for shot in shots),
            quality_factor=Distribution.of([shot.quality_factor or 0.0 for shot in graded]),
            time_error_ulps=Distribution.of(times),
            faulty=tuple(shot for shot in shots if shot.faults),
            worst=tuple(graded[:WORST]),
        )

    @property
    def table(self) -> RenderableType:
        """How exact our engine is over many random shots, and the shots worth a look."""
        counts = [(f"proof: {name}", str(count)) for name, count in self.endings.items()]
        counts += [(f"graded: {name}", str(count)) for name, count in self.extents.items()]
        spreads = (
            ("quality factor of a shot", *self.quality_factor.cells),
            ("error of an event's time [ulps]", *self.time_error_ulps.cells),
        )
        worth_a_look = [("breaks a limit", shot) for shot in self.faulty]
        worth_a_look += [("worst", shot) for shot in self.worst[:3]]
        return Group(
            table_of((f"{self.shots} shots from number {self.first}", "shots"), counts),
            table_of(("quantity", "values", "median", "99 %", "greatest"), spreads),
            f"{self.events} events proved: {self.missing} not found, {self.invented} invented; "
            f"{self.swapped} in another order, {self.negligible} below rounding",
            *(
                Text(f"{why}: quality factor {shot.quality_factor or 0.0:.3g}: {shot.again}. ")
                + Text("; ".join(shot.faults))
                for why, shot in worth_a_look
            ),
        )


def measure_accuracy(
    shots: int = SHOTS, *, first: int = 0, jobs: int = JOBS, progress: Progress[str] | None = None
) -> AccuracyMeasurement:
    """Simulate, prove and grade random shots.

    `first`: the number of the first one; see `shot_of`.
    `jobs`: processes; 1 runs everything in this one.
    """
    numbers = range(first, first + shots)
    compile_kernels((shot_of(number) for number in numbers[:_VARIED]), jobs)
    graded = []
    with closing(run_tasks(numbers, jobs, _grade_shot)) as answers:
        for count, done in enumerate(answers, start=1):
            graded.append(done.or_else(_crashed))
            if progress is not None:
                progress(count, shots, f"shot {done.task}")
    return AccuracyMeasurement.of(first, sorted(graded, key=lambda shot: shot.number))


def shot_of(number: int) -> Scene:
    """Return the random shot of a number."""
    return random_scene(number, **PROVABLE)


def _crashed(number: int, reason: str) -> Never:
    raise MeasurementError(f"the measurement of shot {number}: {reason}")


def _grade_shot(number: int) -> Shot:
    scene = shot_of(number)
    result = simulate(scene, record="trajectory", max_events=MAX_EVENTS)
    # Not kept on the disk: thousands of them would push out those of the shipped scenes.
    proof = certify(scene, PROOF, motion=True, cached=False)
    graded = grade(result, proof)
    faults = faults_of(graded, scene)
    if not result.status.complete:
        faults += (f"our engine stopped early: {result.status.value}",)
    return Shot(
        number=number,
        ending=proof.ending,
        extent=graded.extent,
        events=graded.events,
        missing=len(graded.missing),
        invented=len(graded.invented),
        swapped=graded.swapped,
        negligible=graded.negligible,
        quality_factor=graded.quality_factor,
        time_errors=tuple(graded.time_errors.tolist()),
        faults=faults,
    )

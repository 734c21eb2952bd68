"""Accuracy of Ghostball's engine, measured in thousands of random shots with certified results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import typer
from pydantic import Field, computed_field
from rich.console import Group, RenderableType
from rich.text import Text

from benchmarks.commands import Count, benchmark, in_processes
from benchmarks.measurements import BenchmarkMeasurement, Distribution, table_of
from ghostball.cli.options import AUTO, Jobs
from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.reference_adapters.certified import CertifiedSettings, certify
from ghostball.validation.checks.requirements import faults_of
from ghostball.validation.grading.grading import grade
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.results.measurement import Record
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene

SHOTS = 10_000
"""Number of shots of a whole measurement, about two minutes in two processes."""

WORST_KEPT = 10
"""Number of shots stored as the worst, those with the largest quality factors."""

CERTIFICATION = CertifiedSettings(time_limit=60.0, max_events=5_000)
"""Limits of the certification of a shot; a few elastic shots have thousands of events."""

MAX_EVENTS = 10_000
"""Largest number of events and contact steps of a run; more are a fault of the engine."""

_SHOTS_TO_COMPILE = 80
"""Number of shots that together need every variant of the kernels."""

_COUNTS = ("events", "missing", "invented", "swapped", "negligible")
"""Fields that count events of a shot."""


class GradedShot(Record):
    """The grade of one shot.

    `faults`: common limits that the shot fails.
    `missing`, `invented`: number of certified events that the engine missed, and of its events that
        aren't certified.
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
        """Return the command that grades this shot."""
        return f"python -m benchmarks accuracy --first {self.number} --shots 1"

    @computed_field
    def scene(self) -> dict[str, Any]:
        """Return the scene, as in a scene file."""
        return shot_of(self.number).model_dump(mode="json", by_alias=True)


class AccuracyMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks accuracy`.

    `endings`: number of shots by the end of their certification.
    `extents`: number of shots by the part of them that is graded.
    `events`: number of certified events that were compared.
    `missing`, `invented`: number of events that the engine missed, and of wrong events.
    `swapped`: number of events in another order.
    `negligible`: number of events below rounding.
    `quality_factor`: distribution over shots.
    `time_error_ulps`: distribution over events.
    `faulty`, `worst`: shots that fail a limit, and shots with the largest quality factors.
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
    faulty: tuple[GradedShot, ...]
    worst: tuple[GradedShot, ...]

    @classmethod
    def of(cls, first: int, shots: Sequence[GradedShot]) -> AccuracyMeasurement:
        """Return the measurement from the grades of its shots."""
        factors = {shot: shot.quality_factor for shot in shots if shot.quality_factor is not None}
        worst = sorted(factors, key=lambda shot: (-factors[shot], shot.number))
        return cls(
            first=first,
            shots=len(shots),
            endings=Counter(sorted(shot.ending for shot in shots)),
            extents=Counter(sorted(shot.extent for shot in shots)),
            **{name: sum(getattr(shot, name) for shot in shots) for name in _COUNTS},
            quality_factor=Distribution.of([*factors.values()]),
            time_error_ulps=Distribution.of([x for shot in shots for x in shot.time_errors]),
            faulty=tuple(shot for shot in shots if shot.faults),
            worst=tuple(worst[:WORST_KEPT]),
        )

    @property
    def failure(self) -> str:
        """Message with the number of shots that fail a limit, or ""."""
        return f"Shots that fail a common limit: {len(self.faulty)}" if self.faulty else ""

    @property
    def table(self) -> RenderableType:
        """Tables of counts and distributions, and a line for each faulty or worst shot."""
        counts = [(f"certified: {name}", str(count)) for name, count in self.endings.items()]
        counts += [(f"graded: {name}", str(count)) for name, count in self.extents.items()]
        spreads = (
            ("quality factor of a shot", self.quality_factor),
            ("error of an event's time [ulps]", self.time_error_ulps),
        )
        cells = (
            (name, str(one.count), *map(_shown, (one.median, one.p99, one.greatest)))
            for name, one in spreads
        )
        named = [("fails a limit", shot) for shot in self.faulty]
        named += [("worst", shot) for shot in self.worst[:3]]
        return Group(
            table_of((f"{self.shots} shots from number {self.first}", "shots"), counts),
            table_of(("quantity", "values", "median", "99 %", "largest"), cells),
            f"{self.events} certified events: {self.missing} missed, {self.swapped} in another "
            f"order; {self.invented} wrong events; {self.negligible} events below rounding",
            *(
                Text(
                    f"{why}: quality factor {_shown(shot.quality_factor)}: {shot.again}. "
                    f"{'; '.join(shot.faults)}"
                )
                for why, shot in named
            ),
        )


def _shown(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


@benchmark
def accuracy(
    shots: Count = SHOTS,
    first: Annotated[
        int, typer.Option(min=0, help="Number of the first shot; a number is always the same shot.")
    ] = 0,
    jobs: Jobs = AUTO,
) -> AccuracyMeasurement:
    """Certify random shots and compare Ghostball's engine; exit status 1 if it fails a limit."""
    numbers = range(first, first + shots)
    compile_kernels((shot_of(number) for number in numbers[:_SHOTS_TO_COMPILE]), jobs)
    graded = in_processes(numbers, jobs, _grade_shot, "shot")
    return AccuracyMeasurement.of(first, sorted(graded, key=lambda shot: shot.number))


def shot_of(number: int) -> Scene:
    """Return the random shot with a number."""
    return random_scene(number, **PROVABLE)


def _grade_shot(number: int) -> GradedShot:
    scene = shot_of(number)
    result = simulate(scene, record="trajectory", max_events=MAX_EVENTS)
    # Not cached: thousands of certificates would displace those of the shipped scenes.
    proof = certify(scene, CERTIFICATION, motion=True, cached=False)
    graded = grade(result, proof)
    faults = faults_of(graded, scene)
    if not result.status.complete:
        faults += (f"the engine did not finish: {result.status.value}",)
    return GradedShot(
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

"""Our engine on thousands of random shots, each proved and graded: how exact it is, in numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import typer
from pydantic import Field, computed_field
from rich.console import Group, RenderableType
from rich.text import Text

from benchmarks.frame import Count, benchmark, in_processes
from benchmarks.measurements import Distribution, Shown, table_of
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
"""Shots of a whole measurement: some two minutes in two processes."""

WORST = 10
"""Shots of the greatest quality factors that are kept."""

PROOF = CertifiedSettings(time_limit=60.0, max_events=5_000)
"""How far a shot is proved: a few elastic ones have thousands of events."""

MAX_EVENTS = 10_000
"""Events and contact steps after which our engine's run of a shot is given up, which is a fault."""

_VARIED = 80
"""Shots that need every variant of the kernels between them."""

_COUNTS = ("events", "missing", "invented", "swapped", "negligible")
"""Events of a shot that are counted."""


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
            worst=tuple(worst[:WORST]),
        )

    @property
    def failure(self) -> str:
        """How many shots break a limit."""
        return f"Shots that break a limit of every scene: {len(self.faulty)}" if self.faulty else ""

    @property
    def table(self) -> RenderableType:
        """How exact our engine is over many random shots, and the shots worth a look."""
        counts = [(f"proof: {name}", str(count)) for name, count in self.endings.items()]
        counts += [(f"graded: {name}", str(count)) for name, count in self.extents.items()]
        spreads = (
            ("quality factor of a shot", self.quality_factor),
            ("error of an event's time [ulps]", self.time_error_ulps),
        )
        cells = (
            (name, str(one.count), *map(_shown, (one.median, one.p99, one.greatest)))
            for name, one in spreads
        )
        worth_a_look = [("breaks a limit", shot) for shot in self.faulty]
        worth_a_look += [("worst", shot) for shot in self.worst[:3]]
        return Group(
            table_of((f"{self.shots} shots from number {self.first}", "shots"), counts),
            table_of(("quantity", "values", "median", "99 %", "greatest"), cells),
            f"{self.events} events proved: {self.missing} not found, {self.invented} invented; "
            f"{self.swapped} in another order, {self.negligible} below rounding",
            *(
                Text(
                    f"{why}: quality factor {_shown(shot.quality_factor)}: {shot.again}. "
                    f"{'; '.join(shot.faults)}"
                )
                for why, shot in worth_a_look
            ),
        )


def _shown(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


@benchmark
def accuracy(
    shots: Count = SHOTS,
    first: Annotated[
        int, typer.Option(min=0, help="Number of the first shot: the same number, the same shot.")
    ] = 0,
    jobs: Jobs = AUTO,
) -> AccuracyMeasurement:
    """Prove random shots and grade our engine by them; exit with 1 if it breaks a limit."""
    numbers = range(first, first + shots)
    compile_kernels((shot_of(number) for number in numbers[:_VARIED]), jobs)
    graded = in_processes(numbers, jobs, _grade_shot, "shot")
    return AccuracyMeasurement.of(first, sorted(graded, key=lambda shot: shot.number))


def shot_of(number: int) -> Scene:
    """Return the random shot of a number."""
    return random_scene(number, **PROVABLE)


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

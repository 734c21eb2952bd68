"""How often the model error that an attribution gives is right to its bound, on random shots."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Literal

from pydantic import BaseModel, ConfigDict

from benchmarks.measurements import Measurement, measured_where
from benchmarks.running import run_each, shot_numbers
from ghostball.engine import Ball, Physics, Scene, Table
from ghostball.engine.scene import POOL_BALL_RADIUS
from ghostball.reference_adapters import make_engine
from ghostball.validation.diagnose.attribution import Attribution, attribute, largest_distance
from ghostball.validation.diagnose.attribution.attribution_record import Outcome
from ghostball.validation.parallel.compiling import compile_kernels
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.runs.steps import with_setting
from ghostball.validation.truth.known_shot import KnownShot, known_shot

SHOTS = 200
"""Shots of a whole measurement: a quarter of an hour of one processor."""

NOMINAL = 0.95
"""The part of the bounds that should hold at least."""

LONGEST = 1.5
"""When a shot is cut off [s]: a ladder of steps is affordable until then."""

RESTITUTION = 0.9
"""Of the balls, for the engine that represents it otherwise than the scene means it."""


@dataclass(frozen=True)
class Subject:
    """An engine whose model error is known.

    Attributes
    ----------
    engine : str
        With its settings.
    landed : bool
        Whether its model's end is known from the mode that lands its steps on contacts: that has
        the same model and no error of its steps. Else it has no model error: its end is the truth.
    restitution : float [1]
        Of the balls of its shots.
    every : int
        It plays one shot of so many.
    """

    engine: str
    landed: bool
    restitution: float = 1.0
    every: int = 1


SUBJECTS = (
    Subject("pymunk", landed=True),
    # It multiplies the restitutions of two balls, so that 0.9 makes 0.81: a model error.
    Subject("pymunk:config=default,dt=1e-3", landed=True, restitution=RESTITUTION, every=4),
    Subject("paper-discrete", landed=False),
)


class AttributedShot(BaseModel):
    """What an attribution said of one shot on one engine, and what is true.

    `difference`, `model`, `uncertainty` and `true_model` are in m; None where no number is given.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    number: int
    engine: str
    outcome: Outcome
    reason: str = ""
    difference: float | None = None
    model: float | None = None
    uncertainty: float | None = None
    true_model: float | None = None

    @property
    def covered(self) -> bool | None:
        """Whether the true size lies within the bound; None where no number is given."""
        if self.model is None or self.uncertainty is None or self.true_model is None:
            return None
        return abs(self.model - self.true_model) <= self.uncertainty


class Coverage(BaseModel):
    """What came of all shots on one engine.

    `covered` of `attributed` bounds hold; `not_told` shots have no number since the runs don't say
    how to divide their difference, `not_compared` since nothing can be compared. `blamed` have a
    model error that is told from none. `relative` is the median of uncertainty over difference.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    engine: str
    shots: int
    attributed: int
    covered: int
    not_told: int
    not_compared: int
    blamed: int
    relative: float | None

    @classmethod
    def of(cls, engine: str, rows: Sequence[AttributedShot]) -> Coverage:
        """Count the shots on an engine."""
        mine = [row for row in rows if row.engine == engine]
        given = [row for row in mine if row.covered is not None]
        sizes = [(row.model or 0.0, row.uncertainty or 0.0, row.difference) for row in given]
        return cls(
            engine=engine,
            shots=len(mine),
            attributed=len(given),
            covered=sum(row.covered is True for row in given),
            not_told=sum(row.outcome == "not told" for row in mine),
            not_compared=sum(row.outcome == "not compared" for row in mine),
            blamed=sum(size > bound for size, bound, _ in sizes),
            relative=median(bound / whole for _, bound, whole in sizes if whole) if sizes else None,
        )


class AttributionMeasurement(Measurement):
    """What `python -m benchmarks attribution` measured."""

    kind: Literal["attribution"] = "attribution"
    first: int
    shots: int
    engines: tuple[Coverage, ...]
    rows: tuple[AttributedShot, ...]

    @property
    def anything(self) -> bool:
        """Whether a shot was attributed before an interrupt."""
        return bool(self.rows)

    @property
    def failing(self) -> list[str]:
        """The engines of whose bounds fewer hold than should."""
        return [one.engine for one in self.engines if one.covered < NOMINAL * one.attributed]


def pool_shot(number: int, restitution: float = 1.0) -> Scene:
    """Return the shot of this number: a cue ball hits one of one to four balls that lie together.

    Balls roll and cushions mirror, on a table or without one: what every engine here represents.
    """
    # The seed is text, whose hash is the same everywhere.
    chance = random.Random(f"ghostball attribution {number}")
    cue = (0.5, 0.4)
    middle = (chance.uniform(0.9, 1.6), chance.uniform(0.3, 0.9))
    places: list[tuple[float, float]] = []
    wanted = chance.randint(1, 4)
    while len(places) < wanted:
        x, y = (side + chance.uniform(-0.2, 0.2) for side in middle)
        if all(math.dist((x, y), other) > 2.02 * POOL_BALL_RADIUS for other in places):
            places.append((x, y))
    aim = chance.choice(places)
    reach = 2.0 * POOL_BALL_RADIUS / math.dist(aim, cue)
    # A cut of at most 58 degrees: beyond, steps of a millisecond miss it altogether.
    turn = math.asin(reach) * chance.uniform(-0.85, 0.85)
    direction = math.atan2(aim[1] - cue[1], aim[0] - cue[0]) + turn
    speed = chance.uniform(0.6, 2.0)
    velocity = (speed * math.cos(direction), speed * math.sin(direction))
    return Scene(
        name=f"pool-shot-{number}",
        table=chance.choice((None, Table(length=2.54, width=1.27))),
        t_max=LONGEST,
        physics=Physics(rolling_friction=chance.choice((0.01, 0.02)), ball_restitution=restitution),
        balls=[
            Ball(id="cue", position=cue, velocity=velocity),
            *(Ball(id=f"b{i}", position=place) for i, place in enumerate(places)),
        ],
    )


def measure_attribution(
    shots: int = SHOTS, *, first: int = 0, jobs: int = 2, progress: Progress[str] | None = None
) -> AttributionMeasurement:
    """Attribute random shots on engines whose model error is known; Ctrl-C keeps those done.

    Parameters
    ----------
    shots : int
        How many.
    first : int
        The number of the first one; see `pool_shot`.
    jobs : int
        Processes; 1 runs everything in this one.
    progress : callable, optional
        Called with how many attributions are done.

    Raises
    ------
    BenchError
        Where a number is wrong, or a process dies.
    """
    tasks = [
        (number, subject)
        for number in shot_numbers(shots, first, jobs)
        for subject in SUBJECTS
        if number % subject.every == 0
    ]
    compile_kernels([pool_shot(first)], jobs)
    rows: list[AttributedShot] = []
    interrupted = run_each(tasks, jobs, _attributed, rows.append, _name, progress)
    order = [subject.engine for subject in SUBJECTS]
    rows.sort(key=lambda row: (row.number, order.index(row.engine)))
    return AttributionMeasurement(
        environment=measured_where(),
        rounds=1,
        interrupted=interrupted,
        first=first,
        shots=len({row.number for row in rows}),
        engines=tuple(Coverage.of(name, rows) for name in order),
        rows=tuple(rows),
    )


def _name(task: tuple[int, Subject]) -> str:
    number, subject = task
    return f"shot {number} on {subject.engine}"


def _attributed(task: tuple[int, Subject]) -> AttributedShot:
    number, subject = task
    scene = pool_shot(number, subject.restitution)
    known = known_shot(scene)
    found = attribute(scene, make_engine(subject.engine), known=known)
    row = AttributedShot(
        number=number,
        engine=subject.engine,
        outcome=found.outcome,
        reason=found.reason,
        difference=found.difference,
    )
    if found.model is None:
        return row
    return row.model_copy(
        update={
            "model": found.model.size,
            "uncertainty": found.model.uncertainty,
            "true_model": _true_model(subject, known, found),
        }
    )


def _true_model(subject: Subject, known: KnownShot, found: Attribution) -> float:
    """Return how far the engine's model is off at the instant that was compared [m]."""
    if not subject.landed:
        return 0.0
    scene = known.scene
    shot = scene if found.instant is None else scene.model_copy(update={"t_max": found.instant})
    # Its longest step matters to nothing but the time that it takes.
    engine = with_setting(make_engine(subject.engine), "mode", "landed")
    result = engine.simulate(shot)
    return largest_distance(result.rest_positions[:, :2], known.positions(found.instant))

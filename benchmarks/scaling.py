"""Time per event against the number of balls, and against how densely they are packed."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Literal

from benchmarks.comparison import PEER_ERRORS, outcome_of
from benchmarks.measurements import measured_where
from benchmarks.peer_engines import Peer, PeerRun
from benchmarks.records import Curve, Outcome, Physics, Point, ScalingMeasurement
from benchmarks.running import after, collision_rate, run, until
from benchmarks.timing import Clock, Samples, Task, take_turns
from ghostball.engine import Scene
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.scenes.gases import FRICTIONLESS, FULL_CLOTH, packed_gas

Along = Literal["balls", "packing"]

PHYSICS: tuple[Physics, ...] = ("gas", "cloth")
"""An elastic gas, and all of pool's physics: no peer represents both."""

FIXED_PACKING = 0.3
"""The part of the area that balls cover, where their number varies."""

FIXED_BALLS = 256
"""How many balls there are, where their packing varies."""

MELTING = 5.0
"""Collisions of each ball, by `collision_rate`, before a gas is measured.

On cloth balls start from the lattice: they would be at rest.
"""

OUR_COLLISIONS, PEER_COLLISIONS = 10.0, 2.0
"""The same while it is measured; peers need long. On cloth, where balls are slowed, it's fewer."""

MOST_SCENES = 200
"""Of few balls, in one sample."""

LONGEST_SAMPLE = 5.0
"""Seconds: a peer that needs more goes no further, and measures that point only once."""


@dataclass(frozen=True)
class Extent:
    """How far a measurement goes.

    Attributes
    ----------
    balls : tuple of int, increasing
    packings : tuple of float
    fixed_balls : int
    least_events, least_peer_events : int
        Where a scene has fewer, several go into one sample.
    """

    balls: tuple[int, ...] = (2, 4, 8, 16, 32, 64, 128, 256, 1000, 3000, 10_000, 30_000, 100_000)
    packings: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)
    fixed_balls: int = FIXED_BALLS
    least_events: int = 5_000
    least_peer_events: int = 40


WIDE = Extent()
TINY = Extent((2, 4), (0.1, 0.3), fixed_balls=4, least_events=1, least_peer_events=1)


class OurEngine:
    """Our engine, as peers are."""

    name, version = "ghostball", ""

    def simulate(self, scene: Scene) -> PeerRun:
        """Run a scene to its end."""
        result = run(scene)
        return PeerRun(result.wall_time, result.work["events"])


@dataclass(eq=False)
class _Course:
    """One engine with one physics: as far as it went, and why no further."""

    engine: Peer
    physics: Physics
    collisions: float
    least_events: int
    ours: bool = False
    outcome: Outcome = "ran"
    detail: str = ""
    largest: float = math.inf  # balls beyond which it isn't asked any more
    warm: bool = False
    slow: set[str] = field(default_factory=set)  # points that are measured only once

    def curve(self) -> Curve:
        return Curve(
            engine=self.engine.name,
            physics=self.physics,
            version=self.engine.version,
            outcome=self.outcome,
            detail=self.detail,
        )


@dataclass(frozen=True)
class _Place:
    """One point to be measured."""

    course: _Course
    along: Along
    balls: int
    packing: float

    @property
    def name(self) -> str:
        course = self.course
        return f"{course.engine.name}, {course.physics}, {self.balls} balls at {self.packing:g}"

    @property
    def key(self) -> str:
        return f"{self.along}: {self.name}"

    def task(self) -> Task:
        return Task(self.key, lambda: self._sample)

    def point(self, samples: Samples) -> Point | None:
        spreads = samples.spreads(self.key)
        if "per_event" not in spreads:
            return None
        return Point(
            engine=self.course.engine.name,
            physics=self.course.physics,
            balls=self.balls,
            packing=self.packing,
            events=spreads["events"].median,
            per_event=spreads["per_event"].median,
            least=spreads["per_event"].least,
            greatest=spreads["per_event"].greatest,
            samples=spreads["per_event"].samples,
        )

    def _sample(self, clock: Clock) -> dict[str, float]:
        course = self.course
        if course.outcome != "ran" or self.balls > course.largest or self.key in course.slow:
            return {}
        try:
            if not course.warm:  # it may compile
                course.engine.simulate(
                    scene_of(course.physics, 2, FIXED_PACKING, 0, course.collisions)
                )
                course.warm = True
            return self._measure(clock)
        except PEER_ERRORS as error:
            self._note(error)
            return {}

    def _measure(self, clock: Clock) -> dict[str, float]:
        course = self.course
        expected = self.balls * course.collisions / 2.0
        count = min(math.ceil(course.least_events / expected), MOST_SCENES)
        scenes = [
            scene_of(course.physics, self.balls, self.packing, seed, course.collisions)
            for seed in range(count)
        ]
        for scene in scenes[:1] if course.ours else ():
            course.engine.simulate(scene)  # laid out, and whatever it needs compiled
        began = clock()
        runs = [course.engine.simulate(scene) for scene in scenes]
        took = clock() - began
        if took > LONGEST_SAMPLE and not course.ours:
            course.slow.add(self.key)
            if self.along == "balls" and self.balls < course.largest:
                course.largest = self.balls
                course.detail = f"no further: {took:.0f} s for {self.balls} balls"
        events = sum(one.events for one in runs)
        seconds = sum(one.seconds for one in runs)
        return {"events": float(events), "per_event": seconds / events} if events else {}

    def _note(self, error: Exception) -> None:
        course = self.course
        if course.warm and self.along == "balls":  # it could with fewer
            course.largest = min(course.largest, self.balls - 1)
            course.detail = f"not with {self.balls} balls: {error}"
        elif not course.warm:
            course.outcome, course.detail = outcome_of(error), str(error)


def scene_of(physics: Physics, balls: int, packing: float, seed: int, collisions: float) -> Scene:
    """Return a scene to measure on; it begins alike for all engines, and lasts `collisions`."""
    return until(_beginning(physics, balls, packing, seed), collisions / collision_rate(packing))


@cache
def _beginning(physics: Physics, balls: int, packing: float, seed: int) -> Scene:
    melting = MELTING / collision_rate(packing)
    if physics == "cloth":
        return packed_gas(balls, packing, FULL_CLOTH, melting, seed)
    return after(packed_gas(balls, packing, FRICTIONLESS, melting, seed))


def measure_scaling(
    peers: Sequence[Peer] = (),
    *,
    rounds: int,
    extent: Extent = WIDE,
    clock: Clock = time.perf_counter,
    progress: Progress[str] | None = None,
) -> ScalingMeasurement:
    """Measure time per event of our engine and of peers; Ctrl-C keeps what was measured.

    Parameters
    ----------
    peers : sequence of Peer
    rounds : int
        At most as many samples of each point.
    extent : Extent
    clock, progress
        As for `take_turns`.
    """
    environment = measured_where()
    ours = OurEngine()
    courses = [
        _Course(ours, physics, OUR_COLLISIONS, extent.least_events, ours=True)
        for physics in PHYSICS
    ]
    courses += [
        _Course(peer, physics, PEER_COLLISIONS, extent.least_peer_events)
        for peer in peers
        for physics in PHYSICS
    ]
    places = list(_places(courses, extent))
    samples = take_turns([p.task() for p in places], rounds, clock=clock, progress=progress)
    points = [(place.along, place.point(samples)) for place in places]
    by_balls, by_packing = (
        tuple(point for along, point in points if point and along == wanted)
        for wanted in ("balls", "packing")
    )
    _beginning.cache_clear()
    return ScalingMeasurement(
        environment=environment,
        rounds=rounds,
        quick=extent != WIDE,
        interrupted=samples.interrupted,
        fixed_packing=FIXED_PACKING,
        fixed_balls=extent.fixed_balls,
        by_balls=by_balls,
        by_packing=by_packing,
        curves=tuple(course.curve() for course in courses),
    )


def _places(courses: Sequence[_Course], extent: Extent) -> Iterator[_Place]:
    """Yield the points in the order of measurement: few balls first, engine by engine."""
    for balls in extent.balls:
        for course in courses:
            yield _Place(course, "balls", balls, FIXED_PACKING)
    for packing in extent.packings:
        for course in courses:
            yield _Place(course, "packing", extent.fixed_balls, packing)

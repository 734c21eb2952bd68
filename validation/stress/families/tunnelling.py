"""Tunnelling: the largest step with which an engine lets no ball through another.

An engine that steps sees a contact only where a step ends in it. A ball whose path crosses another
one over a chord of length c is missed by steps of v dt > c, from some of the instants at which the
steps may begin. Chipmunk and Bullet push balls apart only while they approach, over the first half
of the chord: of a path that passes at b from the other ball's centre,

    P(miss) = 1 - sqrt(4 R^2 - b^2) / (v dt)

of all start phases. An engine without steps has no such cliff, and one that looks ahead neither;
that is tried, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from typing import Any, ClassVar

import numpy as np

from ghostball.model import (
    POOL_BALL_RADIUS,
    Ball,
    EventKind,
    Physics,
    Result,
    Scene,
    Table,
    first_energy,
)
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.runs.playing import run_engine
from ghostball.validation.runs.steps import step_setting, with_step
from ghostball.validation.stress.invariants import is_exact
from ghostball.validation.stress.trial import (
    Family,
    SceneTrial,
    Suite,
    Trial,
    Verdict,
    play,
)

DIAMETER = 2.0 * POOL_BALL_RADIUS

PHASES = 8
"""Start phases of each step: the ball begins a part of it farther away."""

FINEST, COARSEST = -5, 2
"""Shortest and longest step of the ladder: 2 to these, in diameters that the ball goes in it."""

MOST_ENERGY_ERROR = 1e-3
"""By which the energy at the end may be off, over the first, in an engine that steps."""

ROOM = 1.0
"""Way of the ball before the contact and after it, beside whole steps, in diameters."""


def crossing(depth: float) -> float:
    """Return half of the chord that a path `depth` diameters deep cuts [m].

    Over this way two balls approach and overlap.
    """
    return DIAMETER * math.sqrt(depth * (2.0 - depth))


def passing(depth: float, speed: float, step: float, phase: float) -> Scene:
    """Return a ball that comes `depth` diameters deep across another one, at `speed` [m/s].

    The path to the contact is `phase` of a step longer than whole steps; they end with the run.
    """
    way = speed * step
    before = math.ceil(ROOM * DIAMETER / way) + phase
    after = math.ceil((2.0 * crossing(depth) + ROOM * DIAMETER) / way)
    # Contact is where the centres are a diameter apart.
    x = -(before * way + crossing(depth))
    # A step is shortened to fit a whole number of them, so an ulp above it would add one.
    t_max = (math.floor(before) + 1 + after) * step * (1.0 - 1e-9)
    return Scene(
        name="passing",
        t_max=t_max,
        physics=Physics(rolling_friction=0.0),
        balls=[
            Ball(id="cue", position=(x, DIAMETER * (1.0 - depth)), velocity=(speed, 0.0)),
            Ball(id="object", position=(0.0, 0.0)),
        ],
    )


@dataclass(frozen=True)
class Passing(Trial):
    """One ball shot across another, at an engine's own step, and maybe at those of a ladder.

    It survives where it misses from no start phase at its own step, or whatever its settings where
    it has none. The ladder is measured, not judged.

    `speed` [m/s].
    `depth`: of the impact, in diameters.
    `halves`: rungs of the ladder for each factor 2; 0 for none.
    `phases`: start phases at each rung; at the engine's own step there are `PHASES`.
    """

    name: str
    speed: float
    depth: float
    halves: int = 0
    phases: int = PHASES
    limit: ClassVar[float] = 300.0

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Shoot from every start phase, then down the ladder."""
        setting = step_setting(engine)
        own = None if setting is None else own_step(engine, self._scene(DIAMETER / self.speed, 0.0))
        missed, faults = self._misses(engine, own or DIAMETER / self.speed / 8.0, PHASES)
        values: dict[str, Any] = {
            "speed": self.speed,
            "depth": self.depth,
            "step": own,
            "missed": len(missed),
            "phases": PHASES,
        }
        if setting is not None and self.halves:
            values |= self._ladder(engine)
        if missed:
            at_step = "" if own is None else f" at a step of {own:.3g} s"
            faults = [
                *faults,
                f"{len(missed)} of {PHASES} shots at {self.speed:g} m/s, "
                f"{self.depth:g} diameters deep, go through the other ball{at_step}",
            ]
        scene = missed[0] if missed else self._scene(own or 0.001, 0.0)
        severity = len(missed) / PHASES + bool(faults)
        return Verdict(tuple(faults), scene, severity, PHASES, len(missed), values)

    def examples(self) -> Iterator[Scene]:
        """Yield the shot."""
        yield self._scene(0.001, 0.0)

    def _scene(self, step: float, phase: float) -> Scene:
        return passing(self.depth, self.speed, step, phase)

    def _misses(
        self, engine: ReferenceEngine, step: float, phases: int
    ) -> tuple[list[Scene], list[str]]:
        """Return the shots that are missed at a step, and what else goes wrong."""
        missed: list[Scene] = []
        faults: list[str] = []
        for k in range(phases):
            scene = self._scene(step, k / phases)
            result = play(engine, scene, "events")
            if isinstance(result, Verdict):
                faults += result.faults
                missed.append(scene)
            elif not result.collision_counts[EventKind.BALL_BALL.label]:
                missed.append(scene)
        return missed, faults

    def _ladder(self, engine: ReferenceEngine) -> dict[str, Any]:
        """Return the misses at each step, and the largest step up to which there is none."""
        rungs = []
        for rung in range(FINEST * self.halves, COARSEST * self.halves + 1):
            step = DIAMETER / self.speed * 2.0 ** (rung / self.halves)
            missed, _ = self._misses(with_step(engine, step), step, self.phases)
            rungs.append({"dt": step, "missed": len(missed)})
        safe = [one["dt"] for one in takewhile(lambda one: not one["missed"], rungs)]
        return {"ladder": rungs, "largest_step": safe[-1] if safe else None}


@dataclass(frozen=True)
class EndEnergy:
    """Whether the energy at the end of a shot is right.

    `energy` [J]: what is left.
    """

    energy: float

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        first, last = result.energy(np.array([0.0, result.rest_time])).total
        error, limit = float(abs(last - self.energy) / first), energy_limit(result)
        faults = []
        if not error <= limit:
            faults.append(
                f"the energy at the end is off by {error:.3g} of the first, at most {limit:.3g}"
            )
        return Verdict.of(result.scene, faults, error / limit, {"energy_error": error})


def energy_limit(result: Result) -> float:
    """Return by how much the energy at the end may be off, over the first.

    Of exact motion some roundings for the sum at the end, and one at each event: each rounds the
    speeds of its balls, whose energy is a part of the whole, and its instant.
    """
    if not is_exact(result):
        return MOST_ENERGY_ERROR
    assert result.events is not None
    return EPS * (8.0 + len(result.events))


def elastic_break() -> tuple[Scene, float]:
    """Return a break of nine frozen balls on a small table that nothing slows, and its energy."""
    places = [(0.25, 0.305)]
    for row, count in enumerate((1, 2, 3, 2, 1)):
        places += [
            (0.6 + row * DIAMETER * math.sqrt(0.75), 0.3 + (k - (count - 1) / 2.0) * DIAMETER)
            for k in range(count)
        ]
    scene = Scene(
        name="elastic-break",
        t_max=0.5,
        table=Table(length=1.2, width=0.6),
        physics=Physics(rolling_friction=0.0),
        balls=[
            Ball(id=f"b{k}", position=place, velocity=(0.0 if k else 5.0, 0.0))
            for k, place in enumerate(places)
        ],
    )
    return scene, first_energy(scene)


def bounces() -> tuple[Scene, float]:
    """Return a ball that rolls to and fro between two cushions, and its energy at the end.

    Each cushion takes a part of its speed, so that whoever sees it late has another energy.
    """
    radius, mass, length, t_max, v = POOL_BALL_RADIUS, 0.17, 0.8, 2.0, 3.0
    physics = Physics(
        rolling_friction=0.05, cushion="restitution", cushion_restitution=0.7, gravity=9.81
    )
    scene = Scene(
        name="bounces",
        t_max=t_max,
        table=Table(length=length, width=0.4),
        physics=physics,
        balls=[Ball(id="cue", position=(0.3, 0.2), velocity=(v, 0.0), mass=mass)],
    )
    slowing = physics.rolling_friction * physics.gravity
    t, way = 0.0, length - radius - 0.3
    while v * v > 2.0 * slowing * way:
        # The first root of way = v s - slowing s^2 / 2, without cancellation.
        s = 2.0 * way / (v + math.sqrt(v * v - 2.0 * slowing * way))
        if t + s > t_max:
            break
        t += s
        v = physics.cushion_restitution * (v - slowing * s)
        way = length - 2.0 * radius
    v = max(0.0, v - slowing * (t_max - t))
    return scene, 0.7 * mass * v * v


def own_step(engine: ReferenceEngine, scene: Scene) -> float:
    """Return the step of an engine as it is set [s]; what a run says, where none is set."""
    name = step_setting(engine)
    assert name is not None
    value = getattr(engine.settings, name)
    if value is None:
        value = run_engine(engine, scene, "rest").settings[name]
    return float(value)


SPEED, DEPTH = 2.0, 0.1
"""The shot that tells the largest step of an engine in one number: [m/s], and in diameters."""

SPEEDS = {"quick": (2.0, 10.0), "full": (0.5, 1.0, 2.0, 5.0, 10.0)}
DEPTHS = {"quick": (0.1, 0.01), "full": (0.5, 0.1, 0.05, 0.02, 0.01)}
"""What a pool game has: up to the hardest break [m/s], and cuts of up to 82 degrees; in diameters
of depth."""


def _trials(suite: Suite) -> Iterator[Trial]:
    halves, phases = (1, 4) if suite == "quick" else (2, PHASES)
    for speed in SPEEDS[suite]:
        for depth in DEPTHS[suite]:
            rungs = halves if (speed, depth) == (SPEED, DEPTH) else 0
            yield Passing(f"speed-{speed:g}-depth-{depth:g}", speed, depth, rungs, phases)
    for name, (scene, energy) in (("elastic-break", elastic_break()), ("bounces", bounces())):
        yield SceneTrial(f"energy-of-{name}", scene, EndEnergy(energy))


FAMILY = Family(
    "tunnelling",
    "Largest step without a miss",
    "At its own step an engine lets no ball through another, from whichever instant the steps are "
    f"counted: {PHASES} of them for each speed of a pool game, 0.5 to 10 m/s, and each depth of "
    "impact, 0.5 to 0.01 diameters; and the energy at the end is right, to rounding where motion "
    "is exact and else to 1e-3 of the first, in an elastic break of frozen balls and of a ball "
    "that bounces to and fro. How large steps might be is measured of one shot for engines that "
    "have any; ours has none, so it has no such limit.",
    _trials,
)

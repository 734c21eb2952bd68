"""Tunnelling: the largest step with which an engine lets no ball through another.

An engine that steps sees a contact only where a step ends in it. A ball whose path crosses another
one over a chord of length c is missed by steps of v dt > c from some of the instants at which a step
may begin. Chipmunk and Bullet push balls apart only while they approach, over the first half of the
chord: of a path that passes at b from the other ball's centre,

    P(miss) = 1 - sqrt(4 R^2 - b^2) / (v dt)

of all start phases. An engine without steps has no such cliff, and one that looks ahead neither;
that is tried, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from engine import Ball, EventKind, Physics, Scene, Table
from engine.scene import POOL_BALL_RADIUS
from reference_adapters import ReferenceEngine
from validation.steps import step_setting, with_step
from validation.stress.family import Family
from validation.stress.judges import energies, instants
from validation.stress.trial import Suite, Trial, Verdict, play

DIAMETER = 2.0 * POOL_BALL_RADIUS

PHASES = 8
"""Start phases of each step: the ball begins a part of it farther away."""

FINEST = -5
"""Shortest step of the ladder: 2 to this, in diameters that the ball goes in it."""

ROOM = 1.0
"""Way of the ball before the contact and after it, beside whole steps, in diameters."""


def crossing(depth: float) -> float:
    """Return half of the chord that a path `depth` diameters deep cuts [m].

    Over this way two balls approach and overlap.
    """
    return DIAMETER * math.sqrt(depth * (2.0 - depth))


def miss_rate(depth: float, way: float) -> float:
    """Return the part of start phases from which a step of `way` [m] leads past the contact.

    Of an engine that reacts to balls that overlap and approach where a step ends.
    """
    return max(0.0, 1.0 - crossing(depth) / way)


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
    """One ball shot across another, at an engine's own step and at those of a ladder.

    It survives where it misses from no start phase at its own step, or whatever its settings where
    it has none. The ladder is measured, not judged.

    Attributes
    ----------
    name : str
    speed : float [m/s]
    depth : float
        Of the impact, in diameters.
    halves : int
        Rungs of the ladder for each factor 2.
    phases : int
    """

    name: str
    speed: float
    depth: float
    halves: int = 2
    phases: int = PHASES
    limit: ClassVar[float] = 300.0

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Shoot from every start phase, then down the ladder."""
        setting = step_setting(engine)
        own = None if setting is None else own_step(engine, self._scene(DIAMETER / self.speed, 0))
        missed, faults = self._misses(engine, own or DIAMETER / self.speed / 8.0)
        values: dict[str, Any] = {
            "speed": self.speed,
            "depth": self.depth,
            "step": own,
            "missed": len(missed),
            "phases": self.phases,
        }
        if setting is not None:
            values |= self._ladder(engine)
        if missed:
            at_step = "" if own is None else f" at a step of {own:.3g} s"
            faults = [
                *faults,
                f"{len(missed)} of {self.phases} shots at {self.speed:g} m/s, "
                f"{self.depth:g} diameters deep, go through the other ball{at_step}",
            ]
        scene = missed[0] if missed else self._scene(own or 0.001, 0)
        severity = len(missed) / self.phases
        return Verdict(
            tuple(faults), scene, severity + bool(faults), self.phases, len(missed), values
        )

    def _scene(self, step: float, k: int) -> Scene:
        return passing(self.depth, self.speed, step, k / self.phases)

    def _misses(self, engine: ReferenceEngine, step: float) -> tuple[list[Scene], list[str]]:
        """Return the shots that are missed at a step, and what else goes wrong."""
        missed, faults = [], []
        for k in range(self.phases):
            scene = self._scene(step, k)
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
        top = 2 * self.halves
        for rung in range(FINEST * self.halves, top + 1):
            step = DIAMETER / self.speed * 2.0 ** (rung / self.halves)
            missed, _ = self._misses(with_step(engine, step), step)
            rungs.append([step, len(missed)])
        safe = None
        for step, count in rungs:
            if count:
                break
            safe = step
        return {"ladder": rungs, "largest_step": safe, "cliff": safe != rungs[-1][0]}


def own_step(engine: ReferenceEngine, scene: Scene) -> float:
    """Return the step of an engine as it is set [s]; what a run says, where none is set."""
    name = step_setting(engine)
    assert name is not None
    value = getattr(engine.settings, name)
    if value is None:
        value = engine.simulate(scene).settings[name]
    return float(value)

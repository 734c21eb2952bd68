"""Grazing: two balls that only just touch, or only just miss."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from engine import Ball, EventKind, Physics, Result, Scene
from validation.stress.family import Family
from validation.stress.trial import SceneTrial, Suite, Trial, Verdict

SPEED = 1.0
DISTANCE = 0.3
"""Speed of the moving ball [m/s], and its way to the other one [m]."""

DEEPEST, FINEST = 1, 13
"""Impact depths: 10 to the minus these, in diameters. Past 1e-13 doubles can't tell."""

_KINDS = {
    "rolling": Physics(rolling_friction=0.02),
    "elastic": Physics(rolling_friction=0.0),
    "sliding": Physics(preset="pool"),
}


def _scene(name: str, physics: Physics, depth: float, turn: float) -> Scene:
    """Return a shot that passes the other ball at one diameter less `depth` diameters.

    Turned by an angle about the object ball, and so that each coordinate is rounded.
    """
    c, s = math.cos(turn), math.sin(turn)
    aside = 2.0 * Ball(id="x", position=(0.0, 0.0)).radius * (1.0 - depth)
    x, y = -DISTANCE, aside
    return Scene(
        name=name,
        physics=physics,
        t_max=2.0 * DISTANCE / SPEED,
        balls=[
            Ball(
                id="cue",
                position=(c * x - s * y, s * x + c * y),
                velocity=(SPEED * c, SPEED * s),
            ),
            Ball(id="object", position=(0.0, 0.0)),
        ],
    )


def depth_of(scene: Scene) -> float:
    """Return how deep the moving ball's straight path goes into the other ball, in diameters.

    From the scene's own doubles, in exact arithmetic until the last step; negative for a miss.
    """
    cue, other = scene.balls
    x, y = (
        Fraction(b) - Fraction(a) for a, b in zip(cue.position[:2], other.position[:2], strict=True)
    )
    vx, vy = map(Fraction, cue.velocity[:2])
    diameter = Fraction(cue.radius) + Fraction(other.radius)
    across = (x * vy - y * vx) ** 2 / (vx**2 + vy**2)  # (r x v)^2 / v^2, the passing distance
    return float((diameter**2 - across) / (diameter * (diameter + _root(across))))


def _root(square: Fraction) -> Fraction:
    return Fraction(math.sqrt(square))


@dataclass(frozen=True)
class HitOrMiss:
    """Whether the balls collide exactly where their paths do.

    Attributes
    ----------
    depth : float
        In diameters; negative where they must not collide.
    """

    depth: float

    def __call__(self, result: Result) -> Verdict:
        """Judge a run."""
        assert result.events is not None
        hits = int(np.count_nonzero(result.events["kind"] == EventKind.BALL_BALL))
        faults = []
        if self.depth > 0.0 and not hits:
            faults.append(f"a hit {self.depth:.2e} diameters deep is missed")
        if self.depth < 0.0 and hits:
            faults.append(
                f"a collision is seen where the balls miss by {-self.depth:.2e} diameters"
            )
        if hits > 1:
            faults.append(f"{hits} collisions of two balls that meet once")
        # The shallower, the harder: 1 at the limit of double precision.
        hard = -math.log10(abs(self.depth)) / FINEST
        values = {"depth": self.depth, "hits": hits}
        return Verdict.of(result.scene, faults, min(hard, 0.999), values)


def _trials(suite: Suite) -> Iterator[Trial]:
    turns = (0.0, 0.7) if suite == "quick" else (0.0, 0.3, 0.7, 1.1, 2.3, 4.0)
    powers = range(DEEPEST, FINEST + 1, 3 if suite == "quick" else 1)
    for kind, physics in _KINDS.items():
        for power in powers:
            for turn in turns:
                for sign, word in ((1.0, "hit"), (-1.0, "miss")):
                    name = f"{kind}-{word}-1e-{power:02d}-turned-{turn:g}"
                    scene = _scene(name, physics, sign * 10.0**-power, turn)
                    yield SceneTrial(name, scene, HitOrMiss(depth_of(scene)), "events")


FAMILY = Family(
    "grazing",
    "Grazing hits and near misses",
    "Two balls whose paths come within a diameter less a small part of it collide, once; where "
    "they come within a diameter and as much, they never do.",
    _trials,
)

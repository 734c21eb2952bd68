"""Flight: balls that jump, drop and bounce; what must hold in space whatever the shot."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ghostball.model import Ball, EventKind, Physics, Result, Scene
from ghostball.validation.stress.judges import Invariants
from ghostball.validation.stress.trial import Family, SceneTrial, Suite, Trial, Verdict

R = Ball(id="any", position=(0.0, 0.0)).radius
G = 9.81
_FLIES = Physics(preset="pool", airborne=True, table_restitution=0.5)


@dataclass(frozen=True)
class Lands:
    """Whether the last landing of each ball is where the series of its bounces ends.

    To 1e-14 of that time for each landing; and balls that are let go together land together.

    `ends` [s]: when the last bounce of each ends.
    """

    ends: float

    def __call__(self, result: Result) -> Verdict:
        """Judge a run, recorded as a trajectory."""
        assert result.events is not None
        landings = result.events[result.events["kind"] == EventKind.BALL_CLOTH]
        faults = []
        off = 0.0
        for i in range(len(result.scene.balls)):
            last = float(landings["t"][landings["a"] == i].max(initial=0.0))
            off = max(off, abs(last / self.ends - 1.0))
        if len(np.unique(landings["t"])) * len(result.scene.balls) != len(landings):
            faults.append("balls that land at one instant land at several")
        limit = 1e-14 * max(len(landings), 1)
        if not off <= limit:
            faults.append(f"bounces end off by {off:.3g} of their time {self.ends:.6g} s")
        return Verdict.of(result.scene, faults, off / limit, {"off": off})


def over_the_top(depth: float, turn: float) -> Scene:
    """Return a jump whose apex is above a resting ball, `depth` diameters nearer than a touch.

    At 1 m/s, fast enough for the path to be nearest there: 2 R g < v^2.
    """
    speed, before = 1.0, 0.1
    c, s = math.cos(turn), math.sin(turn)
    top = 3.0 * R - 2.0 * R * depth
    way = speed * before
    return Scene(
        name=f"over-top-{depth:g}-{turn:g}",
        physics=_FLIES,
        balls=[
            Ball(
                id="cue",
                position=(-c * way, -s * way, top - 0.5 * G * before * before),
                velocity=(speed * c, speed * s, G * before),
                angular_velocity=(0.0, 0.0, 0.0),
            ),
            Ball(id="object", position=(0.0, 0.0)),
        ],
        t_max=1.2 * before,
    )


def on_top(aside: float, restitution: float, drop: float) -> Scene:
    """Return a ball that falls on another, `aside` radii from its middle."""
    return Scene(
        name=f"on-top-{aside:g}-{restitution:g}-{drop:g}",
        physics=_FLIES.model_copy(update={"ball_restitution": restitution}),
        balls=[
            Ball(id="below", position=(0.0, 0.0)),
            Ball(id="above", position=(aside * R, 0.0, 3.0 * R + drop)),
        ],
    )


def endless(count: int, restitution: float, drop: float) -> Scene:
    """Return balls that are let go at one instant, from one height."""
    return Scene(
        name=f"endless-{count}-{restitution:g}-{drop:g}",
        physics=_FLIES.model_copy(update={"table_restitution": restitution}),
        balls=[Ball(id=f"b{i}", position=(0.25 * i, 0.0, R + drop)) for i in range(count)],
    )


def _trials(suite: Suite) -> Iterator[Trial]:
    finest = 10 if suite == "full" else 6
    for depth in [s * 10.0**-k for k in range(1, finest) for s in (1.0, -1.0)]:
        for turn in (0.0, 0.7) if suite == "quick" else (0.0, 0.3, 0.7, 2.0):
            scene = over_the_top(depth, turn)
            yield SceneTrial(scene.name, scene, Invariants(meets=depth > 0.0))
    for aside in (0.0, 1e-13, 1e-6, 0.5, 1.5):
        for restitution in (0.0, 0.95, 1.0):
            for drop in (0.1,) if suite == "quick" else (0.1, 1e-3, 1e-7):
                scene = on_top(aside, restitution, drop)
                yield SceneTrial(scene.name, scene, Invariants(meets=True))
    for restitution in (0.0, 0.3, 0.6, 0.9, 0.99):
        for count in (1, 2):
            scene = endless(count, restitution, 0.1)
            first = math.sqrt(2.0 * 0.1 / G)
            ends = first * (1.0 + restitution) / (1.0 - restitution)
            yield SceneTrial(scene.name, scene, Lands(ends))


FAMILY = Family(
    "flight",
    "Balls that fly",
    "A jump clears a ball or clips its top, down to 1e-10 of a diameter; a ball that falls on "
    "another, however near to its middle, comes off it; endless bounces end when their series "
    "does, of balls that land at one instant too. Random shots that fly are in `combined` and "
    "`graded`.",
    _trials,
    ours_alone=True,
)

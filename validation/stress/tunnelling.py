"""Tunnelling: the speeds up to which no ball passes through another.

A time-stepping engine detects a contact only if a step ends in it. A ball with a path that crosses
another ball along a chord of length c is missed by steps of v dt > c, for some phases of the steps.
Chipmunk and Bullet separate balls only while they approach, along the first half of the chord. For
a path at a distance b from the other ball's centre, the share of missed phases is

    P(miss) = 1 - sqrt(4 R^2 - b^2) / (v dt)

Only v dt matters: doubling the speed has the same effect as doubling the step. Engines without time
steps, and engines with continuous collision detection, must not have this limit; this is tested,
too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Scene, Table
from ghostball.validation.stress.shots import (
    StressFamily,
    StressShot,
    StressSize,
    limit,
    scene_of,
    shot,
)

DIAMETER = 2.0 * POOL_BALL_RADIUS

STEP = 1e-3
"""Time step of most engines [s]; the phases are fractions of it."""

PHASES = 8
"""Number of phases: the ball starts at a fraction of a step farther away."""

FREE_PATH = 1.0
"""Path of the ball before and after the contact, besides whole steps, in diameters."""


def crossing(depth: float) -> float:
    """Return half of the chord that a path with an overlap of `depth` diameters cuts [m].

    Along this half, the two balls approach and overlap.
    """
    return DIAMETER * math.sqrt(depth * (2.0 - depth))


def passing(depth: float, speed: float, step: float, phase: float) -> Scene:
    """Return a ball that passes another with an overlap of `depth` diameters, at `speed` [m/s].

    The path to the contact is `phase` of a step longer than whole steps; the run ends with a whole
    step.
    """
    way = speed * step
    before = math.ceil(FREE_PATH * DIAMETER / way) + phase
    after = math.ceil((2.0 * crossing(depth) + FREE_PATH * DIAMETER) / way)
    # Contact is where the centres are a diameter apart.
    x = -(before * way + crossing(depth))
    # An engine may shorten its step to fit a whole number of steps; an ulp more would add a step.
    t_max = (math.floor(before) + 1 + after) * step * (1.0 - 1e-9)
    cue = Ball(id="cue", position=(x, DIAMETER * (1.0 - depth)), velocity=(speed, 0.0))
    rests = Ball(id="object", position=(0.0, 0.0))
    return scene_of(cue, rests, physics=Physics(rolling_friction=0.0), t_max=t_max)


def elastic_break() -> Scene:
    """Return a break of nine frozen balls on a small table without friction."""
    places = [(0.25, 0.305)]
    for row, count in enumerate((1, 2, 3, 2, 1)):
        places += [
            (0.6 + row * DIAMETER * math.sqrt(0.75), 0.3 + (k - (count - 1) / 2.0) * DIAMETER)
            for k in range(count)
        ]
    balls = [
        Ball(id=f"b{k}", position=place, velocity=(0.0 if k else 5.0, 0.0))
        for k, place in enumerate(places)
    ]
    table, physics = Table(length=1.2, width=0.6), Physics(rolling_friction=0.0)
    return scene_of(*balls, physics=physics, t_max=0.5, table=table)


def bounces() -> Scene:
    """Return a ball that rolls back and forth between two cushions.

    Each cushion reduces its speed, so an engine that detects a cushion late has a different energy.
    """
    table = Table(length=0.8, width=0.4)
    physics = Physics(
        rolling_friction=0.05, cushion="restitution", cushion_restitution=0.7, gravity=9.81
    )
    cue = Ball(id="cue", position=(0.3, 0.2), velocity=(3.0, 0.0), mass=0.17)
    return scene_of(cue, physics=physics, t_max=2.0, table=table)


def _passings(size: StressSize) -> Iterator[StressShot]:
    halves = 2 if size.full else 1
    beyond = [10.0 * 2.0 ** (k / halves) for k in range(1, 4 * halves + 1)]
    game = product(SPEEDS[size.full], DEPTHS[size.full])
    for speed, depth in (*game, *product(beyond, (DEPTH,))):
        for k in range(PHASES):
            name = f"speed-{speed:.3g}-depth-{depth:g}-phase-{k}"
            scene = passing(depth, speed, STEP, k / PHASES)
            why = f"The path goes {depth:g} diameters deep: the ball can't pass."
            met = limit("ball_ball_count", why, at_least=1)
            swept = {"speed": speed} if depth == DEPTH else {}
            yield shot(name, scene, met, **swept)


DEPTH = 0.1
"""Depth of the shots that are also run at speeds above those of pool [diameters]."""

SPEEDS = ((2.0, 10.0), (0.5, 1.0, 2.0, 5.0, 10.0))
DEPTHS = ((0.1, 0.01), (0.5, 0.1, 0.05, 0.02, 0.01))
"""Speeds of pool up to the hardest break [m/s], and depths of cuts up to 82 degrees [diameters],
for the small size and the full size."""


def _shots(size: StressSize) -> Iterator[StressShot]:
    yield from _passings(size)
    yield shot("energy-of-elastic-break", elastic_break())
    yield shot("energy-of-bounces", bounces())


FAMILY = StressFamily(
    "tunnelling",
    "Fast balls and time steps",
    "No ball passes through another ball, at any phase of the time step: "
    f"{PHASES} phases for each speed of a pool game, 0.5 to 10 m/s, and each depth of impact, 0.5 "
    f"to 0.01 diameters, and for speeds up to 160 m/s, {DEPTH:g} diameters deep. The energy is "
    "right in an elastic break of frozen balls, and for a ball that bounces back and forth.",
    _shots,
)

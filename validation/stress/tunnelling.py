"""Tunnelling: the speeds at which an engine lets no ball through another.

An engine that steps sees a contact only where a step ends in it. A ball whose path crosses another
one over a chord of length c is missed by steps of v dt > c, from some of the instants at which the
steps may begin. Chipmunk and Bullet push balls apart only while they approach, over the first half
of the chord: of a path that passes at b from the other ball's centre,

    P(miss) = 1 - sqrt(4 R^2 - b^2) / (v dt)

of all start phases. What counts is v dt: twice the speed is as much as twice the step. An engine
without steps has no such cliff, and one that looks ahead neither; that is tried, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Scene, Table
from ghostball.validation.stress.shots import Family, Shot, Size, limit, scene_of, shot

DIAMETER = 2.0 * POOL_BALL_RADIUS

STEP = 1e-3
"""Time step of most engines [s]: the start phases are parts of it."""

PHASES = 8
"""Start phases: the ball begins a part of a step farther away."""

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
    cue = Ball(id="cue", position=(x, DIAMETER * (1.0 - depth)), velocity=(speed, 0.0))
    rests = Ball(id="object", position=(0.0, 0.0))
    return scene_of(cue, rests, physics=Physics(rolling_friction=0.0), t_max=t_max)


def elastic_break() -> Scene:
    """Return a break of nine frozen balls on a small table that nothing slows."""
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
    """Return a ball that rolls to and fro between two cushions.

    Each cushion takes a part of its speed, so that whoever sees it late has another energy.
    """
    table = Table(length=0.8, width=0.4)
    physics = Physics(
        rolling_friction=0.05, cushion="restitution", cushion_restitution=0.7, gravity=9.81
    )
    cue = Ball(id="cue", position=(0.3, 0.2), velocity=(3.0, 0.0), mass=0.17)
    return scene_of(cue, physics=physics, t_max=2.0, table=table)


def _passings(size: Size) -> Iterator[Shot]:
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
"""Depth of the shots that are also played faster than any pool game [diameters]."""

SPEEDS = ((2.0, 10.0), (0.5, 1.0, 2.0, 5.0, 10.0))
DEPTHS = ((0.1, 0.01), (0.5, 0.1, 0.05, 0.02, 0.01))
"""What a pool game has, in the small size and the full one: up to the hardest break [m/s], and cuts
of up to 82 degrees; in diameters of depth."""


def _shots(size: Size) -> Iterator[Shot]:
    yield from _passings(size)
    yield shot("energy-of-elastic-break", elastic_break())
    yield shot("energy-of-bounces", bounces())


FAMILY = Family(
    "tunnelling",
    "Fast balls and time steps",
    "No ball passes through another ball, at any phase of the time step: "
    f"{PHASES} phases for each speed of a pool game, 0.5 to 10 m/s, and each depth of impact, 0.5 "
    f"to 0.01 diameters, and for speeds up to 160 m/s, {DEPTH:g} diameters deep; and the energy is "
    "right in an elastic break of frozen balls and of a ball that bounces to and fro.",
    _shots,
)

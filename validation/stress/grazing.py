"""Grazing: two balls that barely touch or miss, and a ball that barely reaches a cushion.

These are the hardest cases for collision detection. Rounding of the scene is a hundredth of the
smallest depth and can't turn a hit into a miss; a test certifies each shot. Below a depth of 1e-13
diameters, doubles can't distinguish the two.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import product

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.stress.shots import (
    StressFamily,
    StressShot,
    StressSize,
    limit,
    scene_of,
    shot,
)

SPEED = 1.0
PATH = 0.1
"""Speed of the moving ball [m/s], and its path to the other ball, or to the cushion [m]."""

SHALLOWEST = 13
"""Impact depths range from 1e-1 to 10 to the minus this, in diameters."""

_RADIUS = Ball(id="any", position=(0.0, 0.0)).radius
_CLOTH = Physics(preset="pool", sliding_friction=0.4)
_SLIDING_DECELERATION = _CLOTH.sliding_friction * _CLOTH.gravity
"""Deceleration of the contact point of a sliding ball [m/s^2]."""


def straight(depth: float, turn: float, *, physics: Physics, ratio: float = 1.0) -> Scene:
    """Return a shot along a straight line, with an overlap of `depth` diameters at a ball at rest.

    The shot is rotated by an angle [rad] about the object ball, so that every coordinate is
    rounded. The object ball has `ratio` times the radius of the cue ball.
    """
    c, s = math.cos(turn), math.sin(turn)
    aside = (1.0 + ratio) * _RADIUS * (1.0 - depth)
    start = (-c * PATH - s * aside, -s * PATH + c * aside)
    cue = Ball(id="cue", position=start, velocity=(SPEED * c, SPEED * s))
    rests = Ball(id="object", position=(0.0, 0.0), radius=ratio * _RADIUS)
    return scene_of(cue, rests, physics=physics, t_max=2.0 * PATH / SPEED)


def curved(depth: float, turn: float) -> Scene:
    """Return a shot on a path that sidespin bends around a ball at rest; see `straight`."""
    c, s = math.cos(turn), math.sin(turn)
    # The ball rolls, and also spins about the direction of the shot: the cloth pushes it sideways,
    # along a parabola, until it has passed.
    spin = SPEED / _RADIUS
    aside = 3.0 * spin
    t = PATH / SPEED
    bent, reach = 0.5 * _SLIDING_DECELERATION * t * t, 2.0 * _RADIUS * (1.0 - depth)
    sideways = _SLIDING_DECELERATION * t
    speed = math.hypot(SPEED, sideways)
    along, across = PATH + reach * sideways / speed, bent - reach * SPEED / speed
    cue = Ball(
        id="cue",
        position=(0.0, 0.0),
        velocity=(SPEED * c, SPEED * s),
        angular_velocity=(-aside * c - spin * s, -aside * s + spin * c, 0.0),
    )
    rests = Ball(id="object", position=(c * along - s * across, s * along + c * across))
    return scene_of(cue, rests, physics=_CLOTH, t_max=2.0 * t)


def at_cushion(depth: float, _turn: float) -> Scene:
    """Return a shot that sidespin turns back just where it reaches a cushion."""
    spin, up = 2.0 * SPEED / _RADIUS, 0.4 * SPEED
    apex = up * up / (2.0 * _SLIDING_DECELERATION)
    # The slip is only sideways, so the friction points away from the cushion.
    cue = Ball(
        id="cue",
        position=(0.3, 0.6 - _RADIUS - apex + 2.0 * _RADIUS * depth),
        velocity=(SPEED, up),
        angular_velocity=(spin, SPEED / _RADIUS, 0.0),
    )
    table = Table(length=1.2, width=0.6)
    return scene_of(cue, physics=_CLOTH, table=table, t_max=2.0 * PATH / SPEED)


def hit_or_miss(depth: float, metric: str = "collision_count") -> Criterion:
    """Return the limit on the collisions of a path with a depth [diameters]; negative is a miss."""
    if depth > 0.0:
        return limit(metric, f"The path goes {depth:.0e} diameters deep: one collision.", equals=1)
    return limit(metric, f"The path misses by {-depth:.0e} diameters: no collision.", equals=0)


def grazes(
    kind: str,
    make: Callable[[float, float], Scene],
    powers: Iterable[int],
    turns: Iterable[float],
    metric: str = "collision_count",
) -> Iterator[StressShot]:
    """Yield shots with depths of plus (hit) and minus (miss) these powers of ten [diameters].

    `make`: returns the scene for a depth [diameters] and a rotation [rad].
    `metric`: the count of collisions that the limit is on.
    """
    for power, turn, word in product(powers, turns, ("hit", "miss")):
        name = f"{kind}-{word}-1e-{power:02d}" + (f"-turned-{turn:g}" if turn else "")
        depth = (1.0 if word == "hit" else -1.0) * 10.0**-power
        yield shot(name, make(depth, turn), hit_or_miss(depth, metric), depth=abs(depth))


def _shots(size: StressSize) -> Iterator[StressShot]:
    turns = (0.0, 0.3, 0.7, 1.1, 2.3, 4.0) if size.full else (0.0, 0.7)
    powers = range(1, SHALLOWEST + 1, 1 if size.full else 3)
    sliding = Physics(preset="pool")
    kinds: dict[str, Callable[[float, float], Scene]] = {
        "rolling": partial(straight, physics=Physics()),
        "elastic": partial(straight, physics=Physics(rolling_friction=0.0)),
        "sliding": partial(straight, physics=sliding),
        "small": partial(straight, physics=sliding, ratio=0.25),
        "curved": curved,
        "cushion": at_cushion,
    }
    for kind, make in kinds.items():
        yield from grazes(kind, make, powers, turns[:1] if kind == "cushion" else turns)


FAMILY = StressFamily(
    "grazing",
    "Grazing hits and near misses",
    "A path that goes 1e-1 to 1e-13 of a diameter into a ball or a cushion gives one "
    "collision; a path that misses by as much gives none.",
    _shots,
)

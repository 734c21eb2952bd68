"""Scenes that are measured but no data files, and how one is run: random racks."""

from __future__ import annotations

import math
import random
from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Record, Result, Scene, Table
from ghostball.validation.results.measurement import MeasurementError
from ghostball.validation.scenes.gases import FULL_CLOTH

POOL_TABLE = Table(length=2.54, width=1.27)

SLOWEST, FASTEST = 4.0, 12.0
"""Speeds of a cue ball [m/s]."""

LOOSEST = 1e-3
"""The widest gap of a loose rack [m]."""

WIDEST_AIM = 0.01
"""How far off the rack's axis a cue ball is aimed at most [rad]."""

FARTHEST = 0.5
"""How far from that axis it starts at most, in radii."""


def random_rack(number: int) -> Scene:
    """Return a break with all of pool's physics, on a table without pockets.

    `number`: even: a loose rack, its gap uniform in 0 to 1 mm, one for the whole rack. Odd: a
    frozen rack, whose neighbours touch to a rounding, as in the shipped `frozen-break`. Speed, aim
    and place of the cue ball are uniform, too.
    """
    chance = random.Random(number)
    speed = chance.uniform(SLOWEST, FASTEST)
    aim = chance.uniform(-WIDEST_AIM, WIDEST_AIM)
    offset = chance.uniform(-FARTHEST, FARTHEST) * POOL_BALL_RADIUS
    gap = 0.0 if number % 2 else chance.uniform(0.0, LOOSEST)
    velocity = (speed * math.cos(aim), speed * math.sin(aim))
    return racked(f"rack-{number}", velocity, offset, gap)


def racked(
    name: str,
    velocity: tuple[float, float],
    offset: float,
    gap: float,
    table: Table = POOL_TABLE,
) -> Scene:
    """Return a break of 15 racked balls with all of pool's physics.

    `velocity` [m/s]: of the cue ball, which has no spin.
    `offset` [m]: how far left of the rack's axis it starts.
    `gap` [m]: between racked neighbours.
    """
    cue = Ball(
        id="cue",
        position=(0.25 * table.length, table.width / 2.0 + offset),
        velocity=velocity,
        angular_velocity=(0.0, 0.0, 0.0),
    )
    places = rack_places(gap, table).tolist()
    rack = [Ball(id=str(k), position=tuple(place)) for k, place in enumerate(places, start=1)]
    return Scene(name=name, table=table, balls=(cue, *rack), physics=Physics(**FULL_CLOTH))


def rack_places(gap: float | NDArray[np.float64], table: Table = POOL_TABLE) -> NDArray[np.float64]:
    """Return where racked balls lie, (..., 15, 2) [m]; neighbours are `gap`, (...) [m], apart."""
    spacing = 2.0 * POOL_BALL_RADIUS + np.asarray(gap)
    places = np.empty((*spacing.shape, 15, 2))
    for row in range(5):
        for place in range(row + 1):
            k = row * (row + 1) // 2 + place
            places[..., k, 0] = 0.75 * table.length + row * spacing * math.sqrt(0.75)
            places[..., k, 1] = table.width / 2.0 + (place - row / 2.0) * spacing
    return places


def run(scene: Scene, *, record: Record = "rest", no_skip: Collection[str] = ()) -> Result:
    """Simulate `scene` to its natural end; arguments as for `simulate`."""
    result = simulate(scene, record=record, no_skip=no_skip)
    if not result.status.complete:
        raise MeasurementError(
            f'scene "{scene.name}" did not end by itself: {result.status.value}: {result.reason}. '
            "Its time would mean nothing"
        )
    return result

"""Random racks for benchmarks, and a function that runs a scene to its end."""

from __future__ import annotations

import math
import random
from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Record, Result, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.model.scene.rack import Rack
from ghostball.validation.results.measurement import MeasurementError
from ghostball.validation.scenes.gases import FULL_CLOTH

POOL_TABLE = Table(length=2.54, width=1.27)

SLOWEST, FASTEST = 4.0, 12.0
"""Range of the speed of the cue ball [m/s]."""

LARGEST_GAP = 1e-3
"""Largest gap of a loose rack [m]."""

LARGEST_ANGLE = 0.01
"""Largest angle between the velocity of the cue ball and the axis of the rack [rad]."""

LARGEST_OFFSET = 0.5
"""Largest distance of the cue ball from the axis of the rack, in radii."""


def random_rack(number: int) -> Scene:
    """Return a random break with the full physics of pool, on a table without pockets.

    `number`: the seed. Even numbers are loose racks with one gap, uniform between 0 and 1 mm. Odd
        numbers are frozen racks, in which neighbours touch within rounding, as in the shipped scene
        `frozen-break`.

    Speed, direction and offset of the cue ball are uniformly distributed, too.
    """
    chance = random.Random(number)
    speed = chance.uniform(SLOWEST, FASTEST)
    aim = chance.uniform(-LARGEST_ANGLE, LARGEST_ANGLE)
    offset = chance.uniform(-LARGEST_OFFSET, LARGEST_OFFSET) * POOL_BALL_RADIUS
    gap = 0.0 if number % 2 else chance.uniform(0.0, LARGEST_GAP)
    velocity = (speed * math.cos(aim), speed * math.sin(aim))
    return racked(f"rack-{number}", velocity, offset, gap)


def racked(
    name: str,
    velocity: tuple[float, float],
    offset: float,
    gap: float,
    table: Table = POOL_TABLE,
) -> Scene:
    """Return a break of 15 racked balls with the full physics of pool.

    `velocity` [m/s]: velocity of the cue ball, which has no spin.
    `offset` [m]: distance of the cue ball from the axis of the rack, positive to the left.
    `gap` [m]: gap between neighbours in the rack.
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
    """Return the positions of racked balls, (..., 15, 2) [m], for gaps of shape (...) [m]."""
    spacing = 2.0 * POOL_BALL_RADIUS + np.asarray(gap)
    places = np.empty((*spacing.shape, 15, 2))
    for row in range(5):
        for place in range(row + 1):
            k = row * (row + 1) // 2 + place
            places[..., k, 0] = 0.75 * table.length + row * spacing * math.sqrt(0.75)
            places[..., k, 1] = table.width / 2.0 + (place - row / 2.0) * spacing
    return places


def racks_made_uneven(
    places: FloatArray, gaps: FloatArray, chance: np.random.Generator
) -> FloatArray:
    """Return places of racked balls, (k, 15, 2) [m], with every gap between 0 and twice `gaps`.

    `places` (k, 15, 2) [m]: racked balls with even gaps.
    `gaps` (k,) [m]: these gaps; the result has at least the gaps of a template.

    As in a scene's `rack` with `unevenness` 1, each ball is anywhere in a disc of half a gap.
    """
    template = Rack.PRESETS["template"]["gap"]
    wide = np.maximum(gaps, template)
    opened = 1.0 + (wide - gaps) / (2.0 * POOL_BALL_RADIUS + gaps)
    first = places[:, :1]
    angle = chance.uniform(0.0, 2.0 * math.pi, places.shape[:2])
    reach = 0.5 * wide[:, None] * np.sqrt(chance.uniform(0.0, 1.0, places.shape[:2]))
    moved: FloatArray = first + (places - first) * opened[:, None, None]
    moved += reach[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=2)
    return moved


def run(scene: Scene, *, record: Record = "rest", no_skip: Collection[str] = ()) -> Result:
    """Simulate `scene` to its end; arguments as for `simulate`.

    Raises `MeasurementError` if the run stops early.
    """
    result = simulate(scene, record=record, no_skip=no_skip)
    if not result.status.complete:
        raise MeasurementError(
            f'scene "{scene.name}" did not finish: {result.status.value}: {result.reason}. Only '
            "finished runs can be measured"
        )
    return result

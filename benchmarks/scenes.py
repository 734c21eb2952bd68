"""Scenes that are measured but no data files, and how one is run: random racks, and a gas."""

from __future__ import annotations

import math
import random
from collections.abc import Collection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Record, Result, Scene, Table
from ghostball.validation.results.measurement import MeasurementError
from ghostball.validation.scenes.gases import FRICTIONLESS, FULL_CLOTH, lattice_of

POOL_TABLE = Table(length=2.54, width=1.27)

ROLLING: dict[str, Any] = {"preset": "paper"}
"""Physics of the paper: balls roll, impacts are elastic."""

SLOWEST_BREAK, FASTEST_BREAK = 8.0, 10.0  # [m/s]
NARROWEST_GAP, WIDEST_GAP = 1e-5, 1e-4  # [m]

SLOWEST_RACK, FASTEST_RACK = 4.0, 12.0  # [m/s]
LOOSEST = 1e-3
"""The widest gap of a loose rack [m]."""

WIDEST_AIM = 0.01
"""How far off the rack's axis a cue ball is aimed at most [rad]."""

FARTHEST = 0.5
"""How far from that axis it starts at most, in radii."""


def racked_break(seed: int, physics: dict[str, Any]) -> Scene:
    """Return a break of 15 racked balls, without spin, on a pool table without pockets.

    `seed`: decides all that is random, uniformly: speed of the cue ball 8 to 10 m/s, its offset up
        to half a radius and its aim up to 0.01 rad off the rack's axis. The gap between racked
        neighbours is log-uniform in 1e-5 to 1e-4 m, one for the whole rack.
    `physics`: fields of `Physics`.
    """
    chance = random.Random(seed)
    cue = _cue_ball(chance, (SLOWEST_BREAK, FASTEST_BREAK), physics)
    gap = math.exp(chance.uniform(math.log(NARROWEST_GAP), math.log(WIDEST_GAP)))
    return _racked(f"break-{seed}", cue, gap, physics)


def random_rack(number: int) -> Scene:
    """Return a break with all of pool's physics, of a loose rack or of a frozen one.

    `number`: even: a loose rack, its gap uniform in 0 to 1 mm, one for the whole rack. Odd: a
    frozen rack, whose neighbours touch to a rounding, as in the shipped `frozen-break`. The cue
    ball is that of `racked_break`, but at 4 to 12 m/s.
    """
    chance = random.Random(number)
    cue = _cue_ball(chance, (SLOWEST_RACK, FASTEST_RACK), FULL_CLOTH)
    gap = 0.0 if number % 2 else chance.uniform(0.0, LOOSEST)
    return _racked(f"rack-{number}", cue, gap, FULL_CLOTH)


def _cue_ball(chance: random.Random, speeds: tuple[float, float], physics: dict[str, Any]) -> Ball:
    speed = chance.uniform(*speeds)
    aim = chance.uniform(-WIDEST_AIM, WIDEST_AIM)
    offset = chance.uniform(-FARTHEST, FARTHEST) * POOL_BALL_RADIUS
    return Ball(
        id="cue",
        position=(0.25 * POOL_TABLE.length, POOL_TABLE.width / 2.0 + offset),
        velocity=(speed * math.cos(aim), speed * math.sin(aim)),
        angular_velocity=(0.0, 0.0, 0.0) if physics.get("preset") == "pool" else None,
    )


def _racked(name: str, cue: Ball, gap: float, physics: dict[str, Any]) -> Scene:
    """Return a cue ball and a rack of 15 whose neighbours are `gap` [m] apart."""
    rack = [
        Ball(id=str(k), position=tuple(place))
        for k, place in enumerate(rack_places(gap).tolist(), start=1)
    ]
    return Scene(name=name, table=POOL_TABLE, balls=(cue, *rack), physics=Physics(**physics))


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


def table_gas(count: int, t_max: float) -> Scene:
    """Return an elastic gas of `count` balls on a pool table; see its lattice."""
    columns = math.ceil(math.sqrt(2.0 * count))
    rows = math.ceil(count / columns)
    steps = np.array([POOL_TABLE.length / columns, POOL_TABLE.width / rows])
    return lattice_of("table-gas", count, columns, steps, POOL_TABLE, FRICTIONLESS, t_max, 0)


def run(scene: Scene, *, record: Record = "rest", no_skip: Collection[str] = ()) -> Result:
    """Simulate `scene` to its natural end; arguments as for `simulate`."""
    result = simulate(scene, record=record, no_skip=no_skip)
    if not result.status.complete:
        raise MeasurementError(
            f'scene "{scene.name}" did not end by itself: {result.status.value}: {result.reason}. '
            "Its time would mean nothing"
        )
    return result

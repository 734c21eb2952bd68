"""Scenes that are measured but no data files: gases of any number of balls."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Scene, Table

FRICTIONLESS: dict[str, Any] = {"preset": "paper", "rolling_friction": 0.0}
"""Physics of an elastic gas: nothing slows a ball, cushions are mirrors."""

FULL_CLOTH: dict[str, Any] = {"preset": "pool"}
"""Physics of the whole game: sliding, spin, throw, restitution, Han's cushions."""


def packed_gas(
    count: int, packing: float, physics: dict[str, Any], t_max: float | None = None, seed: int = 0
) -> Scene:
    """Return balls that fill `packing` of a square of their own, with random velocities.

    `packing`: the part of the area that balls cover, up to 0.75; a square lattice holds pi / 4.
    `physics`: fields of `Physics`.
    `t_max`: where to stop [s]; needed where nothing slows a ball.
    `seed`: of the velocities: each component normal, with 1 m/s.

    A lattice at the start: only what has moved for a while is a gas. The table is as
    large as the lattice's cells, so that it is a little wider than high where `count` is no square.
    """
    columns = math.ceil(math.sqrt(count))
    rows = math.ceil(count / columns)
    spacing = POOL_BALL_RADIUS * math.sqrt(math.pi / packing)
    velocities = np.random.default_rng(seed).normal(size=(count, 2)).tolist()
    balls = [
        ball_at(
            str(k),
            ((k % columns + 0.5) * spacing, (k // columns + 0.5) * spacing, POOL_BALL_RADIUS),
            (*velocities[k], 0.0),
        )
        for k in range(count)
    ]
    table = Table(length=columns * spacing, width=rows * spacing)
    return Scene(
        name=f"gas-{count}", balls=balls, table=table, physics=Physics(**physics), t_max=t_max
    )


@cache  # each run of a gate looks at them again and again
def many_balls() -> tuple[Scene, ...]:
    """Return scenes of so many balls that cells schedule them: the shipped ones have fewer."""
    gas = packed_gas(256, 0.4, FRICTIONLESS, t_max=0.5)
    cloth = packed_gas(256, 0.3, FULL_CLOTH)
    return (
        gas.model_copy(update={"name": "gas-256"}),
        cloth.model_copy(update={"name": "cloth-256"}),
    )


def ball_at(name: str, position: tuple[float, ...], velocity: tuple[float, ...]) -> Ball:
    """Return a pool ball at a place [m] with a velocity [m/s]."""
    return Ball(id=name, position=tuple(map(float, position)), velocity=velocity)

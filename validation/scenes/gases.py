"""Generated scenes without data files: gases with any number of balls."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Scene, Table

FRICTIONLESS: dict[str, Any] = {"preset": "paper", "rolling_friction": 0.0}
"""Physics of an elastic gas: balls aren't slowed, and cushions are mirrors."""

FULL_CLOTH: dict[str, Any] = {"preset": "pool"}
"""Physics of real pool: sliding, spin, throw, restitution, Han's cushions."""


def packed_gas(
    count: int, packing: float, physics: dict[str, Any], t_max: float | None = None, seed: int = 0
) -> Scene:
    """Return balls with random velocities that cover the share `packing` of a table of their own.

    `packing`: the share of the area that balls cover, up to 0.75; the limit of a square lattice is
        pi / 4.
    `physics`: fields of `Physics`.
    `t_max`: time at which the simulation stops [s]; required if nothing slows balls.
    `seed`: of the velocities: each component is normal with standard deviation 1 m/s.

    The balls start on a lattice, so they form a gas only after some time. The table has the size of
    the lattice, so its length exceeds its width if `count` isn't a square number.
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


@cache  # each comparison with baselines needs them many times
def many_balls() -> tuple[Scene, ...]:
    """Return scenes with more balls than shipped scenes have; the grid scheduler runs them."""
    gas = packed_gas(256, 0.4, FRICTIONLESS, t_max=0.5)
    cloth = packed_gas(256, 0.3, FULL_CLOTH)
    return (
        gas.model_copy(update={"name": "gas-256"}),
        cloth.model_copy(update={"name": "cloth-256"}),
    )


def ball_at(name: str, position: tuple[float, ...], velocity: tuple[float, ...]) -> Ball:
    """Return a pool ball with a position [m] and a velocity [m/s]."""
    return Ball(id=name, position=tuple(map(float, position)), velocity=velocity)

"""Scenes for the engine's tests: short to write down, random ones from a seed."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any

from engine import Ball, Physics, Scene, Table

R = 0.028575
"""Radius of a pool ball [m]; two touch at a distance of exactly 2 R in doubles."""

POOL_TABLE = Table(length=2.54, width=1.27)


def ball(
    position: Sequence[float], velocity: Sequence[float] = (0.0, 0.0), **fields: Any
) -> dict[str, Any]:
    return {"position": tuple(position), "velocity": tuple(velocity), **fields}


def scene_of(
    *balls: dict[str, Any],
    table: Table | None = None,
    t_max: float | None = None,
    **physics: Any,
) -> Scene:
    """Return the scene of these balls, called b0, b1 ... where they have no id."""
    return Scene(
        name="test",
        balls=[Ball(**{"id": f"b{i}", **fields}) for i, fields in enumerate(balls)],
        table=table,
        t_max=t_max,
        physics=Physics(**physics),
    )


def random_shot(seed: int, n: int, *, table: Table | None = POOL_TABLE, **physics: Any) -> Scene:
    """Return n balls at random places, at least one of them moving, up to 3 m/s.

    Every other seed has pool balls only; the rest mix radii and masses.
    """
    chance = random.Random(seed)
    width = 0.8 if table is None else table.width
    length = 0.8 if table is None else table.length
    balls: list[dict[str, Any]] = []
    while len(balls) < n:
        radius = R if seed % 2 else chance.uniform(0.5, 2.0) * R
        place = (
            chance.uniform(1.01 * radius, length - 1.01 * radius),
            chance.uniform(1.01 * radius, width - 1.01 * radius),
        )
        if any(
            math.dist(place, other["position"]) < 1.01 * (radius + other["radius"])
            for other in balls
        ):
            continue
        velocity = (0.0, 0.0)
        if not balls or chance.random() < 0.5:
            speed, angle = chance.uniform(0.2, 3.0), chance.uniform(0.0, 2 * math.pi)
            velocity = (speed * math.cos(angle), speed * math.sin(angle))
        mass = 0.170097 if seed % 2 else 0.170097 * chance.uniform(0.3, 3.0)
        balls.append(ball(place, velocity, radius=radius, mass=mass))
    return scene_of(*balls, table=table, **physics)


def rack(n: int, apex: tuple[float, float], gap: float) -> list[dict[str, Any]]:
    """Return n balls in a triangle that opens along +x, neighbours `gap` [m] apart."""
    spacing = 2 * R + gap
    balls, row = [], 0
    while len(balls) < n:
        for k in range(min(row + 1, n - len(balls))):
            x = apex[0] + row * spacing * math.sqrt(3) / 2
            balls.append(ball((x, apex[1] + (k - row / 2) * spacing)))
        row += 1
    return balls


def random_break(seed: int, *, n: int = 16, e: float = 1.0, **physics: Any) -> Scene:
    """Return a break of n - 1 racked balls: speed, aim and rack gap (0 to 1 mm) from the seed."""
    chance = random.Random(seed)
    gap = 0.0 if seed % 4 == 0 else 10 ** chance.uniform(-9, -3)
    speed = 10 ** chance.uniform(0.0, 1.0)  # slower, the rack is out of reach
    aim = chance.uniform(-0.02, 0.02)
    # Rows of equally spaced balls may overlap by rounding; 1e-15 m keeps them just apart.
    return scene_of(
        ball((0.6, 0.635), (speed * math.cos(aim), speed * math.sin(aim))),
        *rack(n - 1, (1.9, 0.635), gap + 1e-15),
        table=POOL_TABLE,
        ball_restitution=e,
        **physics,
    )

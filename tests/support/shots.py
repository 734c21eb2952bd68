"""Short functions for scenes in tests, and random scenes from a seed."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ghostball.model import Ball, Physics, Result, Scene, Status, Table, initial_state

R = 0.028575
"""Radius of a pool ball [m]; two balls touch at a distance of exactly 2 R in doubles."""

POOL_TABLE = Table(length=2.54, width=1.27)


def crowded_table() -> Table:
    """Return a table with more posts than Ghostball's engine supports."""
    posts = [{"centre": (0.5 + k, 2.5), "radius": 0.02} for k in range(60)]
    return Table.model_validate({"length": 61.0, "width": 3.0, "posts": posts})


FLIES = {
    "motion": "sliding",
    "airborne": True,
    "table_restitution": 0.5,
    "sliding_friction": 0.2,
    "rolling_friction": 0.01,
}
"""Physics with airborne balls."""

JUST_ABOVE = R * (1 + 2.0**-50)
"""Height of a centre just above the cloth: the ball lands at once."""


def kept_scene(name: str) -> Scene:
    """Return a scene of the folder `scenes`, which once revealed a bug."""
    return Scene.load(Path(__file__).with_name("scenes") / f"{name}.toml")


def ball(
    position: Sequence[float], velocity: Sequence[float] = (0.0, 0.0), **fields: Any
) -> dict[str, Any]:
    return {"position": tuple(position), "velocity": tuple(velocity), **fields}


def result_of(scene: Scene, **fields: Any) -> Result:
    """Return the result of an engine in which no ball moves."""
    defaults = {
        "engine": "toy",
        "settings": {},
        "scene": scene,
        "status": Status.REST,
        "final_state": initial_state(scene),
        "rest_time": 0.0,
        "collision_counts": {},
        "work": {},
        "wall_time": 0.0,
    }
    return Result(**{**defaults, **fields})


def scene_of(
    *balls: dict[str, Any],
    table: Table | None = None,
    t_max: float | None = None,
    **physics: Any,
) -> Scene:
    """Return a scene with these balls; balls without an id get the ids b0, b1, ..."""
    return Scene(
        name="test",
        balls=[Ball(**{"id": f"b{i}", **fields}) for i, fields in enumerate(balls)],
        table=table,
        t_max=t_max,
        physics=Physics(**physics),
    )


def random_shot(
    seed: int,
    n: int,
    *,
    table: Table | None = POOL_TABLE,
    t_max: float | None = None,
    **physics: Any,
) -> Scene:
    """Return n balls at random positions; at least one ball moves, with up to 3 m/s.

    Every second seed has only pool balls; the other seeds have mixed radii and masses.
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
    return scene_of(*balls, table=table, t_max=t_max, **physics)


def rack(n: int, apex: tuple[float, float], gap: float) -> list[dict[str, Any]]:
    """Return n balls in a triangle that opens along +x, with gaps of `gap` [m]."""
    spacing = 2 * R + gap
    balls: list[dict[str, Any]] = []
    row = 0
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
    speed = 10 ** chance.uniform(0.0, 1.0)  # a slower ball wouldn't reach the rack
    aim = chance.uniform(-0.02, 0.02)
    # Rows of equally spaced balls may overlap by rounding; 1e-15 m prevents this.
    return scene_of(
        ball((0.6, 0.635), (speed * math.cos(aim), speed * math.sin(aim))),
        *rack(n - 1, (1.9, 0.635), gap + 1e-15),
        table=POOL_TABLE,
        ball_restitution=e,
        **physics,
    )


def random_cloth_shot(seed: int, n: int | None = None) -> Scene:
    """Return a random shot of n balls (2 to 5) with all kinds of motion on the cloth.

    Balls slide or roll, with spin about any axis; a third of the balls have their own cloth
    friction. Radii are within a quarter of a pool ball's radius, so that one nose height is
    suitable for all balls. In three of four shots, the first ball is aimed at another ball.
    """
    chance = random.Random(f"cloth {seed}")
    n = chance.randint(2, 5) if n is None else n
    small = Table(length=0.9, width=0.7)
    table = chance.choice((POOL_TABLE, small, small, None))
    physics = _random_physics(chance)
    alike = chance.random() < 0.5
    balls: list[dict[str, Any]] = []
    while len(balls) < n:
        one = _random_place(chance, alike, table or small)
        if all(_apart(one, other) > 0.01 * one["radius"] for other in balls):
            balls.append(one)
    for i, one in enumerate(balls):
        target = chance.choice(balls[1:]) if i == 0 and chance.random() < 0.75 else None
        one.update(_random_motion(chance, one, target, always=i == 0))
        if chance.random() < 1 / 3:
            one["rolling_friction"] = chance.uniform(0.005, 0.03)
            one["sliding_friction"] = chance.uniform(0.1, 0.5)
            one["spinning_friction_rate"] = chance.uniform(2.0, 20.0)
    return scene_of(*balls, table=table, **physics)


def _random_physics(chance: random.Random) -> dict[str, Any]:
    """Return coefficients and laws; in one of six shots, the cloth lacks one kind of friction.

    A cloth without sliding friction isn't combined with mirror cushions: after two of them, a
    rolling ball would roll again except for rounding, and slide forever because of rounding.
    """
    frictions = ("rolling_friction", "sliding_friction", "spinning_friction_rate")
    without = chance.choice(frictions) if chance.random() < 1 / 6 else None
    cushions = ("restitution", "frictional", "han2005", "han2005", "mirror")
    cushion = chance.choice(cushions[:4] if without == "sliding_friction" else cushions)
    physics: dict[str, Any] = {
        "motion": "sliding",
        "rolling_friction": chance.uniform(0.005, 0.02),
        "sliding_friction": chance.uniform(0.15, 0.4),
        "spinning_friction_rate": chance.uniform(5.0, 15.0),
        "ball_restitution": chance.choice((1.0, chance.uniform(0.85, 0.99))),
        "ball_friction": chance.choice((0.0, "alciatore", chance.uniform(0.01, 0.2))),
        "cushion": cushion,
    }
    if cushion != "mirror":
        physics["cushion_restitution"] = chance.uniform(0.6, 0.95)
    if cushion == "restitution":
        physics["cushion_tangential_restitution"] = chance.uniform(0.7, 1.0)
    if cushion in ("frictional", "han2005"):
        physics["cushion_friction"] = chance.uniform(0.05, 0.4)
    if cushion == "han2005":
        physics["cushion_height"] = chance.uniform(1.0, 1.4) * R
    if without is not None:
        physics[without] = 0.0
        physics["t_max"] = chance.uniform(0.5, 2.0)
    return physics


def _random_place(chance: random.Random, alike: bool, table: Table) -> dict[str, Any]:
    radius = R if alike else chance.uniform(0.8, 1.25) * R
    mass = 0.170097 if alike else 0.170097 * chance.uniform(0.5, 2.0)
    place = (
        chance.uniform(1.01 * radius, table.length - 1.01 * radius),
        chance.uniform(1.01 * radius, table.width - 1.01 * radius),
    )
    return ball(place, radius=radius, mass=mass)


def _apart(one: dict[str, Any], other: dict[str, Any]) -> float:
    """Return the gap between two balls [m]."""
    reach: float = one["radius"] + other["radius"]
    return math.dist(one["position"], other["position"]) - reach


def _random_motion(
    chance: random.Random, one: dict[str, Any], target: dict[str, Any] | None, always: bool
) -> dict[str, Any]:
    """Return velocity and spin of a ball: at rest, or up to 3 m/s, towards the target if given.

    Two of five balls have no given angular velocity: they roll, or rest.
    """
    fields: dict[str, Any] = {}
    if always or chance.random() < 0.4:
        speed, angle = chance.uniform(0.2, 3.0), chance.uniform(0.0, 2 * math.pi)
        if target is not None:
            (x, y), (to_x, to_y) = one["position"], target["position"]
            width = (one["radius"] + target["radius"]) / math.dist((x, y), (to_x, to_y))
            angle = math.atan2(to_y - y, to_x - x) + chance.uniform(-width, width)
        fields["velocity"] = (speed * math.cos(angle), speed * math.sin(angle))
    if chance.random() < 0.6:
        fields["angular_velocity"] = tuple(chance.uniform(-80.0, 80.0) for _ in range(3))
    return fields

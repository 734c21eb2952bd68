"""Random small shots, each from its number alone: of all physics that can be certified."""

from __future__ import annotations

import math
import random
from typing import Any

from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Scene, Table

TABLES = (
    None,
    Table(length=2.54, width=1.27),
    Table(length=0.8, width=0.5),
    Table(length=1.2, width=0.6, cushions=("left", "top")),
)
"""Unbounded, a pool table, one so small that there are many collisions, one that is partly open."""

MOST_BALLS = 6

FASTEST = 5.0
"""Speed of the fastest ball at the start [m/s]."""

_ELASTIC_PATH = 6.0
"""Way of the fastest ball where nothing slows it [m]: some tens of collisions."""


def random_shot(number: int) -> Scene:
    """Return the shot of this number: the same on every machine, and in every process.

    One to six balls, equal or of mixed radii and masses, at random places; at least one of them
    moves, from a crawl to a hard shot, half of the time straight at another ball, with any spin.
    Everything is drawn anew for each shot: the way of moving, the laws of impacts with their
    coefficients, the table and its cushions.
    """
    # The seed is text, whose hash is the same everywhere.
    chance = random.Random(f"ghostball shot {number}")
    table = chance.choice(TABLES)
    balls = _balls(chance, table)
    slides = chance.random() < 0.7
    least = min(ball["radius"] for ball in balls)
    physics = _physics(chance, slides, least, has_cushions=table is not None, alone=len(balls) == 1)
    fastest = _set_off(chance, balls, spun=slides)
    endless = physics["rolling_friction"] == 0.0
    return Scene(
        name=f"shot-{number}",
        title=f"Random shot {number}",
        table=table,
        t_max=_ELASTIC_PATH / fastest if endless else None,
        physics=Physics(**physics),
        balls=[Ball(id=f"b{i}", **ball) for i, ball in enumerate(balls)],
    )


def _balls(chance: random.Random, table: Table | None) -> list[dict[str, Any]]:
    """Return balls at rest that don't touch each other or a cushion."""
    length, width = (1.0, 0.6) if table is None else (table.length, table.width)
    equal = chance.random() < 0.5
    balls: list[dict[str, Any]] = []
    wanted = chance.randint(1, MOST_BALLS)
    while len(balls) < wanted:
        radius = POOL_BALL_RADIUS if equal else POOL_BALL_RADIUS * chance.uniform(0.6, 1.6)
        place = tuple(
            chance.uniform(1.01 * radius, side - 1.01 * radius) for side in (length, width)
        )
        if any(
            math.dist(place, other["position"]) < 1.01 * (radius + other["radius"])
            for other in balls
        ):
            continue
        ball: dict[str, Any] = {"position": place, "radius": radius}
        if not equal:
            ball["mass"] = 0.17 * 10.0 ** chance.uniform(-0.7, 0.7)
        balls.append(ball)
    return balls


def _physics(
    chance: random.Random, slides: bool, least: float, *, has_cushions: bool, alone: bool
) -> dict[str, Any]:
    """Return the physics; `least` is the radius of the smallest ball [m]."""
    physics: dict[str, Any] = {
        "motion": "sliding" if slides else "rolling",
        "rolling_friction": chance.choice((0.0, 0.005, 0.02, chance.uniform(0.003, 0.1))),
        "impacts": chance.choice(("simultaneous", "sequential")),
        "ball_restitution": chance.choice((1.0, 0.95, 0.0, chance.uniform(0.3, 1.0))),
    }
    if slides:
        physics["sliding_friction"] = chance.uniform(0.1, 0.5)
        physics["spinning_friction_rate"] = chance.choice((0.0, chance.uniform(2.0, 30.0)))
        friction: Any = chance.choice((0.0, "alciatore", chance.uniform(0.01, 0.3)))
        physics["ball_friction"] = 0.0 if alone else friction
    if not has_cushions:
        return physics
    laws = ["mirror", "restitution"] + (["frictional", "han2005"] if slides else [])
    law = physics["cushion"] = chance.choice(laws)
    physics |= cushion_constants(chance, law)
    if law == "han2005":
        physics["cushion_height"] = least * chance.uniform(1.0, 1.4)
    return physics


def cushion_constants(chance: random.Random, law: str) -> dict[str, float]:
    """Return the constants that a law of cushions has, but for the height of the nose."""
    constants: dict[str, float] = {}
    if law != "mirror":
        constants["cushion_restitution"] = chance.uniform(0.3, 1.0)
    if law == "restitution":
        constants["cushion_tangential_restitution"] = chance.uniform(0.3, 1.0)
    if law in ("frictional", "han2005"):
        constants["cushion_friction"] = chance.uniform(0.0, 0.4)
    return constants


def _set_off(chance: random.Random, balls: list[dict[str, Any]], *, spun: bool) -> float:
    """Give one ball or several their motion; return the fastest speed [m/s]."""
    movers = chance.sample(range(len(balls)), k=chance.randint(1, min(3, len(balls))))
    fastest = 0.0
    for k in movers:
        speed = FASTEST * 10.0 ** chance.uniform(-1.7, 0.0)
        direction = chance.uniform(-math.pi, math.pi)
        others = [ball for ball in balls if ball is not balls[k]]
        if others and chance.random() < 0.5:
            aim = chance.choice(others)
            dx, dy = (b - a for a, b in zip(balls[k]["position"], aim["position"], strict=True))
            # Up to a graze on either side.
            reach = (aim["radius"] + balls[k]["radius"]) / math.hypot(dx, dy)
            direction = math.atan2(dy, dx) + math.asin(reach) * chance.uniform(-1.0, 1.0)
        balls[k]["velocity"] = (speed * math.cos(direction), speed * math.sin(direction))
        if spun and chance.random() < 0.7:
            balls[k]["angular_velocity"] = tuple(
                chance.uniform(-2.0, 2.0) * speed / balls[k]["radius"] for _ in "xyz"
            )
        fastest = max(fastest, speed)
    return fastest

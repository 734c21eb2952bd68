"""Random shots in which balls fly, each from its number alone: jumps, drops, breaks."""

from __future__ import annotations

import math
import random
from typing import Any

from ghostball.model import POOL_BALL_RADIUS, Ball, Physics, Scene, Table
from ghostball.validation.scenes.random_shots import cushion_constants

TABLE = Table(length=2.54, width=1.27)

_APEX = 1.8
_CUE = 0.6
"""Where the first racked ball and the cue ball lie along the table [m]."""


def random_jump(number: int) -> Scene:
    """Return the shot of this number: the same in every process, and where sin and cos are.

    In one of five a rack of 6 to 15 balls is broken by a ball that comes with up to 12 m/s and may
    rise. Else 1 to 7 balls lie anywhere or hang above the cloth, some of them exactly above others;
    1 to 3 of them are sent off, many at another ball, in two of five mixed in size and mass.
    """
    # The seed is text, whose hash is the same everywhere.
    chance = random.Random(f"ghostball jump {number}")
    kind = chance.choice(("jump", "jump", "drop", "drop", "break"))
    mixed = kind != "break" and chance.random() < 0.4
    balls = _break(chance) if kind == "break" else _scattered(chance, mixed, dropped=kind == "drop")
    lowest = min(ball["radius"] for ball in balls)
    physics = _physics(chance)
    physics["cushion_height"] = chance.uniform(1.0, 1.9 if mixed else 1.4) * lowest
    return Scene(
        name=f"jump-{number}",
        title=f"Random shot with flight {number}",
        table=TABLE,
        physics=Physics(**physics),
        balls=[Ball(id=f"b{i}", **ball) for i, ball in enumerate(balls)],
    )


def _break(chance: random.Random) -> list[dict[str, Any]]:
    """Return racked balls, and one that comes in."""
    radius, middle = POOL_BALL_RADIUS, TABLE.width / 2.0
    spacing = 2.0 * radius * (1.0 + 1e-12) + chance.choice((0.0, 1e-4, 1e-3))
    balls: list[dict[str, Any]] = []
    for row in range(chance.choice((3, 4, 5))):
        for place in range(row + 1):
            x = _APEX + row * spacing * math.sqrt(0.75)
            y = middle + (place - row / 2.0) * spacing
            balls.append({"radius": radius, "position": (x, y, radius)})
    speed, rising = chance.uniform(3.0, 12.0), chance.uniform(0.0, 0.15)
    aside = chance.choice((0.0, chance.uniform(-0.02, 0.02)))
    turns = [chance.uniform(-1.0, 1.0) * speed / radius for _ in range(2)]
    balls.append(
        {
            "radius": radius,
            "position": (_CUE, middle + aside, radius),
            "velocity": (speed * math.cos(rising), 0.0, speed * math.sin(rising)),
            "angular_velocity": (0.0, *turns),
        }
    )
    return balls


def _scattered(chance: random.Random, mixed: bool, *, dropped: bool) -> list[dict[str, Any]]:
    """Return balls that lie anywhere or hang in the air, some of them sent off."""
    balls: list[dict[str, Any]] = []
    for _ in range(chance.randint(1, 6)):
        ball = _ball(chance, mixed)
        for _ in range(50):
            if not dropped or chance.random() < 0.4:
                height = ball["radius"]
            else:
                height = ball["radius"] + chance.uniform(0.0, 0.3)
            ball["position"] = (*_place(chance, ball["radius"]), height)
            if _has_room(ball, balls):
                balls.append(ball)
                break
    if dropped and chance.random() < 0.6:
        below, ball = balls[0], _ball(chance, mixed)
        reach = below["radius"] + ball["radius"]
        x, y = (
            below["position"][k] + chance.choice((0.0, chance.uniform(-1.0, 1.0))) * ball["radius"]
            for k in range(2)
        )
        x = min(max(x, 1.05 * ball["radius"]), TABLE.length - 1.05 * ball["radius"])
        y = min(max(y, 1.05 * ball["radius"]), TABLE.width - 1.05 * ball["radius"])
        ball["position"] = (x, y, below["position"][2] + reach + chance.uniform(0.0, 0.2))
        if _has_room(ball, balls):
            balls.append(ball)
    for ball in chance.sample(balls, chance.randint(1, min(3, len(balls)))):
        _send_off(chance, ball, [other for other in balls if other is not ball])
    return balls


def _ball(chance: random.Random, mixed: bool) -> dict[str, Any]:
    if not mixed:
        return {"radius": POOL_BALL_RADIUS}
    return {
        "radius": POOL_BALL_RADIUS * chance.uniform(0.7, 1.4),
        "mass": 0.17 * 10.0 ** chance.uniform(-0.5, 0.5),
    }


def _place(chance: random.Random, radius: float) -> tuple[float, float]:
    x = chance.uniform(1.05 * radius, TABLE.length - 1.05 * radius)
    return x, chance.uniform(1.05 * radius, TABLE.width - 1.05 * radius)


def _has_room(ball: dict[str, Any], balls: list[dict[str, Any]]) -> bool:
    return all(
        math.dist(ball["position"], other["position"]) > ball["radius"] + other["radius"] + 1e-9
        for other in balls
    )


def _send_off(chance: random.Random, ball: dict[str, Any], others: list[dict[str, Any]]) -> None:
    speed, aim = 10.0 ** chance.uniform(-1.0, 0.85), chance.uniform(-math.pi, math.pi)
    rising = chance.choice((0.0, chance.uniform(0.0, 1.2)))
    (x, y, z), radius = ball["position"], ball["radius"]
    if others and chance.random() < 0.6:
        to_x, to_y, _ = chance.choice(others)["position"]
        aim = math.atan2(to_y - y, to_x - x) + chance.choice((0.0, chance.uniform(-0.03, 0.03)))
    up = speed * math.sin(rising)
    if z > radius and chance.random() < 0.4:
        up = -up
    level = speed * math.cos(rising)
    ball["velocity"] = (level * math.cos(aim), level * math.sin(aim), up)
    ball["angular_velocity"] = tuple(chance.uniform(-1.5, 1.5) * speed / radius for _ in range(3))


def _physics(chance: random.Random) -> dict[str, Any]:
    """Return coefficients and laws; all that are drawn let every ball come to rest."""
    law = chance.choice(("mirror", "restitution", "frictional", "han2005"))
    physics: dict[str, Any] = {
        "motion": "sliding",
        "airborne": True,
        "table_restitution": chance.choice((0.5, 0.0, 0.9, chance.uniform(0.0, 0.99))),
        "sliding_friction": chance.uniform(0.05, 0.5),
        "rolling_friction": chance.choice((0.01, chance.uniform(0.003, 0.1))),
        "spinning_friction_rate": chance.choice((10.0, chance.uniform(2.0, 30.0))),
        "ball_restitution": chance.choice((0.95, 1.0, 0.0, chance.uniform(0.0, 1.0))),
        "ball_friction": chance.choice((0.06, 0.0, chance.uniform(0.0, 0.3), "alciatore")),
        "cushion": law,
        "impacts": chance.choice(("simultaneous", "sequential")),
    }
    return physics | cushion_constants(chance, law)

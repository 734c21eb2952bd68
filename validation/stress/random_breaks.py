"""Random breaks, each from its number alone: many-ball shots, the cloth's whole physics."""

from __future__ import annotations

import math
import random
from typing import Any

from ghostball.model import POOL_BALL_MASS, POOL_BALL_RADIUS, Ball, Physics, Scene, Table

TABLE = Table(length=2.54, width=1.27)

MOST_BALLS = 16

SLOWEST, FASTEST = 0.3, 20.0
"""Speed of the cue ball, log-uniform [m/s]: from too slow to reach the rack to twice the hardest
break."""

NARROWEST, WIDEST = 1e-9, 1e-2
"""Gap between racked balls, log-uniform [m]. Every fourth rack has none: its balls touch."""

_CUE, _APEX = 0.6, 1.9
"""Where the cue ball and the first racked ball lie along the table [m]."""


def random_break(number: int) -> Scene:
    """Return the break of this number: the same in every process, and where sin, cos and exp are.

    2 to 16 balls on a pool table without pockets: in three breaks of four they are racked, as many
    as there are, else they lie anywhere. The cue ball is up to a ball's radius off the middle, its
    spin is up to 1.25 times that of rolling, about each axis. In one break of five radii (within a
    fifth) and masses (within a factor of 4) are mixed. Everything is drawn anew for each break: the
    way of moving, the laws of impacts with their coefficients, how impacts at one instant are
    resolved, all frictions.
    """
    # The seed is text, whose hash is the same everywhere.
    chance = random.Random(f"ghostball break {number}")
    count = chance.randint(2, MOST_BALLS)
    mixed = chance.random() < 0.2
    balls = [_ball(chance, mixed) for _ in range(count)]
    cue, *others = balls
    cue["position"] = (_CUE, TABLE.width / 2.0 + chance.uniform(-1.0, 1.0) * POOL_BALL_RADIUS)
    if chance.random() < 0.75:
        _rack(chance, others)
    else:
        _scatter(chance, cue, others)
    slides = chance.random() < 0.75
    _strike(chance, cue, others, spun=slides)
    return Scene(
        name=f"break-{number}",
        title=f"Random break {number}",
        table=TABLE,
        physics=Physics(**_physics(chance, slides)),
        balls=[Ball(id=f"b{i}", **ball) for i, ball in enumerate(balls)],
    )


def _ball(chance: random.Random, mixed: bool) -> dict[str, Any]:
    if not mixed:
        return {"radius": POOL_BALL_RADIUS}
    return {
        "radius": POOL_BALL_RADIUS * chance.uniform(0.8, 1.2),
        "mass": POOL_BALL_MASS * 4.0 ** chance.uniform(-1.0, 1.0),
    }


def _rack(chance: random.Random, balls: list[dict[str, Any]]) -> None:
    """Place balls in a triangle that opens along +x; mixed ones as if all were the largest."""
    gap = 0.0
    if chance.random() >= 0.25:
        gap = math.exp(chance.uniform(math.log(NARROWEST), math.log(WIDEST)))
    spacing = 2.0 * max(ball["radius"] for ball in balls) + gap
    row, place = 0, 0
    for ball in balls:
        x = _APEX + row * spacing * math.sqrt(0.75)
        ball["position"] = (x, TABLE.width / 2.0 + (place - row / 2.0) * spacing)
        row, place = (row, place + 1) if place < row else (row + 1, 0)


def _scatter(chance: random.Random, cue: dict[str, Any], balls: list[dict[str, Any]]) -> None:
    """Place balls anywhere, at least a hundredth of a radius apart."""
    placed = [cue]
    for ball in balls:
        radius = ball["radius"]
        while True:
            place = tuple(
                chance.uniform(1.01 * radius, side - 1.01 * radius)
                for side in (TABLE.length, TABLE.width)
            )
            if all(
                math.dist(place, other["position"]) > radius + other["radius"] + 0.01 * radius
                for other in placed
            ):
                break
        ball["position"] = place
        placed.append(ball)


def _strike(
    chance: random.Random, cue: dict[str, Any], others: list[dict[str, Any]], *, spun: bool
) -> None:
    """Send the cue ball towards the first of the others."""
    speed = math.exp(chance.uniform(math.log(SLOWEST), math.log(FASTEST)))
    (x, y), (to_x, to_y) = cue["position"], others[0]["position"]
    aim = math.atan2(to_y - y, to_x - x) + chance.uniform(-0.01, 0.01)
    velocity = cue["velocity"] = (speed * math.cos(aim), speed * math.sin(aim))
    if spun and chance.random() < 0.8:
        radius = cue["radius"]
        top, side = chance.uniform(-1.25, 1.25), chance.uniform(-1.25, 1.25)
        cue["angular_velocity"] = (
            top * -velocity[1] / radius,
            top * velocity[0] / radius,
            side * speed / radius,
        )


def _physics(chance: random.Random, slides: bool) -> dict[str, Any]:
    """Return coefficients and laws; all that are drawn let every ball come to rest."""
    physics: dict[str, Any] = {
        "motion": "sliding" if slides else "rolling",
        "rolling_friction": chance.choice((0.005, 0.01, 0.02, chance.uniform(0.003, 0.1))),
        "impacts": chance.choice(("simultaneous", "sequential")),
        "ball_restitution": chance.choice((1.0, 0.98, 0.95, 0.9, chance.uniform(0.0, 1.0))),
    }
    laws = ["mirror", "restitution"]
    if slides:
        laws += ["frictional", "han2005", "mathavan2010"]
        physics["sliding_friction"] = chance.choice((0.2, chance.uniform(0.1, 0.5)))
        physics["spinning_friction_rate"] = chance.uniform(2.0, 30.0)
        physics["ball_impact"] = chance.choice(("frictional", "mathavan2014"))
        physics["ball_friction"] = chance.choice((0.0, 0.06, "alciatore", chance.uniform(0.0, 0.3)))
    law = physics["cushion"] = chance.choice(laws)
    if law != "mirror":
        physics["cushion_restitution"] = chance.choice((0.85, 0.98, chance.uniform(0.3, 1.0)))
    if law == "restitution":
        physics["cushion_tangential_restitution"] = chance.uniform(0.3, 1.0)
    elif law in ("frictional", "han2005", "mathavan2010"):
        physics["cushion_friction"] = chance.choice((0.14, 0.2, chance.uniform(0.0, 0.4)))
    return physics

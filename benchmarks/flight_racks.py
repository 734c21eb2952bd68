"""Random shots in flight onto frozen racks: what lies on what it hit asks for the most work.

Drops and jumps onto triangles, rows, and racks frozen to a rail or into a corner; all laws and
coefficients that let every ball come to rest. Counted and timed one after the other.
"""

from __future__ import annotations

import math
import random
from typing import Any, NamedTuple

from benchmarks.scenes import POOL_TABLE
from ghostball.engine import Ball, Physics, Scene, simulate
from ghostball.engine.scene import POOL_BALL_RADIUS
from ghostball.validation.scenes.random_shots import cushion_constants

FLIGHTS = 535
"""Shots of a whole measurement."""

MOST_EVENTS = 200_000

_R = POOL_BALL_RADIUS
_NOSE = Physics(preset="pool").cushion_height
_REACH = math.sqrt(_NOSE * (2.0 * _R - _NOSE))
"""How far from a cushion a ball on the cloth touches its nose [m]."""

Place = tuple[float, float]


class Flight(NamedTuple):
    """What one shot took: the least time of its rounds [ms], and how much work."""

    name: str
    milliseconds: float
    events: int
    contact_steps: int
    joint_impacts: int
    status: str


def flight_rack(number: int) -> Scene:
    """Return the shot of this number, the same in every process."""
    chance = random.Random(f"flight rack {number}")
    kind, places = _frozen(chance)
    at = chance.choice(places)
    if chance.random() < 0.5:
        what = "drop"
        x, y = (at[k] + chance.uniform(-1.2, 1.2) * _R for k in range(2))
        x = min(max(x, 1.05 * _R), POOL_TABLE.length - 1.05 * _R)
        y = min(max(y, 1.05 * _R), POOL_TABLE.width - 1.05 * _R)
        position = (x, y, 3.0 * _R + chance.uniform(0.001, 0.3))
        velocity = (chance.uniform(-1.0, 1.0), chance.uniform(-1.0, 1.0), 0.0)
        if chance.random() < 0.3:
            velocity = (0.0, 0.0, 0.0)
    else:
        what = "jump"
        turn, (x, y) = _start(chance, at, places)
        speed = chance.uniform(1.0, 7.0)
        rises = chance.choice((0.0, chance.uniform(0.0, 0.6)))
        aim = turn + math.pi + chance.uniform(-0.05, 0.05)
        level = speed * math.cos(rises)
        position = (x, y, _R)
        velocity = (level * math.cos(aim), level * math.sin(aim), speed * math.sin(rises))
    spin = tuple(chance.uniform(-1.0, 1.0) * 50.0 for _ in range(3))
    cue = Ball(id="cue", position=position, velocity=velocity, angular_velocity=spin)
    return Scene(
        name=f"{kind}-{what}-{number}",
        table=POOL_TABLE,
        physics=Physics(**_physics(chance)),
        balls=[*(Ball(id=f"b{k}", position=place) for k, place in enumerate(places)), cue],
    )


def _start(chance: random.Random, at: Place, places: list[Place]) -> tuple[float, Place]:
    """Return from which direction the ball comes that jumps at `at` [rad], and from where."""
    while True:
        turn = chance.uniform(-math.pi, math.pi)
        away = chance.uniform(0.15, 1.0)
        x, y = at[0] + away * math.cos(turn), at[1] + away * math.sin(turn)
        inside = 1.1 * _R < x < POOL_TABLE.length - 1.1 * _R
        inside = inside and 1.1 * _R < y < POOL_TABLE.width - 1.1 * _R
        if inside and all(math.dist((x, y), place) > 2.1 * _R for place in places):
            return turn, (x, y)


def _frozen(chance: random.Random) -> tuple[str, list[Place]]:
    """Return balls that touch each other, and cushions."""
    kind = chance.choice(("triangle", "rail", "corner", "row"))
    side, deep = 2.0 * _R, math.sqrt(0.75) * 2.0 * _R
    if kind == "triangle":
        rows = chance.choice((2, 3, 4, 5))
        turn = chance.uniform(-math.pi, math.pi)
        c, s = math.cos(turn), math.sin(turn)
        ways = [(r * deep - 0.1, (p - r / 2.0) * side) for r in range(rows) for p in range(r + 1)]
        return kind, [(1.7 + c * x - s * y, 0.635 + s * x + c * y) for x, y in ways]
    if kind == "row":
        count, turn = chance.randint(2, 6), chance.uniform(-math.pi, math.pi)
        c, s = math.cos(turn), math.sin(turn)
        return kind, [(1.6 + k * side * c, 0.635 + k * side * s) for k in range(count)]
    count = chance.randint(1, 6)
    first = _REACH if kind == "corner" else 0.8
    places = [(first + k * side, _REACH) for k in range(count)]
    if chance.random() < 0.6:
        behind = range(max(count - 1, 1))
        places += [(first + (k + 0.5) * side, _REACH + deep) for k in behind]
    if kind == "corner" and chance.random() < 0.5:
        more = (_REACH, _REACH + side)
        if all(math.dist(place, more) >= side * (1.0 - 1e-12) for place in places):
            places.append(more)
    return kind, places


def _physics(chance: random.Random) -> dict[str, Any]:
    law = chance.choice(("mirror", "restitution", "frictional", "han2005"))
    physics: dict[str, Any] = {
        "motion": "sliding",
        "airborne": True,
        "table_restitution": chance.choice((0.5, 0.0, 0.9, chance.uniform(0.0, 0.95))),
        "sliding_friction": chance.uniform(0.05, 0.5),
        "rolling_friction": chance.choice((0.01, chance.uniform(0.003, 0.1))),
        "spinning_friction_rate": chance.choice((10.0, chance.uniform(2.0, 30.0))),
        "ball_restitution": chance.choice((0.95, 1.0, 0.0, chance.uniform(0.0, 1.0))),
        "ball_friction": chance.choice((0.06, 0.0, chance.uniform(0.0, 0.3), "alciatore")),
        "cushion": law,
        "cushion_height": _NOSE,
        "impacts": chance.choice(("simultaneous", "sequential")),
    }
    return physics | cushion_constants(chance, law)


def measure_flights(count: int, rounds: int) -> list[Flight]:
    """Play the first `count` shots, each `rounds` times, and return what each took."""
    flights = []
    for number in range(count):
        scene = flight_rack(number)
        results = [simulate(scene, max_events=MOST_EVENTS) for _ in range(rounds)]
        work = results[0].work
        flights.append(
            Flight(
                scene.name,
                1e3 * min(result.wall_time for result in results),
                work["events"],
                work["contact_steps"],
                work["joint_impacts"],
                results[0].status.name,
            )
        )
    return flights


def told(flights: list[Flight]) -> str:
    """Return what is said of them: means, the slowest, and those that didn't come to rest."""
    times = [flight.milliseconds for flight in flights]
    early = sum(flight.status != "REST" for flight in flights)
    mean = sum(times) / len(times)
    lines = [
        f"{len(flights)} shots: mean {mean:.2f} ms, slowest {max(times):.1f} ms, "
        f"{sum(flight.events for flight in flights)} events, "
        f"{sum(flight.contact_steps for flight in flights)} contact steps, "
        f"{sum(flight.joint_impacts for flight in flights)} joint impacts, {early} not to rest"
    ]
    for flight in sorted(flights, key=lambda flight: -flight.milliseconds)[:10]:
        lines.append(
            f"  {flight.name:20s} {flight.milliseconds:8.1f} ms {flight.events:6d} events "
            f"{flight.contact_steps:6d} contact steps {flight.joint_impacts:4d} joint impacts "
            f"{flight.status}"
        )
    return "\n".join(lines)

"""A scene mirrored, turned, scaled, relabelled: what the same physics must answer alike."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from invariants import collisions

from ghostball.engine import Ball, EventKind, Result, Scene, Table, simulate

Plane = Callable[[float, float], tuple[float, float]]
"""A map of the plane onto itself that takes the axes onto the axes."""

REFLECTIONS: dict[str, Plane] = {
    "left-right": lambda x, y: (-x, y),
    "up-down": lambda x, y: (x, -y),
    "diagonal": lambda x, y: (y, x),
}
ROTATIONS: dict[str, Plane] = {
    "quarter turn": lambda x, y: (-y, x),
    "half turn": lambda x, y: (-x, -y),
    "three quarters": lambda x, y: (y, -x),
}
MAPS = {**REFLECTIONS, **ROTATIONS}


def with_balls(scene: Scene, balls: Iterable[Ball], **update: object) -> Scene:
    """Return the scene with other balls, and whatever else is to change."""
    fields = {name: getattr(scene, name) for name in ("name", "physics", "table", "t_max")}
    return Scene(**{**fields, "balls": tuple(balls), **update})


def changed(one: Ball, **update: object) -> Ball:
    """Return the ball with other fields."""
    return Ball(**{**one.model_dump(exclude_none=True), **update})


def spin_under(name: str, spin: Sequence[float]) -> tuple[float, float, float]:
    """Return the angular velocity under a map: an axial vector, so a reflection turns its sign."""
    sign = -1.0 if name in REFLECTIONS else 1.0
    wx, wy = MAPS[name](spin[0], spin[1])
    return (sign * wx, sign * wy, sign * spin[2])


def image(scene: Scene, name: str) -> Scene:
    """Return the scene under the map of that name; without a table."""
    assert scene.table is None
    return with_balls(scene, [image_of_ball(one, name) for one in scene.balls])


def image_of_ball(one: Ball, name: str) -> Ball:
    """Return one ball under the map of that name."""
    plane = MAPS[name]
    spin = (
        {}
        if one.angular_velocity is None
        else {"angular_velocity": spin_under(name, one.angular_velocity)}
    )
    return changed(
        one, position=plane(*one.position[:2]), velocity=plane(*one.velocity[:2]), **spin
    )


def scaled(scene: Scene, k: int) -> Scene:
    """Return the scene with lengths times 4^k and speeds and times times 2^k; gravity stays.

    Froude's scaling: a = mu g stays. An angular velocity is a speed over a length, times 2^-k, and
    loses that in a time: the rate of the spin's decay goes with 4^-k.
    """
    length, velocity = 4.0**k, 2.0**k
    balls = []
    for one in scene.balls:
        fields: dict[str, object] = {
            "position": [length * c for c in one.position[:2]],
            "velocity": [velocity * c for c in one.velocity[:2]],
            "radius": length * one.radius,
        }
        if one.angular_velocity is not None:
            fields["angular_velocity"] = [c / velocity for c in one.angular_velocity]
        if one.spinning_friction_rate is not None:
            fields["spinning_friction_rate"] = one.spinning_friction_rate / length
        balls.append(changed(one, **fields))
    physics = scene.physics
    update = {"spinning_friction_rate": physics.spinning_friction_rate / length}
    if physics.cushion in ("han2005", "mathavan2010"):
        update["cushion_height"] = length * physics.cushion_height
    physics = physics.model_copy(update=update)
    table = scene.table
    if table is not None:
        table = Table(
            length=length * table.length, width=length * table.width, cushions=table.cushions
        )
    t_max = None if scene.t_max is None else velocity * scene.t_max
    return with_balls(scene, balls, table=table, physics=physics, t_max=t_max)


def shuffled(scene: Scene, order: Sequence[int]) -> Scene:
    """Return the scene whose ball k is ball order[k]."""
    return with_balls(scene, [scene.balls[i] for i in order])


def same_log(base: Result, other: Result, order: Sequence[int]) -> bool:
    """Whether `other`, whose ball k is ball order[k] of `base`, has the same events to the bit."""
    assert base.events is not None
    assert other.events is not None

    def row(event: np.void, name: Callable[[int], int]) -> tuple[str, int, int, int]:
        kind, a, b = int(event["kind"]), name(int(event["a"])), int(event["b"])
        if kind == EventKind.BALL_BALL:
            a, b = sorted((a, name(b)))
        return float(event["t"]).hex(), kind, a, b

    return sorted(row(event, int) for event in base.events) == sorted(
        row(event, lambda i: order[i]) for event in other.events
    )


def sensitivity(scene: Scene) -> float:
    """Measure how much the end of a run moves per relative change of its start; at least 1.

    A nudge of 1e-10 is far above rounding; where the events themselves change, the answer is inf.
    """
    chance = random.Random(0)

    def nudged(vector: Sequence[float]) -> list[float]:
        scale = 1e-10 * max(map(abs, vector))
        return [component + scale * chance.uniform(-1, 1) for component in vector]

    base = simulate(scene, record="events")
    balls = []
    for one in scene.balls:
        update: dict[str, object] = {
            "position": nudged(one.position[:2]),
            "velocity": nudged(one.velocity[:2]),
        }
        if one.angular_velocity is not None:
            update["angular_velocity"] = nudged(one.angular_velocity)
        balls.append(changed(one, **update))
    other = simulate(with_balls(scene, balls), record="events")
    if collisions(base) != collisions(other):
        return np.inf
    ends = [np.array(run.final_state[:2]) for run in (base, other)]
    return max(1.0, float(np.max(np.abs(ends[0] - ends[1]))) / 1e-10)

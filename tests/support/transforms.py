"""A scene mirrored, turned, scaled, relabelled: what the same physics must answer alike."""

from __future__ import annotations

import random
from collections.abc import Sequence

import numpy as np
from invariants import collisions

from ghostball.engine import Ball, Result, Scene, Table, simulate
from ghostball.validation.stress.same.images import MAPS, image, rows_of, shuffled, spin_under
from ghostball.validation.stress.same.plays import with_balls

__all__ = [
    "MAPS",
    "changed",
    "image",
    "same_log",
    "scaled",
    "sensitivity",
    "shuffled",
    "spin_under",
    "with_balls",
]


def changed(one: Ball, **update: object) -> Ball:
    """Return the ball with other fields."""
    return Ball(**{**one.model_dump(exclude_none=True), **update})


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


def same_log(base: Result, other: Result, order: Sequence[int]) -> bool:
    """Whether `other`, whose ball k is ball order[k] of `base`, has the same events to the bit."""
    return rows_of(base, range(len(order))) == rows_of(other, order)


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

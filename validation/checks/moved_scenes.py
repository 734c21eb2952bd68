"""Tables and balls that are turned, mirrored, shifted, boosted, or measured in other units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from ghostball.model import Ball, Table
from ghostball.model.arrays import FloatArray
from ghostball.model.scene.pockets import Pocket, Pockets
from ghostball.model.scene.sides import INWARD

SAME: Final = np.eye(3)
"""The map that turns nothing."""


def table_from(table: Table, turn: FloatArray, shift: FloatArray, unit: float = 1.0) -> Table:
    """Return a table that is turned or mirrored, shifted, and has a larger unit of length."""

    def place(point: Sequence[float]) -> tuple[float, float]:
        x, y, _ = (unit * (turn @ np.array([*point, 0.0])) + shift + 0.0).tolist()
        return x, y

    posts = tuple(
        post.model_copy(update={"centre": place(post.centre), "radius": unit * post.radius})
        for post in table.posts
    )
    if table.vertices:
        vertices = [place(point) for point in table.vertices]
        if np.linalg.det(turn) < 0.0:
            vertices.reverse()  # counterclockwise again
        return Table.model_validate({"vertices": tuple(vertices), "posts": posts})
    length, width, _ = (unit * np.abs(turn) @ np.array([table.length, table.width, 0.0])).tolist()
    names = {normal: name for name, normal in INWARD.items()}
    turned = [turn[:2, :2] @ np.array(INWARD[name]) + 0.0 for name in table.cushions]
    cushions = tuple(names[x, y] for x, y in (one.tolist() for one in turned))
    pockets = table.pockets
    if pockets is not None:
        sizes = [_larger(one, unit) for one in (pockets.corner, pockets.side)]
        pockets = Pockets(corner=sizes[0], side=sizes[1])
    return Table(length=length, width=width, cushions=cushions, pockets=pockets, posts=posts)


def _larger(pocket: Pocket | None, unit: float) -> Pocket | None:
    if pocket is None:
        return None
    lengths = ("mouth", "jaw_radius", "depth", "radius")
    return pocket.model_copy(update={name: unit * getattr(pocket, name) for name in lengths})


def moved(
    ball: Ball,
    *,
    turn: FloatArray = SAME,
    shift: FloatArray | None = None,
    speed: FloatArray | None = None,
    unit: float = 1.0,
    clock: float = 1.0,
    spin: Sequence[float] | None = None,
) -> Ball:
    """Return a ball in the second shot; see `RelatedShot`.

    `spin` [rad/s]: its angular velocity, if the velocity no longer determines it.
    """
    ball = ball.without_strike()
    spin = ball.angular_velocity if spin is None else spin
    place = unit * (turn @ np.array(ball.position)) + (0.0 if shift is None else shift)
    velocity = unit / clock * (turn @ np.array(ball.velocity)) + (0.0 if speed is None else speed)
    changed: dict[str, Any] = {
        "position": tuple((place + 0.0).tolist()),
        "velocity": tuple((velocity + 0.0).tolist()),
        "angular_velocity": None,
        # Stated, because the presets of the table and of the physics would give other values.
        "radius": unit * ball.radius,
        "mass": unit**3 * ball.mass,
    }
    if spin is not None:  # an axial vector: a mirror reverses it
        axis = np.linalg.det(turn) * (turn @ np.array(spin)) / clock
        changed["angular_velocity"] = tuple((axis + 0.0).tolist())
    if ball.spinning_friction_rate is not None:
        changed["spinning_friction_rate"] = ball.spinning_friction_rate / clock**2
    return ball.model_copy(update=changed)

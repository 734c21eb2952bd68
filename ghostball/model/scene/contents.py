"""The fields of a scene, each valid on its own, and the same values as arrays.

The rules between the fields take a `SceneContents`; a `Scene` has passed these rules.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.model.rounding import EPS
from ghostball.model.scene.ball import Ball, rolling_angular_velocity
from ghostball.model.scene.fields import Positive, SceneName, Text, whole_number
from ghostball.model.scene.part import ScenePart
from ghostball.model.scene.physics import Physics
from ghostball.model.scene.table import Table

ROLLING_ULPS = 4.0
"""Slip of a ball that counts as rolling, in units of EPS times its speed; see `Scene.rolls`."""


class SceneContents(ScenePart):
    """The fields of a scene, documented in `Scene`, and the values of its balls as arrays."""

    schema_version: Annotated[Literal[1], BeforeValidator(whole_number)] = Field(
        default=1, alias="schema"
    )
    name: SceneName
    title: Text = ""
    tags: tuple[Text, ...] = ()
    t_max: Positive | None = None
    physics: Physics = Field(default_factory=Physics)
    table: Table | None = None
    balls: Annotated[tuple[Ball, ...], Field(min_length=1)]

    @model_validator(mode="before")
    @classmethod
    def _with_balls_of_table(cls, data: Any) -> Any:
        """Give each ball without a radius or a mass the values of the table's preset."""
        if not isinstance(data, dict):
            return data
        balls, table = data.get("balls"), data.get("table")
        if not isinstance(balls, Iterable) or isinstance(balls, str | bytes | Mapping):
            return data
        preset = table.get("preset") if isinstance(table, dict) else table
        preset = table.preset if isinstance(table, Table) else preset
        own = Table.BALLS.get(preset) if isinstance(preset, str) else None
        if own is None:
            return data
        return {**data, "balls": [_with_fields(ball, own) for ball in balls]}

    @property
    def positions(self) -> FloatArray:
        """Initial centres, (n, 3) float64 [m]; a new array."""
        return np.array([ball.position for ball in self.balls], dtype=np.float64)

    @property
    def velocities(self) -> FloatArray:
        """Initial velocities, (n, 3) float64 [m/s]; a new array."""
        return np.array([ball.velocity for ball in self.balls], dtype=np.float64)

    @property
    def angular_velocities(self) -> FloatArray:
        """Initial angular velocities, (n, 3) float64 [rad/s]; a new array."""
        rolling = rolling_angular_velocity(self.velocities, self.radii)
        for i, ball in enumerate(self.balls):
            if ball.angular_velocity is not None:
                rolling[i] = ball.angular_velocity
        return rolling

    @property
    def radii(self) -> FloatArray:
        """Radii, (n,) float64 [m]; a new array."""
        return np.array([ball.radius for ball in self.balls], dtype=np.float64)

    @property
    def masses(self) -> FloatArray:
        """Masses, (n,) float64 [kg]; a new array."""
        return np.array([ball.mass for ball in self.balls], dtype=np.float64)

    @property
    def rolling_frictions(self) -> FloatArray:
        """Coefficients of rolling friction, (n,) float64 [1]; a new array."""
        shared = self.physics.rolling_friction
        return _own_or_shared([ball.rolling_friction for ball in self.balls], shared)

    @property
    def sliding_frictions(self) -> FloatArray:
        """Coefficients of sliding friction, ball on cloth, (n,) float64 [1]; a new array."""
        shared = self.physics.sliding_friction
        return _own_or_shared([ball.sliding_friction for ball in self.balls], shared)

    @property
    def spinning_friction_rates(self) -> FloatArray:
        """Decelerations of vertical spin, (n,) float64 [rad/s^2]; a new array."""
        shared = self.physics.spinning_friction_rate
        return _own_or_shared([ball.spinning_friction_rate for ball in self.balls], shared)

    @property
    def rolls(self) -> BoolArray:
        """Whether each ball starts rolling without slip, or at rest, (n,) bool; a new array.

        A ball without a given angular velocity rolls, and so does every ball if `motion` is
        "rolling". Otherwise the slip at the lowest point of the ball, (vx - R wy, vy + R wx), must
        be at most 4 EPS times the larger of |v| and R |(wx, wy)|; the 4 allows for rounding in a
        computed v / R. Vertical spin and height don't matter: a ball in the air that would roll on
        the cloth counts as rolling.
        """
        given = np.array([ball.angular_velocity is not None for ball in self.balls])
        if self.physics.motion == "rolling" or not np.any(given):
            return np.ones(len(self.balls), dtype=np.bool_)
        return ~given | rolling(self.velocities, self.angular_velocities, self.radii)


def rolling(v: FloatArray, w: FloatArray, radii: FloatArray) -> BoolArray:
    """Return whether balls roll, up to rounding, or rest, as defined in `Scene.rolls`.

    `v` and `w` are velocities and angular velocities (..., 3) [m/s, rad/s]; `radii` [m] has their
    shape without the last axis, or is broadcast against it.
    """
    slip = np.hypot(v[..., 0] - radii * w[..., 1], v[..., 1] + radii * w[..., 0])
    speed = np.maximum(np.hypot(v[..., 0], v[..., 1]), radii * np.hypot(w[..., 0], w[..., 1]))
    rolls: BoolArray = slip <= ROLLING_ULPS * EPS * speed
    return rolls


def rolls_alone(v: Sequence[float], w: Sequence[float], radius: float) -> bool:
    """Return `rolling` of one ball, in less time unless rounding decides."""
    x, y = v[0] - radius * w[1], v[1] + radius * w[0]
    if x == 0.0 and y == 0.0:
        return True
    speeds = abs(v[0]) + abs(v[1]) + radius * (abs(w[0]) + abs(w[1]))
    if max(abs(x), abs(y)) > 2.0 * ROLLING_ULPS * EPS * speeds:
        return False
    return bool(rolling(np.array(v), np.array(w), np.array(radius)))


def _with_fields(ball: Any, fields: Mapping[str, float]) -> Any:
    """Return a ball, or its values, with `fields` added if the ball has no values for them."""
    if isinstance(ball, Ball):
        radius, given = ball.radius, ball.model_fields_set
        ball = {name: getattr(ball, name) for name in given}
        place = ball.get("position")
        if "radius" not in given and isinstance(place, tuple) and place[2:] == (radius,):
            ball["position"] = place[:2]
    return {**fields, **ball} if isinstance(ball, dict) else ball


def _own_or_shared(own: list[float | None], shared: float) -> FloatArray:
    return np.array([shared if value is None else value for value in own], dtype=np.float64)

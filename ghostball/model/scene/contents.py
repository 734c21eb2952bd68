"""The fields of a scene, each valid on its own, and the same values as arrays.

The rules between the fields take a `SceneContents`; a `Scene` has passed these rules.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.model.errors import GhostballError
from ghostball.model.rounding import EPS
from ghostball.model.scene.ball import POOL_BALL, Ball, rolling_angular_velocity
from ghostball.model.scene.fields import Positive, SceneName, Text, problem, whole_number
from ghostball.model.scene.part import ScenePart
from ghostball.model.scene.physics import Physics, usual_physics
from ghostball.model.scene.rack import Rack, add_rack
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
    physics: Physics = Field(default_factory=usual_physics)
    table: Table | None = None
    rack: Rack | None = Field(
        default=None, exclude=True, description="balls to be added to the listed ones"
    )
    balls: Annotated[tuple[Ball, ...], Field(min_length=1)]

    @model_validator(mode="before")
    @classmethod
    def _with_usual_balls(cls, data: Any) -> Any:
        """Give each ball without a radius or a mass the values of `usual_ball`."""
        if not isinstance(data, dict):
            return data
        balls, table = data.get("balls"), data.get("table")
        if not isinstance(balls, Iterable) or isinstance(balls, str | bytes | Mapping):
            return data
        preset = table if isinstance(table, str) else _preset_in(table)
        physics = _preset_in(data.get("physics"))
        usual = usual_ball(preset, physics)
        if usual == POOL_BALL:
            return data  # the defaults of `Ball`
        balls = list(balls)
        if usual is None:
            _check_sizes(balls, f'the table "{preset}"', f'the physics "{physics}"')
            return data | {"balls": balls}
        return data | {"balls": [_with_fields(ball, usual) for ball in balls]}

    def _rack_up(self) -> None:
        """Add the balls of the rack to the listed balls; the scene then has no rack any more."""
        if self.rack is None:
            return
        table = None if self.table is None else self.table.preset
        size = usual_ball(table, self.physics.preset)
        first = {"radius": self.balls[0].radius, "mass": self.balls[0].mass}
        balls = add_rack(self.rack, self.table, self.balls, size or first)
        # The scene is frozen, but still under construction here.
        object.__setattr__(self, "balls", balls)
        object.__setattr__(self, "rack", None)

    def index_of(self, ball: int | str, argument: str) -> int:
        """Return the index of a ball that is given by its index or id.

        Raises `GhostballError`, which names the `argument`, if there is no such ball.
        """
        n = len(self.balls)
        if type(ball) is int and 0 <= ball < n:
            return ball
        for i, one in enumerate(self.balls):
            if one.id == ball:
                return i
        raise GhostballError(
            f"`{argument}` must be the index of a ball, 0 to {n - 1}, or its id, got {ball!r}"
        )

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
    """Return `rolling` for one ball; faster, unless rounding decides."""
    x, y = v[0] - radius * w[1], v[1] + radius * w[0]
    if x == 0.0 and y == 0.0:
        return True
    speeds = abs(v[0]) + abs(v[1]) + radius * (abs(w[0]) + abs(w[1]))
    if max(abs(x), abs(y)) > 2.0 * ROLLING_ULPS * EPS * speeds:
        return False
    return bool(rolling(np.array(v), np.array(w), np.array(radius)))


def usual_ball(table: str | None, physics: str | None) -> Mapping[str, float] | None:
    """Return the radius [m] and mass [kg] of balls for which a scene gives none.

    `table` and `physics` are the presets of the scene's table and physics, or None. A preset may
    belong to a game with its own balls; if neither does, balls are pool balls. The result is None
    if the presets belong to different games.
    """
    on_table = Table.BALLS.get(table or "")
    measured = Physics.BALLS.get(physics or "")
    if on_table is None or measured is None:
        return on_table or measured or POOL_BALL
    return on_table if on_table == measured else None


def _preset_in(part: Any) -> str | None:
    """Return the name of the preset in a part of a scene, which may be invalid."""
    preset = part.get("preset") if isinstance(part, dict) else getattr(part, "preset", None)
    return preset if isinstance(preset, str) else None


def _check_sizes(balls: list[Any], table: str, physics: str) -> None:
    """Reject a ball without its own radius or mass: the presets have different balls."""
    for i, ball in enumerate(balls):
        if not isinstance(ball, Ball | dict):
            continue  # rejected later
        given = ball.model_fields_set if isinstance(ball, Ball) else ball
        missing = [name for name in POOL_BALL if name not in given]
        if missing:
            raise problem(
                f"`balls[{i}].{missing[0]}` must be given, because {table} and {physics} have "
                "different balls. Give `radius` and `mass` of each ball, or choose presets of one "
                "game",
                at=("balls", i),
            )


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

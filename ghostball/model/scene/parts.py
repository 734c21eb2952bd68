"""Balls.

What a field may hold is in `scene.fields`.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

import numpy as np
from pydantic import (
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from ghostball.model.arrays import FloatArray
from ghostball.model.scene.fields import (
    NonNegative,
    PlaneVector,
    Positive,
    SpaceVector,
    Text,
    problem,
)
from ghostball.model.scene.part import Part
from ghostball.model.scene.strike import Strike, Vector, stroke_of

# The paper's ball is Alciatore's pool ball (2 1/4 in, 6 oz).
POOL_BALL_RADIUS = 0.028575  # [m]
POOL_BALL_MASS = 0.170097  # [kg]


class Ball(Part):
    """One ball. The cloth's friction on it is the scene's, unless it has one of its own.

    `position` and `velocity` are given with 2 or 3 components and kept with 3. A ball with a
    `strike` has the velocities that the cue gives it: where balls stay on the cloth, until it is
    part of a scene where they may fly. A ball without a radius or a mass is a pool ball, unless
    it is part of a scene whose table preset has other balls.
    """

    id: Annotated[Text, Field(min_length=1, max_length=64)] = Field(
        description="unique name within the scene"
    )
    position: PlaneVector = Field(description="centre [m]; z defaults to the radius: on the cloth")
    velocity: PlaneVector = Field(
        default=(0.0, 0.0, 0.0), description="of the centre [m/s]; z defaults to 0"
    )
    angular_velocity: SpaceVector | None = Field(
        default=None, description="[rad/s]; left out: that of rolling without slip"
    )
    strike: Strike | None = Field(
        default=None, description="stroke of a cue, in place of `velocity` and `angular_velocity`"
    )
    radius: Positive = Field(
        default=POOL_BALL_RADIUS, description="[m]; without it, from the table's preset"
    )
    mass: Positive = Field(
        default=POOL_BALL_MASS, description="[kg]; without it, from the table's preset"
    )
    rolling_friction: NonNegative | None = Field(
        default=None, description="coefficient of rolling resistance [1]; left out: the scene's"
    )
    sliding_friction: NonNegative | None = Field(
        default=None, description="coefficient of sliding friction [1]; left out: the scene's"
    )
    spinning_friction_rate: NonNegative | None = Field(
        default=None, description="deceleration of vertical spin [rad/s^2]; left out: the scene's"
    )

    @model_validator(mode="after")
    def _complete(self) -> Self:
        # Frozen for everyone else; this is still construction.
        if len(self.position) == 2:
            object.__setattr__(self, "position", (*self.position, self.radius))
        if len(self.velocity) == 2:
            object.__setattr__(self, "velocity", (*self.velocity, 0.0))
        if self.strike is not None:
            self._set_in_motion(self.strike)
        return self

    def _set_in_motion(self, strike: Strike) -> None:
        # What is filled in below doesn't count as given, not in a copy either.
        for field in ("velocity", "angular_velocity"):
            value = getattr(self, field)
            if field in self.model_fields_set and value is not None:
                name = field.replace("_", " ")
                raise problem(
                    "struck_in_motion",
                    f"must have no {name} beside its strike, got {value}: the cue sets the ball in "
                    f"motion. Leave out the strike or the {name}",
                    at=(field,),
                )
        if self.position[2] != self.radius:
            raise problem(
                "struck_in_the_air",
                f"must lie on the cloth where it has a strike, its centre z at its radius, "
                f"{self.radius} m, got {self.position[2]} m. Leave z out, or give it a velocity in "
                "place of the strike",
                at=("position",),
            )
        stroke = stroke_of(strike, self.radius, self.mass)
        fill_in_motion(self, (*stroke.velocity[:2], 0.0), stroke.angular_velocity)

    @model_serializer(mode="wrap")
    def _as_typed(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out a strike that isn't there, as in scenes stored before; else what it gives."""
        fields: dict[str, Any] = dump(self)
        follows = ("strike",) if self.strike is None else ("velocity", "angular_velocity")
        for name in follows:
            fields.pop(name, None)
        return fields

    @property
    def is_checked(self) -> bool:
        """Whether it was made by its checks; False with a strike, which each scene has answered."""
        return self.strike is None and super().is_checked

    def without_strike(self) -> Ball:
        """Return the ball with its velocities in place of its strike; itself where it has none."""
        if self.strike is None:
            return self
        motion = {"velocity": self.velocity, "angular_velocity": self.angular_velocity}
        return self.model_copy(update={"strike": None, **motion})

    @property
    def speed(self) -> float:
        """Speed of the centre [m/s]."""
        return math.hypot(*self.velocity)


def fill_in_motion(ball: Ball, velocity: Vector, angular_velocity: Vector) -> None:
    """Fill in the velocities [m/s, rad/s] that a ball's strike gives, where it or a scene is made.

    They don't count as given, so that the ball can become part of another scene.
    """
    # Frozen for everyone else; this is still construction.
    object.__setattr__(ball, "velocity", velocity)
    object.__setattr__(ball, "angular_velocity", angular_velocity)


def rolling_angular_velocity(velocity: FloatArray, radius: FloatArray) -> FloatArray:
    """Return the angular velocity of rolling without slip, k x v / R, (..., 3) [rad/s].

    `velocity` (..., 3) [m/s], `radius` [m] broadcast against it without its last axis. The paper
    (section 5.3) prints the axis as r = v x k; in a right-handed frame with k up, a ball rolls
    about k x v, so its angle about the printed axis is -s / R.
    """
    omega = np.zeros_like(velocity)
    omega[..., 0] = -velocity[..., 1] / radius
    omega[..., 1] = velocity[..., 0] / radius
    return omega

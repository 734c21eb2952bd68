"""The balls of a scene.

The values that a field may have are defined in `scene.fields`.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Final, Self

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
from ghostball.model.scene.part import ScenePart
from ghostball.model.scene.strike import Strike, Vector, stroke_of

# The ball in the paper (docs/paper.md) is Alciatore's pool ball (2 1/4 in, 6 oz).
POOL_BALL_RADIUS = 0.028575  # [m]
POOL_BALL_MASS = 0.170097  # [kg]

POOL_BALL: Final = {"radius": POOL_BALL_RADIUS, "mass": POOL_BALL_MASS}

SNOOKER_BALL: Final = {"radius": 0.02625, "mass": 0.1406}
"""Mathavan, Jackson and Parkin 2014."""

CAROM_BALL: Final = {"radius": 0.03075, "mass": 0.21}
"""These values are within the range that the rules of the Union Mondiale de Billard permit."""


class Ball(ScenePart):
    """One ball. The cloth friction is the scene's, unless the ball has its own coefficients.

    `position` and `velocity` are given with 2 or 3 components and stored with 3. A ball with a
    `strike` has the velocities that the cue gives it. If the scene is airborne, the scene also
    applies the reaction of the table to the stroke. A ball without a radius or a mass has the
    values of its scene's presets (`usual_ball` in `scene.contents`), or those of a pool ball.
    """

    id: Annotated[Text, Field(min_length=1, max_length=64)] = Field(
        description="unique name within the scene"
    )
    position: PlaneVector = Field(description="centre [m]; z defaults to the radius: on the cloth")
    velocity: PlaneVector = Field(
        default=(0.0, 0.0, 0.0), description="velocity of the centre [m/s]; z defaults to 0"
    )
    angular_velocity: SpaceVector | None = Field(
        default=None, description="angular velocity [rad/s]; default: rolling without slip"
    )
    strike: Strike | None = Field(
        default=None, description="stroke of a cue, instead of `velocity` and `angular_velocity`"
    )
    radius: Positive = Field(
        default=POOL_BALL_RADIUS,
        description="radius [m]; default: from the preset of table or physics",
    )
    mass: Positive = Field(
        default=POOL_BALL_MASS,
        description="mass [kg]; default: from the preset of table or physics",
    )
    rolling_friction: NonNegative | None = Field(
        default=None, description="coefficient of rolling friction [1]; default: the scene's"
    )
    sliding_friction: NonNegative | None = Field(
        default=None, description="coefficient of sliding friction [1]; default: the scene's"
    )
    spinning_friction_rate: NonNegative | None = Field(
        default=None, description="deceleration of vertical spin [rad/s^2]; default: the scene's"
    )

    @model_validator(mode="after")
    def _complete(self) -> Self:
        # The ball is frozen, but still under construction here.
        if len(self.position) == 2:
            object.__setattr__(self, "position", (*self.position, self.radius))
        if len(self.velocity) == 2:
            object.__setattr__(self, "velocity", (*self.velocity, 0.0))
        if self.strike is not None:
            self._set_in_motion(self.strike)
        return self

    def _set_in_motion(self, strike: Strike) -> None:
        # The values that are filled in below don't count as given, even in a copy.
        for field in ("velocity", "angular_velocity"):
            value = getattr(self, field)
            if field in self.model_fields_set and value is not None:
                name = field.replace("_", " ")
                raise problem(
                    f"must not have both a strike and its own {name}, got {value}: the cue sets "
                    f"the ball in motion. Remove the strike or the {name}",
                    at=(field,),
                )
        if self.position[2] != self.radius:
            raise problem(
                f"must have z = {self.radius} m, the radius, because a ball with a strike must lie "
                f"on the cloth; got {self.position[2]} m. Remove z, or give the ball a velocity "
                "instead of the strike",
                at=("position",),
            )
        stroke = stroke_of(strike, self.radius, self.mass)
        fill_in_motion(self, (*stroke.velocity[:2], 0.0), stroke.angular_velocity)

    @model_serializer(mode="wrap")
    def _as_typed(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Omit an absent strike, or the values that a strike gives.

        Without a strike, scenes stored by older versions stay equal.
        """
        fields: dict[str, Any] = dump(self)
        follows = ("strike",) if self.strike is None else ("velocity", "angular_velocity")
        for name in follows:
            fields.pop(name, None)
        return fields

    @property
    def is_checked(self) -> bool:
        """Whether validation created the ball.

        False for a ball with a strike, because each scene applies the table's reaction again.
        """
        return self.strike is None and super().is_checked

    def without_strike(self) -> Ball:
        """Return the ball with velocities instead of a strike, or itself if it has none."""
        if self.strike is None:
            return self
        motion = {"velocity": self.velocity, "angular_velocity": self.angular_velocity}
        return self.model_copy(update={"strike": None, **motion})

    @property
    def speed(self) -> float:
        """Speed of the centre [m/s]."""
        return math.hypot(*self.velocity)


def fill_in_motion(ball: Ball, velocity: Vector, angular_velocity: Vector) -> None:
    """Set the velocities [m/s, rad/s] that the strike of a ball gives.

    Called while a ball or a scene is constructed. The values don't count as given, so that the ball
    can become part of another scene.
    """
    # The ball is frozen, but it or its scene is still under construction here.
    object.__setattr__(ball, "velocity", velocity)
    object.__setattr__(ball, "angular_velocity", angular_velocity)


def rolling_angular_velocity(velocity: FloatArray, radius: FloatArray) -> FloatArray:
    """Return the angular velocity of rolling without slip, k x v / R, (..., 3) [rad/s].

    `velocity` is (..., 3) [m/s]; `radius` [m] is broadcast against it without its last axis. The
    paper (section 5.3) prints the axis as r = v x k; in a right-handed frame with k up, a ball
    rolls about k x v, so its angle about the printed axis is -s / R.
    """
    omega = np.zeros_like(velocity)
    omega[..., 0] = -velocity[..., 1] / radius
    omega[..., 1] = velocity[..., 0] / radius
    return omega

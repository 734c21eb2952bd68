"""Balls, and what all parts of a scene have in common.

What a field may hold is in `scene.fields`.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)

from ghostball.model.errors import SceneError
from ghostball.model.scene.fields import (
    NonNegative,
    PlaneVector,
    Positive,
    SpaceVector,
    Text,
)
from ghostball.model.scene.messages import describe

# The paper's ball is Alciatore's pool ball (2 1/4 in, 6 oz).
POOL_BALL_RADIUS = 0.028575  # [m]
POOL_BALL_MASS = 0.170097  # [kg]


class Part(BaseModel):
    """What is checked as it is made, frozen, and refused with one sentence."""

    # A part that pydantic made without its checks is checked where it becomes part of a whole.
    model_config = ConfigDict(
        frozen=True, extra="forbid", populate_by_name=True, revalidate_instances="always"
    )

    def __init__(self, /, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise SceneError(describe(error, type(self))) from None

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Make one of plain values, such as those of a JSON object.

        Raises
        ------
        SceneError
            Where a rule is broken.
        """
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise SceneError(describe(error, cls)) from None

    @classmethod
    def model_validate_json(cls, json_data: str | bytes | bytearray, **options: Any) -> Self:
        """Make one of JSON text, such as `model_dump_json` writes.

        Raises
        ------
        SceneError
            Where it is no JSON, or a rule is broken.
        """
        try:
            return super().model_validate_json(json_data, **options)
        except ValidationError as error:
            raise SceneError(describe(error, cls)) from None

    # pydantic would otherwise run this for nested models too, and lose where in the scene they are.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]


class Ball(Part):
    """One ball. The cloth's friction on it is the scene's, unless it has one of its own.

    `position` and `velocity` are given with 2 or 3 components and kept with 3.
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
    radius: Positive = Field(default=POOL_BALL_RADIUS, description="[m]")
    mass: Positive = Field(default=POOL_BALL_MASS, description="[kg]")
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
    def _complete_vectors(self) -> Self:
        # Frozen for everyone else; this is still construction.
        if len(self.position) == 2:
            object.__setattr__(self, "position", (*self.position, self.radius))
        if len(self.velocity) == 2:
            object.__setattr__(self, "velocity", (*self.velocity, 0.0))
        return self

    @property
    def speed(self) -> float:
        """Speed of the centre [m/s]."""
        return math.hypot(*self.velocity)


def rolling_angular_velocity(
    velocity: NDArray[np.float64], radius: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Angular velocity of rolling without slip, k x v / R.

    Parameters
    ----------
    velocity : (..., 3) float64 [m/s]
    radius : float64 [m], broadcast against `velocity` without its last axis

    Returns
    -------
    (..., 3) float64 [rad/s]

    Notes
    -----
    The paper (section 5.3) prints the axis as r = v x k; in a right-handed frame with k up, a
    ball rolls about k x v, so its angle about the printed axis is -s / R.
    """
    omega = np.zeros_like(velocity)
    omega[..., 0] = -velocity[..., 1] / radius
    omega[..., 1] = velocity[..., 0] / radius
    return omega

"""The parts of a scene: balls, the table, the physics.

What a field may hold is in `scene.fields`, the rules of the laws of impacts in `scene.law_rules`.
"""

from __future__ import annotations

import math
import operator
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from ghostball.engine.errors import SceneError
from ghostball.engine.scene.fields import (
    BallLaw,
    CushionLaw,
    Flag,
    Fraction,
    NonNegative,
    PlaneVector,
    Positive,
    SpaceVector,
    Text,
    problem,
)
from ghostball.engine.scene.law_rules import check_laws
from ghostball.engine.scene.messages import describe

# The paper's ball is Alciatore's pool ball (2 1/4 in, 6 oz).
POOL_BALL_RADIUS = 0.028575  # [m]
POOL_BALL_MASS = 0.170097  # [kg]

CushionName = Literal["left", "right", "bottom", "top"]
CUSHIONS: tuple[CushionName, ...] = ("left", "right", "bottom", "top")
"""Cushion names in the order of their index: x = 0, x = length, y = 0, y = width."""


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


class Physics(Part):
    """Constants and laws of one scene; a `preset` gives the defaults, any field overrides it.

    `impacts/laws/registry.py` says what each law of impacts uses, and where it comes from. A field
    that the chosen law would ignore is refused, unless it has the preset's value or the default.

    Sources: the paper's own model ("paper": section 4.2 and 5.2, mu = 0.02, everything elastic);
    Alciatore's table of pool constants ("pool"); the same with a restitution and a coefficient of
    friction at each contact, as engines of games have them ("pool-coulomb").
    """

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        "paper": {},
        "pool": {
            "motion": "sliding",
            "rolling_friction": 0.01,
            "ball_restitution": 0.95,
            "ball_friction": "alciatore",
            "cushion": "han2005",
            "cushion_restitution": 0.85,
            "cushion_height": 0.0357,
        },
        "pool-coulomb": {
            "motion": "sliding",
            "rolling_friction": 0.01,
            "ball_restitution": 0.95,
            "ball_friction": 0.06,
            "cushion": "frictional",
            "cushion_restitution": 0.85,
        },
    }

    preset: Literal["paper", "pool", "pool-coulomb"] = "paper"
    gravity: Positive = Field(default=9.81, description="acceleration of free fall [m/s^2]")
    motion: Literal["rolling", "sliding"] = Field(
        default="rolling",
        description='"rolling": always without slip (the paper), no friction between balls or with '
        'cushions; "sliding": slides until it rolls, and spin is a state of its own',
    )
    rolling_friction: NonNegative = Field(
        default=0.02, description="coefficient of rolling resistance, ball on cloth [1]"
    )
    sliding_friction: NonNegative = Field(
        default=0.2, description="coefficient of sliding friction, ball on cloth [1]"
    )
    spinning_friction_rate: NonNegative = Field(
        default=10.0, description="deceleration of vertical spin [rad/s^2]"
    )
    impacts: Literal["simultaneous", "sequential"] = Field(
        default="simultaneous",
        description="how impacts at one instant are resolved: together, whatever the order of the "
        "balls, or one after another",
    )
    ball_impact: BallLaw = Field(
        default="frictional", description="law of the ball-ball impact, see impacts/laws/"
    )
    ball_restitution: Fraction = Field(default=1.0, description="ball-ball restitution [1]")
    ball_friction: NonNegative | Literal["alciatore"] = Field(
        default=0.0,
        description='coefficient of friction between balls [1], or "alciatore": falls with the '
        "speed of slip",
    )
    cushion: CushionLaw = Field(
        default="mirror", description="law of the ball-cushion impact, see impacts/laws/"
    )
    cushion_restitution: Fraction = Field(
        default=1.0, description='normal restitution of the cushion (all laws but "mirror") [1]'
    )
    cushion_tangential_restitution: Fraction = Field(
        default=1.0, description='factor on the velocity along the cushion (law "restitution") [1]'
    )
    cushion_friction: NonNegative = Field(
        default=0.2,
        description="coefficient of friction between ball and cushion "
        '("frictional", "han2005", "mathavan2010") [1]',
    )
    cushion_height: Positive = Field(
        default=0.0357,
        description="height of the cushion's nose above the cloth, less than every ball's "
        '("han2005", "mathavan2010") [m]',
    )
    air_drag: NonNegative = Field(default=0.0, description="k in a = -k |v| v [1/m]")
    rolling_friction_quadratic: NonNegative = Field(
        default=0.0,
        exclude_if=operator.not_,  # scenes stored before there was such a field stay the same
        description="b in a = mu g + b v^2 of a ball that rolls, beside what air takes [1/m]",
    )
    airborne: Flag = Field(default=False, description="whether a ball may leave the cloth")
    table_restitution: Fraction = Field(
        default=0.5, description="restitution of a ball that lands on the table [1]"
    )

    @model_validator(mode="before")
    @classmethod
    def _apply_preset(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        preset = data.get("preset", "paper")
        defaults = cls.PRESETS.get(preset, {}) if isinstance(preset, str) else {}
        return {**defaults, **data}

    @model_validator(mode="after")
    def _no_field_without_effect(self) -> Self:
        check_laws(self)
        return self


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


class Table(Part):
    """A rectangle between cushion noses, from (0, 0) to (length, width) [m].

    `cushions` names the sides that have one; a side without is open and the cloth goes on. Where a
    neighbouring side is open, a cushion's line goes on too, without end.
    """

    length: Positive = Field(description="along x, between the noses of the cushions [m]")
    width: Positive = Field(description="along y [m]")
    cushions: tuple[CushionName, ...] = Field(
        default=CUSHIONS, description="the sides that have one: x = 0, x = length, y = 0, y = width"
    )

    @field_validator("cushions")
    @classmethod
    def _each_once(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(value)) != len(value):
            raise problem("repeated", "must name each cushion once, got {value}", value=value)
        return tuple(name for name in CUSHIONS if name in value)


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

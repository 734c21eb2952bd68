"""A scene: balls, table and physics of one shot, in SI units, validated once and frozen.

`Scene` is what every engine of the harness takes. It is checked here, at the boundary, and trusted
everywhere else. The rules between its parts are in `_scene_checks`; reading and writing TOML is in
`_scene_file`.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    AfterValidator,
    AllowInfNan,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    Strict,
    ValidationError,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from engine._scene_checks import LARGEST, SMALLEST, check_scene, problem
from engine.errors import SceneError

# The paper's ball is Alciatore's pool ball (2 1/4 in, 6 oz).
POOL_BALL_RADIUS = 0.028575  # [m]
POOL_BALL_MASS = 0.170097  # [kg]

CushionName = Literal["left", "right", "bottom", "top"]
CUSHIONS: tuple[CushionName, ...] = ("left", "right", "bottom", "top")
"""Cushion names in the order of their index: x = 0, x = length, y = 0, y = width."""


def _not_tiny(value: float) -> float:
    if value < SMALLEST:
        raise PydanticCustomError("greater_than_equal", "too small", {"ge": SMALLEST})
    return value


def _whole_number(value: Any) -> Any:
    # A literal compares by value, and true == 1.0 == 1.
    if type(value) is not int:
        raise PydanticCustomError("literal_error", "not a whole number", {"expected": "1"})
    return value


Finite = Annotated[float, Strict(), AllowInfNan(False)]
Real = Annotated[Finite, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[Finite, Field(gt=0.0, le=LARGEST), AfterValidator(_not_tiny)]
NonNegative = Annotated[Finite, Field(ge=0.0, le=LARGEST)]
Fraction = Annotated[Finite, Field(ge=0.0, le=1.0)]
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict()]


def _two_or_three(value: tuple[float, ...]) -> tuple[float, ...]:
    if len(value) not in (2, 3):
        raise problem("vector_length", "must have 2 or 3 components, got {count}", count=len(value))
    return value


PlaneVector = Annotated[tuple[Real, ...], AfterValidator(_two_or_three)]
SpaceVector = tuple[Real, Real, Real]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)

    def __init__(self, /, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            from engine._scene_file import describe  # noqa: PLC0415 - the two need each other

            raise SceneError(describe(error, type(self))) from None

    # pydantic would otherwise run this for nested models too, and lose where in the scene they are.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]


class Physics(_Model):
    """Constants and laws of one scene; a `preset` gives the defaults, any field overrides it.

    Sources: the paper's own model ("paper": section 4.2 and 5.2, mu = 0.02, everything elastic);
    Alciatore's table of pool constants ("pool").
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
    }

    preset: Literal["paper", "pool"] = "paper"
    gravity: Positive = Field(default=9.81, description="acceleration of free fall [m/s^2]")
    motion: Literal["rolling", "sliding"] = Field(
        default="rolling",
        description="rolls without slip always (the paper), or slides until it rolls",
    )
    rolling_friction: NonNegative = Field(
        default=0.02, description="coefficient of rolling resistance [1]"
    )
    sliding_friction: NonNegative = Field(
        default=0.2, description="coefficient of sliding friction, ball on cloth [1]"
    )
    spinning_friction_rate: NonNegative = Field(
        default=10.0, description="deceleration of vertical spin [rad/s^2]"
    )
    ball_restitution: Fraction = Field(default=1.0, description="ball-ball restitution [1]")
    ball_friction: NonNegative | Literal["alciatore"] = Field(
        default=0.0, description='ball-ball friction [1], or "alciatore": speed-dependent'
    )
    cushion: Literal["mirror", "restitution", "frictional", "han2005", "mathavan2010"] = Field(
        default="mirror", description="law of the ball-cushion impact"
    )
    cushion_restitution: Fraction = Field(
        default=1.0, description="normal restitution of the cushion [1]"
    )
    cushion_tangential_restitution: Fraction = Field(
        default=1.0, description='factor on the velocity along the cushion ("restitution") [1]'
    )
    cushion_friction: NonNegative = Field(
        default=0.2, description='ball-cushion friction ("frictional", Han, Mathavan) [1]'
    )
    cushion_height: Positive = Field(
        default=0.0357, description="height of the cushion's nose above the cloth [m]"
    )
    air_drag: NonNegative = Field(default=0.0, description="k in a = -k |v| v [1/m]")
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
        # "mirror" would ignore these in silence; a user who set one wants another law.
        if self.cushion == "mirror":
            for field in ("cushion_restitution", "cushion_tangential_restitution"):
                if getattr(self, field) != 1.0 and field in self.model_fields_set:
                    preset_value = self.PRESETS[self.preset].get(field)
                    if getattr(self, field) != preset_value:
                        raise problem(
                            "no_effect",
                            '`{field}` = {value} has no effect with `cushion` = "mirror". '
                            'Set `cushion` = "restitution", or leave the field out',
                            field=field,
                            value=getattr(self, field),
                        )
        return self


class Ball(_Model):
    """One ball. `position` is its centre [m]; z defaults to the radius, that is on the cloth.

    Attributes
    ----------
    id : str
        Unique name within the scene.
    position, velocity : tuple of 3 float
        [m], [m/s]; given with 2 or 3 components.
    angular_velocity : tuple of 3 float or None
        [rad/s]; None is rolling without slip.
    radius, mass : float
        [m], [kg].
    """

    id: Annotated[Text, Field(min_length=1, max_length=64)]
    position: PlaneVector
    velocity: PlaneVector = (0.0, 0.0, 0.0)
    angular_velocity: SpaceVector | None = None
    radius: Positive = POOL_BALL_RADIUS
    mass: Positive = POOL_BALL_MASS

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


class Table(_Model):
    """A rectangle between cushion noses, from (0, 0) to (length, width) [m].

    `cushions` names the sides that have one; a side without is open and the cloth goes on. Where a
    neighbouring side is open, a cushion's line goes on too, without end.
    """

    length: Positive
    width: Positive
    cushions: tuple[CushionName, ...] = CUSHIONS

    @field_validator("cushions")
    @classmethod
    def _each_once(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(value)) != len(value):
            raise problem("repeated", "must name each cushion once, got {value}", value=value)
        return tuple(name for name in CUSHIONS if name in value)


class Scene(_Model):
    """A shot: what every engine simulates.

    Attributes
    ----------
    name : str
        Identifier, used in file names: lower case letters, digits, ".", "_", "-".
    title : str
        What the scene probes, in one line.
    tags : tuple of str
    balls : tuple of Ball
        At least one; results list balls in this order.
    table : Table or None
        None is an unbounded cloth.
    physics : Physics
    t_max : float or None
        Where to stop [s]; None is "until every ball rests".
    """

    schema_version: Annotated[Literal[1], BeforeValidator(_whole_number)] = Field(
        default=1, alias="schema"
    )
    name: Annotated[Text, Field(pattern=r"^[a-z0-9][a-z0-9._-]{0,63}$")]
    title: Text = ""
    tags: tuple[Text, ...] = ()
    t_max: Positive | None = None
    physics: Physics = Field(default_factory=Physics)
    table: Table | None = None
    balls: Annotated[tuple[Ball, ...], Field(min_length=1)]

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """Read a scene from a TOML file.

        Raises
        ------
        SceneError
            Where the file can't be read, isn't TOML, or breaks a rule; the message names file,
            line, field, value and rule.
        """
        from engine._scene_file import load  # noqa: PLC0415 - the two need each other

        return load(Path(path))

    @classmethod
    def loads(cls, text: str, source: str = "<scene>") -> Scene:
        """Read a scene from TOML text; `source` is what errors call it."""
        from engine._scene_file import loads  # noqa: PLC0415 - the two need each other

        return loads(text, source)

    def save(self, path: str | Path) -> None:
        """Write the scene as TOML; `load` reads back an equal scene, to the last bit."""
        from engine._scene_file import save  # noqa: PLC0415 - the two need each other

        save(self, Path(path))

    @property
    def positions(self) -> NDArray[np.float64]:
        """Centres at the start, (n, 3) float64 [m]; a fresh array."""
        return np.array([ball.position for ball in self.balls], dtype=np.float64)

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities at the start, (n, 3) float64 [m/s]; a fresh array."""
        return np.array([ball.velocity for ball in self.balls], dtype=np.float64)

    @property
    def angular_velocities(self) -> NDArray[np.float64]:
        """Angular velocities at the start, (n, 3) float64 [rad/s]; a fresh array."""
        rolling = rolling_angular_velocity(self.velocities, self.radii)
        for i, ball in enumerate(self.balls):
            if ball.angular_velocity is not None:
                rolling[i] = ball.angular_velocity
        return rolling

    @property
    def radii(self) -> NDArray[np.float64]:
        """Radii, (n,) float64 [m]; a fresh array."""
        return np.array([ball.radius for ball in self.balls], dtype=np.float64)

    @property
    def masses(self) -> NDArray[np.float64]:
        """Masses, (n,) float64 [kg]; a fresh array."""
        return np.array([ball.mass for ball in self.balls], dtype=np.float64)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        check_scene(self, rolling_angular_velocity(self.velocities, self.radii))
        return self


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

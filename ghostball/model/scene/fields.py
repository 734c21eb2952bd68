"""Types for the fields of a scene: numbers, texts, vectors, and names of laws."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import AfterValidator, AllowInfNan, Field, Strict
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from ghostball.model.impact_laws import BALL_LAW_NAMES, CUSHION_LAW_NAMES

LARGEST = 1e50
"""Largest size of a number in a scene, and the longest run [SI units].

The engine multiplies distances by speeds and squares the product. A distance is at most a speed
times a time, 1e100 m, so the square is at most 1e300, within the range of doubles. With larger
numbers, sums would become infinite without an error.
"""

MAX_DRAG_RATE = 1e10
"""Largest rate at which air, or friction that grows with the speed, slows a ball [1/s].

Motion in air is a power series in time: its n-th term is a speed, at most 1e50 m/s, times the n-th
power of this rate, for n up to 24. That is at most 1e290, within the range of doubles. At this rate
a ball stops within 1e-10 s.
"""

MAX_IMPACTS = 1e12
"""Largest number of cushion collisions in a shot without `t_max`; computing them takes days."""

MAX_FALL_DRAG = 1e6
"""Largest `air_drag` times `gravity` for airborne balls [1/s^2].

At this limit, a falling ball reaches its terminal speed within a thousandth of a second. At the top
of a flight, the terms of the power series grow with a rate of at most 1e9 times the root of this
limit, 1e12 1/s. The 24th power of this rate is 1e288.
"""

SMALLEST = 1.0 / LARGEST
"""Smallest value of a positive field. Such fields are divisors: a spin is v / R, at most 1e100."""


def problem(rule: str, *, at: tuple[int | str, ...] = ()) -> PydanticCustomError:
    """Return the error that a validator raises.

    `rule` is a sentence. `at` is the location of the field at fault, relative to the validator; it
    is used to find the line in a file.
    """
    return PydanticCustomError("broken_rule", "{sentence}", {"sentence": rule, "at": at})


def in_degrees(value: float) -> str:
    """Return the advice for an angle that may have been given in degrees."""
    return f"Angles are in radians: {value:g} degrees are {math.radians(value):.9g}"


def _not_tiny(value: float) -> float:
    if value < SMALLEST:
        raise PydanticCustomError("greater_than_equal", "too small", {"ge": SMALLEST})
    return value


def whole_number(value: Any) -> Any:
    """Reject a value that isn't an int, because a `Literal[1]` would accept true and 1.0."""
    if type(value) is not int:
        raise PydanticCustomError("literal_error", "not a whole number", {"expected": "1"})
    return value


def _two_or_three(value: tuple[float, ...]) -> tuple[float, ...]:
    if len(value) not in (2, 3):
        raise problem(
            f"must have 2 or 3 components, got {len(value)}",
        )
    return value


class _OneOf:
    """Annotation for a text that must be one of `names`: a `Literal` with values from data."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names

    def __get_pydantic_core_schema__(self, *_: object) -> CoreSchema:
        return core_schema.literal_schema(list(self.names))


Finite = Annotated[float, Strict(), AllowInfNan(False)]
Real = Annotated[Finite, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[Finite, Field(gt=0.0, le=LARGEST), AfterValidator(_not_tiny)]
NonNegative = Annotated[Finite, Field(ge=0.0, le=LARGEST)]
Fraction = Annotated[Finite, Field(ge=0.0, le=1.0)]
FrequencyRatio = Annotated[Finite, Field(gt=1.0, lt=2.0)]
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict()]
SceneName = Annotated[Text, Field(pattern=r"^[a-z0-9][a-z0-9._-]{0,63}$")]
"""Used in file names, so it must not be a path."""
PlaneVector = Annotated[tuple[Real, ...], AfterValidator(_two_or_three)]
SpaceVector = tuple[Real, Real, Real]

# Only `model.impact_laws` lists the laws.
BallLaw = Annotated[str, _OneOf(BALL_LAW_NAMES)]
CushionLaw = Annotated[str, _OneOf(CUSHION_LAW_NAMES)]

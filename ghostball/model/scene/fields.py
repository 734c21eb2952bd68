"""What a single field of a scene may hold: kinds of numbers, texts and vectors, and the laws."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import AfterValidator, AllowInfNan, Field, Strict
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from ghostball.model.impact_laws import BALL_LAW_NAMES, CUSHION_LAW_NAMES

LARGEST = 1e50
"""Largest size of a number in a scene, and the longest run [SI units].

The engine multiplies distances by speeds and squares the product. A distance travelled is at most
a speed times a time, 1e100 m, so that square is at most 1e300: still a double. Beyond, sums become
infinite without a word.
"""

FASTEST_DRAG = 1e10
"""Largest rate at which air, or friction that grows with the speed, slows a ball [1/s].

Motion in air is a power series in time: its n-th term is a speed, at most 1e50 m/s, times the n-th
power of this rate, n up to 24. That is at most 1e290 and still a double; the ball stands after a
ten-thousandth of a millionth of a second.
"""

MOST_IMPACTS = 1e12
"""Most collisions with cushions that a shot without `t_max` may need: they take days."""

FASTEST_FALL = 1e6
"""Largest `air_drag` times `gravity` of balls that fly [1/s^2]: air then holds a fall within a
thousandth of a second. At the top of a throw the power series of the motion grow like a rate that
is at most 1e9 times its root, to the 24th power: 1e288."""

SMALLEST = 1.0 / LARGEST
"""Smallest size of what must be positive, since it divides: a spin is v / R, at most 1e100."""


def problem(kind: str, rule: str, *, at: tuple[int | str, ...] = ()) -> PydanticCustomError:
    """Build the error that a validator raises.

    `kind` is pydantic's type of the error, `rule` a sentence, `at` the field to blame, from where
    the validator stands down: it finds the line in a file.
    """
    return PydanticCustomError(kind, "{sentence}", {"sentence": rule, "at": at})


def in_degrees(value: float) -> str:
    """Return the advice for an angle that somebody may have typed in degrees."""
    return f"Angles are in radians: {value:g} degrees are {math.radians(value):.9g}"


def _not_tiny(value: float) -> float:
    if value < SMALLEST:
        raise PydanticCustomError("greater_than_equal", "too small", {"ge": SMALLEST})
    return value


def whole_number(value: Any) -> Any:
    """Refuse what isn't an int: a literal compares by value, and true == 1.0 == 1."""
    if type(value) is not int:
        raise PydanticCustomError("literal_error", "not a whole number", {"expected": "1"})
    return value


def _two_or_three(value: tuple[float, ...]) -> tuple[float, ...]:
    if len(value) not in (2, 3):
        raise problem(
            "vector_length",
            f"must have 2 or 3 components, got {len(value)}",
        )
    return value


class _OneOf:
    """Annotation of a text that must be one of `names`: a `Literal` whose values are data."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names

    def __get_pydantic_core_schema__(self, *_: object) -> CoreSchema:
        return core_schema.literal_schema(list(self.names))


Finite = Annotated[float, Strict(), AllowInfNan(False)]
Real = Annotated[Finite, Field(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[Finite, Field(gt=0.0, le=LARGEST), AfterValidator(_not_tiny)]
NonNegative = Annotated[Finite, Field(ge=0.0, le=LARGEST)]
Fraction = Annotated[Finite, Field(ge=0.0, le=1.0)]
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict()]
SceneName = Annotated[Text, Field(pattern=r"^[a-z0-9][a-z0-9._-]{0,63}$")]
"""Part of the names of files, so that it must be no path."""
PlaneVector = Annotated[tuple[Real, ...], AfterValidator(_two_or_three)]
SpaceVector = tuple[Real, Real, Real]

# The registry alone lists the laws: to add one is to name it there.
BallLaw = Annotated[str, _OneOf(BALL_LAW_NAMES)]
CushionLaw = Annotated[str, _OneOf(CUSHION_LAW_NAMES)]

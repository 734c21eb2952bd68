"""What is known of how far a shot can be predicted: plain values, one line of JSON each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from pydantic import ConfigDict

from validation.results.records import FloatArray
from validation.truth.bifurcations import Bifurcation

SCHEMA: Final = 2
"""Version of a line; another one is refused, but for those of `OLDER`."""

OLDER: Final = (1,)
"""Versions that are read too: 1 had no `code_hash`, so what it says is measured again."""


@dataclass(frozen=True, eq=False)
class Separation:
    """How far apart two shots come that begin almost alike, and what the tangent map says of it.

    Attributes
    ----------
    size : float [m/s]
        What the second shot's fastest ball is faster by at the start.
    apart : (k,) float64 [m]
        The largest distance of a ball in one shot from where it is in the other, at
        `Predictability.times`.
    predicted : (k,) float64 [m]
        That by the tangent map of the first shot; nan where no derivative exists.
    """

    size: float
    apart: FloatArray
    predicted: FloatArray

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)


@dataclass(frozen=True, eq=False)
class Predictability:
    """How far a shot of our engine can be predicted.

    Attributes
    ----------
    scene : str
    rest_time : float [s]
    tolerance : float [m]
    horizon : float [s] or None
        When rounding may exceed the tolerance; None: never.
    ends : str
        What the horizon comes from: "growth" of rounding, or "several collisions at one instant"
        or "sustained contact", past which no derivative exists; "" where there is none.
    times : (k,) float64 [s]
    growth : (k,) float64 [m]
        The largest `Result.sensitivity` of a ball; nan where no derivative exists.
    bifurcations : tuple of Bifurcation
        The nearest of each kind, the nearest first.
    nearest : str
        The first of them in words; "" where there is none.
    fragile : bool
        Whether the last bits of the scene's numbers decide its course: the nearest bifurcation is
        within 32 roundings.
    separations : tuple of Separation
        Of a scene with the tag "chaos".
    definition_hash : str
        Of the scene: one of its name may be another.
    code_hash : str
        Of the code that measured it, `validation.suite.unchanged.Code`; "" where that can't be
        told, so that it is measured again.
    """

    scene: str
    rest_time: float
    tolerance: float
    horizon: float | None
    ends: str
    times: FloatArray
    growth: FloatArray
    bifurcations: tuple[Bifurcation, ...]
    nearest: str
    fragile: bool
    separations: tuple[Separation, ...] = ()
    definition_hash: str = ""
    code_hash: str = ""
    schema: int = SCHEMA

    __pydantic_config__ = ConfigDict(extra="forbid", arbitrary_types_allowed=True)

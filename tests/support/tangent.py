"""A result whose tangent map is made up: what grading makes of it, without what made it."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine import Result


@dataclass(frozen=True, eq=False)
class MadeUp(Result):
    """A result with the amplification of each ball [m], the same at all times, and a horizon."""

    amplification: tuple[float, ...] = ()
    ends: float = math.inf

    def sensitivity(self, times: ArrayLike) -> NDArray[np.float64]:
        return np.tile(self.amplification, (len(np.atleast_1d(times)), 1))

    def horizon(self, tolerance: float = 1e-3) -> float:
        return self.ends


def with_tangent(
    result: Result, amplification: float | tuple[float, ...] = 1.0, horizon: float = math.inf
) -> MadeUp:
    """Return a result that says so of its rounding."""
    if isinstance(amplification, float):
        amplification = (amplification,) * len(result.scene.balls)
    fields: dict[str, Any] = {
        field.name: getattr(result, field.name) for field in dataclasses.fields(Result)
    }
    return MadeUp(**fields, amplification=amplification, ends=horizon)

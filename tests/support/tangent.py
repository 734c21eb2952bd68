"""Growth of errors that is made up: what grading makes of it, without what made it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.validation.grading.certified_growth import CertifiedGrowth


@dataclass(frozen=True, eq=False)
class _MadeUp:
    amplification: tuple[float, ...]
    ends: float
    derivative_ends: float = math.inf

    def sizes(self, times: ArrayLike) -> NDArray[np.float64]:
        return np.tile(self.amplification, (len(np.atleast_1d(times)), 1))

    @property
    def rounding_horizon(self) -> float:
        return self.ends


def made_up(
    balls: int, amplification: float | tuple[float, ...] = 1.0, horizon: float = math.inf
) -> CertifiedGrowth:
    """Return growth of so much for each ball [m], the same at all times, and a horizon."""
    if isinstance(amplification, float):
        amplification = (amplification,) * balls
    return _MadeUp(amplification, horizon)  # type: ignore[return-value]

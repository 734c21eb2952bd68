"""Where an engine's balls end as its step goes to zero, and a bound of how wrong that is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

RUNS = 19
"""Runs that the finest one is held against, the engine's own among them.

If the error over the step is drawn alike in all twenty, the finest one's is the largest of them
once in twenty.
"""

LEAST_RATIO = 2.0
"""Least ratio of these runs' steps to the finest: of nearer ones, the quotient is mostly noise."""

MARGIN = 1.5
"""What the largest correction of the first order is multiplied by.

Without it the bound would have nothing to spare for an error c h^p with p = 1, and would not hold
for one whose second order hides a part of the first at all longer steps. With it, it holds for all
p of 3/4 and more.
"""

GROWTH = 3.0
"""How many times larger the error over the step may be in the finer half of the runs.

Lateness that is as good as random makes it 1, or half as much again; an error that doesn't fall
with the step makes it 4 over the shortest ladder, and 15 or more over the longer ones.
"""


@dataclass(frozen=True, eq=False)
class ZeroStep:
    """What runs at several steps say of zero step.

    Attributes
    ----------
    positions : (n, 2) float64 [m]
        Of the finest run.
    uncertainty : float [m]
        How far any ball of them may be from the limit; see `zero_step_of`.
    spread : float [m]
        Largest distance of a ball between the finest run and another.
    growth : float [1]
        Largest error over the step in the finer half of the other runs over that in the coarser
        half, as estimated from the finest run; 0 where no run differs from another.
    """

    positions: FloatArray
    uncertainty: float
    spread: float
    growth: float

    @property
    def falls(self) -> bool:
        """Whether the runs' errors fall with their steps as the bound asks."""
        return self.growth <= GROWTH


def largest_distance(a: FloatArray, b: FloatArray) -> float:
    """Return the largest distance of a ball between two states (n, 2) [m]."""
    return float(np.max(np.hypot(*(a - b).T)))


def zero_step_of(steps: Sequence[float], states: Sequence[FloatArray]) -> ZeroStep:
    """Bound where balls end at zero step from where they end at several steps.

    Parameters
    ----------
    steps : sequence of float [s]
        Falling; the last is less than all others by `LEAST_RATIO` at least.
    states : sequence of (n, 2) float64 [m]
        Where the balls end with each.

    Notes
    -----
    A step sees a contact late by any part of it, so the error e(h) of a run is no smooth function
    of the step h: e / h is as good as random, with a largest value that depends on the shot. No
    order can be fitted to that, and none is. The finest run stands for the limit. From a run with
    the step h, a correction of the first order would move it by

        d = |x(h) - x(h_f)| h_f / (h - h_f),

    and the uncertainty is `MARGIN` times the largest d of all runs.

    - e / h random, but drawn alike at all steps: where the run with the largest e / h isn't the
      finest, its d is at least e(h_f), and the bound holds. It is the finest in one of `RUNS` + 1
      shots, whatever the distribution is, and beyond the margin in fewer.
    - e = c h^p in one direction: d over e(h_f) is (r^p - 1) / (r - 1), r the ratio of the steps, so
      that the bound holds for p >= 1, and with the margin, at r = 2, for p >= 3/4.

    Both need errors that fall: see `ZeroStep.falls`.
    """
    h, finest = np.array(steps[:-1]), steps[-1]
    differences = np.array([largest_distance(one, states[-1]) for one in states[:-1]])
    slopes = differences / (h - finest)
    half = len(h) // 2
    coarse, fine = slopes[:half].max(), slopes[half:].max()
    growth = 0.0 if fine == 0.0 else math.inf if coarse == 0.0 else float(fine / coarse)
    return ZeroStep(
        positions=states[-1],
        uncertainty=MARGIN * finest * float(slopes.max()),
        spread=float(differences.max()),
        growth=growth,
    )

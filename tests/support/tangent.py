"""Made-up growth of errors, and small changes propagated along a certified motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ghostball.validation.grading.certified_flow import PARTS, SLIP, VELOCITY, CertifiedBall
from ghostball.validation.grading.certified_growth import CertifiedGrowth

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MadeUpGrowth:
    """Growth of each ball [m] that is the same at all times; see `horizon.Growth`."""

    amplification: tuple[float, ...]
    derivative_ends: float = math.inf
    t_end: float = 1.0
    times: FloatArray = field(default_factory=lambda: np.zeros(1))

    def sizes(self, times: ArrayLike) -> FloatArray:
        return np.tile(self.amplification, (len(np.atleast_1d(times)), 1))


def made_up(balls: int, amplification: float | tuple[float, ...] = 1.0) -> MadeUpGrowth:
    """Return a constant growth of the given size for each ball [m]."""
    if isinstance(amplification, float):
        amplification = (amplification,) * balls
    return MadeUpGrowth(amplification)


def carried(growth: CertifiedGrowth, directions: FloatArray, times: FloatArray) -> FloatArray:
    """Return the changes of positions at `times`, (k, m, n, 2) [m], for changes of the first state.

    `directions` (m, n, 7): changes of every ball's position x, y [m], velocity x, y [m/s] and
        angular velocity x, y, z [rad/s], as for `Result.tangent`.
    """
    m = len(directions)
    whole = np.zeros((PARTS * len(growth.balls), m))
    kept = [np.full((len(ball.segments), PARTS, m), np.nan) for ball in growth.balls]

    def keep(ball: int, k: int) -> None:
        kept[ball][k] = whole[PARTS * ball : PARTS * (ball + 1)]
        for row, flow in growth.balls[ball].along(k):
            kept[ball][row] = flow @ kept[ball][row - 1]

    for i, ball in enumerate(growth.balls):
        whole[PARTS * i : PARTS * (i + 1)] = first_changes(ball, directions[:, i].T)
        keep(i, 0)
    for event in growth.events:
        rows = np.concatenate([np.arange(PARTS * i, PARTS * (i + 1)) for i in event.balls])
        whole[rows] = np.nan if event.matrix is None else event.matrix @ whole[rows]
        for i, k in zip(event.balls, event.segments, strict=True):
            keep(i, k)
    out = np.empty((len(times), m, len(growth.balls), 2))
    for i, ball in enumerate(growth.balls):
        at, flow = ball.displacement(times)
        out[:, :, i] = (flow @ kept[i][at]).transpose(0, 2, 1)
    return out


def first_changes(ball: CertifiedBall, directions: FloatArray) -> FloatArray:
    """Return changes of a ball's first state, (7, m), with the slip in place of the rotation."""
    change = directions.copy()
    change[SLIP] = change[VELOCITY]
    change[4] -= ball.radius * directions[5]
    change[5] += ball.radius * directions[4]
    if not ball.slides(0):
        change[SLIP] = 0.0  # the ball rolls or rests at the start
    ball.hold(0, change)
    return change

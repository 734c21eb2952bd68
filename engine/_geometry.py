"""Where balls are relative to each other at an instant, without moving them."""

from __future__ import annotations

import math

from engine._jit import kernel
from engine._state import Balls
from engine._tolerances import CONTACT_TOLERANCE


@kernel
def relative_motion(
    balls: Balls, i: int, j: int, t: float
) -> tuple[float, float, float, float, float, float]:
    """Position, velocity and acceleration of ball j relative to ball i at the instant t [s]."""
    si, sj = t - balls.epoch[i], t - balls.epoch[j]
    xi = balls.x[i] + si * (balls.vx[i] + 0.5 * balls.ax[i] * si)
    yi = balls.y[i] + si * (balls.vy[i] + 0.5 * balls.ay[i] * si)
    xj = balls.x[j] + sj * (balls.vx[j] + 0.5 * balls.ax[j] * sj)
    yj = balls.y[j] + sj * (balls.vy[j] + 0.5 * balls.ay[j] * sj)
    return (
        xj - xi,
        yj - yi,
        (balls.vx[j] + balls.ax[j] * sj) - (balls.vx[i] + balls.ax[i] * si),
        (balls.vy[j] + balls.ay[j] * sj) - (balls.vy[i] + balls.ay[i] * si),
        balls.ax[j] - balls.ax[i],
        balls.ay[j] - balls.ay[i],
    )


@kernel
def negligible_hop(rate: float, acceleration: float, reach: float) -> bool:
    """Whether a gap that opens at `rate` and is pulled back would open by less than is resolved.

    A hop at speed v under a rises v^2 / 2a. Below `CONTACT_TOLERANCE` of the centre distance it
    counts as staying in contact.
    """
    return rate * rate <= 2.0 * acceleration * (CONTACT_TOLERANCE * reach)


@kernel
def in_contact(gap: float, rate: float, acceleration: float, reach: float) -> bool:
    """Whether a gap [m], changing at `rate` [m/s], counts as closed within a contact step."""
    touching = abs(gap) <= 4.0 * CONTACT_TOLERANCE * reach
    return touching and negligible_hop(rate, acceleration, reach)


@kernel
def pair_in_contact(balls: Balls, i: int, j: int, t: float, deceleration: float) -> bool:
    """Whether balls i and j count as in contact at the instant t [s]."""
    rx, ry, vx, vy, _, _ = relative_motion(balls, i, j, t)
    reach = balls.radius[i] + balls.radius[j]
    distance = math.sqrt(rx * rx + ry * ry)
    return in_contact(distance - reach, (rx * vx + ry * vy) / distance, deceleration, reach)

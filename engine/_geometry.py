"""Where balls are relative to each other at an instant, without moving them."""

from __future__ import annotations

import math

from engine._jit import kernel
from engine._state import (
    AX,
    AY,
    EPOCH,
    RADIUS,
    VX,
    VY,
    Balls,
    X,
    Y,
)
from engine._tolerances import CONTACT_TOLERANCE, EPS, GAP_ULPS


@kernel
def relative_motion(
    balls: Balls, i: int, j: int, t: float
) -> tuple[float, float, float, float, float, float]:
    """Position, velocity and acceleration of ball j relative to ball i at the instant t [s]."""
    si, sj = t - balls.state[EPOCH, i], t - balls.state[EPOCH, j]
    xi = balls.state[X, i] + si * (balls.state[VX, i] + 0.5 * balls.state[AX, i] * si)
    yi = balls.state[Y, i] + si * (balls.state[VY, i] + 0.5 * balls.state[AY, i] * si)
    xj = balls.state[X, j] + sj * (balls.state[VX, j] + 0.5 * balls.state[AX, j] * sj)
    yj = balls.state[Y, j] + sj * (balls.state[VY, j] + 0.5 * balls.state[AY, j] * sj)
    vxi = balls.state[VX, i] + balls.state[AX, i] * si
    vyi = balls.state[VY, i] + balls.state[AY, i] * si
    vxj = balls.state[VX, j] + balls.state[AX, j] * sj
    vyj = balls.state[VY, j] + balls.state[AY, j] * sj
    return (
        xj - xi,
        yj - yi,
        vxj - vxi,
        vyj - vyi,
        balls.state[AX, j] - balls.state[AX, i],
        balls.state[AY, j] - balls.state[AY, i],
    )


@kernel
def negligible_hop(rate: float, acceleration: float, reach: float) -> bool:
    """Whether a gap that opens at `rate` and is pulled back would open by less than is resolved.

    A hop at speed v under a rises v^2 / 2a. Below `CONTACT_TOLERANCE` of the centre distance it
    counts as staying in contact.
    """
    return rate * rate <= 2.0 * acceleration * (CONTACT_TOLERANCE * reach)


@kernel
def gap_rounding(balls: Balls, i: int) -> float:
    """Return the rounding [m] of a gap computed from ball i's coordinates at its epoch."""
    coordinates: float = abs(balls.state[X, i]) + abs(balls.state[Y, i])
    return GAP_ULPS * EPS * coordinates


@kernel
def contact_tolerance(balls: Balls, i: int, reach: float) -> float:
    """Gap or overlap [m] that a contact step of ball i may leave, at its epoch."""
    return CONTACT_TOLERANCE * reach + 8.0 * gap_rounding(balls, i)


@kernel
def cushion_in_contact(balls: Balls, i: int, gap: float, rate: float, deceleration: float) -> bool:
    """Whether the gap [m] of ball i to a cushion, changing at `rate` [m/s], counts as closed."""
    reach = 2.0 * balls.state[RADIUS, i]
    touching = abs(gap) <= 4.0 * contact_tolerance(balls, i, reach)
    return touching and negligible_hop(rate, 3.0 * deceleration, reach)


@kernel
def pair_in_contact(balls: Balls, i: int, j: int, t: float, deceleration: float) -> bool:
    """Whether balls i and j count as in contact at the instant t [s].

    Friction pulls two balls together with at most twice the deceleration of one, and stops one that
    was struck at rest with as much again.
    """
    rx, ry, vx, vy, _, _ = relative_motion(balls, i, j, t)
    reach = balls.state[RADIUS, i] + balls.state[RADIUS, j]
    distance = math.sqrt(rx * rx + ry * ry)
    touching = abs(distance - reach) <= 4.0 * contact_tolerance(balls, i, reach)
    return touching and negligible_hop((rx * vx + ry * vy) / distance, 3.0 * deceleration, reach)


@kernel
def blocking_ball(balls: Balls, i: int, nx: float, ny: float, t: float, deceleration: float) -> int:
    """Return a ball in contact with ball i on the side that (nx, ny) points to, or -1."""
    for j in range(len(balls.own_kind)):
        if j != i and pair_in_contact(balls, i, j, t, deceleration):
            rx, ry, _, _, _, _ = relative_motion(balls, i, j, t)
            if rx * nx + ry * ny > 0.0:
                return j
    return -1

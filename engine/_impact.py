"""What an impact does to velocities: balls with each other, a ball with a cushion."""

from __future__ import annotations

import math

from engine._geometry import cushion_side
from engine._jit import kernel
from engine._state import (
    MASS,
    VX,
    VY,
    Balls,
    Laws,
    X,
    Y,
)


@kernel
def collide_balls(balls: Balls, i: int, j: int, laws: Laws) -> None:
    """Give balls i and j the impulse of a collision with restitution, along their line of centres.

    Contract: both balls are advanced to the instant of the impact and approach each other.

    Notes
    -----
    The paper's section 4.2 (after the elastic formula without angles) times (1 + e) / 2. With the
    unit normal, which is exact along an axis, and shares that are exactly 1/2 for equal masses, a
    full hit along an axis stops exactly. The larger share is what the smaller leaves: as a quotient
    near 1 its rounding would be the same in each collision of the two, and add up (31 415
    collisions of Galperin's balls: 1e-12 of the energy).
    """
    rx, ry = balls.state[X, j] - balls.state[X, i], balls.state[Y, j] - balls.state[Y, i]
    vx, vy = balls.state[VX, j] - balls.state[VX, i], balls.state[VY, j] - balls.state[VY, i]
    distance = math.sqrt(rx * rx + ry * ry)
    nx, ny = rx / distance, ry / distance
    exchange = (1.0 + laws.ball_restitution) * (nx * vx + ny * vy)
    total = balls.state[MASS, i] + balls.state[MASS, j]
    if balls.state[MASS, i] >= balls.state[MASS, j]:
        to_i = exchange * (balls.state[MASS, j] / total)
        to_j = exchange - to_i
    else:
        to_j = exchange * (balls.state[MASS, i] / total)
        to_i = exchange - to_j
    balls.state[VX, i] += to_i * nx
    balls.state[VY, i] += to_i * ny
    balls.state[VX, j] -= to_j * nx
    balls.state[VY, j] -= to_j * ny


@kernel
def bounce(balls: Balls, i: int, cushion: int, laws: Laws) -> None:
    """Reflect ball i at a cushion: v_n -> -e_n v_n, v_t -> e_t v_t (1 and 1: the paper's mirror).

    Contract: the ball is advanced to the instant of the impact. It leaves the cushion whatever the
    sign that rounding gave to a vanishing approach.
    """
    nx, ny, _ = cushion_side(laws, cushion)
    vx, vy = balls.state[VX, i], balls.state[VY, i]
    normal = nx * vx + ny * vy
    rebound = laws.cushion_restitution * abs(normal)
    balls.state[VX, i] = laws.cushion_tangential * (vx - normal * nx) + rebound * nx
    balls.state[VY, i] = laws.cushion_tangential * (vy - normal * ny) + rebound * ny

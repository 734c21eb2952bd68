"""What an impact does to velocities: balls with each other, a ball with a cushion."""

from __future__ import annotations

from engine._jit import kernel
from engine._state import (
    BOTTOM,
    LEFT,
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
    The paper's section 4.2 (after the elastic formula without angles) times (1 + e) / 2. The shares
    of the two balls are exactly 1/2 for equal masses, so that a full hit stops exactly. The larger
    share is what the smaller leaves: as a quotient near 1 its rounding would be the same in each
    collision of the two, and add up (31 415 collisions of Galperin's balls: 1e-12 of the energy).
    """
    rx, ry = balls.state[X, j] - balls.state[X, i], balls.state[Y, j] - balls.state[Y, i]
    vx, vy = balls.state[VX, j] - balls.state[VX, i], balls.state[VY, j] - balls.state[VY, i]
    total = balls.state[MASS, i] + balls.state[MASS, j]
    exchange = (1.0 + laws.ball_restitution) * ((rx * vx + ry * vy) / (rx * rx + ry * ry))
    if balls.state[MASS, i] >= balls.state[MASS, j]:
        to_i = exchange * (balls.state[MASS, j] / total)
        to_j = exchange - to_i
    else:
        to_j = exchange * (balls.state[MASS, i] / total)
        to_i = exchange - to_j
    balls.state[VX, i] += to_i * rx
    balls.state[VY, i] += to_i * ry
    balls.state[VX, j] -= to_j * rx
    balls.state[VY, j] -= to_j * ry


@kernel
def bounce(balls: Balls, i: int, cushion: int, laws: Laws) -> None:
    """Reflect ball i at a cushion: v_n -> -e_n v_n, v_t -> e_t v_t (1 and 1: the paper's mirror).

    Contract: the ball is advanced to the instant of the impact. It leaves the cushion whatever the
    sign that rounding gave to a vanishing approach.
    """
    if cushion < 2:
        normal = laws.cushion_restitution * abs(balls.state[VX, i])
        balls.state[VX, i] = normal if cushion == LEFT else -normal
        balls.state[VY, i] *= laws.cushion_tangential
    else:
        normal = laws.cushion_restitution * abs(balls.state[VY, i])
        balls.state[VY, i] = normal if cushion == BOTTOM else -normal
        balls.state[VX, i] *= laws.cushion_tangential

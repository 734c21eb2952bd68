"""One impact: two balls, or a ball and a cushion, by the law that the scene chose.

Here the state is turned into the frame of the contact and back; what the impact does is the law's
(`impact_laws`).
"""

from __future__ import annotations

import math

from engine._geometry import cushion_side
from engine._jit import kernel
from engine._motion import loosen
from engine._state import (
    CLOTH,
    MASS,
    RADIUS,
    VX,
    VY,
    WX,
    WY,
    WZ,
    Balls,
    Laws,
    X,
    Y,
)
from engine.impact_laws.dispatch import ball_law, cushion_law
from engine.impact_laws.interface import BallImpact, CushionImpact


@kernel
def collide_balls(balls: Balls, i: int, j: int, laws: Laws) -> None:
    """Collide balls i and j by the scene's law.

    Contract: both balls are advanced to the instant of the impact and approach each other.

    Notes
    -----
    With the unit normal, which is exact along an axis, and shares that are exactly 1/2 for equal
    masses, a full hit along an axis stops exactly.
    """
    if not laws.slides:
        # No law that is left acts on spin: the paper's section 4.2, times (1 + e) / 2.
        nx, ny = contact_normal(balls, i, j)
        vx, vy = balls.state[VX, j] - balls.state[VX, i], balls.state[VY, j] - balls.state[VY, i]
        _push_apart(balls, i, j, nx, ny, -(1.0 + laws.ball_restitution) * (nx * vx + ny * vy))
        return
    loosen(balls, i)
    loosen(balls, j)
    nx, ny = contact_normal(balls, i, j)
    impulse = ball_law(_seen_along(balls, i, j, nx, ny), laws)
    _push_apart(balls, i, j, nx, ny, impulse.normal)
    if impulse.along != 0.0 or impulse.up != 0.0:
        # The same impulse along the contact, to and fro, and the turn that it gives: R / I is
        # 5 / (2 m R), so that a turn is 5/2 of the velocity over the radius.
        tx, ty = -ny, nx
        _push_apart(balls, i, j, tx, ty, impulse.along)
        to_i, to_j = _shares(balls, i, j)
        for k, share in ((i, to_i), (j, to_j)):
            turn = 2.5 * share / balls.state[RADIUS, k]
            balls.state[WX, k] += turn * impulse.up * tx
            balls.state[WY, k] += turn * impulse.up * ty
            balls.state[WZ, k] -= turn * impulse.along
    _rub_cloth(balls, i, nx, ny, impulse.a_cloth_n, impulse.a_cloth_t)
    _rub_cloth(balls, j, nx, ny, impulse.b_cloth_n, impulse.b_cloth_t)


@kernel
def contact_normal(balls: Balls, i: int, j: int) -> tuple[float, float]:
    """Return the unit normal from ball i to ball j, both at one instant."""
    rx, ry = balls.state[X, j] - balls.state[X, i], balls.state[Y, j] - balls.state[Y, i]
    distance = math.sqrt(rx * rx + ry * ry)
    return rx / distance, ry / distance


@kernel
def _shares(balls: Balls, i: int, j: int) -> tuple[float, float]:
    """Return what part of a change of their relative velocity balls i and j take; 1 in all.

    The larger is what the smaller leaves.
    """
    total = balls.state[MASS, i] + balls.state[MASS, j]
    if balls.state[MASS, i] >= balls.state[MASS, j]:
        to_i = balls.state[MASS, j] / total
        return to_i, 1.0 - to_i
    to_j = balls.state[MASS, i] / total
    return 1.0 - to_j, to_j


@kernel
def _push_apart(balls: Balls, i: int, j: int, nx: float, ny: float, exchange: float) -> None:
    """Change the velocity of ball j relative to ball i by `exchange` [m/s] along (nx, ny).

    Notes
    -----
    The larger share is what the smaller leaves of the exchange: as a quotient near 1 its rounding
    would be the same in each collision of the two, and add up (31 415 collisions of Galperin's
    balls: 1e-12 of the energy).
    """
    total = balls.state[MASS, i] + balls.state[MASS, j]
    if balls.state[MASS, i] >= balls.state[MASS, j]:
        to_i = exchange * (balls.state[MASS, j] / total)
        to_j = exchange - to_i
    else:
        to_j = exchange * (balls.state[MASS, i] / total)
        to_i = exchange - to_j
    balls.state[VX, i] -= to_i * nx
    balls.state[VY, i] -= to_i * ny
    balls.state[VX, j] += to_j * nx
    balls.state[VY, j] += to_j * ny


@kernel
def _seen_along(balls: Balls, i: int, j: int, nx: float, ny: float) -> BallImpact:
    """Return both balls in the frame of their contact: n = (nx, ny), t = (-ny, nx), z."""
    return BallImpact(
        nx * balls.state[VX, i] + ny * balls.state[VY, i],
        nx * balls.state[VY, i] - ny * balls.state[VX, i],
        nx * balls.state[WX, i] + ny * balls.state[WY, i],
        nx * balls.state[WY, i] - ny * balls.state[WX, i],
        balls.state[WZ, i],
        balls.state[RADIUS, i],
        balls.state[MASS, i],
        balls.state[CLOTH, i],
        nx * balls.state[VX, j] + ny * balls.state[VY, j],
        nx * balls.state[VY, j] - ny * balls.state[VX, j],
        nx * balls.state[WX, j] + ny * balls.state[WY, j],
        nx * balls.state[WY, j] - ny * balls.state[WX, j],
        balls.state[WZ, j],
        balls.state[RADIUS, j],
        balls.state[MASS, j],
        balls.state[CLOTH, j],
    )


@kernel
def _rub_cloth(balls: Balls, k: int, nx: float, ny: float, along_n: float, along_t: float) -> None:
    """Give ball k the cloth's impulse at its lowest point, over its mass [m/s]."""
    if along_n == 0.0 and along_t == 0.0:
        return
    cx, cy = along_n * nx - along_t * ny, along_n * ny + along_t * nx
    turn = 2.5 / balls.state[RADIUS, k]
    balls.state[VX, k] += cx
    balls.state[VY, k] += cy
    balls.state[WX, k] += turn * cy
    balls.state[WY, k] -= turn * cx


@kernel
def bounce(balls: Balls, i: int, cushion: int, laws: Laws) -> None:
    """Bounce ball i off a cushion by the scene's law.

    Contract: the ball is advanced to the instant of the impact. It leaves the cushion whatever the
    sign that rounding gave to a vanishing approach.
    """
    inward_x, inward_y, _ = cushion_side(laws, cushion)
    nx, ny = -inward_x, -inward_y
    if laws.slides:
        loosen(balls, i)
    vx, vy = balls.state[VX, i], balls.state[VY, i]
    wx, wy = balls.state[WX, i], balls.state[WY, i]
    after = cushion_law(
        CushionImpact(
            abs(nx * vx + ny * vy),
            nx * vy - ny * vx,
            nx * wx + ny * wy,
            nx * wy - ny * wx,
            balls.state[WZ, i],
            balls.state[RADIUS, i],
            balls.state[MASS, i],
            balls.state[CLOTH, i],
        ),
        laws,
    )
    balls.state[VX, i] = after.vn * nx - after.vt * ny
    balls.state[VY, i] = after.vn * ny + after.vt * nx
    balls.state[WX, i] = after.wn * nx - after.wt * ny
    balls.state[WY, i] = after.wn * ny + after.wt * nx
    balls.state[WZ, i] = after.wz


@kernel
def bounce_in_corner(balls: Balls, i: int, cushion: int, other: int, laws: Laws) -> None:
    """Bounce ball i off two cushions at once: the mean of one after the other, in both orders.

    So neither cushion is favoured; energy doesn't rise, since the mean of two states has at most
    the mean of their energies.
    """
    if laws.slides:
        loosen(balls, i)
    vx, vy = balls.state[VX, i], balls.state[VY, i]
    wx, wy, wz = balls.state[WX, i], balls.state[WY, i], balls.state[WZ, i]
    _bounce_off_both(balls, i, cushion, other, laws)
    vx1, vy1 = balls.state[VX, i], balls.state[VY, i]
    wx1, wy1, wz1 = balls.state[WX, i], balls.state[WY, i], balls.state[WZ, i]
    balls.state[VX, i], balls.state[VY, i] = vx, vy
    balls.state[WX, i], balls.state[WY, i], balls.state[WZ, i] = wx, wy, wz
    _bounce_off_both(balls, i, other, cushion, laws)
    balls.state[VX, i] = 0.5 * (balls.state[VX, i] + vx1)
    balls.state[VY, i] = 0.5 * (balls.state[VY, i] + vy1)
    balls.state[WX, i] = 0.5 * (balls.state[WX, i] + wx1)
    balls.state[WY, i] = 0.5 * (balls.state[WY, i] + wy1)
    balls.state[WZ, i] = 0.5 * (balls.state[WZ, i] + wz1)


@kernel
def _bounce_off_both(balls: Balls, i: int, first: int, second: int, laws: Laws) -> None:
    """Bounce ball i off one cushion, then off another if it still approaches that."""
    bounce(balls, i, first, laws)
    nx, ny, _ = cushion_side(laws, second)
    if nx * balls.state[VX, i] + ny * balls.state[VY, i] < 0.0:
        bounce(balls, i, second, laws)

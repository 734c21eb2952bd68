"""Where a ball is and how fast, on its piece of motion: from `epoch` until its own next event.

Everybody else asks here. What a piece is made of is in `core.state.BallRow`, its polynomial in
`motion.polynomial`. A piece may be of any degree (`core.state.Balls.higher`). Bounds of contact
times take it for a quadratic whose acceleration is known but for its `bend`: by how much it may
differ, until the piece ends, from what it is now. Where no piece of a run is of a degree above 2,
`higher` is None, and the compiler leaves out all of this.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import GONE, HIGHER, SLIDING, Balls, FloatArray
from ghostball.engine.motion import polynomial

way = kernel(inline=True)(polynomial.way)
speed = kernel(inline=True)(polynomial.speed)
_tail = kernel(polynomial.tail)


@kernel(inline=True)
def place(balls: Balls, i: int, t: float) -> tuple[float, float]:
    """Return where the centre of ball i is at the instant t [s], x and y [m]."""
    ball = balls.state[i]
    s = t - ball.epoch
    x, y = ball.x + way(ball.vx, ball.ax, s), ball.y + way(ball.vy, ball.ay, s)
    return _with_tail(balls.higher, i, s, 0, x, y)


@kernel(inline=True)
def velocity(balls: Balls, i: int, t: float) -> tuple[float, float]:
    """Return the velocity of ball i at the instant t [s], x and y [m/s]."""
    ball = balls.state[i]
    s = t - ball.epoch
    vx, vy = speed(ball.vx, ball.ax, s), speed(ball.vy, ball.ay, s)
    return _with_tail(balls.higher, i, s, 1, vx, vy)


@kernel(inline=True)
def acceleration(balls: Balls, i: int, t: float) -> tuple[float, float]:
    """Return the acceleration of ball i at the instant t [s], x and y [m/s^2]."""
    ball = balls.state[i]
    return _with_tail(balls.higher, i, t - ball.epoch, 2, ball.ax, ball.ay)


@kernel(inline=True)
def _with_tail(
    higher: FloatArray | None, i: int, s: float, order: int, x: float, y: float
) -> tuple[float, float]:
    """Add to x and y what a piece's powers beyond the second come to after s seconds."""
    if higher is None:
        return x, y
    powers = higher[i, HIGHER:]
    return x + _tail(powers, 0, s, order), y + _tail(powers, 1, s, order)


@kernel(inline=True)
def bend(balls: Balls, i: int, duration: float, nx: float, ny: float) -> float:
    """Return by how much ball i's acceleration changes within a duration [s] at most [m/s^2].

    Along (nx, ny); 0 for a quadratic.
    """
    return _bend(balls.higher, i, duration, nx, ny)


@kernel(inline=True)
def _bend(higher: FloatArray | None, i: int, duration: float, nx: float, ny: float) -> float:
    if higher is None:
        return 0.0
    rate: float = abs(nx) * higher[i, 0] + abs(ny) * higher[i, 1]
    # A piece of higher degree ends; another may last for ever.
    return rate * max(duration, 0.0) if rate > 0.0 else 0.0


@kernel(inline=True)
def relative_bend(balls: Balls, i: int, j: int, t: float, nx: float, ny: float) -> float:
    """Return `bend` of ball j relative to ball i, from the instant t until the first one ends."""
    left = min(balls.state[i].own_time, balls.state[j].own_time) - t
    return bend(balls, i, left, nx, ny) + bend(balls, j, left, nx, ny)


@kernel(inline=True)
def straighten(balls: Balls, i: int) -> None:
    """Begin a piece of ball i that is a quadratic."""
    _straighten(balls.higher, i)


@kernel(inline=True)
def _straighten(higher: FloatArray | None, i: int) -> None:
    if higher is not None:
        higher[i, :] = 0.0


@kernel(inline=True)
def meets_until(balls: Balls, i: int) -> float:
    """Return until when ball i may meet others on its piece [s]; one that is gone never does."""
    until: float = -math.inf if balls.state[i].phase == GONE else balls.state[i].own_time
    return until


@kernel
def relative_motion(
    balls: Balls, i: int, j: int, t: float
) -> tuple[float, float, float, float, float, float]:
    """Position, velocity and acceleration of ball j relative to ball i at the instant t [s]."""
    xi, yi = place(balls, i, t)
    xj, yj = place(balls, j, t)
    vxi, vyi = velocity(balls, i, t)
    vxj, vyj = velocity(balls, j, t)
    axi, ayi = acceleration(balls, i, t)
    axj, ayj = acceleration(balls, j, t)
    return (
        xj - xi,
        yj - yi,
        vxj - vxi,
        vyj - vyi,
        axj - axi,
        ayj - ayi,
    )


@kernel
def advance(balls: Balls, i: int, t: float) -> None:
    """Move ball i along its piece to the instant t [s], its new epoch.

    Contract: t is not beyond the ball's own next event. No allocation.
    """
    ball = balls.state[i]
    s = t - ball.epoch
    ball.x, ball.y = place(balls, i, t)
    ball.vx, ball.vy = velocity(balls, i, t)
    ball.ax, ball.ay = acceleration(balls, i, t)
    _shift(balls.higher, i, s)
    if ball.phase == SLIDING:
        ball.wx += ball.bx * s
        ball.wy += ball.by * s
    turn_about_vertical(balls, i, s)
    ball.epoch = t


@kernel
def turn_about_vertical(balls: Balls, i: int, s: float) -> None:
    """Take from ball i what the cloth takes of its spin about the vertical in s seconds.

    And add what a contact step adds.
    """
    spin = balls.state[i].wz
    if spin != 0.0:
        left = max(abs(spin) - s * balls.state[i].spin_slowing, 0.0)
        balls.state[i].wz = left if spin > 0.0 else -left
    balls.state[i].wz += balls.state[i].bz * s


@kernel(inline=True)
def _shift(higher: FloatArray | None, i: int, s: float) -> None:
    """Let the powers of ball i's piece count from s seconds later."""
    if higher is not None:
        powers = higher[i, HIGHER:]
        for row in range(len(powers)):
            shifted, factor, degree = 0.0, 1.0, 3 + row // 2
            for above in range(row, len(powers), 2):
                shifted += factor * powers[above]
                factor *= s * (degree + 1 + (above - row) // 2) / (1 + (above - row) // 2)
            powers[row] = shifted

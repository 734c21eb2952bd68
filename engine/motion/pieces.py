"""Where a ball is and how fast, on its piece of motion: from `epoch` until its own next event.

Everybody else asks here. What a piece is made of is in `core.state.BallRow`, its polynomial in
`motion.polynomial`.
"""

from __future__ import annotations

import math

from engine.core.kernel import kernel
from engine.core.state import GONE, SLIDING, Balls
from engine.motion import polynomial

way = kernel(inline=True)(polynomial.way)
speed = kernel(inline=True)(polynomial.speed)


@kernel(inline=True)
def place(balls: Balls, i: int, t: float) -> tuple[float, float]:
    """Return where the centre of ball i is at the instant t [s], x and y [m]."""
    ball = balls.state[i]
    s = t - ball.epoch
    return ball.x + way(ball.vx, ball.ax, s), ball.y + way(ball.vy, ball.ay, s)


@kernel(inline=True)
def velocity(balls: Balls, i: int, t: float) -> tuple[float, float]:
    """Return the velocity of ball i at the instant t [s], x and y [m/s]."""
    ball = balls.state[i]
    s = t - ball.epoch
    return speed(ball.vx, ball.ax, s), speed(ball.vy, ball.ay, s)


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
    return (
        xj - xi,
        yj - yi,
        vxj - vxi,
        vyj - vyi,
        balls.state[j].ax - balls.state[i].ax,
        balls.state[j].ay - balls.state[i].ay,
    )


@kernel
def advance(balls: Balls, i: int, t: float) -> None:
    """Move ball i along its piece to the instant t [s], its new epoch.

    Contract: t is not beyond the ball's own next event. No allocation.
    """
    ball = balls.state[i]
    s = t - ball.epoch
    ball.x += way(ball.vx, ball.ax, s)
    ball.y += way(ball.vy, ball.ay, s)
    ball.vx = speed(ball.vx, ball.ax, s)
    ball.vy = speed(ball.vy, ball.ay, s)
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

"""Position and velocity of a ball at a time, on its piece of motion.

A piece is the motion of a ball over the cloth, as a polynomial of the time, from its `epoch` to its
own next event; `motion.flight` adds the height. All other modules use these functions.
`core.state.BallRow` lists the numbers of a piece, `model.trajectory.polynomial` evaluates it.

A piece may have any degree (`core.state.Balls.powers`). Bounds on contact times treat it as a
quadratic, and add the largest effect of its `jerk`: the largest rate of change of its acceleration
until it ends. If all pieces of a run have degree 2 or less, `powers` is None, and the compiler
removes the code for higher degrees.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray
from ghostball.engine.core.tolerances import ONE_INSTANT
from ghostball.model.trajectory import polynomial
from ghostball.model.trajectory.polynomial import OF_X, OF_Y, PER_POWER

FOR_EVER = 1e100
"""A duration that is longer than any piece [s]."""

displacement = kernel(inline=True)(polynomial.displacement)
speed = kernel(inline=True)(polynomial.speed)
_tails = kernel(polynomial.tails)
_rises = kernel(polynomial.rises)
_turns = kernel(polynomial.turns)


@kernel(inline=True)
def position_at(balls: Balls, i: int, t: float) -> tuple[float, float]:
    """Return the position of ball i's centre at the time t [s], x and y [m]."""
    ball = balls.state[i]
    s = t - ball.epoch
    x, y = ball.x + displacement(ball.vx, ball.ax, s), ball.y + displacement(ball.vy, ball.ay, s)
    return _with_tail(balls, i, s, 0, x, y)


@kernel(inline=True)
def velocity(balls: Balls, i: int, t: float) -> tuple[float, float]:
    """Return the velocity of ball i at the time t [s], x and y [m/s]."""
    ball = balls.state[i]
    s = t - ball.epoch
    vx, vy = speed(ball.vx, ball.ax, s), speed(ball.vy, ball.ay, s)
    return _with_tail(balls, i, s, 1, vx, vy)


@kernel(inline=True)
def acceleration(balls: Balls, i: int, t: float) -> tuple[float, float]:
    """Return the acceleration of ball i at the time t [s], x and y [m/s^2]."""
    ball = balls.state[i]
    return _with_tail(balls, i, t - ball.epoch, 2, ball.ax, ball.ay)


@kernel(inline=True)
def _with_tail(
    balls: Balls, i: int, s: float, order: int, x: float, y: float
) -> tuple[float, float]:
    """Add the terms of a piece's powers beyond the second after s seconds to x and y."""
    if balls.powers is None or balls.powers[i, st.COUNT] == 0.0 or s == 0.0:
        return x, y
    further = _tails(balls.powers[i, st.POWERS :], int(balls.powers[i, st.COUNT]), s)
    return x + further[2 * order], y + further[2 * order + 1]


@kernel(inline=True)
def neither_bends(powers: FloatArray, i: int, j: int) -> bool:
    """Return whether the pieces of two balls are parabolas."""
    bent_i = powers[i, st.JERK_X] + powers[i, st.JERK_Y]
    return bool(bent_i + powers[j, st.JERK_X] + powers[j, st.JERK_Y] == 0.0)


@kernel(inline=True)
def bend(balls: Balls, i: int, duration: float) -> tuple[float, float]:
    """Return the largest change of ball i's acceleration within a duration [s] [m/s^2].

    The two values are for x and for y; they are 0 for a quadratic.
    """
    # A piece of higher degree has an end; other pieces may have none.
    if balls.powers is None or jerk(balls, i) == 0.0:
        return 0.0, 0.0
    lasts = max(duration, 0.0)
    return balls.powers[i, st.JERK_X] * lasts, balls.powers[i, st.JERK_Y] * lasts


@kernel(inline=True)
def jerk(balls: Balls, i: int) -> float:
    """Return the largest rate of change of ball i's acceleration until its piece ends [m/s^3]."""
    if balls.powers is None:
        return 0.0
    x, y = balls.powers[i, st.JERK_X], balls.powers[i, st.JERK_Y]
    return math.sqrt(x * x + y * y)


@kernel(inline=True)
def jerk_along(balls: Balls, i: int, nx: float, ny: float) -> float:
    """Return the largest rate of change of ball i's acceleration along a unit vector [m/s^3]."""
    if balls.powers is None:
        return 0.0
    most: float = abs(nx) * balls.powers[i, st.JERK_X] + abs(ny) * balls.powers[i, st.JERK_Y]
    return most


@kernel
def whole_jerk_along(balls: Balls, i: int, nx: float, ny: float, duration: float) -> float:
    """Return `jerk_along` from the powers, within `duration` [s] of the start of the piece.

    Powers along x and along y whose components along the vector cancel don't contribute.
    """
    if balls.powers is None:
        return 0.0
    size = 0.0
    for power in range(int(balls.powers[i, st.COUNT]) - 1, 0, -1):
        at = st.POWERS + PER_POWER * power
        along = nx * balls.powers[i, at + OF_X] + ny * balls.powers[i, at + OF_Y]
        size = size * duration + abs(along) * float((power + 2) * (power + 1) * power)
    return size


@kernel
def relative_jerk(powers: FloatArray, i: int, j: int, lasts: float) -> float:
    """Return the largest rate of change of the relative acceleration of two balls [m/s^3].

    The pieces of both balls must have started at the same time. The result is valid for `lasts` [s]
    from that time.
    """
    count_i, count_j = int(powers[i, st.COUNT]), int(powers[j, st.COUNT])
    size = 0.0
    for power in range(max(count_i, count_j) - 1, 0, -1):
        at = st.POWERS + PER_POWER * power
        x, y = 0.0, 0.0
        if power < count_i:
            x, y = powers[i, at + OF_X], powers[i, at + OF_Y]
        if power < count_j:
            x, y = x - powers[j, at + OF_X], y - powers[j, at + OF_Y]
        bent = (abs(x) + abs(y)) * float((power + 2) * (power + 1) * power)
        size = size * lasts + bent
    return size


@kernel(inline=True)
def both_last(balls: Balls, i: int, j: int, t: float) -> float:
    """Return the time for which the pieces of both balls last after t [s]; a finite number.

    Pieces with a jerk have an end. Without a jerk the result is only multiplied by 0.
    """
    ends = min(balls.state[i].own_time, balls.state[j].own_time)
    left: float = max(min(ends - t, FOR_EVER), 0.0)
    return left


@kernel(inline=True)
def straighten(balls: Balls, i: int) -> None:
    """Make the piece of ball i a quadratic, at its start."""
    if balls.powers is not None:
        for column in range(st.POWERS):
            balls.powers[i, column] = 0.0


@kernel(inline=True)
def meets_until(balls: Balls, i: int) -> float:
    """Return the time until which ball i may hit other balls on its piece [s]; -inf if GONE."""
    until: float = -math.inf if balls.state[i].phase == st.GONE else balls.state[i].own_time
    return until


@kernel(inline=True)
def whole_motion(balls: Balls, i: int, t: float) -> tuple[float, float, float, float, float, float]:
    """Return position, velocity and acceleration of ball i at the time t [s], x and y each."""
    ball = balls.state[i]
    s = t - ball.epoch
    x, y = ball.x + displacement(ball.vx, ball.ax, s), ball.y + displacement(ball.vy, ball.ay, s)
    vx, vy = speed(ball.vx, ball.ax, s), speed(ball.vy, ball.ay, s)
    if balls.powers is None or balls.powers[i, st.COUNT] == 0.0 or s == 0.0:
        return x, y, vx, vy, ball.ax, ball.ay
    count = int(balls.powers[i, st.COUNT])
    fx, fy, fvx, fvy, fax, fay = _tails(balls.powers[i, st.POWERS :], count, s)
    return x + fx, y + fy, vx + fvx, vy + fvy, ball.ax + fax, ball.ay + fay


@kernel
def relative_motion(
    balls: Balls, i: int, j: int, t: float
) -> tuple[float, float, float, float, float, float]:
    """Return position, velocity, acceleration of ball j relative to ball i at the time t [s]."""
    xi, yi, vxi, vyi, axi, ayi = whole_motion(balls, i, t)
    xj, yj, vxj, vyj, axj, ayj = whole_motion(balls, j, t)
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
    """Move ball i along its piece to the time t [s], its new epoch.

    Contract: t is not later than the ball's own next event. A piece of degree above 2 ends here;
    the caller must predict another one before the clock moves on. No allocation.
    """
    ball = balls.state[i]
    s = t - ball.epoch
    ball.x, ball.y, ball.vx, ball.vy, ball.ax, ball.ay = whole_motion(balls, i, t)
    size = abs(ball.vx) + abs(ball.vy)
    ball.fastest = size if s > 0.0 else max(size, ball.fastest)
    ball.impacts = impacts_after(balls, i, s, t)
    if ball.phase == st.SLIDING:
        ball.wx += ball.bx * s
        ball.wy += ball.by * s
        if balls.powers is not None:
            wx, wy = _turns(balls.powers[i, st.POWERS :], int(balls.powers[i, st.COUNT]), s)
            ball.wx += wx
            ball.wy += wy
    if balls.height is not None:
        _rise_on(balls.height, balls, i, s)
    straighten(balls, i)
    turn_about_vertical(balls, i, s)
    ball.epoch = t


@kernel(inline=True)
def impacts_after(balls: Balls, i: int, s: float, t: float) -> float:
    """Return how many earlier impacts of ball i count as simultaneous with an impact at t [s].

    `s` [s]: time since the ball's epoch.
    """
    return 0.0 if s > ONE_INSTANT * t else balls.state[i].impacts


@kernel(inline=True)
def slowed_spin(spin: float, slowed: float) -> float:
    """Return a spin about the vertical after the cloth has reduced it by `slowed`."""
    left = max(abs(spin) - slowed, 0.0)
    return left if spin > 0.0 else -left


@kernel
def turn_about_vertical(balls: Balls, i: int, s: float) -> None:
    """Change ball i's vertical spin over s seconds, by the cloth and by a contact step."""
    spin = balls.state[i].wz
    if spin != 0.0 and not flies(balls, i):
        balls.state[i].wz = slowed_spin(spin, s * balls.state[i].spin_slowing)
    balls.state[i].wz += balls.state[i].bz * s


@kernel(inline=True)
def pair_reach(balls: Balls, i: int, j: int) -> float:
    """Return the distance in plan of two touching balls on the cloth [m]; see `motion.flight`."""
    reach: float = balls.state[i].radius + balls.state[j].radius
    if balls.height is not None:
        above = balls.height[i, st.BASE] - balls.height[j, st.BASE]
        if above != 0.0:
            reach = math.sqrt(reach * reach - above * above)
    return reach


@kernel(inline=True)
def flies(balls: Balls, i: int) -> bool:
    """Return whether ball i is in flight."""
    return False if balls.height is None else bool(balls.state[i].phase == st.FLYING)


@kernel(inline=True)
def one_flies(balls: Balls, i: int, j: int) -> bool:
    """Return whether one of two balls is in flight."""
    return flies(balls, i) or flies(balls, j)


@kernel(inline=True)
def _rise_on(height: FloatArray, balls: Balls, i: int, s: float) -> None:
    """Let ball i rise or fall for s seconds; its remaining low bounces are cancelled."""
    up, fall = height[i, st.UP_SPEED], height[i, st.FALL]
    z, vz, _ = with_rises(balls, i, s, s * (up - 0.5 * fall * s), up - fall * s, -fall)
    height[i, st.RISE] += z
    height[i, st.UP_SPEED] = vz
    height[i, st.LASTS] = 0.0


@kernel(inline=True)
def with_rises(
    balls: Balls, i: int, s: float, z: float, vz: float, az: float
) -> tuple[float, float, float]:
    """Add the effect of air after s seconds to ball i's vertical motion: z, vz and az."""
    if balls.powers is None or balls.powers[i, st.COUNT] == 0.0:
        return z, vz, az
    more, faster, pull = _rises(balls.powers[i, st.POWERS :], int(balls.powers[i, st.COUNT]), s)
    return z + more, vz + faster, az + pull

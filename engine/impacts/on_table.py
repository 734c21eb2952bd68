"""What the table does to a ball that may fly: it returns its speed downwards, and rubs it.

The speed downwards is returned `table_restitution` times, with the cloth's friction; at the instant
of the impact that pushed the ball down, after it (that order is a choice; a joint law would give
the ball that can't move downwards another mass).

Bounces on the table that would rise less than `LOWEST_BOUNCE` aren't followed one by one. They are
a geometric series: how long they take, which velocity their friction takes, and how far the ball
goes meanwhile have closed forms, whether it sticks at one of them or slips through all.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws
from ghostball.engine.core.tolerances import LOWEST_BOUNCE, TIME_ROUNDING
from ghostball.engine.motion.next_piece import keep_spin
from ghostball.engine.motion.position import impacts_after, slowed_spin

STICKING = 2.0 / 7.0
"""Impulse over the mass that ends a slip of 1, of a solid sphere."""


@kernel
def set_free(balls: Balls, i: int) -> None:
    """Let ball i keep its angular velocity while an impulse changes its velocity, in flight too."""
    if balls.state[i].phase != st.FLYING:
        keep_spin(balls, i)


@kernel
def respond_by_table(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Let the table respond to ball i, if it lies there: one that is pushed down comes up again.

    And say how it continues: in the air, in bounces too low to be followed, or on the cloth.
    """
    height[i, st.LASTS] = 0.0
    if height[i, st.RISE] > 0.0:
        return
    height[i, st.RISE], height[i, st.SLOW_IMPACTS] = 0.0, 0.0
    if height[i, st.UP_SPEED] < 0.0:
        _bounce_on_table(height, balls, i, laws)
    up = height[i, st.UP_SPEED]
    e = laws.table_restitution
    if up * up > 2.0 * laws.gravity * LOWEST_BOUNCE * 2.0 * balls.state[i].radius:
        balls.state[i].phase = st.FLYING
        return
    height[i, st.UP_SPEED], height[i, st.FALL] = 0.0, 0.0
    if balls.state[i].phase == st.FLYING:
        balls.state[i].phase = st.SLIDING
    if e < 1.0:
        lasts = 2.0 * up / (laws.gravity * (1.0 - e))
        if lasts > 2.0 * TIME_ROUNDING * balls.state[i].epoch:
            _find_end_of_bounces(height, balls, i, laws, up, lasts)


@kernel
def _bounce_on_table(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Return a ball's speed downwards, and rub it on the cloth: it slips, or sticks."""
    ball = balls.state[i]
    down = -height[i, st.UP_SPEED]
    ux, uy = ball.vx - ball.radius * ball.wy, ball.vy + ball.radius * ball.wx
    slip = math.sqrt(ux * ux + uy * uy)
    most = ball.cloth_friction * (1.0 + laws.table_restitution) * down
    part = min(most / slip, STICKING) if slip > 0.0 else 0.0
    _rub(balls, i, -part * ux, -part * uy)
    height[i, st.UP_SPEED] = laws.table_restitution * down


@kernel(inline=True)
def _rub(balls: Balls, i: int, cx: float, cy: float) -> None:
    """Give ball i an impulse over its mass [m/s] at its lowest point."""
    ball = balls.state[i]
    turn = 2.5 / ball.radius
    ball.vx += cx
    ball.vy += cy
    ball.wx += turn * cy
    ball.wy -= turn * cx


@kernel
def _find_end_of_bounces(
    height: FloatArray, balls: Balls, i: int, laws: Laws, up: float, lasts: float
) -> None:
    """Find how bounces that begin with the speed `up` [m/s] end, after `lasts` [s], and where.

    Impact n, from 1 on, comes at t_n, with e^(n-1) up; what is left then is 2 e^n up / (g (1 - e)).
    It takes mu (1 + e) e^(n-1) up of the velocity, or the 2/7 of the slip that are left; from there
    on nothing slips. If none sticks, all of them take mu (1 + e) up / (1 - e), and of the way
    2 mu e up^2 / (g (1 - e)^2).

    The ball goes that way at its mean velocity: so much of the friction acts at once, the rest at
    the end. So does the air, see `_slow_bounces`.
    """
    ball = balls.state[i]
    e, friction = laws.table_restitution, ball.cloth_friction
    ux, uy = ball.vx - ball.radius * ball.wy, ball.vy + ball.radius * ball.wx
    slip, rubbed = math.sqrt(ux * ux + uy * uy), 0.0
    taken, displacement, rolls = 0.0, 0.0, lasts
    if slip > 0.0:
        if STICKING * slip >= friction * (1.0 + e) * up / (1.0 - e):
            taken = friction * (1.0 + e) * up / (1.0 - e)
            displacement = 2.0 * friction * e * up * up / (laws.gravity * (1.0 - e) * (1.0 - e))
            rolls = 0.0
        else:
            speed, left = up, e * lasts
            while taken < STICKING * slip and speed > 0.0:
                impulse = min(friction * (1.0 + e) * speed, STICKING * slip - taken)
                taken += impulse
                displacement += impulse * left
                rolls = left
                speed, left = e * speed, e * left
        rubbed = taken
        taken, displacement = taken / slip, displacement / slip
    height[i, st.LASTS] = lasts
    turn = 2.5 * taken / ball.radius
    height[i, st.END_VX], height[i, st.END_VY] = ball.vx - taken * ux, ball.vy - taken * uy
    height[i, st.END_WX], height[i, st.END_WY] = ball.wx - turn * uy, ball.wy + turn * ux
    _rub(balls, i, -displacement / lasts * ux, -displacement / lasts * uy)
    if laws.air_drag > 0.0:
        most = friction * (1.0 + e) * up / (1.0 - e)
        _slow_bounces(height, balls, i, laws, up, rolls, most - rubbed)


@kernel
def _slow_bounces(
    height: FloatArray, balls: Balls, i: int, laws: Laws, up: float, rolls: float, spare: float
) -> None:
    """Let air slow ball i while bounces that begin with the speed `up` [m/s] end.

    Air slows its way by D = k v^2. Where it goes along far faster than up, air slows its rise by
    c = k v times its speed there: of a bounce at u that makes 2 u / g (1 - c u / 3g), after which
    it is slower by 2 c u^2 / 3g, and all together are shorter by c up / 3g (1 - e) of their time L.
    Straight up and down c is 3/4 k u, and they are shorter by k up^2 (1 + e) / 4g (1 - e^3). In
    between the root of both squares is as near as doubles can tell.

    In the last of L, `rolls` [s], the ball doesn't slip after any impact: the cloth returns 2/7 of
    what the air takes, each time at the next impact, as far as its friction reaches: `spare` [m/s]
    is what is left of that. With s = L - `rolls` and f for 2/7, the way is then shorter by D / 2
    times s^2 + (1 - f) (L^2 - s^2) + f `rolls`^2 (1 - e) / (1 + e). Left out is k times the square
    of what friction changes meanwhile, and that the slip turns.
    """
    ball, e = balls.state[i], laws.table_restitution
    lasts = height[i, st.LASTS]
    square = ball.vx * ball.vx + ball.vy * ball.vy
    rise = up * (1.0 + e) / (4.0 * (1.0 + e + e * e))
    slowed = laws.air_drag * math.sqrt(square / 9.0 + rise * rise)
    height[i, st.LASTS] = lasts / (1.0 + slowed * up / (laws.gravity * (1.0 - e)))
    drag = laws.air_drag * math.sqrt(square)
    middle = 1.0 / (1.0 + 0.5 * drag * lasts)  # of the speed
    dx, dy = drag * middle * middle * ball.vx, drag * middle * middle * ball.vy
    taken = lasts * math.sqrt(dx * dx + dy * dy)
    part = 0.0
    if rolls > 0.0 and taken > 0.0:
        part = min(STICKING, max(spare, 0.0) / taken)
    turn = 2.5 * part * lasts / ball.radius
    height[i, st.END_VX] -= (1.0 - part) * lasts * dx
    height[i, st.END_VY] -= (1.0 - part) * lasts * dy
    height[i, st.END_WX] += turn * dy
    height[i, st.END_WY] -= turn * dx
    slips = lasts - rolls
    squares = slips * slips + (1.0 - part) * (lasts * lasts - slips * slips)
    squares += part * rolls * rolls * (1.0 - e) / (1.0 + e)
    ball.vx -= 0.5 * squares / lasts * dx
    ball.vy -= 0.5 * squares / lasts * dy


@kernel
def land(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Let ball i, which is advanced to the instant at which it lands, bounce or stay down.

    The instant is rounded, and the height there with it: leaving it out changes the energy by as
    much to either side. Of 3 000 landings of balls that keep their speed, in the first 12 s, one
    changed it by 1e-15 of it, and all together by -3e-17 (+- 2e-17) a landing.
    """
    height[i, st.RISE] = 0.0
    respond_by_table(height, balls, i, laws)


@kernel
def end_bounces(height: FloatArray, balls: Balls, i: int, t: float) -> None:
    """Move ball i to where bounces too low to be followed have ended, at the instant t [s]."""
    ball = balls.state[i]
    ball.x += (t - ball.epoch) * ball.vx
    ball.y += (t - ball.epoch) * ball.vy
    ball.vx, ball.vy = height[i, st.END_VX], height[i, st.END_VY]
    ball.wx, ball.wy = height[i, st.END_WX], height[i, st.END_WY]
    ball.wz = slowed_spin(ball.wz, (t - ball.epoch) * ball.spin_slowing)
    height[i, st.LASTS] = 0.0
    ball.phase = st.SLIDING
    ball.fastest = 0.0
    ball.impacts = impacts_after(balls, i, t - ball.epoch, t)
    ball.epoch = t

"""Response of the table to a ball that may fly: rebound and friction.

A ball that moves down with speed v leaves the table with `table_restitution` v. If an impact pushes
a ball down onto the table, the table responds at the same time, after the impact. This order is a
choice. A joint law would treat a ball that can't move down like a ball of another mass.

Bounces that would rise less than `LOWEST_BOUNCE` aren't simulated one by one. They form a geometric
series: their duration, their effect on the velocity and the displacement of the ball have closed
forms, whether the ball sticks at one of the bounces or slips at all of them.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws
from ghostball.engine.core.tolerances import LOWEST_BOUNCE, TIME_ROUNDING
from ghostball.engine.impacts.impact import push_at_cloth
from ghostball.engine.impacts.laws.ball_frictional import STICKING
from ghostball.engine.motion.position import impacts_after, slowed_spin


@kernel
def respond_by_table(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Apply the response of the table to ball i, if the ball touches it: a rebound, and friction.

    The function also sets how the ball continues: in flight, in low bounces, or on the cloth.
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
    """Reverse the downward velocity of a ball, and apply the friction of the cloth."""
    ball = balls.state[i]
    down = -height[i, st.UP_SPEED]
    ux, uy = ball.vx - ball.radius * ball.wy, ball.vy + ball.radius * ball.wx
    slip = math.sqrt(ux * ux + uy * uy)
    most = ball.cloth_friction * (1.0 + laws.table_restitution) * down
    part = min(most / slip, STICKING) if slip > 0.0 else 0.0
    push_at_cloth(balls, i, -part * ux, -part * uy)
    height[i, st.UP_SPEED] = laws.table_restitution * down


@kernel
def _find_end_of_bounces(
    height: FloatArray, balls: Balls, i: int, laws: Laws, up: float, lasts: float
) -> None:
    """Compute low bounces of ball i, with upward speed `up` [m/s] at first and duration `lasts`.

    Impact n = 1, 2, ... has the speed e^(n-1) up, and the bounces after it take 2 e^n up /
    (g (1 - e)). Friction at this impact changes the velocity by mu (1 + e) e^(n-1) up, or only by
    the part that ends the slip; from then on the ball doesn't slip. If it never sticks, all impacts
    together change the velocity by mu (1 + e) up / (1 - e), and the displacement by
    2 mu e up^2 / (g (1 - e)^2).

    During the bounces, the ball moves uniformly with its mean velocity. So a part of the friction
    acts at the start, and the rest at the end. The effect of the air is divided likewise, see
    `_slow_bounces`.
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
    push_at_cloth(balls, i, -displacement / lasts * ux, -displacement / lasts * uy)
    if laws.air_drag > 0.0:
        most = friction * (1.0 + e) * up / (1.0 - e)
        _slow_bounces(height, balls, i, laws, up, rolls, most - rubbed)


@kernel
def _slow_bounces(
    height: FloatArray, balls: Balls, i: int, laws: Laws, up: float, rolls: float, spare: float
) -> None:
    """Apply the effect of air on ball i to low bounces that start with the upward speed `up` [m/s].

    Along the cloth, air decelerates the ball by D = k v^2. If the ball moves along the cloth much
    faster than `up`, air decelerates its vertical motion by c = k v times the vertical speed. A
    bounce with speed u then lasts 2 u / g (1 - c u / 3g), and returns with a speed lower by
    2 c u^2 / 3g. All bounces together are shorter by the fraction c up / 3g (1 - e) of their
    duration L. For vertical bounces c is 3/4 k u, and the fraction is
    k up^2 (1 + e) / 4g (1 - e^3). Between the two cases, the root of the sum of their squares is
    accurate to rounding.

    In the last part of L, `rolls` [s], the ball doesn't slip after any impact. At each impact the
    cloth then returns 2/7 of the velocity that air has taken since the last impact, as far as its
    friction allows; `spare` [m/s] is the friction still available. With s = L - `rolls` and
    f = 2/7, the displacement is shorter by D / 2 times
    s^2 + (1 - f) (L^2 - s^2) + f `rolls`^2 (1 - e) / (1 + e). Two effects are neglected: k times
    the square of the velocity change by friction, and the turning of the slip.
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
    """Let ball i, which is advanced to the time at which it lands, bounce or stay down.

    The landing time is rounded, so the computed height isn't exactly 0. Setting it to 0 changes the
    energy by amounts of either sign. In 3 000 landings of balls that keep their speed, in the first
    12 s, one landing changed the energy by about 1e-15 of it, and the mean change was
    -3e-17 (+- 2e-17).
    """
    height[i, st.RISE] = 0.0
    respond_by_table(height, balls, i, laws)


@kernel
def end_bounces(height: FloatArray, balls: Balls, i: int, t: float) -> None:
    """Move ball i to its position after its low bounces, which end at time t [s]."""
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

"""Impacts in scenes with flight, along the normal in space: of two balls, and of a ball and a nose.

Restitution acts along the normal, and Coulomb friction across it, against the slip of the surfaces.
So an impulse has a vertical component. It lifts a ball, or pushes a ball into the table, which
responds at the same time (`impacts.on_table`). The coefficients are those of the scene. The named
laws aren't used, except that a cushion law decides whether the cushion has friction.

Slow impacts of a ball in flight have rules of their own: see `impacts.slow_impacts`. Slow impacts
on the cloth are impacts in the plane by the laws of the scene (`impacts.impact`), because no ball
rises.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws, World
from ghostball.engine.core.tolerances import EPS, GAP_ROUNDING, GAP_ULPS
from ghostball.engine.impacts.impact import bounce, collide_balls, has_collapsed
from ghostball.engine.impacts.laws.ball_frictional import STICKING
from ghostball.engine.impacts.laws.compliant_contact import compliant_share
from ghostball.engine.impacts.laws.falling_restitution import restitution_at
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.impacts.lying_still import bounces_on, capture_speed, hold, is_wedged, settle
from ghostball.engine.impacts.on_table import respond_by_table
from ghostball.engine.impacts.slow_impacts import part_from_nose, part_slowly
from ghostball.engine.motion.geometry import reduced_mass
from ghostball.engine.motion.next_piece import keep_spin
from ghostball.engine.motion.obstacles import above_nose, facing


@kernel
def collide_in_space(height: FloatArray, world: World, i: int, j: int) -> None:
    """Collide balls i and j, of which one or both may be in the air; then the table responds.

    Contract: both balls are advanced to the time of the impact and approach each other.
    """
    balls, laws = world.balls, world.laws
    a, b = balls.state[i], balls.state[j]
    free = st.FLYING in (a.phase, b.phase)
    nx, ny = b.x - a.x, b.y - a.y
    nz = (height[j, st.BASE] + height[j, st.RISE]) - (height[i, st.BASE] + height[i, st.RISE])
    distance = math.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx / distance, ny / distance, nz / distance
    vx, vy, vz = a.vx - b.vx, a.vy - b.vy, height[i, st.UP_SPEED] - height[j, st.UP_SPEED]
    speed = vx * nx + vy * ny + vz * nz
    slow = capture_speed(laws, 0.5 * (a.radius + b.radius))
    if free and speed <= slow and settle(height, balls, i, j, laws):
        return
    collapsed = laws.ball_restitution < 1.0 and (
        has_collapsed(balls, i, laws) or has_collapsed(balls, j, laws)
    )
    if speed <= slow and not (free and collapsed):
        if free:
            overlap = a.radius + b.radius - distance
            part_slowly(height, world, i, j, nx, ny, nz, overlap)
        else:
            collide_balls(balls, i, j, laws)
        return
    keep_spin(balls, i)
    keep_spin(balls, j)
    reduced = reduced_mass(a.mass, b.mass)
    returned = max(laws.ball_restitution * speed, slow if free else 0.0)
    if collapsed:
        returned = 0.0
    normal = (speed + returned) * reduced
    # The slip of a's surface over b's: the velocity across the normal, plus (R_a w_a + R_b w_b) x
    # n.
    wx, wy = a.radius * a.wx + b.radius * b.wx, a.radius * a.wy + b.radius * b.wy
    wz = a.radius * a.wz + b.radius * b.wz
    sx = (vx - speed * nx) + (wy * nz - wz * ny)
    sy = (vy - speed * ny) + (wz * nx - wx * nz)
    sz = (vz - speed * nz) + (wx * ny - wy * nx)
    slip = math.sqrt(sx * sx + sy * sy + sz * sz)
    part = 0.0
    if slip > 0.0:
        part = min(friction_coefficient(laws, slip) * normal / slip, STICKING * reduced)
    px, py, pz = normal * nx + part * sx, normal * ny + part * sy, normal * nz + part * sz
    turn_x, turn_y = part * (ny * sz - nz * sy), part * (nz * sx - nx * sz)
    turn_z = part * (nx * sy - ny * sx)
    for k, sign in ((i, -1.0), (j, 1.0)):
        ball = balls.state[k]
        ball.vx += sign * px / ball.mass
        ball.vy += sign * py / ball.mass
        height[k, st.UP_SPEED] += sign * pz / ball.mass
        turn = 2.5 / (ball.mass * ball.radius)
        ball.wx -= turn * turn_x
        ball.wy -= turn * turn_y
        ball.wz -= turn * turn_z
    for k in (i, j):
        respond_by_table(height, balls, k, laws)


@kernel
def fastest_nose(height: FloatArray, balls: Balls, i: int, k: int, laws: Laws) -> int:
    """Return the obstacle whose nose ball i touches and approaches fastest; k in case of a tie.

    If several noses are hit at the same time, the order of the impacts matters. The order may
    depend on the motion, but not on the numbering of the cushions.
    """
    ball = balls.state[i]
    sizes = abs(ball.x) + abs(ball.y) + height[i, st.BASE] + height[i, st.RISE]
    reach = ball.radius + GAP_ROUNDING * ball.radius + GAP_ULPS * EPS * sizes
    fastest, first = 0.0, k
    balls.counters[st.WORK] += len(laws.obstacles)
    for other in range(len(laws.obstacles)):
        nx, ny, away = facing(laws, other, ball.x, ball.y)
        above = above_nose(height, i, laws, other)
        distance = math.sqrt(away * away + above * above)
        rate = (away * (nx * ball.vx + ny * ball.vy) + above * height[i, st.UP_SPEED]) / distance
        touches = distance <= reach and laws.obstacles[other].law != st.TAKES_OUT
        if touches and (-rate > fastest or (other == k and -rate == fastest)):
            fastest, first = -rate, other
    return first


@kernel
def bounce_off_nose(height: FloatArray, balls: Balls, i: int, k: int, laws: Laws) -> None:
    """Bounce ball i off the nose of obstacle k; then the table responds.

    If the law of the cushion has a factor on the velocity along the cushion, this factor is
    applied. If the nose is far above the ball's centre, the ball may approach the nose again at
    once: this is another impact.

    Contract: the ball is advanced to the time of the impact, and approaches the nose within
    rounding.
    """
    free = balls.state[i].phase == st.FLYING
    if not free:
        nx, ny, _ = facing(laws, k, balls.state[i].x, balls.state[i].y)
        rate = nx * balls.state[i].vx + ny * balls.state[i].vy
        if -rate <= capture_speed(laws, balls.state[i].radius):
            bounce(balls, i, k, laws)
            return
    keep_spin(balls, i)
    ball, cushion = balls.state[i], laws.obstacles[k]
    inward_x, inward_y, away = facing(laws, k, ball.x, ball.y)
    above = above_nose(height, i, laws, k)
    distance = math.sqrt(away * away + above * above)
    nx, ny, nz = -inward_x * away / distance, -inward_y * away / distance, -above / distance
    speed = abs(ball.vx * nx + ball.vy * ny + height[i, st.UP_SPEED] * nz)
    slow = capture_speed(laws, ball.radius)
    if free and speed <= slow:
        if bounces_on(height, balls, i, laws) and is_wedged(height, balls, i, laws):
            hold(height, balls, i)
            return
        part_from_nose(height, balls, i, laws, nx, ny, nz, speed, ball.radius - distance)
        return
    returned = restitution_at(speed, cushion.restitution, cushion.loss) * speed
    normal = speed + max(returned, slow if free else 0.0)
    along = inward_x * ball.vy - inward_y * ball.vx
    px, py, pz = -normal * nx, -normal * ny, -normal * nz
    if cushion.turns == 1.0:
        sx = (ball.vx - speed * nx) + ball.radius * (ball.wy * nz - ball.wz * ny)
        sy = (ball.vy - speed * ny) + ball.radius * (ball.wz * nx - ball.wx * nz)
        sz = (height[i, st.UP_SPEED] - speed * nz) + ball.radius * (ball.wx * ny - ball.wy * nx)
        slip = math.sqrt(sx * sx + sy * sy + sz * sz)
        part = min(cushion.friction * normal / slip, STICKING) if slip > 0.0 else 0.0
        if cushion.ratio > 0.0 and speed > 0.0:
            part = compliant_share(slip / speed, cushion.friction, returned / speed, cushion.ratio)
        px, py, pz = px - part * sx, py - part * sy, pz - part * sz
        turn = 2.5 * part / ball.radius
        ball.wx -= turn * (ny * sz - nz * sy)
        ball.wy -= turn * (nz * sx - nx * sz)
        ball.wz -= turn * (nx * sy - ny * sx)
    else:
        lost = (1.0 - cushion.tangential) * along
        px, py = px + lost * inward_y, py - lost * inward_x
    ball.vx += px
    ball.vy += py
    height[i, st.UP_SPEED] += pz
    respond_by_table(height, balls, i, laws)

"""Impacts where balls may leave the cloth: along the true normal, and on the table.

Restitution acts along the normal of the contact in space, Coulomb friction across it, against the
slip of the surfaces there; so an impulse has a vertical part, and lifts a ball, or presses it into
the table. The coefficients are the scene's; of the laws that it names, only whether that of the
cushions turns balls counts. Then the table answers at the same instant, after the impact that did
it: the speed downwards is returned `table_restitution` times, with the cloth's friction (that order
is a choice; a joint law would give the ball that can't yield downwards another mass).

A slow impact of a ball in flight, whose rebound would rise less than `CAPTURE_HEIGHT`, is elastic:
else a ball that lies on others would bounce ever faster before it slides off. And one on the table
that it presses down doesn't yield downwards then, by the joint law. It keeps its energy. As slow an
impact on the cloth is one in the plane, by the scene's laws (`impacts.impact`): nothing hops.

Bounces on the table that would rise less than `LOWEST_HOP` aren't followed one by one. They are a
geometric series: how long they take, which velocity their friction takes, and how far the ball goes
meanwhile have closed forms, whether it sticks at one of them or slips through all.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    BASE,
    END_VX,
    END_VY,
    END_WX,
    END_WY,
    FALL,
    FLYING,
    LASTS,
    RISE,
    ROLLING,
    SLIDING,
    UP_SPEED,
    Balls,
    FloatArray,
    Laws,
)
from ghostball.engine.core.tolerances import (
    CAPTURE_HEIGHT,
    LOWEST_HOP,
    TIME_ROUNDING,
)
from ghostball.engine.impacts.impact import bounce, collide_balls
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.motion.geometry import obstacle_in_contact, reduced_mass
from ghostball.engine.motion.next_piece import loosen
from ghostball.engine.motion.obstacles import facing

_ASIDE = 2.0**-20
"""How much the normal of a ball that is exactly above another, to which it falls slowly, is taken
to lean at least: nothing else would decide where it falls, or it would take seconds to."""

_STICKING = 2.0 / 7.0
"""Impulse over the mass that ends a slip of 1, of a solid sphere."""


@kernel
def collide_in_space(height: FloatArray, balls: Balls, i: int, j: int, laws: Laws) -> None:
    """Collide balls i and j, of which one or both may be in the air; then the table answers.

    Contract: both are advanced to the instant of the impact and approach each other.
    """
    a, b = balls.state[i], balls.state[j]
    free = FLYING in (a.phase, b.phase)
    nx, ny = b.x - a.x, b.y - a.y
    nz = (height[j, BASE] + height[j, RISE]) - (height[i, BASE] + height[i, RISE])
    distance = math.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx / distance, ny / distance, nz / distance
    vx, vy, vz = a.vx - b.vx, a.vy - b.vy, height[i, UP_SPEED] - height[j, UP_SPEED]
    speed = vx * nx + vy * ny + vz * nz
    slow = _capture_speed(laws, 0.5 * (a.radius + b.radius))
    if speed <= slow:
        if free:
            depth = a.radius + b.radius - distance
            _part_slowly(height, balls, i, j, laws, nx, ny, nz, depth)
            answer_by_table(height, balls, i, laws)
            answer_by_table(height, balls, j, laws)
        else:
            collide_balls(balls, i, j, laws)
        return
    set_free(balls, i)
    set_free(balls, j)
    reduced = reduced_mass(a.mass, b.mass)
    returned = max(laws.ball_restitution * speed, slow if free else 0.0)
    normal = (speed + returned) * reduced
    # The slip of a's surface over b's: what of the velocity is across, and (R_a w_a + R_b w_b) x n.
    wx, wy = a.radius * a.wx + b.radius * b.wx, a.radius * a.wy + b.radius * b.wy
    wz = a.radius * a.wz + b.radius * b.wz
    sx = (vx - speed * nx) + (wy * nz - wz * ny)
    sy = (vy - speed * ny) + (wz * nx - wx * nz)
    sz = (vz - speed * nz) + (wx * ny - wy * nx)
    slip = math.sqrt(sx * sx + sy * sy + sz * sz)
    part = 0.0
    if laws.rubs and slip > 0.0:
        part = min(friction_coefficient(laws, slip) * normal / slip, _STICKING * reduced)
    px, py, pz = normal * nx + part * sx, normal * ny + part * sy, normal * nz + part * sz
    turn_x, turn_y = part * (ny * sz - nz * sy), part * (nz * sx - nx * sz)
    turn_z = part * (nx * sy - ny * sx)
    for k, sign in ((i, -1.0), (j, 1.0)):
        ball = balls.state[k]
        ball.vx += sign * px / ball.mass
        ball.vy += sign * py / ball.mass
        height[k, UP_SPEED] += sign * pz / ball.mass
        turn = 2.5 / (ball.mass * ball.radius)
        ball.wx -= turn * turn_x
        ball.wy -= turn * turn_y
        ball.wz -= turn * turn_z
    for k in (i, j):
        answer_by_table(height, balls, k, laws)


@kernel
def _part_slowly(
    height: FloatArray,
    balls: Balls,
    i: int,
    j: int,
    laws: Laws,
    nx: float,
    ny: float,
    nz: float,
    depth: float,
) -> None:
    """Let two balls, of which one flies, part as fast as they approach, without friction.

    One on the table that is pressed down yields across only, and along a cushion that it touches:
    it goes on rolling if it rolls. A ball exactly above another falls off along x.

    Notes
    -----
    Where they overlap by `depth` [m], and would come less than half out again, they part fast
    enough to come out, and higher by `LOWEST_HOP`. Other balls that they hit meanwhile take energy
    from their hops, which would sink ever deeper; so what is missing for that comes from the slip.
    The impulse along it acts as a friction does, and no energy comes in.
    """
    vx, vy = balls.state[i].vx - balls.state[j].vx, balls.state[i].vy - balls.state[j].vy
    vz = height[i, UP_SPEED] - height[j, UP_SPEED]
    level = math.sqrt(nx * nx + ny * ny)
    if level < _ASIDE:
        lean_x = _ASIDE * (nx / level) if level > 0.0 else math.copysign(_ASIDE, nz)
        lean_y = _ASIDE * (ny / level) if level > 0.0 else 0.0
        lean_z = math.copysign(math.sqrt(1.0 - _ASIDE * _ASIDE), nz)
        approach = vx * lean_x + vy * lean_y + vz * lean_z
        if approach > 0.0:
            nx, ny, nz = lean_x, lean_y, lean_z
    held = True
    xx, xy, yy, zz, vx, vy = _yielding_together(height, balls, i, j, laws, held, nx, ny, nz)
    if not vx * nx + vy * ny + vz * nz > 0.0:
        held = False  # that it comes off its cushion is all of the approach
        xx, xy, yy, zz, vx, vy = _yielding_together(height, balls, i, j, laws, held, nx, ny, nz)
    speed = vx * nx + vy * ny + vz * nz
    yielding = xx * nx * nx + 2.0 * xy * nx * ny + yy * ny * ny + zz * nz * nz
    if yielding == 0.0:
        return
    px, py, pz, returned = 0.0, 0.0, 0.0, speed
    above = LOWEST_HOP * (balls.state[i].radius + balls.state[j].radius)
    missing = (2.0 * laws.gravity * (depth + above) - speed * speed) / yielding
    if speed * speed < laws.gravity * depth:
        # An impulse P gives the relative velocity v the change -Y P, Y how both yield, and the
        # energy -P.v + P.Y P / 2. With P = part d and n.Y d = 0 the normal speed stays, and the
        # energy given is -part q + part^2 r / 2.
        dx, dy, dz = vx - speed * nx, vy - speed * ny, vz - speed * nz
        tilt = ((xx * nx + xy * ny) * dx + (xy * nx + yy * ny) * dy + zz * nz * dz) / yielding
        dx, dy, dz = dx - tilt * nx, dy - tilt * ny, dz - tilt * nz
        q = dx * vx + dy * vy + dz * vz
        r = xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy + zz * dz * dz
        if r > 0.0 and q != 0.0:
            taken = min(missing, q * q / r)
            part = taken / (q + math.copysign(math.sqrt(max(q * q - r * taken, 0.0)), q))
            px, py, pz = part * dx, part * dy, part * dz
            returned = math.sqrt(speed * speed + taken * yielding)
    push = (speed + returned) / yielding
    px, py, pz = px + push * nx, py + push * ny, pz + push * nz
    for k, sign in ((i, -1.0), (j, 1.0)):
        xx, xy, yy, zz, _, _ = _yielding(
            height, balls, k, laws, held, sign * nx, sign * ny, sign * nz
        )
        if xx == 0.0 and yy == 0.0:
            continue
        ball = balls.state[k]
        if zz == 0.0 and ball.phase not in (SLIDING, FLYING):
            ball.phase = ROLLING
        else:
            set_free(balls, k)
        ball.vx += sign * (xx * px + xy * py)
        ball.vy += sign * (xy * px + yy * py)
        height[k, UP_SPEED] += sign * zz * pz


@kernel(inline=True)
def _yielding_together(
    height: FloatArray,
    balls: Balls,
    i: int,
    j: int,
    laws: Laws,
    held: bool,
    nx: float,
    ny: float,
    nz: float,
) -> tuple[float, float, float, float, float, float]:
    """Return what `_yielding` does, of ball i and ball j together: sums, and what is between."""
    xx, xy, yy, zz, vx, vy = _yielding(height, balls, i, laws, held, -nx, -ny, -nz)
    more_xx, more_xy, more_yy, more_zz, ux, uy = _yielding(height, balls, j, laws, held, nx, ny, nz)
    return xx + more_xx, xy + more_xy, yy + more_yy, zz + more_zz, vx - ux, vy - uy


@kernel
def _yielding(
    height: FloatArray,
    balls: Balls,
    k: int,
    laws: Laws,
    held: bool,
    nx: float,
    ny: float,
    nz: float,
) -> tuple[float, float, float, float, float, float]:
    """Return which velocity an impulse along a normal gives ball k, and which it has meanwhile.

    Of the matrix xx, xy, yy and zz [1/kg], of the velocity x and y [m/s]. One on the table that is
    pressed down doesn't yield downwards, nor, where cushions have `held` it, into one that it
    touches; in a corner it yields not at all.
    """
    ball = balls.state[k]
    over = 1.0 / ball.mass
    if height[k, RISE] > 0.0 or height[k, UP_SPEED] > 0.0 or nz >= 0.0:
        return over, 0.0, over, over, ball.vx, ball.vy
    if ball.phase not in (SLIDING, FLYING):
        over /= 1.4  # it rolls on
    touched, bx, by = 0, 0.0, 0.0
    for row in range(len(laws.obstacles) if held else 0):
        inward_x, inward_y, _ = facing(laws, row, ball.x, ball.y)
        if nx * inward_x + ny * inward_y < 0.0 and obstacle_in_contact(balls, k, laws, row):
            touched, bx, by = touched + 1, inward_x, inward_y
    if touched == 0:
        return over, 0.0, over, 0.0, ball.vx, ball.vy
    if touched > 1:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    along = bx * ball.vy - by * ball.vx
    return over * by * by, -over * bx * by, over * bx * bx, 0.0, -by * along, bx * along


@kernel(inline=True)
def _capture_speed(laws: Laws, radius: float) -> float:
    """Speed [m/s] of a rebound that rises `CAPTURE_HEIGHT`."""
    return 2.0 * math.sqrt(laws.gravity * CAPTURE_HEIGHT * radius)


@kernel
def bounce_off_nose(height: FloatArray, balls: Balls, i: int, k: int, laws: Laws) -> None:
    """Bounce ball i off the nose of obstacle k; then the table answers.

    The factor along the cushion, of the law that has one, is on the velocity there. Below a nose
    that is far above its centre a ball may approach it again at once: that is another impact.

    Contract: the ball is advanced to the instant of the impact, and approaches the nose but for
    rounding.
    """
    free = balls.state[i].phase == FLYING
    if not free:
        nx, ny, _ = facing(laws, k, balls.state[i].x, balls.state[i].y)
        rate = nx * balls.state[i].vx + ny * balls.state[i].vy
        if -rate <= _capture_speed(laws, balls.state[i].radius):
            bounce(balls, i, k, laws)
            return
    set_free(balls, i)
    ball = balls.state[i]
    inward_x, inward_y, away = facing(laws, k, ball.x, ball.y)
    above = height[i, BASE] + height[i, RISE] - laws.cushion_height
    distance = math.sqrt(away * away + above * above)
    nx, ny, nz = -inward_x * away / distance, -inward_y * away / distance, -above / distance
    speed = abs(ball.vx * nx + ball.vy * ny + height[i, UP_SPEED] * nz)
    slow = _capture_speed(laws, ball.radius)
    if free and speed <= slow:
        _part_from_nose(height, balls, i, laws, nx, ny, nz, speed, ball.radius - distance)
        return
    normal = speed + max(laws.cushion_restitution * speed, slow if free else 0.0)
    along = inward_x * ball.vy - inward_y * ball.vx
    px, py, pz = -normal * nx, -normal * ny, -normal * nz
    if laws.cushion_turns:
        sx = (ball.vx - speed * nx) + ball.radius * (ball.wy * nz - ball.wz * ny)
        sy = (ball.vy - speed * ny) + ball.radius * (ball.wz * nx - ball.wx * nz)
        sz = (height[i, UP_SPEED] - speed * nz) + ball.radius * (ball.wx * ny - ball.wy * nx)
        slip = math.sqrt(sx * sx + sy * sy + sz * sz)
        part = min(laws.cushion_friction * normal / slip, _STICKING) if slip > 0.0 else 0.0
        px, py, pz = px - part * sx, py - part * sy, pz - part * sz
        turn = 2.5 * part / ball.radius
        ball.wx -= turn * (ny * sz - nz * sy)
        ball.wy -= turn * (nz * sx - nx * sz)
        ball.wz -= turn * (nx * sy - ny * sx)
    else:
        lost = (1.0 - laws.cushion_tangential) * along
        px, py = px + lost * inward_y, py - lost * inward_x
    ball.vx += px
    ball.vy += py
    height[i, UP_SPEED] += pz
    answer_by_table(height, balls, i, laws)


@kernel
def _part_from_nose(
    height: FloatArray,
    balls: Balls,
    i: int,
    laws: Laws,
    nx: float,
    ny: float,
    nz: float,
    speed: float,
    depth: float,
) -> None:
    """Let ball i, which flies, part from a nose as fast as it approaches: as `_part_slowly`."""
    ball = balls.state[i]
    sx, sy, sz = ball.vx - speed * nx, ball.vy - speed * ny, height[i, UP_SPEED] - speed * nz
    slip = sx * sx + sy * sy + sz * sz
    above = LOWEST_HOP * 2.0 * ball.radius
    missing = 2.0 * laws.gravity * (depth + above) - speed * speed
    taken = min(missing, slip) if speed * speed < laws.gravity * depth else 0.0
    left = math.sqrt((slip - taken) / slip) if slip > 0.0 else 1.0
    returned = math.sqrt(speed * speed + taken)
    ball.vx, ball.vy = left * sx - returned * nx, left * sy - returned * ny
    height[i, UP_SPEED] = left * sz - returned * nz
    answer_by_table(height, balls, i, laws)


@kernel
def set_free(balls: Balls, i: int) -> None:
    """Let ball i keep its angular velocity while an impulse changes its velocity, in flight too."""
    if balls.state[i].phase != FLYING:
        loosen(balls, i)


@kernel
def answer_by_table(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Let the table answer to ball i, if it lies there: one that is pressed down comes up again.

    And say how it goes on: in the air, in bounces too low to be followed, or on the cloth.
    """
    height[i, LASTS] = 0.0
    if height[i, RISE] > 0.0:
        return
    height[i, RISE] = 0.0
    if height[i, UP_SPEED] < 0.0:
        _bounce_on_table(height, balls, i, laws)
    up = height[i, UP_SPEED]
    e = laws.table_restitution
    if up * up > 2.0 * laws.gravity * LOWEST_HOP * 2.0 * balls.state[i].radius:
        balls.state[i].phase = FLYING
        return
    height[i, UP_SPEED], height[i, FALL] = 0.0, 0.0
    if balls.state[i].phase == FLYING:
        balls.state[i].phase = SLIDING
    if e < 1.0:
        lasts = 2.0 * up / (laws.gravity * (1.0 - e))
        if lasts > 2.0 * TIME_ROUNDING * balls.state[i].epoch:
            _find_end_of_bounces(height, balls, i, laws, up, lasts)


@kernel
def _bounce_on_table(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Return a ball's speed downwards, and rub it on the cloth: it slips, or sticks."""
    ball = balls.state[i]
    down = -height[i, UP_SPEED]
    ux, uy = ball.vx - ball.radius * ball.wy, ball.vy + ball.radius * ball.wx
    slip = math.sqrt(ux * ux + uy * uy)
    most = ball.cloth_friction * (1.0 + laws.table_restitution) * down
    part = min(most / slip, _STICKING) if slip > 0.0 else 0.0
    _rub(balls, i, -part * ux, -part * uy)
    height[i, UP_SPEED] = laws.table_restitution * down


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

    Notes
    -----
    Impact n, from 1 on, comes at t_n, with e^(n-1) up; what is left then is 2 e^n up / (g (1 - e)).
    It takes mu (1 + e) e^(n-1) up of the velocity, or the 2/7 of the slip that are left; from there
    on nothing slips. If none sticks, all of them take mu (1 + e) up / (1 - e), and of the way
    2 mu e up^2 / (g (1 - e)^2).

    The ball goes that way at its mean velocity: so much of the friction acts at once, the rest at
    the end.
    """
    ball = balls.state[i]
    e, friction = laws.table_restitution, ball.cloth_friction
    ux, uy = ball.vx - ball.radius * ball.wy, ball.vy + ball.radius * ball.wx
    slip = math.sqrt(ux * ux + uy * uy)
    taken, way = 0.0, 0.0
    if slip > 0.0:
        if _STICKING * slip >= friction * (1.0 + e) * up / (1.0 - e):
            taken = friction * (1.0 + e) * up / (1.0 - e)
            way = 2.0 * friction * e * up * up / (laws.gravity * (1.0 - e) * (1.0 - e))
        else:
            speed, left = up, e * lasts
            while taken < _STICKING * slip and speed > 0.0:
                impulse = min(friction * (1.0 + e) * speed, _STICKING * slip - taken)
                taken += impulse
                way += impulse * left
                speed, left = e * speed, e * left
        taken, way = taken / slip, way / slip
    height[i, LASTS] = lasts
    turn = 2.5 * taken / ball.radius
    height[i, END_VX], height[i, END_VY] = ball.vx - taken * ux, ball.vy - taken * uy
    height[i, END_WX], height[i, END_WY] = ball.wx - turn * uy, ball.wy + turn * ux
    _rub(balls, i, -way / lasts * ux, -way / lasts * uy)


@kernel
def land(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Let ball i, which is advanced to the instant at which it lands, bounce or stay down."""
    height[i, RISE] = 0.0
    answer_by_table(height, balls, i, laws)


@kernel
def end_bounces(height: FloatArray, balls: Balls, i: int, t: float) -> None:
    """Move ball i to where bounces too low to be followed have ended, at the instant t [s]."""
    ball = balls.state[i]
    ball.x += (t - ball.epoch) * ball.vx
    ball.y += (t - ball.epoch) * ball.vy
    ball.vx, ball.vy = height[i, END_VX], height[i, END_VY]
    ball.wx, ball.wy = height[i, END_WX], height[i, END_WY]
    left = max(abs(ball.wz) - (t - ball.epoch) * ball.spin_slowing, 0.0)
    ball.wz = left if ball.wz > 0.0 else -left
    height[i, LASTS] = 0.0
    ball.phase = SLIDING
    ball.epoch = t

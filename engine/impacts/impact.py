"""One impact on the cloth: two balls, or a ball and a cushion, by the law of the scene.

This module transforms the state to the frame of the contact and back; `impacts.laws` computes the
effect of the impact. An upward impulse turns a ball but never lifts it: the cloth takes the
impulse. For scenes in which balls may leave the cloth see `impacts.in_space`, which uses this
module for impacts that are too slow to lift a ball. A `cushion` is any row of `Laws.obstacles`.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    Balls,
    Laws,
)
from ghostball.engine.impacts.laws.dispatch import (
    ball_law,
    cushion_law,
    is_ball_law_integrated,
    is_integrated,
)
from ghostball.engine.impacts.laws.interface import BallImpact, BallInFrame
from ghostball.engine.motion.geometry import rounding_of, speed_of
from ghostball.engine.motion.next_piece import keep_spin
from ghostball.engine.motion.obstacles import facing

_MOST_REBOUNDS = 128
"""Number of impacts of a ball at one time after which further impacts don't separate bodies.

With inelastic impacts, infinitely many impacts may follow each other in a finite time (inelastic
collapse: McNamara and Young 1992), until the balls lie against each other or a cushion. The clock
stands still long before, and the number of remaining impacts is unbounded. Usual shots stay below
this limit: a ball in a frozen line has at most about one impact for each ball of the line. Elastic
impacts, which lose no energy, always separate bodies.
"""

_MOST_WITHOUT_FRICTION = 24
"""The limit in place of `_MOST_REBOUNDS` if nothing slows balls.

Balls that lie together then collapse again after each impact on one of them: 400 balls with
restitution 0.2 took more than 1e7 events with a limit of 128 impacts, and 4e6 with 24.
"""

MOST_IN_CORNER = 512
"""Largest number of bounces of a ball in a corner at one time.

It is enough for a ball to leave a corner of 0.4 degrees. If a ball can also leave a sharper corner,
because the cushions take little energy, its bounces become several events at one time.
"""

_UNSETTLED = 32
"""Number of bounces in a corner during which friction may still change how the spin develops."""

_E_FOLDS_TO_ROUNDING = 36.0
"""ln(2^52): number of e-folds after which a speed is below the rounding of its initial value."""

_WORK_OF_BOUNCE = 4
_WORK_OF_INTEGRATION = 4096
"""Units of work of a bounce off a cushion, and of an impact whose law integrates over it."""


@kernel(inline=True)
def collide_balls(balls: Balls, i: int, j: int, laws: Laws) -> None:
    """Collide balls i and j by the scene's law.

    Contract: both balls are advanced to the time of the impact and approach each other.

    The unit normal is exact along an axis, and the shares are exactly 1/2 for equal masses. So a
    head-on collision along an axis stops a ball exactly.
    """
    if not laws.slides:
        # Only laws without spin remain: the paper's section 4.2 (docs/paper.md), with (1 + e) / 2.
        nx, ny = contact_normal(balls, i, j)
        vx, vy = balls.state[j].vx - balls.state[i].vx, balls.state[j].vy - balls.state[i].vy
        exchange = -(1.0 + laws.ball_restitution) * (nx * vx + ny * vy)
        _exchange(balls, i, j, nx, ny, exchange - exchange * excess_length(nx, ny))
        return
    keep_spin(balls, i)
    keep_spin(balls, j)
    balls.counters[st.WORK] += _WORK_OF_INTEGRATION if is_ball_law_integrated(laws) else 0
    nx, ny = contact_normal(balls, i, j)
    impulse = ball_law(BallImpact(_in_frame(balls, i, nx, ny), _in_frame(balls, j, nx, ny)), laws)
    longer = excess_length(nx, ny)
    _exchange(balls, i, j, nx, ny, impulse.normal - impulse.normal * longer)
    if impulse.along != 0.0 or impulse.up != 0.0:
        # The tangential impulse, with opposite signs on the two balls, and its change of spin: R/I
        # is 5 / (2 m R), so a change of spin is 5/2 of the change of velocity over the radius.
        tx, ty = -ny, nx
        _exchange(balls, i, j, tx, ty, impulse.along - impulse.along * longer)
        to_i, to_j = _shares(balls, i, j)
        for k, share in ((i, to_i), (j, to_j)):
            turn = 2.5 * share / balls.state[k].radius
            balls.state[k].wx += turn * impulse.up * tx
            balls.state[k].wy += turn * impulse.up * ty
            balls.state[k].wz -= turn * impulse.along
    _rub_cloth(balls, i, nx, ny, impulse.a_cloth_n, impulse.a_cloth_t)
    _rub_cloth(balls, j, nx, ny, impulse.b_cloth_n, impulse.b_cloth_t)


@kernel(inline=True)
def has_collapsed(balls: Balls, i: int, laws: Laws) -> bool:
    """Return whether ball i had so many impacts at its epoch that no further one separates bodies.

    The result depends only on the numbers of the ball and the scene, so no skip changes it.
    """
    ball = balls.state[i]
    slowed = ball.roll_slowing > 0.0 or (laws.slides and ball.slide_slowing > 0.0)
    slowed = slowed or laws.air_drag > 0.0 or laws.roll_quadratic > 0.0
    return bool(ball.impacts >= (_MOST_REBOUNDS if slowed else _MOST_WITHOUT_FRICTION))


@kernel
def contact_normal(balls: Balls, i: int, j: int) -> tuple[float, float]:
    """Return the unit normal from ball i to ball j, both at the same time."""
    rx, ry = balls.state[j].x - balls.state[i].x, balls.state[j].y - balls.state[i].y
    distance = math.sqrt(rx * rx + ry * ry)
    return rx / distance, ry / distance


@kernel
def excess_length(nx: float, ny: float) -> float:
    """Return |n|^2 - 1 for a rounded unit normal n, to about 32 digits.

    An impulse along such a normal changes the energy too much by this fraction. Balls that touch
    have the same distance each time, rounded in the same way, so the errors don't cancel: 10^7
    collisions of a gas gained 3e-13 of the energy. Along an axis the result is 0.

    The computation uses the squares of both halves of each number (Dekker 1971), and the rounding
    error of their sum (Knuth 1969). The result is the same for (ny, nx), so mirrored impacts stay
    mirrored to the bit. A simpler form, (nx^2 - 1/2) + (ny^2 - 1/2), left a third of the gain;
    (nx^2 - 1) + ny^2 isn't symmetric.
    """
    xx, yy = nx * nx, ny * ny
    total = xx + yy
    rest = total - xx
    lost = (xx - (total - rest)) + (yy - rest)
    return (total - 1.0) + (lost + (_lost_by_square(nx, xx) + _lost_by_square(ny, yy)))


@kernel
def _lost_by_square(a: float, square: float) -> float:
    """Return the rounding error of the square of a, for |a| < 1."""
    scaled = 134_217_729.0 * a  # 2^27 + 1: splits off the upper 26 bits
    upper = scaled - (scaled - a)
    lower = a - upper
    return ((upper * upper - square) + 2.0 * (upper * lower)) + lower * lower


@kernel
def _shares(balls: Balls, i: int, j: int) -> tuple[float, float]:
    """Return the parts of a change of their relative velocity that balls i and j take; sum 1.

    The larger part is 1 minus the smaller.
    """
    total = balls.state[i].mass + balls.state[j].mass
    if balls.state[i].mass >= balls.state[j].mass:
        to_i = balls.state[j].mass / total
        return to_i, 1.0 - to_i
    to_j = balls.state[i].mass / total
    return 1.0 - to_j, to_j


@kernel
def _exchange(balls: Balls, i: int, j: int, nx: float, ny: float, exchange: float) -> None:
    """Change the velocity of ball j relative to ball i by `exchange` [m/s] along (nx, ny).

    The larger part is the exchange minus the smaller part. If it were computed from a quotient near
    1, its rounding would be the same in each collision of the two balls, and accumulate (31 415
    collisions of Galperin's balls: 1e-12 of the energy).
    """
    total = balls.state[i].mass + balls.state[j].mass
    if balls.state[i].mass >= balls.state[j].mass:
        to_i = exchange * (balls.state[j].mass / total)
        to_j = exchange - to_i
    else:
        to_j = exchange * (balls.state[i].mass / total)
        to_i = exchange - to_j
    balls.state[i].vx -= to_i * nx
    balls.state[i].vy -= to_i * ny
    balls.state[j].vx += to_j * nx
    balls.state[j].vy += to_j * ny


@kernel(inline=True)
def _in_frame(balls: Balls, k: int, nx: float, ny: float) -> BallInFrame:
    """Return ball k in the frame of a contact: n = (nx, ny), t = (-ny, nx), z."""
    ball = balls.state[k]
    return BallInFrame(
        nx * ball.vx + ny * ball.vy,
        nx * ball.vy - ny * ball.vx,
        nx * ball.wx + ny * ball.wy,
        nx * ball.wy - ny * ball.wx,
        ball.wz,
        ball.radius,
        ball.mass,
        ball.cloth_friction,
    )


@kernel
def _rub_cloth(balls: Balls, k: int, nx: float, ny: float, along_n: float, along_t: float) -> None:
    """Apply the cloth's impulse at the lowest point of ball k, over its mass [m/s]."""
    if along_n != 0.0 or along_t != 0.0:
        push_at_cloth(balls, k, along_n * nx - along_t * ny, along_n * ny + along_t * nx)


@kernel(inline=True)
def push_at_cloth(balls: Balls, k: int, cx: float, cy: float) -> None:
    """Apply an impulse over the mass [m/s] to ball k at its lowest point."""
    ball = balls.state[k]
    turn = 2.5 / ball.radius
    ball.vx += cx
    ball.vy += cy
    ball.wx += turn * cy
    ball.wy -= turn * cx


@kernel
def bounce(balls: Balls, i: int, cushion: int, laws: Laws) -> None:
    """Bounce ball i off a cushion by the scene's law.

    Contract: the ball is advanced to the time of the impact. It leaves the cushion whatever sign
    rounding gave to a vanishing approach. If its speed away from the cushion is within the rounding
    of its velocity, now or before the impulses at this time, it moves along the cushion: between
    two noses without space it would bounce endlessly.
    """
    inward_x, inward_y, _ = facing(laws, cushion, balls.state[i].x, balls.state[i].y)
    nx, ny = -inward_x, -inward_y
    if laws.slides:
        keep_spin(balls, i)
    integrated = is_integrated(laws, cushion)
    balls.counters[st.WORK] += _WORK_OF_INTEGRATION if integrated else _WORK_OF_BOUNCE
    vn, vt, wn, wt, wz, radius, mass, cloth = _in_frame(balls, i, nx, ny)
    impact = BallInFrame(abs(vn), vt, wn, wt, wz, radius, mass, cloth)
    after = cushion_law(impact, laws, cushion)
    vn = after.vn
    terms = abs(vn) + abs(after.vt)
    if laws.slides:
        terms += balls.state[i].radius * (abs(after.wn) + abs(after.wt) + abs(after.wz))
    terms = max(terms, balls.state[i].fastest)
    row = laws.obstacles[cushion]
    inelastic = row.restitution < 1.0 or row.loss > 0.0
    if abs(vn) <= rounding_of(terms) or (inelastic and has_collapsed(balls, i, laws)):
        vn = 0.0
    balls.state[i].vx, balls.state[i].vy = _from_contact_frame(vn, after.vt, nx, ny)
    balls.state[i].wx, balls.state[i].wy = _from_contact_frame(after.wn, after.wt, nx, ny)
    balls.state[i].wz = after.wz


@kernel(inline=True)
def _from_contact_frame(n: float, t: float, nx: float, ny: float) -> tuple[float, float]:
    """Return the vector n (nx, ny) + t (-ny, nx), where n and t were computed with (nx, ny), too.

    A slanting cushion has the same rounded normal at each bounce. Without the division by the
    square of its length, 6 000 bounces between two such cushions gained 9e-13 of the energy.
    """
    x1, x2, y1, y2 = n * nx, -t * ny, n * ny, t * nx
    longer = excess_length(nx, ny)
    if longer == 0.0:
        return x1 + x2, y1 + y2
    return _shortened_sum(x1, x2, longer), _shortened_sum(y1, y2, longer)


@kernel(inline=True)
def _shortened_sum(a: float, b: float, longer: float) -> float:
    """Return (a + b) (1 - longer), where longer is about the rounding of a double.

    The whole correction is applied to the smaller summand; in the sum, or in the larger summand, it
    would be rounded away.
    """
    shorter = (a + b) * longer
    if abs(a) < abs(b):
        return b + (a - shorter)
    return a + (b - shorter)


@kernel
def bounce_in_corner(
    balls: Balls, i: int, cushion: int, other: int, laws: Laws
) -> tuple[int, bool]:
    """Bounce ball i off two cushions that it touches, off each in turn, until it leaves both.

    Return the number of bounces, and whether the ball jams in the corner. In a corner of 45 degrees
    it bounces four times. If it approaches both cushions, rounding would decide which is first; so
    the ball gets the mean of the velocities after both orders, with the mean of their energies. If
    both orders give the same velocity, as in a corner whose angle divides two right angles, only
    the law removes energy. (An earlier version took the mean of two single bounces, which stopped a
    ball there.) If it doesn't approach `other`, the bounce off `cushion` is the first.
    """
    nx, ny, _ = facing(laws, other, balls.state[i].x, balls.state[i].y)
    at_once = nx * balls.state[i].vx + ny * balls.state[i].vy < 0.0
    if laws.slides:
        keep_spin(balls, i)
    vx, vy = balls.state[i].vx, balls.state[i].vy
    wx, wy, wz = balls.state[i].wx, balls.state[i].wy, balls.state[i].wz
    bounces, jams = _bounce_until_off(balls, i, cushion, other, laws)
    if not at_once:
        return bounces, jams
    vx1, vy1 = balls.state[i].vx, balls.state[i].vy
    wx1, wy1, wz1 = balls.state[i].wx, balls.state[i].wy, balls.state[i].wz
    balls.state[i].vx, balls.state[i].vy = vx, vy
    balls.state[i].wx, balls.state[i].wy, balls.state[i].wz = wx, wy, wz
    again, jams_too = _bounce_until_off(balls, i, other, cushion, laws)
    vx2, vy2 = balls.state[i].vx, balls.state[i].vy
    vx, vy = 0.5 * (vx2 + vx1), 0.5 * (vy2 + vy1)
    kept, square = 0.5 * ((vx1 * vx1 + vy1 * vy1) + (vx2 * vx2 + vy2 * vy2)), vx * vx + vy * vy
    if square > 0.0:
        longer = math.sqrt(kept / square)
        vx, vy = longer * vx, longer * vy
    balls.state[i].vx, balls.state[i].vy = vx, vy
    balls.state[i].wx = 0.5 * (balls.state[i].wx + wx1)
    balls.state[i].wy = 0.5 * (balls.state[i].wy + wy1)
    balls.state[i].wz = 0.5 * (balls.state[i].wz + wz1)
    return max(bounces, again), jams and jams_too


@kernel
def _bounce_until_off(
    balls: Balls, i: int, first: int, second: int, laws: Laws
) -> tuple[int, bool]:
    """Bounce ball i off two cushions in turn until it approaches neither, or jams.

    Return the number of bounces, at most `MOST_IN_CORNER`, and whether the ball jams: its speed is
    below the rounding of its initial speed, or will be before the ball turns back. The second case
    is predicted when the direction changes steadily from one bounce to the next. So an inelastic
    ball comes to rest in a corner that is too sharp for its cushions, after infinitely many bounces
    in a finite time. Between parallel cushions it moves along them.
    """
    near, far = first, second
    nx, ny, _ = facing(laws, near, balls.state[i].x, balls.state[i].y)
    ox, oy, _ = facing(laws, far, balls.state[i].x, balls.state[i].y)
    settled = _UNSETTLED if nx * oy != ny * ox else MOST_IN_CORNER
    vx, vy = balls.state[i].vx, balls.state[i].vy
    least = rounding_of(max(abs(vx) + abs(vy), balls.state[i].fastest))
    for turn in range(MOST_IN_CORNER):
        bounce(balls, i, near, laws)
        near, far = far, near
        ball = balls.state[i]
        nx, ny, _ = facing(laws, near, ball.x, ball.y)
        if not nx * ball.vx + ny * ball.vy < 0.0:
            return turn + 1, False
        if abs(ball.vx) + abs(ball.vy) <= least:
            return turn + 1, True
        if turn % 2 == 1:
            if turn > settled and _slows_before_it_turns(vx, vy, ball.vx, ball.vy):
                return turn + 1, True
            vx, vy = ball.vx, ball.vy
    return MOST_IN_CORNER, False


@kernel
def _slows_before_it_turns(vx: float, vy: float, to_vx: float, to_vy: float) -> bool:
    """Return whether repeating a change from (vx, vy) to (to_vx, to_vy) stops a ball first.

    That is, its speed is at its rounding before its direction has turned by one radian.
    """
    before, after = speed_of(vx, vy), speed_of(to_vx, to_vy)
    turned = abs(vx * to_vy - vy * to_vx)
    return _E_FOLDS_TO_ROUNDING * turned < after * (before - after)

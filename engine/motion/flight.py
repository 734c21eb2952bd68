"""Flight: the height of flying balls, and when they land, hit a nose, or fly over an obstacle.

`scheduling.time_of_impact` finds collisions of flying balls; `impacts.in_space` resolves collisions
and bounces. A flying ball moves along a parabola, or in air as in `motion.flight_in_air`, and keeps
its angular velocity. It lands when its lowest point is back on the cloth. When bounces have become
lower than `LOWEST_BOUNCE`, so that the ball hardly leaves the cloth, all further bounces are one
motion of known duration.

On a table that isn't a plain rectangle, straight noses have ends, and jaws have round noses. A ball
that flies over one of these is off the table; posts are taller than any flight. A flying ball falls
into a hole if it lands in it, or if it reaches the far edge no higher than `HIGHEST_AT_BACK`. If it
is higher there, it flies over the back of the pocket, and is off the table.

Two balls touch when the distance of their centres in space is the sum of their radii. A ball and a
cushion touch when the distance of its centre from the nose, a line at `cushion_height` above the
cloth, is its radius. So balls of different radii on the cloth touch at the distance 2 sqrt(R_a R_b)
in plan, and a ball of radius R on the cloth touches a nose of height h at sqrt(h (2 R - h)). In
scenes whose balls stay on the cloth, distances are those in the plane: R_a + R_b, and R.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws
from ghostball.engine.core.tolerances import (
    CAPTURE_HEIGHT,
    EPS,
    GAP_ROUNDING,
    GAP_ULPS,
    LOWEST_BOUNCE,
    TIME_ROUNDING,
)
from ghostball.engine.motion.crossings import first_bent_crossing
from ghostball.engine.motion.flight_in_air import flight_piece, time_to_pass
from ghostball.engine.motion.frame import flies_inside
from ghostball.engine.motion.geometry import speed_of
from ghostball.engine.motion.obstacles import MOST_BOUNDS, facing, is_post, turning
from ghostball.engine.motion.position import (
    FOR_EVER,
    jerk_along,
    one_flies,
    whole_motion,
    with_rises,
)

HIGHEST_AT_BACK = 1.4
"""Largest height of a ball's centre, in radii, at which the edge of a hole keeps it in.

The value is that of pooltool, which uses it for balls that bounce off the back of a pocket into the
hole. At the edge towards the table there is no back, but the rule is the same, because such a ball
would land on the lip.
"""

_BESIDE = 2.0**-30
"""Distance beside a nose, in radii, at which a ball still counts as flying over the nose.

This distance is larger than rounding, so that no ball escapes between two pieces of an outline.
"""


@kernel(inline=True)
def may_meet_in_space(balls: Balls) -> bool:
    """Return whether any ball is in flight, or lies higher than others because it is larger.

    Mostly there is no such ball, even in scenes where balls may leave the cloth.
    """
    if balls.height is None:
        return False
    count = 0
    for i in range(len(balls.own_kind)):
        count += balls.state[i].phase == st.FLYING
        count += balls.height[i, st.BASE] != balls.height[0, st.BASE]
    return count > 0


@kernel(inline=True)
def meets_in_space(balls: Balls, i: int, j: int) -> bool:
    """Return whether two balls touch along a line that isn't horizontal."""
    if balls.height is None:
        return False
    return one_flies(balls, i, j) or bool(balls.height[i, st.BASE] != balls.height[j, st.BASE])


@kernel(inline=True)
def vertical_motion(
    height: FloatArray, balls: Balls, i: int, t: float
) -> tuple[float, float, float]:
    """Return height [m], upward speed [m/s] and upward acceleration of ball i at t [s].

    The height is that of its centre above the cloth.
    """
    s = t - balls.state[i].epoch
    up, fall = height[i, st.UP_SPEED], height[i, st.FALL]
    z = height[i, st.BASE] + height[i, st.RISE] + s * (up - 0.5 * fall * s)
    return with_rises(balls, i, s, z, up - fall * s, -fall)


@kernel
def motion_in_space(
    height: FloatArray, balls: Balls, i: int, j: int, t: float
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Return position, velocity, acceleration of ball j relative to ball i at the time t [s]."""
    xi, yi, vxi, vyi, axi, ayi = whole_motion(balls, i, t)
    xj, yj, vxj, vyj, axj, ayj = whole_motion(balls, j, t)
    zi, vzi, azi = vertical_motion(height, balls, i, t)
    zj, vzj, azj = vertical_motion(height, balls, j, t)
    return (
        xj - xi,
        yj - yi,
        zj - zi,
        vxj - vxi,
        vyj - vyi,
        vzj - vzi,
        axj - axi,
        ayj - ayi,
        azj - azi,
    )


@kernel(inline=True)
def one_is_loaded(balls: Balls, i: int, j: int, t: float) -> bool:
    """Return whether a flying ball has lain on one of two balls just before the time t [s]."""
    if balls.height is None:
        return False
    return bool(max(balls.height[i, st.LOADED], balls.height[j, st.LOADED]) > t)


@kernel
def is_near(height: FloatArray, balls: Balls, i: int, j: int, t: float) -> bool:
    """Return whether the gap of balls i and j at t [s] is at most that of a negligible bounce."""
    rx, ry, rz, _, _, _, _, _, _ = motion_in_space(height, balls, i, j, t)
    near = (1.0 + 2.0 * CAPTURE_HEIGHT) * (balls.state[i].radius + balls.state[j].radius)
    return bool(rx * rx + ry * ry + rz * rz <= near * near)


@kernel
def fly(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Start ball i's flight and set its own next event: landing, a nose, or leaving the table.

    A ball that is held still on other balls has no next event.
    """
    ball = balls.state[i]
    ball.ax, ball.ay, ball.bx, ball.by, ball.bz = 0.0, 0.0, 0.0, 0.0, 0.0
    if height[i, st.HELD] == 1.0:
        ball.own_time = math.inf
        balls.own_kind[i] = st.OWN_NONE
        return
    height[i, st.FALL] = laws.gravity
    if laws.air_drag > 0.0:
        duration = flight_piece(height, balls, i, laws)
    else:
        rise, up = height[i, st.RISE], height[i, st.UP_SPEED]
        root = math.sqrt(up * up + 2.0 * laws.gravity * rise)
        duration = (up + root) / laws.gravity if up > 0.0 else 2.0 * rise / (root - up)
        balls.own_kind[i] = st.OWN_LAND
    lasts, count = duration, len(laws.obstacles)
    if laws.outer < count and flies_inside(balls, i, laws, duration):
        count = laws.outer
    for k in range(count):
        if laws.obstacles[k].law != st.TAKES_OUT:
            s, met = _time_to_nose(height, balls, i, laws, k, duration, lasts)
            if s < duration:
                duration = s
                balls.own_kind[i] = st.OWN_CUSHION + k if met else st.OWN_PIECE
        away, rate = _way_over(balls, i, laws, k)
        if rate < 0.0 and away < -rate * duration:
            s = away / -rate
            if laws.air_drag > 0.0:
                s = time_to_pass(balls, i, away, rate, duration)
            kind = _passes(height, balls, i, laws, k, s) if s < duration else st.OWN_NONE
            if kind != st.OWN_NONE:
                duration = s
                balls.own_kind[i] = kind
    ball.own_time = ball.epoch + duration


@kernel(inline=True)
def _way_over(balls: Balls, i: int, laws: Laws, k: int) -> tuple[float, float]:
    """Return the distance [m] to the place where ball i flies over obstacle k, and its rate [m/s].

    The rate is negative; 0: the ball never flies over it. For a hole: to the far edge.
    """
    if laws.obstacles[k].kind == st.LINE:
        nx, ny, away = facing(laws, k, balls.state[i].x, balls.state[i].y)
        return max(away, 0.0), nx * balls.state[i].vx + ny * balls.state[i].vy
    return _way_over_piece(balls, i, laws, k)


@kernel
def _way_over_piece(balls: Balls, i: int, laws: Laws, k: int) -> tuple[float, float]:
    """Return `_way_over` for a segment, whose left side is the table's, or for a disc."""
    ball, row = balls.state[i], laws.obstacles[k]
    x, y, vx, vy = ball.x - row.x, ball.y - row.y, ball.vx, ball.vy
    beside = _BESIDE * ball.radius
    if row.kind == st.SEGMENT:
        dx, dy = row.nx - row.x, row.ny - row.y
        size = math.sqrt(dx * dx + dy * dy)
        dx, dy = dx / size, dy / size
        away, rate = dx * y - dy * x, dx * vy - dy * vx
        if away < -beside or not rate < 0.0:
            return 0.0, 0.0
        away = max(away, 0.0)
        along = dx * x + dy * y + (away / -rate) * (dx * vx + dy * vy)
        return (away, rate) if along > -beside and along < size + beside else (0.0, 0.0)
    speed = speed_of(vx, vy)
    if speed == 0.0 or is_post(laws, k):
        return 0.0, 0.0
    ux, uy = vx / speed, vy / speed
    middle, off = -(ux * x + uy * y), abs(ux * y - uy * x)
    square = (row.radius - off) * (row.radius + off)
    if square <= 0.0:
        return 0.0, 0.0
    # The ball flies over the far edge of a hole, or the near edge of a disc.
    root = math.sqrt(square)
    distance = middle + (root if row.law == st.TAKES_OUT else -root)
    return (max(distance, 0.0), -speed) if distance > -beside else (0.0, 0.0)


@kernel
def _passes(height: FloatArray, balls: Balls, i: int, laws: Laws, k: int, s: float) -> int:
    """Return the own event of ball i when it is over obstacle k after s seconds, or OWN_NONE."""
    row = laws.obstacles[k]
    if row.law != st.TAKES_OUT:
        return st.OWN_OVER + k
    ball = balls.state[i]
    z, _, _ = vertical_motion(height, balls, i, ball.epoch + s)
    if z <= HIGHEST_AT_BACK * ball.radius:
        return st.OWN_CUSHION + k
    x, y, _, _, _, _ = _in_plan(balls, i, s)
    # In front of the middle of the hole is the table, between two facings.
    behind = row.nx * (x - row.x) + row.ny * (y - row.y) <= 0.0
    return st.OWN_OVER + k if behind else st.OWN_NONE


@kernel(inline=True)
def _in_plan(balls: Balls, i: int, s: float) -> tuple[float, float, float, float, float, float]:
    """Return position, velocity and acceleration of a ball s seconds after its flight started."""
    ball = balls.state[i]
    if balls.powers is not None and balls.powers[i, st.COUNT] > 0.0:
        return whole_motion(balls, i, ball.epoch + s)
    return ball.x + s * ball.vx, ball.y + s * ball.vy, ball.vx, ball.vy, 0.0, 0.0


@kernel(inline=True)
def jerk_up(balls: Balls, i: int) -> float:
    """Return the largest rate of change of ball i's upward acceleration, on its piece [m/s^3]."""
    bent: float = 0.0 if balls.powers is None else balls.powers[i, st.JERK_UP]
    return bent


@kernel
def _time_to_nose(
    height: FloatArray, balls: Balls, i: int, laws: Laws, k: int, duration: float, lasts: float
) -> tuple[float, bool]:
    """Return the time until a flying ball touches the nose of obstacle k [s], or inf.

    Only contacts within `duration` [s] count; `lasts` [s] is the whole length of the ball's piece.
    The second value is False if the search was stopped: no contact before that time.

    Each lower bound is computed from the previous one, in the vertical plane across the nose. The
    nose is a point in this plane.
    """
    ball = balls.state[i]
    s = 0.0
    for _ in range(MOST_BOUNDS):
        balls.counters[st.WORK] += 4
        t = ball.epoch + s
        x, y, vx, vy, ax, ay = _in_plan(balls, i, s)
        z, vz, az = vertical_motion(height, balls, i, t)
        nx, ny, away = facing(laws, k, x, y)
        above = z - laws.obstacles[k].height
        if is_post(laws, k):
            above, vz, az = 0.0, 0.0, 0.0
        distance = math.sqrt(away * away + above * above)
        ex, ez = away / distance, above / distance
        gap = max(distance - ball.radius, 0.0)
        rate = ex * (nx * vx + ny * vy) + ez * vz
        pull = ex * (nx * ax + ny * ay) + ez * az
        bent = abs(ex) * jerk_along(balls, i, nx, ny) + abs(ez) * jerk_up(balls, i)
        left = min(lasts - s, FOR_EVER)
        # The nose is a point in this plane. The normal turns as the ball passes this point, and
        # also as it moves round a nose that is curved in plan.
        across, along = ez * (nx * vx + ny * vy) - ex * vz, nx * vy - ny * vx
        opening = pull + across * across / distance + ex * turning(laws, k, x, y) * along * along
        if rate >= 0.0 and pull >= bent * left:
            return math.inf, True
        step = first_bent_crossing(gap, rate, pull, bent, left)
        rounding = GAP_ROUNDING * ball.radius + GAP_ULPS * EPS * (abs(x) + abs(y) + abs(z))
        if gap <= rounding or not step > TIME_ROUNDING * t:
            overlap = ball.radius - distance
            step = time_to_impact(
                laws.gravity, overlap, rate, pull, opening, ball.radius, bent, left
            )
            if step == 0.0:
                return s, True
            step = max(step, 2.0 * TIME_ROUNDING * t)
        s += step
        if not s < duration:
            return math.inf, True
    return s, False


@kernel(inline=True)
def time_to_impact(
    gravity: float,
    overlap: float,
    rate: float,
    pull: float,
    opening: float,
    radius: float,
    bent: float,
    left: float,
) -> float:
    """Return a lower bound on the time [s] until touching bodies in flight have an impact; 0: now.

    An approach that is fast enough to bounce is an impact now. A ball that moves away as fast has
    its impact when it comes back. A slower ball may overlap by `LOWEST_BOUNCE` first, because a
    ball pulled over that distance is fast enough. A ball that already overlaps by this distance may
    move on by a quarter of it. If the overlap is twice this distance, any approach is an impact.

    `pull` [m/s^2] is the acceleration along the normal, which changes by up to `bent` a second
    [m/s^3] for `left` seconds. `opening` [m/s^2] is the acceleration of the gap, which includes the
    turning of the normal: a ball that touches the top of another at high speed isn't pulled towards
    it, however slowly it approaches. If `opening` is near 0, a small part of gravity replaces it:
    otherwise a rate that is only rounding would be a bounce.
    """
    sink = 2.0 * LOWEST_BOUNCE * radius
    lowest = 0.5 * sink * max(-opening, 2.0**-10 * gravity)
    bounces = rate * rate > (2.0**-20 * lowest if overlap > 2.0 * sink and rate < 0.0 else lowest)
    if bounces and rate < 0.0:
        return 0.0
    sinks = max(sink - max(overlap, 0.0), 0.25 * sink)
    return first_bent_crossing(0.0 if bounces else sinks, rate, pull, bent, left)


@kernel
def bounce_on(balls: Balls, i: int) -> None:
    """Let ball i move straight along the cloth during bounces that are too low to be followed."""
    ball = balls.state[i]
    ball.phase = st.SLIDING
    ball.ax, ball.ay, ball.bx, ball.by, ball.bz = 0.0, 0.0, 0.0, 0.0, 0.0
    balls.own_kind[i] = st.OWN_BOUNCES_END

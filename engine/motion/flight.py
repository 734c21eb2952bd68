"""Balls that leave the cloth: how high they are, when they land, meet a nose, or fly over one.

When they meet each other is in `scheduling.time_of_impact`, what an impact then does, or the table,
in `impacts.in_space`. A ball in flight goes along a parabola, or as `motion.flight_in_air` says
where air slows it, and keeps its angular velocity. It lands when its lowest point is back on the
cloth. Where bounces have become so low that nothing could tell them from a ball on the cloth
(`LOWEST_BOUNCE`), all that follow are one motion of known duration.

Over a table that isn't a plain rectangle, straight noses have ends, and jaws have round noses. What
flies over one of them is off the table; a post is taller than any ball flies. A ball in the air
falls into a hole where it lands, or where it would leave it no higher than `HIGHEST_AT_BACK`;
higher, it flies over the back of the pocket, and is off the table.

Two balls touch where their centres are as far apart in space as their radii add up to; a ball and a
cushion where its centre is by its radius away from the nose, a line at `cushion_height` above the
cloth. So balls of different size that lie on the cloth touch at 2 sqrt(R_a R_b) in plan, and a ball
of radius R there touches a nose at the height h when it is sqrt(h (2 R - h)) away. In scenes whose
balls stay on the cloth all of this is as in the plane: at R_a + R_b, and at R.
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
from ghostball.engine.motion.crossings import first_bent_crossing, first_crossing
from ghostball.engine.motion.flight_in_air import flight_piece, time_to_pass
from ghostball.engine.motion.frame import flies_inside
from ghostball.engine.motion.geometry import speed_of
from ghostball.engine.motion.obstacles import MOST_BOUNDS, facing, is_post, turning
from ghostball.engine.motion.position import FOR_EVER, jerk_along, whole_motion, with_rises

HIGHEST_AT_BACK = 1.4
"""How high a ball's centre may be to fall into a hole where it would leave it, in radii.

As in pooltool, which takes it for what the back of a pocket throws back into it. At the edge
towards the table no back is there; the rule is the same, since it would come down on the lip.
"""

_BESIDE = 2.0**-30
"""How far beside a nose, in radii, a ball still flies over it: more than rounding, so that between
two pieces of an outline no ball gets out."""


@kernel(inline=True)
def flies(height: FloatArray | None, balls: Balls, i: int) -> bool:
    """Whether ball i is in the air."""
    return False if height is None else bool(balls.state[i].phase == st.FLYING)


@kernel(inline=True)
def may_meet_in_space(height: FloatArray | None, balls: Balls) -> bool:
    """Whether any ball is in the air, or lies higher than others, being larger.

    Mostly neither is so, also where balls may leave the cloth.
    """
    if height is None:
        return False
    count = 0
    for i in range(len(balls.own_kind)):
        count += balls.state[i].phase == st.FLYING
        count += height[i, st.BASE] != height[0, st.BASE]
    return count > 0


@kernel(inline=True)
def one_flies(height: FloatArray | None, balls: Balls, i: int, j: int) -> bool:
    """Whether one of two balls is in the air."""
    return flies(height, balls, i) or flies(height, balls, j)


@kernel(inline=True)
def meets_in_space(height: FloatArray | None, balls: Balls, i: int, j: int) -> bool:
    """Whether two balls touch along a line that isn't level."""
    if height is None:
        return False
    return one_flies(height, balls, i, j) or bool(height[i, st.BASE] != height[j, st.BASE])


@kernel(inline=True)
def vertical_motion(
    height: FloatArray, balls: Balls, i: int, t: float
) -> tuple[float, float, float]:
    """Return height [m], speed upwards [m/s] and acceleration upwards of ball i at t [s].

    The height is that of its centre above the cloth.
    """
    s = t - balls.state[i].epoch
    up, fall = height[i, st.UP_SPEED], height[i, st.FALL]
    z = height[i, st.BASE] + height[i, st.RISE] + s * (up - 0.5 * fall * s)
    return with_rises(balls.powers, i, s, z, up - fall * s, -fall)


@kernel
def motion_in_space(
    height: FloatArray, balls: Balls, i: int, j: int, t: float
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Position, velocity and acceleration of ball j relative to ball i at the instant t [s]."""
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
def one_is_loaded(height: FloatArray | None, i: int, j: int, t: float) -> bool:
    """Whether a ball in flight has lain on one of two balls just before the instant t [s]."""
    return False if height is None else bool(max(height[i, st.LOADED], height[j, st.LOADED]) > t)


@kernel
def is_near(height: FloatArray, balls: Balls, i: int, j: int, t: float) -> bool:
    """Whether balls i and j are no farther apart at t [s] than after a negligible bounce."""
    rx, ry, rz, _, _, _, _, _, _ = motion_in_space(height, balls, i, j, t)
    near = (1.0 + 2.0 * CAPTURE_HEIGHT) * (balls.state[i].radius + balls.state[j].radius)
    return bool(rx * rx + ry * ry + rz * rz <= near * near)


@kernel
def fly(height: FloatArray, balls: Balls, i: int, laws: Laws) -> None:
    """Begin ball i's flight, and set its own next event: it lands, meets a nose, flies over one.

    Or none, of one that lies still.
    """
    ball = balls.state[i]
    ball.ax, ball.ay, ball.bx, ball.by, ball.bz = 0.0, 0.0, 0.0, 0.0, 0.0
    if height[i, st.HELD] == 1.0:
        ball.own_time = math.inf
        balls.own_kind[i] = st.OWN_NONE
        return
    height[i, st.FALL] = laws.gravity
    duration = _time_in_air(balls.powers, balls.series, height, balls, i, laws)
    if duration < 0.0:
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
            s = _time_over(balls.powers, balls.series, balls, i, laws, away, rate, duration)
            kind = _passes(height, balls, i, laws, k, s) if s < duration else st.OWN_NONE
            if kind != st.OWN_NONE:
                duration = s
                balls.own_kind[i] = kind
    ball.own_time = ball.epoch + duration


@kernel(inline=True)
def _way_over(balls: Balls, i: int, laws: Laws, k: int) -> tuple[float, float]:
    """Return how far ball i has to fly to be over obstacle k [m], and how fast that gets less.

    Its rate is negative [m/s]; 0: it never is. Of a hole: to its far edge.
    """
    if laws.obstacles[k].kind == st.LINE:
        nx, ny, away = facing(laws, k, balls.state[i].x, balls.state[i].y)
        return max(away, 0.0), nx * balls.state[i].vx + ny * balls.state[i].vy
    return _way_over_piece(balls, i, laws, k)


@kernel
def _way_over_piece(balls: Balls, i: int, laws: Laws, k: int) -> tuple[float, float]:
    """`_way_over`, of a segment, whose left side is the table's, or of a disc."""
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
    if row.law == st.TAKES_OUT:
        distance = middle + math.sqrt(square)
        return (max(distance, 0.0), -speed) if distance > -beside else (0.0, 0.0)
    distance = middle - math.sqrt(square)
    return (max(distance, 0.0), -speed) if distance > -beside else (0.0, 0.0)


@kernel
def _passes(height: FloatArray, balls: Balls, i: int, laws: Laws, k: int, s: float) -> int:
    """Return which own event of ball i it is to be over obstacle k in s seconds, or OWN_NONE."""
    row = laws.obstacles[k]
    if row.law != st.TAKES_OUT:
        return st.OWN_OVER + k
    ball = balls.state[i]
    z, _, _ = vertical_motion(height, balls, i, ball.epoch + s)
    if z <= HIGHEST_AT_BACK * ball.radius:
        return st.OWN_CUSHION + k
    x, y, _, _, _, _ = _in_plan(balls.powers, balls, i, s)
    # In front of the hole's middle there is the table, between two facings.
    behind = row.nx * (x - row.x) + row.ny * (y - row.y) <= 0.0
    return st.OWN_OVER + k if behind else st.OWN_NONE


@kernel(inline=True)
def _time_in_air(
    powers: FloatArray | None,
    series: FloatArray | None,
    height: FloatArray,
    balls: Balls,
    i: int,
    laws: Laws,
) -> float:
    """Begin a piece of ball i's flight in air; return how long it lasts [s], or -1 without air."""
    duration = -1.0
    if powers is not None and series is not None and laws.air_drag > 0.0:
        duration = flight_piece(powers, series, height, balls, i, laws)
    return duration


@kernel(inline=True)
def _time_over(
    powers: FloatArray | None,
    series: FloatArray | None,
    balls: Balls,
    i: int,
    laws: Laws,
    away: float,
    rate: float,
    duration: float,
) -> float:
    """Return when ball i passes a line within a duration [s], by which it would without air."""
    s = away / -rate
    if powers is not None and series is not None and laws.air_drag > 0.0:
        s = time_to_pass(powers, series, balls, i, away, rate, duration)
    return s


@kernel(inline=True)
def _in_plan(
    powers: FloatArray | None, balls: Balls, i: int, s: float
) -> tuple[float, float, float, float, float, float]:
    """Return place, velocity and acceleration of a ball s seconds after its flight began."""
    ball = balls.state[i]
    if powers is not None and powers[i, st.COUNT] > 0.0:
        return whole_motion(balls, i, ball.epoch + s)
    return ball.x + s * ball.vx, ball.y + s * ball.vy, ball.vx, ball.vy, 0.0, 0.0


@kernel(inline=True)
def jerk_up(powers: FloatArray | None, i: int) -> float:
    """Return how fast ball i's acceleration upwards changes at most, on its piece [m/s^3]."""
    bent: float = 0.0 if powers is None else powers[i, st.JERK_UP]
    return bent


@kernel
def _time_to_nose(
    height: FloatArray, balls: Balls, i: int, laws: Laws, k: int, duration: float, lasts: float
) -> tuple[float, bool]:
    """Return in how long a ball in flight touches the nose of obstacle k [s], or inf.

    Within a duration [s], as it moves for as long as its piece `lasts` [s]. False beside it: not
    before then, but the search was given up.

    By bounds each of which is found from the one before, in the vertical plane across the nose,
    which is a point there.
    """
    ball = balls.state[i]
    s = 0.0
    for _ in range(MOST_BOUNDS):
        balls.counters[st.WORK] += 4
        t = ball.epoch + s
        x, y, vx, vy, ax, ay = _in_plan(balls.powers, balls, i, s)
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
        bent = abs(ex) * jerk_along(balls, i, nx, ny) + abs(ez) * jerk_up(balls.powers, i)
        left = min(lasts - s, FOR_EVER)
        # The nose is a point in this plane: past it the ball goes round it; and round a nose that
        # is bent in plan.
        across, along = ez * (nx * vx + ny * vy) - ex * vz, nx * vy - ny * vx
        opening = pull + across * across / distance + ex * turning(laws, k, x, y) * along * along
        if rate >= 0.0 and pull >= bent * left:
            return math.inf, True
        step = soonest_crossing(gap, rate, pull, bent, left)
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
def soonest_crossing(gap: float, rate: float, pull: float, bent: float, left: float) -> float:
    """Return in how long a gap closes at the soonest, whose acceleration changes by up to `bent`.

    For `left` seconds; see `first_bent_crossing`.
    """
    step: float = first_crossing(gap, rate, pull)
    if bent > 0.0:
        step = first_bent_crossing(gap, rate, pull, bent, left)
    return step


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
    """Return in how long [s] what touches in flight has an impact at the soonest; 0: now.

    An approach that is fast enough to bounce is an impact now; a ball that moves away as fast has
    its impact when it comes back. A slower one may overlap by `LOWEST_BOUNCE` first, since a ball
    that is pulled together over that distance is fast enough. One that overlaps by so much already
    moves on by a quarter of it, and one that overlaps by twice as much has an impact whenever it
    approaches. `pull` [m/s^2] is the acceleration along the normal, which changes by up to `bent` a
    second [m/s^3] for `left` seconds. `opening` is that of the gap,
    for which the normal turns, too: a ball that touches another's top at speed isn't pulled to it,
    however slowly it approaches. An `opening` near 0 counts as a part of gravity, so that a rate
    that is but rounding is no bounce.
    """
    sink = 2.0 * LOWEST_BOUNCE * radius
    lowest = 0.5 * sink * max(-opening, 2.0**-10 * gravity)
    bounces = rate * rate > (2.0**-20 * lowest if overlap > 2.0 * sink and rate < 0.0 else lowest)
    if bounces and rate < 0.0:
        return 0.0
    sinks = max(sink - max(overlap, 0.0), 0.25 * sink)
    return soonest_crossing(0.0 if bounces else sinks, rate, pull, bent, left)


@kernel
def bounce_on(balls: Balls, i: int) -> None:
    """Let ball i go along the cloth, straight on, while bounces too low to be followed end."""
    ball = balls.state[i]
    ball.phase = st.SLIDING
    ball.ax, ball.ay, ball.bx, ball.by, ball.bz = 0.0, 0.0, 0.0, 0.0, 0.0
    balls.own_kind[i] = st.OWN_BOUNCES_END

"""The time at which a ball reaches an obstacle on the table: a line, a segment or a disc.

Each obstacle is a row of `Laws.obstacles`, made by `running.obstacle_rows`; the cushions of a plain
table are lines. Obstacles are convex. Before a ball can touch one, it must cross the tangent line
at the obstacle's nearest point. The crossing time is a lower bound on the contact time, as for two
balls, and the next bound is computed from there. For balls in flight see `motion.flight`.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws
from ghostball.engine.core.tolerances import (
    APPROACH_ROUNDING,
    EPS,
    GAP_ROUNDING,
    GAP_ULPS,
    TIME_ROUNDING,
)
from ghostball.engine.motion.crossings import first_bent_crossing, first_crossing
from ghostball.engine.motion.position import (
    FOR_EVER,
    jerk,
    jerk_along,
    whole_jerk_along,
    whole_motion,
)

MOST_BOUNDS = 4_096
"""Number of bounds after which the search for a contact stops.

One or two dozen bounds are enough, because convergence is quadratic; a search that needs more than
this number never ends.
"""


@kernel(inline=True)
def facing(laws: Laws, k: int, x: float, y: float) -> tuple[float, float, float]:
    """Return obstacle k's unit normal towards a place, and the distance of the place [m]."""
    if laws.obstacles[k].kind == st.LINE:
        nx, ny = laws.obstacles[k].nx, laws.obstacles[k].ny
        away = nx * (x - laws.obstacles[k].x) + ny * (y - laws.obstacles[k].y)
        return nx, ny, away
    return _facing_nearest(laws, k, x, y)


@kernel
def _facing_nearest(laws: Laws, k: int, x: float, y: float) -> tuple[float, float, float]:
    """Return `facing` for a segment or a disc, whose normal depends on the place."""
    rx, ry = x - laws.obstacles[k].x, y - laws.obstacles[k].y
    if laws.obstacles[k].kind == st.SEGMENT:
        dx = laws.obstacles[k].nx - laws.obstacles[k].x
        dy = laws.obstacles[k].ny - laws.obstacles[k].y
        along, square = rx * dx + ry * dy, dx * dx + dy * dy
        if along >= 0.0 and along <= square:
            # The normal is the same along the whole segment. The rounded direction from the nearest
            # point would let friction along the segment drive a ball into the segment, or off it.
            nx, ny, away = _across(rx, ry, dx, dy)
            return nx, ny, away - laws.obstacles[k].radius
        if along > 0.0:
            rx, ry = rx - dx, ry - dy
    size = math.sqrt(rx * rx + ry * ry)
    return rx / size, ry / size, size - laws.obstacles[k].radius


@kernel(inline=True)
def _across(rx: float, ry: float, dx: float, dy: float) -> tuple[float, float, float]:
    """Return the unit normal of a line along (dx, dy) towards (rx, ry), and the distance [m]."""
    size = math.sqrt(dx * dx + dy * dy)
    nx, ny = -dy / size, dx / size
    away = nx * rx + ny * ry
    if away < 0.0:
        nx, ny, away = -nx, -ny, -away
    return nx, ny, away


@kernel(inline=True)
def nose_reach(balls: Balls, i: int, laws: Laws, k: int) -> float:
    """Return the distance of ball i, on the cloth, from obstacle k when they touch [m].

    If balls may fly (`Laws.airborne`), they touch a nose below or above their centres; see
    `motion.flight`. A hole takes a ball when the ball's centre reaches its edge: 0.
    """
    if laws.obstacles[k].law == st.TAKES_OUT:
        return 0.0
    return _nose_reach(balls, laws, k, balls.state[i].radius)


@kernel(inline=True)
def is_post(laws: Laws, k: int) -> bool:
    """Return whether obstacle k is a post: a disc that balls reach from all sides and heights."""
    row = laws.obstacles[k]
    return bool(row.kind == st.DISC and row.nx == 0.0 and row.ny == 0.0)


@kernel(inline=True)
def above_nose(height: FloatArray, i: int, laws: Laws, k: int) -> float:
    """Return the height of ball i's centre above the nose of obstacle k, at its epoch [m].

    A post touches a ball at the height of its centre: 0.
    """
    above: float = height[i, st.BASE] + height[i, st.RISE] - laws.obstacles[k].height
    return 0.0 if is_post(laws, k) else above


@kernel(inline=True)
def _nose_reach(balls: Balls, laws: Laws, k: int, radius: float) -> float:
    reach = radius
    if balls.height is not None and laws.airborne and not is_post(laws, k):
        nose = laws.obstacles[k].height
        reach = math.sqrt(nose * (2.0 * radius - nose))
    return reach


@kernel
def row_at(laws: Laws, index: int, takes_out: bool, x: float, y: float) -> int:
    """Return the row, nearest to a place, of the obstacle with an `index` in events, or -1.

    A cushion can have several rows. `takes_out`: True for a hole, False for any other obstacle.
    """
    found, nearest = -1, math.inf
    for k in range(len(laws.obstacles)):
        is_hole = laws.obstacles[k].law == st.TAKES_OUT
        if laws.obstacles[k].index == index and is_hole == takes_out:
            away = abs(facing(laws, k, x, y)[2])
            if found < 0 or away < nearest:
                found, nearest = k, away
    return found


@kernel
def hole_at(laws: Laws, x: float, y: float) -> int:
    """Return the row of the hole that contains a place, or -1."""
    for k in range(len(laws.obstacles)):
        if laws.obstacles[k].law == st.TAKES_OUT and facing(laws, k, x, y)[2] <= 0.0:
            return k
    return -1


@kernel
def turning(laws: Laws, k: int, x: float, y: float) -> float:
    """Return the turning of obstacle k's normal as the place moves along the obstacle [1/m]."""
    if laws.obstacles[k].kind == st.LINE:
        return 0.0
    if laws.obstacles[k].kind == st.SEGMENT:
        x0, y0 = laws.obstacles[k].x, laws.obstacles[k].y
        dx, dy = laws.obstacles[k].nx - x0, laws.obstacles[k].ny - y0
        along = (x - x0) * dx + (y - y0) * dy
        if along >= 0.0 and along <= dx * dx + dy * dy:
            return 0.0
    bend: float = 1.0 / (facing(laws, k, x, y)[2] + laws.obstacles[k].radius)
    return bend


@kernel(inline=True)
def time_to_obstacle(
    balls: Balls, i: int, laws: Laws, k: int, duration: float, lasts: float
) -> tuple[float, bool]:
    """Return the time until ball i touches obstacle k [s], and whether that was determined.

    The time counts from the ball's epoch. It is inf, or later than `duration` [s], if there is no
    contact within `duration`. `lasts` [s]: the whole length of the ball's piece. If the second
    value is False, the search was stopped: no contact before that time; later contacts are unknown.
    """
    ball = balls.state[i]
    if laws.obstacles[k].kind == st.LINE and jerk(balls, i) == 0.0:
        nx, ny = laws.obstacles[k].nx, laws.obstacles[k].ny
        rate, pull = nx * ball.vx + ny * ball.vy, nx * ball.ax + ny * ball.ay
        if rate >= 0.0 and pull >= 0.0:
            return math.inf, True
        _, _, away = facing(laws, k, ball.x, ball.y)
        gap = max(away - _nose_reach(balls, laws, k, ball.radius), 0.0)
        # Without pull the equation is linear; its root is the same number, without a square root.
        return (gap / -rate if pull == 0.0 else first_crossing(gap, rate, pull)), True
    return _time_to_any(balls, i, laws, k, duration, lasts)


@kernel
def _time_to_any(
    balls: Balls, i: int, laws: Laws, k: int, duration: float, lasts: float
) -> tuple[float, bool]:
    """Return `time_to_obstacle` for segments, discs, or motion of degree above 2.

    An obstacle behind a line is reached after the line. This rules out most obstacles of a table.
    The place where the ball reaches the line of a segment decides whether it hits the segment.
    """
    if jerk(balls, i) != 0.0:
        return _time_by_bounds(balls, i, laws, k, duration, lasts, 0.0)
    ball = balls.state[i]
    nx, ny, away = _half_plane(laws, k, ball.x, ball.y)
    away -= nose_reach(balls, i, laws, k)
    if not away >= 0.0:
        return _time_by_bounds(balls, i, laws, k, duration, lasts, 0.0)
    rate, pull = _part_along(nx, ny, ball.vx, ball.vy), _part_along(nx, ny, ball.ax, ball.ay)
    if rate >= 0.0 and pull >= 0.0:
        return math.inf, True
    s = away / -rate if pull == 0.0 else first_crossing(away, rate, pull)
    if not s < duration:
        return math.inf, True
    if laws.obstacles[k].kind == st.SEGMENT:
        x0, y0 = laws.obstacles[k].x, laws.obstacles[k].y
        dx, dy = laws.obstacles[k].nx - x0, laws.obstacles[k].ny - y0
        x = ball.x + (ball.vx + 0.5 * ball.ax * s) * s - x0
        y = ball.y + (ball.vy + 0.5 * ball.ay * s) * s - y0
        along = x * dx + y * dy
        if along >= 0.0 and along <= dx * dx + dy * dy:
            return s, True
    return _time_by_bounds(balls, i, laws, k, duration, lasts, s)


@kernel(inline=True)
def _part_along(nx: float, ny: float, x: float, y: float) -> float:
    """Return the component of a vector along a normal; 0 if it is only rounding.

    A ball that moves along a slanting side has such a component by rounding. No bounce can remove
    it, so the ball would bounce there endlessly. Along an axis nothing is rounded.
    """
    part_x, part_y = nx * x, ny * y
    part = part_x + part_y
    return part if abs(part) > APPROACH_ROUNDING * (abs(part_x) + abs(part_y)) else 0.0


@kernel(inline=True)
def _half_plane(laws: Laws, k: int, x: float, y: float) -> tuple[float, float, float]:
    """Return the unit normal, towards a place, of a line that has a segment or disc behind it.

    The third value is the distance of the place in front of the line [m]; -1: no such line exists.
    """
    nx, ny = laws.obstacles[k].nx, laws.obstacles[k].ny
    x, y = x - laws.obstacles[k].x, y - laws.obstacles[k].y
    if laws.obstacles[k].kind == st.DISC:
        if nx == 0.0 and ny == 0.0:
            return 0.0, 0.0, -1.0
        return nx, ny, nx * x + ny * y - laws.obstacles[k].radius
    nx, ny, away = _across(x, y, nx - laws.obstacles[k].x, ny - laws.obstacles[k].y)
    return nx, ny, away - laws.obstacles[k].radius


@kernel
def _time_by_bounds(
    balls: Balls, i: int, laws: Laws, k: int, duration: float, lasts: float, s: float
) -> tuple[float, bool]:
    """Return `time_to_obstacle` from a sequence of lower bounds, each computed from the previous.

    `s` [s] is the first bound. The bounds don't depend on the obstacles checked before, and are the
    same in a mirrored scene.
    """
    ball = balls.state[i]
    for _ in range(MOST_BOUNDS):
        balls.counters[st.WORK] += 4
        t = ball.epoch + s
        x, y, vx, vy, ax, ay = whole_motion(balls, i, t)
        nx, ny, away = facing(laws, k, x, y)
        gap = max(away - nose_reach(balls, i, laws, k), 0.0)
        rate, pull = _part_along(nx, ny, vx, vy), _part_along(nx, ny, ax, ay)
        bent, left = jerk_along(balls, i, nx, ny), min(lasts - s, FOR_EVER)
        step = first_bent_crossing(gap, rate, pull, bent, left)
        if step == math.inf:
            return math.inf, True
        if not step > TIME_ROUNDING * t:
            if rate < 0.0 or pull < 0.0:
                return s, True
            # The ball touches and doesn't approach. The exact jerk is used here, because a ball
            # that moves along an obstacle may have a large jerk in that direction. A gap as small
            # as the rounding of its coordinates can't be known to open or to stay.
            bent = whole_jerk_along(balls, i, nx, ny, lasts)
            unseen = GAP_ROUNDING * ball.radius + GAP_ULPS * EPS * (abs(x) + abs(y))
            step = first_bent_crossing(unseen, rate, pull, bent, left)
            step = max(step, 2.0 * TIME_ROUNDING * t)
        s += step
        if not s < duration:
            return math.inf, True
    return s, False

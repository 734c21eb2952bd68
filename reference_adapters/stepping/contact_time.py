"""Times to the next contacts of balls, in closed form: where the steps of an external engine end.

A time-stepping engine detects a contact up to one step late. With `contact_steps` = exact, its
adapter computes the time to the next contact here and ends the engine's step exactly there, so that
only the error of the engine's solver remains. Only the kernel decorator comes from Ghostball's
engine, because that engine is one of the engines under comparison. The code is compiled because
numpy calls would dominate the run time with so few balls.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache

import numpy as np

from ghostball.engine.core.kernel import kernel
from ghostball.engine.library.entry import Needed
from ghostball.model import Hole, Segment, Table
from ghostball.model.arrays import FloatArray

PointMotion = tuple[float, float, float, float, float, float]
"""Position, velocity and acceleration in the plane [m], [m/s], [m/s^2]."""

SegmentEnds = tuple[float, float, float, float]
"""Start and end of a segment [m]."""

_ORIGIN: SegmentEnds = (0.0, 0.0, 0.0, 0.0)

EPS = float(np.finfo(np.float64).eps)

CONTACT_GAP = 1e-10
"""Gap at which a step ends [m].

This is 1e5 times the rounding of a coordinate on a table, and too small to turn the line of centres
noticeably (by 1e-10 / 2R, 2e-9 rad).
"""

RESTING_OVERLAP = 1e-7
"""Overlap at which a step ends for bodies in resting contact [m]; see `time_to_contact`."""

RESTING_SPEED = 1e-3
"""Speed below which bodies that accelerate towards each other are in resting contact [m/s].

A ball that moves by `RESTING_OVERLAP` at 2 m/s^2 gains 6e-4 m/s.
"""

LATEST = 1e300
"""Latest time of a contact [s]; later times could overflow, and every run ends earlier."""

MAX_ROUNDS = 100
"""Largest number of rounds of conservative advancement.

A collision needs 3 to 5 rounds; a tangency, in which every round halves the remaining time, about
50. The result after the last round is still a lower bound: early, never late.
"""


def time_to_contact(
    positions: FloatArray,
    velocities: FloatArray,
    accelerations: FloatArray,
    radii: FloatArray,
    table: Table | None,
    *,
    gap: float = CONTACT_GAP,
    horizon: float,
) -> float:
    """Return the time until a step should end because a contact starts or a ball enters a hole.

    A contact is one of two balls, or of a ball and a cushion.

    `positions`, `velocities`, `accelerations`: (n, 2) float64 [m], [m/s], [m/s^2]; the motion is x
        + v t + a t^2 / 2, valid up to `horizon` (for example the next time at which a ball stops).
    `radii`: (n,) float64 [m].
    `table`: its `sides` are infinite lines, its `obstacles` are segments, discs and holes; None is
        a cloth without cushions.
    `gap`: positive gap at which to end [m].
    `horizon`: how far to search, positive, possibly inf [s].

    Returns the smallest dt in (0, `horizon`] at which a gap falls to its level, or inf. The level
    is `gap` for bodies farther apart than 2 `gap`. For closer bodies, the level is an overlap that
    is larger by `gap` than the present overlap, so that an engine that detects contacts by overlap
    finds the contact in a step of this length. Separating bodies count when they approach again;
    bodies that touch without approaching never count. In resting contact, for example when topspin
    drives a ball against a different ball, the overlap is `RESTING_OVERLAP`: with `gap`, the ball
    would bounce every 2e-5 s for the duration of the contact.

    Call this function before every step. A contact then takes two steps: one to the gap, and one of
    about 2 `gap` / approach_speed, which overlaps and is resolved. No third constant is needed for
    contacts that the engine resolves badly or that stay closed (balls that roll on together).

    The method is conservative advancement (Mirtich 1996), here with the acceleration: the distance
    of two centres is at least the projection of their separation on the present line of centres, d
    + b t + a t^2 / 2. The first time at which this falls to the level is a lower bound of the
    contact time. Repeating the computation from there converges from below, quadratically, and
    can't miss a contact. For an infinite cushion the projection is the gap itself. For a segment or
    a disc, which are convex, the projection is along the line to the nearest point. The quartic
    equation is never formed.
    """
    # The same memory layout for all calls, to avoid compiling a second version.
    x, v, a = map(np.ascontiguousarray, (positions, velocities, accelerations))
    dt = np.inf
    if table is not None:
        lines, rows = _cushions_of(table)
        for line in lines:
            dt = min(dt, _to_cushion(x, v, a, radii, *line, gap))
        if len(rows):
            dt = min(dt, _to_obstacle(x, v, a, radii, rows, gap, min(horizon, dt)))
    dt = min(dt, _to_ball(x, v, a, radii, gap, min(horizon, dt)))
    return float(dt) if dt <= horizon else math.inf


@lru_cache(maxsize=32)
def _cushions_of(table: Table) -> tuple[list[tuple[int, float, float]], FloatArray]:
    """Return the lines of a table for `_to_cushion`, and rows for `_to_obstacle`."""
    lines = [(one.across, one.normal[one.across], one.point[one.across]) for one in table.sides]
    rows = np.zeros((len(table.obstacles), 6))
    for row, one in zip(rows, table.obstacles, strict=True):
        start, end = (one.start, one.end) if isinstance(one, Segment) else (one.centre, one.centre)
        reach = 0.0 if isinstance(one, Segment) else one.radius
        row[:] = *start, *end, reach, not isinstance(one, Hole)
    return lines, rows


@cache
def warm_up() -> None:
    """Load all kernels of this module once per process, before any run time is measured."""
    for one in needed():
        one.load()


def needed() -> tuple[Needed, ...]:
    """Return the kernels that this module calls, for compilation or loading."""
    name, numbers, vectors = "contact times", np.ones(1), np.zeros((1, 2))
    motion = (vectors, vectors, vectors, numbers)
    return (
        Needed(_to_cushion, (*motion, 0, 1.0, 0.0, CONTACT_GAP), f"{name}: cushions"),
        Needed(
            _to_obstacle,
            (*motion, np.zeros((1, 6)), CONTACT_GAP, math.inf),
            f"{name}: parts of cushions, and holes",
        ),
        Needed(_to_ball, (*motion, CONTACT_GAP, math.inf), f"{name}: balls"),
    )


@kernel
def _level(present: float, rate: float, acceleration: float, gap: float) -> float:
    """Return the level to which the present gap must fall [m]; see `time_to_contact`.

    `rate` [m/s] and `acceleration` [m/s^2] are those of the present gap.
    """
    if present > 2.0 * gap:
        return gap
    resting = abs(rate) < RESTING_SPEED and acceleration < 0.0
    return min(present, 0.0) - (RESTING_OVERLAP if resting else gap)


@kernel
def _first_root(c: float, b: float, a: float) -> float:
    """Return the smallest t > 0 with c + b t + a t^2 / 2 = 0, for c > 0, or inf.

    Each branch adds numbers of the same sign, so only the discriminant has cancellation. Roots
    later than `LATEST` are ignored, because their quotient could overflow.
    """
    discriminant = b * b - 2.0 * a * c
    root = math.sqrt(max(discriminant, 0.0))
    if b < 0.0:
        if discriminant >= 0.0 and root - b > 2.0 * c / LATEST:
            return 2.0 * c / (root - b)
    elif -a > (b + root) / LATEST:
        return (b + root) / -a
    return math.inf


@kernel(entry=True)
def _to_cushion(
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
    radii: FloatArray,
    axis: int,
    inward: float,
    nose: float,
    gap: float,
) -> float:
    """Return the time to the first contact of a ball with a cushion, or inf.

    The cushion is perpendicular to `axis`, at `nose` [m]; `inward` is 1 or -1, the direction of the
    table.
    """
    first = math.inf
    for i in range(len(radii)):
        present = inward * x[i, axis] - inward * nose - radii[i]
        rate, acceleration = inward * v[i, axis], inward * a[i, axis]
        level = _level(present, rate, acceleration, gap)
        first = min(first, _first_root(present - level, rate, acceleration))
    return first


@kernel(entry=True)
def _to_obstacle(
    x: FloatArray,
    v: FloatArray,
    a: FloatArray,
    radii: FloatArray,
    rows: FloatArray,
    gap: float,
    horizon: float,
) -> float:
    """Return the time to the first contact of a ball with an obstacle within `horizon`, or inf.

    `rows`: (m, 6) float64 [m]: the ends of a segment (equal for a disc); its radius; and 1 if the
        radius of the ball is added, or 0 if the centre of the ball counts, as for a hole.
    """
    first = math.inf
    for k in range(len(rows)):
        ends = (rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3])
        farthest = max(abs(ends[0]), abs(ends[1]), abs(ends[2]), abs(ends[3]))
        for i in range(len(radii)):
            reach = rows[k, 4] + rows[k, 5] * radii[i]
            rounding = 8.0 * EPS * (max(farthest, abs(x[i, 0]), abs(x[i, 1])) + reach)
            motion = (x[i, 0], x[i, 1], v[i, 0], v[i, 1], a[i, 0], a[i, 1])
            t = _to_segment(motion, ends, reach, gap, rounding, min(horizon, first))
            first = min(first, t)
    return first


@kernel(entry=True)
def _to_ball(
    x: FloatArray, v: FloatArray, a: FloatArray, radii: FloatArray, gap: float, horizon: float
) -> float:
    """Return the time to the first contact of two balls within `horizon`, or inf.

    In the frame of one ball, the other ball moves, and the first ball is a segment of length 0.
    """
    farthest = 0.0
    for i in range(len(radii)):
        farthest = max(farthest, abs(x[i, 0]), abs(x[i, 1]))
    first = math.inf
    for i in range(len(radii)):
        for j in range(i + 1, len(radii)):
            reach = radii[i] + radii[j]
            # A computed gap below this is noise, from subtracting coordinates of this size.
            rounding = 8.0 * EPS * (farthest + reach)
            motion = (
                x[j, 0] - x[i, 0],
                x[j, 1] - x[i, 1],
                v[j, 0] - v[i, 0],
                v[j, 1] - v[i, 1],
                a[j, 0] - a[i, 0],
                a[j, 1] - a[i, 1],
            )
            t = _to_segment(motion, _ORIGIN, reach, gap, rounding, min(horizon, first))
            first = min(first, t)
    return first


@kernel
def _to_segment(
    motion: PointMotion,
    ends: SegmentEnds,
    reach: float,
    gap: float,
    rounding: float,
    horizon: float,
) -> float:
    """Return the time until a moving point is `reach` from a segment; inf if after `horizon`."""
    x, y, vx, vy, ax, ay = motion
    if vx == 0.0 and vy == 0.0 and ax == 0.0 and ay == 0.0:
        return math.inf  # most balls of a rack
    rx, ry = _from_nearest(ends, x, y)
    distance = math.sqrt(rx * rx + ry * ry)
    if distance == 0.0:  # the centre is on the segment, which doesn't happen in a shot
        return math.inf
    nx, ny = rx / distance, ry / distance
    target = reach + _level(distance - reach, nx * vx + ny * vy, nx * ax + ny * ay, gap)
    t = 0.0
    for _ in range(MAX_ROUNDS):
        rx, ry = _from_nearest(ends, x + (vx + 0.5 * ax * t) * t, y + (vy + 0.5 * ay * t) * t)
        distance = math.sqrt(rx * rx + ry * ry)
        remaining = distance - target
        nx, ny = rx / distance, ry / distance
        rate = nx * (vx + ax * t) + ny * (vy + ay * t)
        step = _first_root(max(remaining, rounding), rate, nx * ax + ny * ay)
        # A gap as small as rounding, or a step too small for the clock, ends the iteration.
        if (t > 0.0 and remaining <= rounding) or step <= 4e-16 * t:
            return t
        t += step
        if not t <= horizon or t == math.inf:
            return math.inf
    return t


@kernel
def _from_nearest(ends: SegmentEnds, x: float, y: float) -> tuple[float, float]:
    """Return the vector to a place from the nearest point of a segment [m]."""
    x0, y0, x1, y1 = ends
    dx, dy = x1 - x0, y1 - y0
    along, length2 = (x - x0) * dx + (y - y0) * dy, dx * dx + dy * dy
    part = 0.0 if along <= 0.0 else (1.0 if along >= length2 else along / length2)
    return x - x0 - part * dx, y - y0 - part * dy

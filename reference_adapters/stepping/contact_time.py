"""When balls next touch, from closed forms: where steps of a foreign engine end.

A stepping engine sees a contact late, by up to one step. With `contact_steps` = exact its adapter
asks here for the time to the next contact and makes the engine's step end just there, so that what
is left is the engine's own solver. Nothing here is of this project's engine, which is one of those
compared, but the decorator: with so few balls numpy would cost its calls.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache

import numpy as np

from ghostball.engine.core.kernel import kernel
from ghostball.engine.library.entry import Needed
from ghostball.model import Hole, Segment, Table
from ghostball.model.arrays import FloatArray

Motion = tuple[float, float, float, float, float, float]
"""A place, a velocity and an acceleration [m], [m/s], [m/s^2]."""

Ends = tuple[float, float, float, float]
"""Where a segment begins and ends [m]."""

_ORIGIN: Ends = (0.0, 0.0, 0.0, 0.0)

EPS = float(np.finfo(np.float64).eps)

CONTACT_GAP = 1e-10
"""Gap at which a step ends [m]: 1e5 times the rounding of a coordinate on a table, and far
too small to turn the line of centres (by 1e-10 / 2R, 2e-9 rad)."""

RESTING_OVERLAP = 1e-7
"""Overlap at which a step ends for what is in resting contact [m]; see `time_to_contact`."""

RESTING_SPEED = 1e-3
"""Speed below which what accelerates towards each other counts as resting contact [m/s].

What falls through `RESTING_OVERLAP` at 2 m/s^2 is faster by 6e-4 m/s.
"""

LATEST = 1e300
"""Time after which a contact is none [s]: it might exceed the doubles, and a run ends before."""

MAX_ROUNDS = 100
"""Rounds of conservative advancement. A collision takes 3 to 5; a tangency, where every round
halves the remaining time, about 50. What is left after that is still a lower bound: early, never
late."""


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
    """Return the time until a step should end because two balls, or a ball and a cushion, touch.

    Or because a ball's centre enters a hole.

    `positions`, `velocities`, `accelerations` (n, 2) float64 [m], [m/s], [m/s^2]: motion is x + v t
        + a t^2 / 2, valid up to `horizon` (the next time a ball stops, say).
    `radii` (n,) float64 [m].
    `table`: its `sides` are infinite lines, its `obstacles` what they say; None is a cloth without
        any.
    `gap` [m]: gap at which to end, positive.
    `horizon` [s]: how far to look, positive; may be inf.

    Returns smallest dt in (0, `horizon`] at which a gap falls to its level, or inf. The level is
    `gap` for what is farther apart than 2 `gap`. What is nearer is there already: its level is an
    overlap that is larger by `gap` than the present one, so that a step of this length makes an
    engine that detects by overlap see the contact. Something that moves apart counts when it has
    come back; something that touches without closing never does. For what is in resting contact,
    such as a ball that its topspin drives against another, the overlap is `RESTING_OVERLAP`: with
    `gap` it would bounce every 2e-5 s, as long as that lasts.

    Call it before every step. A contact then takes two steps, one to the gap and one of about
    2 `gap` / approach_speed that overlaps and is resolved; no third constant is needed for contacts
    that the engine resolves badly or that stay closed (balls rolling on together).

    Conservative advancement (Mirtich 1996; here with the acceleration kept): the distance of two
    centres is at least the projection of their separation on the present line of centres, d + b t +
    a t^2 / 2. The first time this falls to the level is a lower bound of the contact time, so
    repeating from there converges from outside, quadratically, and can't miss a contact. For a
    cushion that is a line the projection is the gap itself; for a part of one, and for a disc, it
    is taken along the line to its nearest point, as they are convex. The true quartic is never
    formed.
    """
    # One layout for all, or each would be compiled for.
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
    """Return the lines of a table, as `_to_cushion` takes them, and rows for `_to_obstacle`."""
    lines = [(one.across, one.normal[one.across], one.point[one.across]) for one in table.sides]
    rows = np.zeros((len(table.obstacles), 6))
    for row, one in zip(rows, table.obstacles, strict=True):
        start, end = (one.start, one.end) if isinstance(one, Segment) else (one.centre, one.centre)
        reach = 0.0 if isinstance(one, Segment) else one.radius
        row[:] = *start, *end, reach, not isinstance(one, Hole)
    return lines, rows


@cache
def warm_up() -> None:
    """Load all that is compiled here, once in a process: no run's time should hold it."""
    for one in needed():
        one.load()


def needed() -> tuple[Needed, ...]:
    """Return the kernels that are called here, to be compiled or loaded."""
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
    """Return the gap that the present one has to fall to [m]; see `time_to_contact`.

    `rate` [m/s] and `acceleration` [m/s^2] are those of the present gap.
    """
    if present > 2.0 * gap:
        return gap
    resting = abs(rate) < RESTING_SPEED and acceleration < 0.0
    return min(present, 0.0) - (RESTING_OVERLAP if resting else gap)


@kernel
def _first_root(c: float, b: float, a: float) -> float:
    """Return the smallest t > 0 with c + b t + a t^2 / 2 = 0, for c > 0; inf where there is none.

    Each branch adds numbers of one sign, so nothing cancels but the discriminant. One that is later
    than `LATEST` is none: its quotient might exceed the doubles.
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

    The cushion lies across `axis`, at `nose` [m]; `inward` is 1 or -1, the direction of the table.
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

    `rows` (m, 6) float64 [m]: the ends of a segment, the same for a disc; its radius; and whether
        that of the ball is added to it (1), or the ball's centre counts (0), as for a hole.
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

    Seen from one of them the other moves, and the one is a segment without length.
    """
    farthest = 0.0
    for i in range(len(radii)):
        farthest = max(farthest, abs(x[i, 0]), abs(x[i, 1]))
    first = math.inf
    for i in range(len(radii)):
        for j in range(i + 1, len(radii)):
            reach = radii[i] + radii[j]
            # Below this a computed gap is noise: coordinates of the size of these, subtracted.
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
    motion: Motion, ends: Ends, reach: float, gap: float, rounding: float, horizon: float
) -> float:
    """Return the time until a point that moves is `reach` from a segment, or inf.

    Inf, too, where that is after `horizon`.
    """
    x, y, vx, vy, ax, ay = motion
    if vx == 0.0 and vy == 0.0 and ax == 0.0 and ay == 0.0:
        return math.inf  # most of a rack
    rx, ry = _from_nearest(ends, x, y)
    distance = math.sqrt(rx * rx + ry * ry)
    if distance == 0.0:  # on the middle of it, which no shot comes to
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
        # Neither a gap of rounding size nor a step that can't move the clock is progress.
        if (t > 0.0 and remaining <= rounding) or step <= 4e-16 * t:
            return t
        t += step
        if not t <= horizon or t == math.inf:
            return math.inf
    return t


@kernel
def _from_nearest(ends: Ends, x: float, y: float) -> tuple[float, float]:
    """Return the way to a place from the nearest point of a segment [m]."""
    x0, y0, x1, y1 = ends
    dx, dy = x1 - x0, y1 - y0
    along, length2 = (x - x0) * dx + (y - y0) * dy, dx * dx + dy * dy
    part = 0.0 if along <= 0.0 else (1.0 if along >= length2 else along / length2)
    return x - x0 - part * dx, y - y0 - part * dy

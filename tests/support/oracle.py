"""A slow, obvious reference for the engine: mpmath, all pairs, one event after another.

Nothing is shared with the engine but the `Scene`, and nothing is clever: every ball is advanced at
every event, every pair is predicted anew, and the time of impact is a root of the true quartic,
isolated by the roots of its derivatives and bisected in 50 digits. So it has no tolerance; what it
can't decide in that precision (two events at one instant, contact under pressure) is not its job,
and balls that don't bounce (restitution 0, which stay pressed together) are refused.

The model: a ball rolls straight and decelerates by mu g until it rests; balls exchange an impulse
along the line of centres, with restitution e; a cushion reverses the normal velocity, times e_n,
and scales the tangential one by e_t.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from mpmath import mp, mpf, workdps

from engine import CUSHIONS, EventKind, Scene

DIGITS = 50
NUDGE = mpf(10) ** -25
"""Relative size of a nudge: far below double rounding, far above what 50 digits resolve."""

Vector = tuple[Any, Any]
Polynomial = list[Any]
"""Coefficients from the constant up."""


@dataclass
class Body:
    """One ball at the current instant, in mpf."""

    position: Vector
    velocity: Vector
    radius: Any
    mass: Any


@dataclass(frozen=True)
class OracleEvent:
    t: Any
    kind: EventKind
    a: int
    b: int

    @property
    def is_collision(self) -> bool:
        return self.kind in (EventKind.BALL_BALL, EventKind.BALL_CUSHION)

    @property
    def key(self) -> tuple[EventKind, int, int]:
        return (self.kind, self.a, self.b)


@dataclass(frozen=True)
class OracleRun:
    """Events in order of time; state at `t_end`, which is rest, `t_max`, or a limit reached."""

    events: list[OracleEvent]
    positions: list[Vector]
    velocities: list[Vector]
    t_end: Any


def solve(
    scene: Scene,
    *,
    max_ball_collisions: int | None = None,
    nudge_seed: int | None = None,
    digits: int = DIGITS,
) -> OracleRun:
    """Simulate `scene` in `digits` digits until rest, `t_max`, or so many ball-ball collisions.

    With `nudge_seed` every coordinate, every velocity and the deceleration is first moved by a
    random part of about `NUDGE`, as rounding would do: the difference of two runs over `NUDGE` is
    the amplification.
    """
    if scene.physics.ball_restitution == 0.0:
        raise ValueError("balls that don't bounce stay pressed together; no event list tells that")
    with workdps(digits):
        return _run(scene, max_ball_collisions, nudge_seed)


def _run(scene: Scene, max_ball_collisions: int | None, nudge_seed: int | None) -> OracleRun:
    bodies = [
        Body(
            (mpf(ball.position[0]), mpf(ball.position[1])),
            (mpf(ball.velocity[0]), mpf(ball.velocity[1])),
            mpf(ball.radius),
            mpf(ball.mass),
        )
        for ball in scene.balls
    ]
    deceleration = mpf(scene.physics.rolling_friction) * mpf(scene.physics.gravity)
    if nudge_seed is not None:
        chance = random.Random(nudge_seed)
        deceleration *= 1 + NUDGE * chance.uniform(-1, 1)
        _nudge(bodies, chance)
    t_max = mp.inf if scene.t_max is None else mpf(scene.t_max)
    t, events, ball_collisions = mpf(0), [], 0
    while ball_collisions != max_ball_collisions:
        event = _next_event(scene, bodies, deceleration, t_max - t)
        if event is None:
            if t_max < mp.inf and any(_norm(body.velocity) > 0 for body in bodies):
                _advance(bodies, deceleration, t_max - t)
                t = t_max
            break
        _advance(bodies, deceleration, event.t)
        t += event.t
        _resolve(scene, bodies, event)
        events.append(OracleEvent(t, event.kind, event.a, event.b))
        ball_collisions += event.kind is EventKind.BALL_BALL
    return OracleRun(
        events, [body.position for body in bodies], [body.velocity for body in bodies], t
    )


def _nudge(bodies: list[Body], chance: random.Random) -> None:
    for body in bodies:
        size = NUDGE * max(map(abs, (*body.position, body.radius)))
        speed = NUDGE * _norm(body.velocity)
        x, y = body.position
        vx, vy = body.velocity
        body.position = (x + size * chance.uniform(-1, 1), y + size * chance.uniform(-1, 1))
        body.velocity = (vx + speed * chance.uniform(-1, 1), vy + speed * chance.uniform(-1, 1))


def _next_event(
    scene: Scene, bodies: list[Body], deceleration: Any, remaining: Any
) -> OracleEvent | None:
    """First event after now, its `t` counted from now, or None where none comes in time."""
    found: OracleEvent | None = None
    horizon = remaining  # nothing later than the earliest event found so far matters
    for i, body in enumerate(bodies):
        speed = _norm(body.velocity)
        if deceleration > 0 and speed > 0 and speed / deceleration < horizon:
            horizon = speed / deceleration
            found = OracleEvent(horizon, EventKind.ROLL_TO_REST, i, -1)
    for i, body in enumerate(bodies):
        for index, name in enumerate(CUSHIONS):
            if scene.table is None or name not in scene.table.cushions or not any(body.velocity):
                continue
            time = _time_to_cushion(scene, body, deceleration, index, horizon)
            if time is not None:
                horizon, found = time, OracleEvent(time, EventKind.BALL_CUSHION, i, index)
    for i in range(len(bodies)):
        for j in range(i + 1, len(bodies)):
            time = time_of_impact(bodies[i], bodies[j], deceleration, horizon)
            if time is not None:
                horizon, found = time, OracleEvent(time, EventKind.BALL_BALL, i, j)
    return found


def _acceleration(body: Body, deceleration: Any) -> Vector:
    speed = _norm(body.velocity)
    if speed == 0:
        return (mpf(0), mpf(0))
    return (-deceleration * body.velocity[0] / speed, -deceleration * body.velocity[1] / speed)


def _time_to_cushion(
    scene: Scene, body: Body, deceleration: Any, index: int, horizon: Any
) -> Any | None:
    axis, far = divmod(index, 2)
    assert scene.table is not None
    side = mpf((scene.table.length, scene.table.width)[axis])
    sign = -1 if far else 1  # the gap grows with sign * coordinate
    gap = (side - body.position[axis] if far else body.position[axis]) - body.radius
    acceleration = _acceleration(body, deceleration)[axis]
    return first_entry(
        [gap, sign * body.velocity[axis], sign * acceleration / 2],
        horizon,
    )


def time_of_impact(a: Body, b: Body, deceleration: Any, horizon: Any) -> Any | None:
    """Time from now in [0, horizon) at which two balls, left alone, come to touch; or None."""
    reach = a.radius + b.radius
    r = _minus(b.position, a.position)
    v = _minus(b.velocity, a.velocity)
    speeds = _norm(a.velocity) + _norm(b.velocity)
    if speeds == 0 or _norm(r) - reach > speeds * horizon:
        return None  # too far apart to meet, even heading straight at each other
    half = tuple(
        c / 2 for c in _minus(_acceleration(b, deceleration), _acceleration(a, deceleration))
    )
    return first_entry(
        [
            _dot(r, r) - reach**2,
            2 * _dot(r, v),
            _dot(v, v) + 2 * _dot(r, half),
            2 * _dot(v, half),
            _dot(half, half),
        ],
        horizon,
    )


def first_entry(gap: Polynomial, horizon: Any) -> Any | None:
    """Time in [0, horizon) at which `gap` goes from positive to negative, first; or None.

    Touching (or overlapping by rounding) and approaching is an entry now; touching and receding
    isn't, nor is touching without approach.
    """
    if gap[0] <= 0 and gap[1] < 0:
        return mpf(0)
    points = [mpf(0), *_sign_changes(_derivative(gap), horizon), horizon]
    for low, high in pairwise(points):
        if _value(gap, low) > 0 > _value(gap, high):
            return _root_between(gap, low, high)
    return None


def _sign_changes(p: Polynomial, horizon: Any) -> list[Any]:
    """Every point in (0, horizon) where `p` changes sign, in order.

    Between two neighbouring sign changes of the derivative p is monotone: it has one root or none.
    """
    if len(p) <= 1:
        return []
    points = [mpf(0), *_sign_changes(_derivative(p), horizon), horizon]
    roots = []
    for low, high in pairwise(points):
        at_low, at_high = _value(p, low), _value(p, high)
        if at_low * at_high < 0:
            roots.append(_root_between(p, low, high))
        elif at_low == 0 and low > 0:
            roots.append(low)
    return roots


def _root_between(p: Polynomial, low: Any, high: Any) -> Any:
    """Root of `p`, monotone from `low` to `high`: 64 halvings, then Newton doubles the digits."""
    rising = _value(p, high) > 0
    for _ in range(64):
        middle = (low + high) / 2
        if (_value(p, middle) > 0) == rising:
            high = middle
        else:
            low = middle
    t, slope = (low + high) / 2, _derivative(p)
    for _ in range(4):
        # Never out of the bracket: a nearly double root keeps the bisected digits.
        t = min(max(t - _value(p, t) / (_value(slope, t) or mpf(1)), low), high)
    return t


def _resolve(scene: Scene, bodies: list[Body], event: OracleEvent) -> None:
    if event.kind is EventKind.ROLL_TO_REST:
        bodies[event.a].velocity = (mpf(0), mpf(0))
    elif event.kind is EventKind.BALL_CUSHION:
        mirror = scene.physics.cushion == "mirror"
        e_n = mpf(1) if mirror else mpf(scene.physics.cushion_restitution)
        e_t = mpf(1) if mirror else mpf(scene.physics.cushion_tangential_restitution)
        factors = (-e_n, e_t) if event.b < 2 else (e_t, -e_n)
        vx, vy = bodies[event.a].velocity
        bodies[event.a].velocity = (factors[0] * vx, factors[1] * vy)
    else:
        a, b = bodies[event.a], bodies[event.b]
        r = _minus(b.position, a.position)
        distance = _norm(r)
        normal = (r[0] / distance, r[1] / distance)
        approach_speed = -_dot(_minus(b.velocity, a.velocity), normal)
        reduced_mass = a.mass * b.mass / (a.mass + b.mass)
        impulse = (1 + mpf(scene.physics.ball_restitution)) * reduced_mass * approach_speed
        a.velocity = _plus(a.velocity, -impulse / a.mass, normal)
        b.velocity = _plus(b.velocity, impulse / b.mass, normal)


def _advance(bodies: list[Body], deceleration: Any, dt: Any) -> None:
    for body in bodies:
        acceleration = _acceleration(body, deceleration)
        body.position = _plus(body.position, dt, body.velocity)
        body.position = _plus(body.position, dt**2 / 2, acceleration)
        body.velocity = _plus(body.velocity, dt, acceleration)


def _derivative(p: Polynomial) -> Polynomial:
    return [k * c for k, c in enumerate(p)][1:]


def _value(p: Polynomial, t: Any) -> Any:
    value = mpf(0)
    for c in reversed(p):
        value = value * t + c
    return value


def _plus(a: Vector, factor: Any, b: Vector) -> Vector:
    return (a[0] + factor * b[0], a[1] + factor * b[1])


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1])


def _dot(a: Vector, b: Vector) -> Any:
    return a[0] * b[0] + a[1] * b[1]


def _norm(a: Vector) -> Any:
    return mp.sqrt(_dot(a, a))

"""A slow, simple reference for the engine: mpmath, all pairs, one event after another.

The oracle shares only the `Scene` with the engine and uses simple methods: every ball is advanced
at every event, every pair is predicted again, and the time of impact is a root of the quartic
equation, isolated by the roots of its derivatives and bisected in 50 digits. So the oracle has no
tolerances. It can't decide simultaneous events of one ball or resting contact, which must not
occur. Scenes with inelastic contacts, or with laws integrated over an impact, are rejected.

The model has all motion on the cloth; `oracle_laws` has the motion and the impacts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mpmath import mp, mpf, workdps
from oracle_laws import (
    SIDES,
    Body,
    Laws,
    Phase,
    Vector,
    acceleration,
    advanced,
    bounced,
    collided,
    next_phase,
    norm,
    settled,
    time_left,
    vector,
)
from oracle_roots import first_entry

from ghostball.model import CUSHIONS, EventKind, Scene

__all__ = ["DIGITS", "OracleEvent", "OracleRun", "first_entry", "solve"]

DIGITS = 50

ALCIATORE = (9.951e-3, 0.108, 1.088)
"""Ball-ball friction a + b exp(-c v), v the slip speed [m/s]: Alciatore's fit to Marlow's data."""


@dataclass(frozen=True)
class OracleEvent:
    t: Any
    kind: EventKind
    a: int
    b: int

    @property
    def key(self) -> tuple[EventKind, int, int]:
        return (self.kind, self.a, self.b)


@dataclass(frozen=True)
class OracleRun:
    """Events in order of time, and the final states of the bodies."""

    events: list[OracleEvent]
    bodies: list[Body]

    @property
    def positions(self) -> list[Vector]:
        return [body.position for body in self.bodies]

    @property
    def spins(self) -> list[Vector]:
        return [body.spin for body in self.bodies]


def solve(scene: Scene) -> OracleRun:
    """Simulate `scene` in 50 digits until rest or `t_max`."""
    _refuse(scene)
    with workdps(DIGITS):
        return _run(scene)


def _refuse(scene: Scene) -> None:
    physics, cushioned = scene.physics, scene.table is not None and scene.table.cushions
    if physics.ball_restitution == 0.0:
        raise ValueError("balls that don't bounce stay in contact; no event list says that")
    if cushioned and physics.cushion != "mirror" and physics.cushion_restitution == 0.0:
        raise ValueError("a ball that doesn't bounce off a cushion stays in contact with it")
    if physics.ball_impact != "frictional":
        raise ValueError(f"the oracle has no integrated ball law: {physics.ball_impact}")
    if cushioned and physics.cushion in ("mathavan2010", "stronge2000"):
        raise ValueError(f"the oracle has no such cushion law: {physics.cushion}")
    if physics.air_drag > 0.0 or physics.rolling_friction_quadratic > 0.0 or physics.airborne:
        raise ValueError("the oracle knows no air and no flight")


def _run(scene: Scene) -> OracleRun:
    laws = _laws_of(scene)
    bodies = _bodies_of(scene, laws)
    t_max = mp.inf if scene.t_max is None else mpf(scene.t_max)
    t = mpf(0)
    events: list[OracleEvent] = []
    while (event := _next_event(scene, bodies, t_max - t)) is not None:
        t += event.t
        bodies = [advanced(body, event.t) for body in bodies]
        _resolve(bodies, event, laws)
        events.append(OracleEvent(t, event.kind, event.a, event.b))
    rested = all(b.phase is Phase.RESTING for b in bodies)
    spun_out = t + max((abs(b.spin[2]) / b.spinning for b in bodies if b.spins), default=0)
    end = spun_out if rested and spun_out <= t_max else t_max
    return OracleRun(events, [advanced(body, end - t) for body in bodies])


def _laws_of(scene: Scene) -> Laws:
    physics = scene.physics
    mu = ALCIATORE if physics.ball_friction == "alciatore" else (physics.ball_friction, 0, 0)
    mirror = physics.cushion == "mirror"
    return Laws(
        always_rolls=physics.motion == "rolling",
        restitution=mpf(physics.ball_restitution),
        friction=(mpf(mu[0]), mpf(mu[1]), mpf(mu[2])),
        cushion=physics.cushion,
        cushion_restitution=mpf(1 if mirror else physics.cushion_restitution),
        cushion_loss=mpf(0 if mirror else physics.cushion_restitution_loss),
        cushion_tangential=mpf(1 if mirror else physics.cushion_tangential_restitution),
        cushion_friction=mpf(physics.cushion_friction),
        cushion_height=mpf(physics.cushion_height),
    )


def _bodies_of(scene: Scene, laws: Laws) -> list[Body]:
    gravity = mpf(scene.physics.gravity)
    bodies = []
    for i, ball in enumerate(scene.balls):
        body = Body(
            position=vector(*ball.position[:2]),
            velocity=vector(*ball.velocity[:2]),
            spin=vector(*(ball.angular_velocity or (0, 0, 0))),
            radius=mpf(ball.radius),
            mass=mpf(ball.mass),
            rolling=mpf(float(scene.rolling_frictions[i])) * gravity,
            sliding=mpf(float(scene.sliding_frictions[i])) * gravity,
            spinning=mpf(float(scene.spinning_friction_rates[i])),
        )
        bodies.append(settled(body, laws.always_rolls or bool(scene.rolls[i])))
    return bodies


def _next_event(scene: Scene, bodies: list[Body], remaining: Any) -> OracleEvent | None:
    """Return the next event, with `t` counted from now, or None if none happens in time."""
    found: OracleEvent | None = None
    horizon = remaining  # only events before the earliest event found so far matter
    for i, body in enumerate(bodies):
        if time_left(body) < horizon:
            horizon = time_left(body)
            stops = norm(next_phase(body).velocity) == 0
            kind = EventKind.ROLL_TO_REST if stops else EventKind.SLIDE_TO_ROLL
            found = OracleEvent(horizon, kind, i, -1)
    for i, body in enumerate(bodies):
        for index, name in enumerate(CUSHIONS):
            if scene.table is None or name not in scene.table.cushions:
                continue
            time = _time_to_cushion(scene, body, index, horizon)
            if time is not None:
                horizon, found = time, OracleEvent(time, EventKind.BALL_CUSHION, i, index)
    for i in range(len(bodies)):
        for j in range(i + 1, len(bodies)):
            time = _time_of_impact(bodies[i], bodies[j], horizon)
            if time is not None:
                horizon, found = time, OracleEvent(time, EventKind.BALL_BALL, i, j)
    return found


def _time_to_cushion(scene: Scene, body: Body, index: int, horizon: Any) -> Any | None:
    """Return the time from now in [0, horizon) at which a body alone meets a cushion, or None."""
    assert scene.table is not None
    if body.phase is Phase.RESTING:
        return None
    side = SIDES[index]
    nose = mpf((0, scene.table.length, 0, scene.table.width)[index])
    gap = nose * (1 if index % 2 else -1) - body.position @ side - body.radius
    return first_entry([gap, -body.velocity @ side, -acceleration(body) @ side / 2], horizon)


def _time_of_impact(a: Body, b: Body, horizon: Any) -> Any | None:
    """Return the time from now in [0, horizon) at which two bodies alone collide, or None."""
    if a.phase is Phase.RESTING and b.phase is Phase.RESTING:
        return None
    reach = a.radius + b.radius
    r, v = b.position - a.position, b.velocity - a.velocity
    half = (acceleration(b) - acceleration(a)) / 2
    if norm(r) - reach > horizon * (norm(v) + horizon * norm(half)):
        return None  # too far apart to meet, even heading straight at each other
    quartic = [r @ r - reach**2, 2 * r @ v, v @ v + 2 * r @ half, 2 * v @ half, half @ half]
    return first_entry(quartic, horizon)


def _resolve(bodies: list[Body], event: OracleEvent, laws: Laws) -> None:
    """Apply an event to the bodies, in place."""
    if event.kind is EventKind.BALL_BALL:
        bodies[event.a], bodies[event.b] = collided(bodies[event.a], bodies[event.b], laws)
    elif event.kind is EventKind.BALL_CUSHION:
        bodies[event.a] = bounced(bodies[event.a], SIDES[event.b], laws)
    else:
        bodies[event.a] = next_phase(bodies[event.a])

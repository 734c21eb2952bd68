"""Simulate scenes with pooltool: slide, roll, spin and rest, with the scene's impact laws."""

import time
from importlib import metadata
from typing import Any

import numpy as np
import pooltool as pt
from pooltool.constants import MIN_DIST
from pooltool.objects.ball.datatypes import BallState
from pooltool.objects.table.datatypes import TableType
from pooltool.objects.table.layout import create_billiard_table_cushion_segments
from pooltool.objects.table.specs import BilliardTableSpecs
from pooltool.physics.engine import PhysicsEngine
from pooltool.physics.evolve import evolve_ball_motion
from pooltool.physics.resolve.ball_ball.friction import (
    AlciatoreBallBallFriction,
    AverageBallBallFriction,
)
from pooltool.physics.resolve.ball_ball.frictional_inelastic import FrictionalInelastic
from pooltool.physics.resolve.ball_ball.frictionless_elastic import FrictionlessElastic
from pooltool.physics.resolve.ball_cushion.han_2005.model import Han2005Circular, Han2005Linear
from pooltool.physics.resolve.ball_cushion.stronge_compliant.model import (
    StrongeCompliantCircular,
    StrongeCompliantLinear,
)
from pooltool.physics.resolve.ball_cushion.unrealistic import UnrealisticCircular, UnrealisticLinear
from pooltool.physics.resolve.ball_pocket import CanonicalBallPocket
from pooltool.physics.resolve.resolver import Resolver
from pooltool.physics.resolve.stick_ball.instantaneous_point import InstantaneousPoint
from pooltool.physics.resolve.transition import CanonicalTransition

RESTING, SLIDING, ROLLING = 0, 2, 3

LEAST_FRICTION = 1e-9
"""Coefficient used for a friction of 0, which pooltool rejects."""

SAMPLE_INTERVAL = 0.005
"""Longest time between two samples [s]."""

KINDS = {
    pt.EventType.BALL_BALL: "ball-ball",
    pt.EventType.BALL_LINEAR_CUSHION: "ball-cushion",
    pt.EventType.SLIDING_ROLLING: "slide-to-roll",
    pt.EventType.ROLLING_STATIONARY: "roll-to-rest",
    pt.EventType.ROLLING_SPINNING: "roll-to-rest",
}


_COMPILED: set[tuple[Any, ...]] = set()


def version() -> str:
    """Return the version of the package."""
    return metadata.version("pooltool-billiards")


def simulate(scene: dict[str, Any], record: str) -> dict[str, Any]:
    """Simulate a scene; building the system isn't timed, recording its history is."""
    physics = scene["physics"]
    table = scene["table"] or {"length": 1000.0, "width": 1000.0}
    shift = np.zeros(3) if scene["table"] else np.array([500.0, 500.0, 0.0])
    if physics["motion"] != "sliding":
        return {"cannot": "its balls slide before they roll"}
    if physics["cushion"] not in ("han2005", "mirror", "stronge2000"):
        return {"cannot": "the adapter has only mirror, Han's and Stronge's cushions"}
    if physics["ball_impact"] != "frictional":
        return {"cannot": "the adapter has only frictional impacts of balls"}
    system = _system(scene, physics, table, shift)
    engine = _engine(physics)
    t_max = scene["t_max"]
    laws = tuple(physics[key] for key in ("ball_friction", "ball_restitution", "cushion"))
    if laws not in _COMPILED:  # a law is compiled on first use, which takes minutes
        pt.simulate(system.copy(), engine=engine, inplace=True, t_final=t_max)
        _COMPILED.add(laws)
    began = time.perf_counter()
    pt.simulate(system, engine=engine, inplace=True, t_final=t_max)
    seconds = time.perf_counter() - began
    end = system.events[-1].time
    if t_max is not None:
        end = min(end, t_max) if _rests(system, end) else t_max
    samples = _samples(system, end, shift, whole=record == "trajectory")
    at_rest = not (np.any(samples["velocities"][-1]) or np.any(samples["angular_velocities"][-1]))
    return {
        "status": "rest" if at_rest else "t-max",
        "rest_time": end,
        "rest_positions": samples["positions"][-1],
        "events": _events(system, end, table),
        "samples": samples,
        "wall_time": seconds,
    }


def _engine(physics: dict[str, Any]) -> PhysicsEngine:
    speed_dependent = physics["ball_friction"] == "alciatore"
    friction = AlciatoreBallBallFriction() if speed_dependent else AverageBallBallFriction()
    elastic = physics["ball_friction"] == 0.0 and physics["ball_restitution"] == 1.0
    linear, circular = _cushions(physics)
    return PhysicsEngine(
        Resolver(
            ball_ball=FrictionlessElastic() if elastic else FrictionalInelastic(friction=friction),
            ball_linear_cushion=linear,
            ball_circular_cushion=circular,
            ball_pocket=CanonicalBallPocket(),
            stick_ball=InstantaneousPoint(),
            transition=CanonicalTransition(),
        )
    )


def _cushions(physics: dict[str, Any]) -> tuple[Any, Any]:
    """Return the models of straight and of round cushions."""
    if physics["cushion"] == "mirror":
        return UnrealisticLinear(), UnrealisticCircular()
    if physics["cushion"] == "han2005":
        return Han2005Linear(), Han2005Circular()
    ratio = physics["cushion_frequency_ratio"]
    return StrongeCompliantLinear(omega_ratio=ratio), StrongeCompliantCircular(omega_ratio=ratio)


def _system(
    scene: dict[str, Any], physics: dict[str, Any], table: dict[str, Any], shift: Any
) -> pt.System:
    # pooltool's tables have the width w along x and the length l along y.
    height = physics["cushion_height"]
    if physics["cushion"] == "stronge2000":
        # pooltool puts the ball's centre R + MIN_DIST beside the nose, at any height of the nose,
        # and the normal points from the nose to the centre. Here (height - R) / R is its sine.
        radius = scene["balls"][0]["radius"]
        sine = (height - radius) / radius
        height = radius + (radius + MIN_DIST) * sine / np.sqrt(1.0 - sine * sine)
    specs = BilliardTableSpecs(w=table["length"], l=table["width"], cushion_height=height)
    cushions = create_billiard_table_cushion_segments(specs)
    world = pt.Table(cushion_segments=cushions, pockets={}, table_type=TableType.BILLIARD)
    balls = {ball["id"]: _ball(ball, physics, shift) for ball in scene["balls"]}
    cue = pt.Cue(cue_ball_id=next(iter(balls)), V0=0.0)
    return pt.System(cue=cue, table=world, balls=balls)


def _rests(system: pt.System, t: float) -> bool:
    return all(
        ball.history[-1].t <= t + 1e-12 and ball.history[-1].s == RESTING
        for ball in system.balls.values()
    )


def _samples(system: pt.System, end: float, shift: Any, *, whole: bool) -> dict[str, Any]:
    """Return the motion: just after each event, in between, and just before the next event."""
    balls = list(system.balls.values())
    instants = [state.t for state in balls[0].history]
    rows = []
    for k, t in enumerate(instants):
        if t > end:
            break
        until = min(instants[k + 1], end) if k + 1 < len(instants) else end
        count = 1 + int((until - t) / SAMPLE_INTERVAL)
        fractions = np.linspace(0.0, 1.0, count + 1) if until > t else np.zeros(1)
        for fraction in fractions if whole or until == end else ():
            since = fraction * (until - t)
            rows.append((t + since, [_evolved(ball, k, since) for ball in balls]))
    t, states = zip(*rows, strict=True)
    rvw = np.array(states)  # (k, n, 3, 3)
    return {
        "t": list(t),
        "positions": (rvw[:, :, 0] - shift).tolist(),
        "velocities": rvw[:, :, 1].tolist(),
        "angular_velocities": rvw[:, :, 2].tolist(),
    }


def _evolved(ball: Any, k: int, dt: float) -> Any:
    state, params = ball.history[k], ball.params
    rvw, _ = evolve_ball_motion(
        state.s,
        state.rvw.copy(),
        params.R,
        params.m,
        params.u_s,
        params.u_sp,
        params.u_r,
        params.g,
        dt,
    )
    return rvw


def _events(system: pt.System, end: float, table: dict[str, Any]) -> list[dict[str, Any]]:
    index = {name: i for i, name in enumerate(system.balls)}
    found = []
    for number, event in enumerate(system.events):
        kind = KINDS.get(event.event_type)
        if kind is None or event.time > end:
            continue
        a = index[event.ids[0]]
        b: int | str | None = None
        if kind == "ball-ball":
            b = index[event.ids[1]]
        elif kind == "ball-cushion":
            names = [name for name in event.ids if name in index]
            a = index[names[0]]
            x, y, _ = system.balls[names[0]].history[number].rvw[0]
            distances = {
                "left": x,
                "right": table["length"] - x,
                "bottom": y,
                "top": table["width"] - y,
            }
            b = min(distances, key=distances.__getitem__)
        found.append({"t": event.time, "kind": kind, "a": a, "b": b})
    return found


def _ball(ball: dict[str, Any], physics: dict[str, Any], shift: Any) -> Any:
    speed_dependent = physics["ball_friction"] == "alciatore"
    radius = ball["radius"]
    params = pt.BallParams(
        m=ball["mass"],
        R=radius,
        u_s=max(physics["sliding_friction"], LEAST_FRICTION),
        u_r=max(physics["rolling_friction"], LEAST_FRICTION),
        # The deceleration of spin is 5 u_sp g / (2 R), and u_sp = R times this.
        u_sp_proportionality=max(
            0.4 * physics["spinning_friction_rate"] / physics["gravity"], LEAST_FRICTION
        ),
        u_b=0.05 if speed_dependent else max(physics["ball_friction"], LEAST_FRICTION),
        e_b=physics["ball_restitution"],
        e_c=max(physics["cushion_restitution"], LEAST_FRICTION),
        f_c=max(physics["cushion_friction"], LEAST_FRICTION),
        g=physics["gravity"],
    )
    velocity = np.array(ball["velocity"])
    rolling = np.array([-velocity[1] / radius, velocity[0] / radius, 0.0])
    spin = rolling if ball["angular_velocity"] is None else np.array(ball["angular_velocity"])
    if not velocity.any() and not spin.any():
        state = RESTING
    else:
        state = ROLLING if np.allclose(spin, rolling) else SLIDING
    return pt.Ball(
        ball["id"],
        state=BallState(np.array([np.array(ball["position"]) + shift, velocity, spin]), state),
        params=params,
    )

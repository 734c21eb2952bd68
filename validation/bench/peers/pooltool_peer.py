"""pooltool: slide, roll, spin and rest, with the laws of impacts that the scene asks for."""

import time
from importlib import metadata
from typing import Any

import numpy as np
import pooltool as pt
from pooltool.objects.ball.datatypes import BallState
from pooltool.objects.table.datatypes import TableType
from pooltool.objects.table.layout import create_billiard_table_cushion_segments
from pooltool.objects.table.specs import BilliardTableSpecs
from pooltool.physics.engine import PhysicsEngine
from pooltool.physics.resolve.ball_ball.friction import (
    AlciatoreBallBallFriction,
    AverageBallBallFriction,
)
from pooltool.physics.resolve.ball_ball.frictional_inelastic import FrictionalInelastic
from pooltool.physics.resolve.ball_cushion.han_2005.model import Han2005Circular, Han2005Linear
from pooltool.physics.resolve.ball_pocket import CanonicalBallPocket
from pooltool.physics.resolve.resolver import Resolver
from pooltool.physics.resolve.stick_ball.instantaneous_point import InstantaneousPoint
from pooltool.physics.resolve.transition import CanonicalTransition

RESTING, SLIDING, ROLLING = 0, 2, 3


def version() -> str:
    """Return the version of the package."""
    return metadata.version("pooltool-billiards")


def simulate(scene: dict[str, Any]) -> dict[str, Any]:
    """Run a scene to its end; building it is not timed, keeping its history is part of the run."""
    physics, table = scene["physics"], scene["table"]
    if physics["motion"] != "sliding" or not physics["rolling_friction"]:
        return {"cannot": "its balls slide before they roll, and friction must be more than 0"}
    if physics["cushion"] != "han2005" or physics["ball_impact"] != "frictional" or not table:
        return {"cannot": "driven here with Han's cushions on a table, and frictional impacts"}
    speed_dependent = physics["ball_friction"] == "alciatore"
    friction = AlciatoreBallBallFriction() if speed_dependent else AverageBallBallFriction()
    engine = PhysicsEngine(
        Resolver(
            ball_ball=FrictionalInelastic(friction=friction),
            ball_linear_cushion=Han2005Linear(),
            ball_circular_cushion=Han2005Circular(),
            ball_pocket=CanonicalBallPocket(),
            stick_ball=InstantaneousPoint(),
            transition=CanonicalTransition(),
        )
    )
    # Its tables are w wide along x and l long along y.
    specs = BilliardTableSpecs(
        w=table["length"], l=table["width"], cushion_height=physics["cushion_height"]
    )
    cushions = create_billiard_table_cushion_segments(specs)
    world = pt.Table(cushion_segments=cushions, pockets={}, table_type=TableType.BILLIARD)
    balls = {ball["id"]: _ball(ball, physics, speed_dependent) for ball in scene["balls"]}
    cue = pt.Cue(cue_ball_id=next(iter(balls)), V0=0.0)
    system = pt.System(cue=cue, table=world, balls=balls)
    began = time.perf_counter()
    pt.simulate(system, engine=engine, inplace=True, t_final=scene["t_max"])
    seconds = time.perf_counter() - began
    events = [event for event in system.events if event.event_type != pt.EventType.NONE]
    return {"seconds": seconds, "events": len(events)}


def _ball(ball: dict[str, Any], physics: dict[str, Any], speed_dependent: bool) -> Any:
    radius = ball["radius"]
    params = pt.BallParams(
        m=ball["mass"],
        R=radius,
        u_s=physics["sliding_friction"],
        u_r=physics["rolling_friction"],
        # Deceleration of spin is 5 u_sp g / (2 R), with u_sp = R times this.
        u_sp_proportionality=0.4 * physics["spinning_friction_rate"] / physics["gravity"],
        u_b=0.05 if speed_dependent else physics["ball_friction"],
        e_b=physics["ball_restitution"],
        e_c=physics["cushion_restitution"],
        f_c=physics["cushion_friction"],
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
        state=BallState(np.array([ball["position"], velocity, spin]), state),
        params=params,
    )

"""A scene reduced to the numbers that determine its motion; equal problems have equal proofs."""

from __future__ import annotations

from dataclasses import dataclass

from ghostball.model import CUSHIONS, Scene
from ghostball.model.scene import Obstacle


@dataclass(frozen=True)
class BallNumbers:
    """One ball, in SI units; every number is the exact double of the scene."""

    x: float
    y: float
    z: float
    vx: float
    vy: float
    vz: float
    wx: float
    wy: float
    wz: float
    rolls: bool  # starts without slip, or at rest: `Scene.rolls`
    radius: float
    mass: float
    rolling_friction: float
    sliding_friction: float
    spinning_friction_rate: float


@dataclass(frozen=True)
class ExactProblem:
    """Everything that the motion of a scene depends on, without names, titles and tags.

    `noses`: coordinates of the cushion lines in the order of `CUSHIONS` [m]; None for an open side.
    `obstacles`: all other obstacles and holes, with their coordinates as doubles.
    """

    balls: tuple[BallNumbers, ...]
    noses: tuple[float | None, ...]
    obstacles: tuple[Obstacle, ...]
    t_max: float | None
    gravity: float
    slides: bool
    simultaneous: bool  # simultaneous impacts act together
    ball_restitution: float
    ball_friction: float | None  # None: Alciatore's curve
    cushion: str
    cushion_restitution: float
    cushion_loss: float
    cushion_tangential: float
    cushion_friction: float
    cushion_height: float
    air_drag: float
    rolling_quadratic: float
    airborne: bool
    table_restitution: float


def problem_of(scene: Scene) -> ExactProblem:
    """Return the numbers of a scene for the certification."""
    physics, table = scene.physics, scene.table
    rolls, spins = scene.rolls, scene.angular_velocities
    rolling, sliding = scene.rolling_frictions, scene.sliding_frictions
    spinning = scene.spinning_friction_rates
    balls = tuple(
        BallNumbers(
            x=ball.position[0],
            y=ball.position[1],
            z=ball.position[2],
            vx=ball.velocity[0],
            vy=ball.velocity[1],
            vz=ball.velocity[2],
            wx=float(spins[i, 0]),
            wy=float(spins[i, 1]),
            wz=float(spins[i, 2]),
            rolls=bool(rolls[i]),
            radius=ball.radius,
            mass=ball.mass,
            rolling_friction=float(rolling[i]),
            sliding_friction=float(sliding[i]),
            spinning_friction_rate=float(spinning[i]),
        )
        for i, ball in enumerate(scene.balls)
    )
    noses: list[float | None] = [None] * len(CUSHIONS)
    if table is not None:
        for side in table.sides:
            noses[side.cushion] = side.point[side.across]
    mirror = physics.cushion == "mirror"
    friction = physics.ball_friction
    return ExactProblem(
        balls=balls,
        noses=tuple(noses),
        obstacles=() if table is None else table.obstacles,
        t_max=scene.t_max,
        gravity=physics.gravity,
        slides=physics.motion == "sliding",
        simultaneous=physics.impacts == "simultaneous",
        ball_restitution=physics.ball_restitution,
        ball_friction=None if friction == "alciatore" else float(friction),
        cushion=physics.cushion,
        cushion_restitution=1.0 if mirror else physics.cushion_restitution,
        cushion_loss=0.0 if mirror else physics.cushion_restitution_loss,
        cushion_tangential=1.0 if mirror else physics.cushion_tangential_restitution,
        cushion_friction=physics.cushion_friction,
        cushion_height=physics.cushion_height,
        air_drag=physics.air_drag,
        rolling_quadratic=physics.rolling_friction_quadratic,
        airborne=physics.airborne,
        table_restitution=physics.table_restitution,
    )

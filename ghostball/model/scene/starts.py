"""How balls begin, as arrays: what the rules of places and of motions are asked about."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ghostball.model.arrays import BoolArray, FloatArray, IntArray
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.parts import fill_in_motion, rolling_angular_velocity
from ghostball.model.scene.strike import bounced, stroke_of


class Starts(NamedTuple):
    """How m balls begin: all of a scene, or some of its balls in each of many shots."""

    ball: IntArray  # (m,) which it is: index in the scene
    radius: FloatArray  # (m,) [m]
    position: FloatArray  # (m, 3) [m]
    velocity: FloatArray  # (m, 3) [m/s]
    spin: FloatArray  # (m, 3) angular velocity [rad/s]
    rolling: FloatArray  # (m, 3) what that of rolling without slip would be [rad/s]
    given: BoolArray  # (m,) whether the spin is given; else it is that of rolling
    shot: IntArray | None = None  # (m,) of many shots, which one; None: there is one

    def name(self, k: int, field: str = "") -> str:
        """Return how a message calls ball k of these, or a field of it."""
        name = f"`balls[{self.ball[k]}]{field}`"
        return name if self.shot is None else f"{name} in shot {self.shot[k]}"


def let_table_answer_strikes(scene: SceneContents) -> None:
    """Fill in how balls that are struck begin where they may fly.

    The cue pushes them up, or into the table, which answers at once. Where balls stay on the cloth,
    it takes what is vertical of the velocity, and they have that already.
    """
    if not scene.physics.airborne:
        return
    restitution = scene.physics.table_restitution
    for ball, friction in zip(scene.balls, scene.sliding_frictions.tolist(), strict=True):
        if ball.strike is None:
            continue
        velocity, spin, _ = stroke_of(ball.strike, ball.radius, ball.mass)
        if velocity[2] < 0.0:
            velocity, spin = bounced(velocity, spin, ball.radius, friction, restitution)
        fill_in_motion(ball, velocity, spin)


def starts_of(scene: SceneContents) -> Starts:
    """Return how the balls of a scene begin."""
    balls = scene.balls
    rows = np.array([(*ball.position, *ball.velocity, ball.radius) for ball in balls])
    radii, velocities = rows[:, 6], rows[:, 3:6]
    rolling = rolling_angular_velocity(velocities, radii)
    turned = [k for k, ball in enumerate(balls) if ball.angular_velocity is not None]
    given, spins = np.zeros(len(balls), dtype=np.bool_), rolling
    if turned:
        given[turned] = True
        spins = rolling.copy()
        spins[turned] = [balls[k].angular_velocity for k in turned]
    return Starts(np.arange(len(balls)), radii, rows[:, :3], velocities, spins, rolling, given)

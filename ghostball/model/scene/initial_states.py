"""Initial states of balls as arrays, for the rules about positions and motions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ghostball.model.arrays import BoolArray, FloatArray, IntArray
from ghostball.model.scene.ball import fill_in_motion, rolling_angular_velocity
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.strike import bounced, stroke_of


class InitialStates(NamedTuple):
    """Initial states of m balls: those of a scene, or some balls in each of many shots."""

    ball: IntArray  # (m,) index of the ball in the scene
    radius: FloatArray  # (m,) [m]
    position: FloatArray  # (m, 3) [m]
    velocity: FloatArray  # (m, 3) [m/s]
    spin: FloatArray  # (m, 3) angular velocity [rad/s]
    rolling: FloatArray  # (m, 3) angular velocity of rolling without slip [rad/s]
    given: BoolArray  # (m,) whether the spin is given; otherwise it is `rolling`
    shot: IntArray | None = None  # (m,) index of the shot; None: there is only one

    def name(self, k: int, field: str = "") -> str:
        """Return the name of ball k, or of one of its fields, for a message."""
        name = f"`balls[{self.ball[k]}]{field}`"
        return name if self.shot is None else f"{name} in shot {self.shot[k]}"


def apply_table_reaction(scene: SceneContents) -> None:
    """Set the initial velocities of struck balls in an airborne scene.

    The cue pushes a ball upwards, or into the table, which reacts at once. In a scene that isn't
    airborne, the cloth absorbs the vertical velocity, and `Ball` has already set the velocities.
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


def initial_states_of(scene: SceneContents) -> InitialStates:
    """Return the initial states of the balls of a scene."""
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
    return InitialStates(
        np.arange(len(balls)), radii, rows[:, :3], velocities, spins, rolling, given
    )

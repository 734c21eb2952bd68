"""Initial states of balls as arrays, for the rules about positions and motions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pydantic_core import PydanticCustomError

from ghostball.model.arrays import BoolArray, FloatArray, IntArray
from ghostball.model.scene.ball import fill_in_motion, rolling_angular_velocity
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.fields import problem
from ghostball.model.scene.strike import (
    Aims,
    Strike,
    aims_of,
    bounced,
    strokes_of,
    vector,
)


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

    def problem(self, k: int, field: str, rule: str) -> PydanticCustomError:
        """Return the error of a field of ball k; `rule` follows the field's name in the message."""
        at = ("balls", int(self.ball[k]), field)
        return problem(f"{self.name(k, f'.{field}')} {rule}", at=at)


def apply_table_reaction(scene: SceneContents) -> None:
    """Set the initial velocities of struck balls in an airborne scene.

    The cue pushes a ball upwards, or into the table, which reacts at once. In a scene that isn't
    airborne, the cloth absorbs the vertical velocity, and `Ball` has already set the velocities.
    """
    if not scene.physics.airborne:
        return
    for i, ball in enumerate(scene.balls):
        if ball.strike is not None:
            velocity, spin = struck_motions(scene, i, ball.strike, aims_of(ball.strike))
            fill_in_motion(ball, vector(velocity[0]), vector(spin[0]))


def struck_motions(
    scene: SceneContents, i: int, cue: Strike, aims: Aims
) -> tuple[FloatArray, FloatArray]:
    """Return the initial velocities of ball i of a scene after each of k strokes of a cue.

    Returns velocities (k, 3) [m/s] and angular velocities (k, 3) [rad/s], after the reaction of the
    table.
    """
    ball = scene.balls[i]
    velocity, spin, _ = strokes_of(cue, aims, ball.radius, ball.mass)
    if scene.physics.airborne:
        friction = float(scene.sliding_frictions[i])
        return bounced(velocity, spin, ball.radius, friction, scene.physics.table_restitution)
    velocity[:, 2] = 0.0
    return velocity, spin


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

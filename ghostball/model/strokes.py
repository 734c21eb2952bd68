"""Compute the strokes of the struck balls of a scene, and the velocities with which they start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ghostball.model.scene import Ball, Scene, Strike, stroke_of


@dataclass(frozen=True)
class StruckBall:
    """A struck ball of a scene, its strike, and the result of the stroke; see `to_dict`."""

    index: int
    ball: Ball
    strike: Strike
    tip_velocity: tuple[float, float, float]
    cue_speed: float

    @property
    def squirt_angle(self) -> float:
        """Squirt angle to the left [rad]: from the direction of the cue to that of the ball.

        The ball's direction is taken as the ball leaves the tip, seen from above.
        """
        x, y, _ = self.tip_velocity
        c, s = math.cos(self.strike.direction), math.sin(self.strike.direction)
        return math.atan2(c * y - s * x, c * x + s * y)

    def to_dict(self) -> dict[str, Any]:
        """Return the stroke as plain values.

        `ball`: index of the ball.
        `strike`: fields of the strike as in the scene.
        `tip_velocity`: velocity of the ball as it leaves the tip [m/s].
        `squirt_angle`: angle from the direction of the cue to that of the ball, to the left [rad].
        `cue_speed`: speed of the cue after the stroke [m/s].
        `velocity`, `angular_velocity`: initial velocities of the ball, after the reaction of the
            table [m/s, rad/s].
        """
        assert self.ball.angular_velocity is not None  # a strike sets the angular velocity
        return {
            "ball": self.index,
            "strike": self.strike.model_dump(mode="json"),
            "tip_velocity": list(self.tip_velocity),
            "squirt_angle": self.squirt_angle,
            "cue_speed": self.cue_speed,
            "velocity": list(self.ball.velocity),
            "angular_velocity": list(self.ball.angular_velocity),
        }


def struck_balls(scene: Scene) -> list[StruckBall]:
    """Return the struck balls of a scene, in the order of the scene."""
    found = []
    for i, ball in enumerate(scene.balls):
        if ball.strike is not None:
            velocity, _, cue_speed = stroke_of(ball.strike, ball.radius, ball.mass)
            found.append(StruckBall(i, ball, ball.strike, velocity, cue_speed))
    return found

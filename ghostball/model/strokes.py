"""What the strikes of a scene came to: the strokes, and how the balls begin."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ghostball.model.scene import Ball, Scene, Strike, stroke_of


@dataclass(frozen=True)
class Struck:
    """One ball of a scene, its strike, and what that gave it; see `to_dict`."""

    index: int
    ball: Ball
    strike: Strike
    tip_velocity: tuple[float, float, float]
    cue_speed: float

    @property
    def squirt_angle(self) -> float:
        """How far to the left of the cue's direction the ball leaves the tip, from above [rad]."""
        x, y, _ = self.tip_velocity
        c, s = math.cos(self.strike.direction), math.sin(self.strike.direction)
        return math.atan2(c * y - s * x, c * x + s * y)

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values.

        `ball` is its index, `strike` has the fields in the scene, `tip_velocity` [m/s] is that of
        the ball as it leaves the tip, `squirt_angle` [rad] is to the left of the cue's direction,
        `cue_speed` [m/s] that of the cue afterwards, `velocity` and `angular_velocity` [m/s, rad/s]
        are those with which the ball begins, when the table has answered.
        """
        assert self.ball.angular_velocity is not None  # a strike gives it
        return {
            "ball": self.index,
            "strike": self.strike.model_dump(mode="json"),
            "tip_velocity": list(self.tip_velocity),
            "squirt_angle": self.squirt_angle,
            "cue_speed": self.cue_speed,
            "velocity": list(self.ball.velocity),
            "angular_velocity": list(self.ball.angular_velocity),
        }


def struck_balls(scene: Scene) -> list[Struck]:
    """Return the balls of a scene that are struck, in its order."""
    found = []
    for i, ball in enumerate(scene.balls):
        if ball.strike is not None:
            velocity, _, cue_speed = stroke_of(ball.strike, ball.radius, ball.mass)
            found.append(Struck(i, ball, ball.strike, velocity, cue_speed))
    return found

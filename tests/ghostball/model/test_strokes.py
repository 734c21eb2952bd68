"""What is told of the strokes of a scene."""

from __future__ import annotations

import json
import math

import pytest
from shots import FLIES

from ghostball.engine import simulate
from ghostball.model import Ball, Physics, Scene, Strike
from ghostball.model.scene import stroke_of
from ghostball.model.strokes import struck_balls

STRIKE = Strike(speed=3.0, direction=2.5, elevation=0.2, offset_left=0.3, squirt="alciatore")
SCENE = Scene(
    name="a",
    physics=Physics(**FLIES),
    balls=[
        Ball(id="still", position=(1.0, 1.0)),
        Ball(id="cue", position=(0.0, 0.0), strike=STRIKE),
    ],
)


def test_each_ball_that_is_struck_is_told():
    (struck,) = struck_balls(SCENE)
    stroke = stroke_of(STRIKE, SCENE.balls[1].radius, SCENE.balls[1].mass)
    told = struck.to_dict()
    assert told == {
        "ball": 1,
        "strike": STRIKE.model_dump(),
        "tip_velocity": list(stroke.velocity),
        "squirt_angle": struck.squirt_angle,
        "cue_speed": stroke.cue_speed,
        "velocity": SCENE.velocities[1].tolist(),
        "angular_velocity": SCENE.angular_velocities[1].tolist(),
    }
    result = simulate(SCENE)
    assert json.loads(result.to_json())["strikes"] == [told]
    assert simulate(SCENE.without_strikes()).to_dict()["strikes"] == []


@pytest.mark.parametrize("direction", [0.0, 1.0, 2.5, -3.0])
def test_squirt_is_seen_from_above_and_away_from_the_side_that_is_hit(direction):
    strike = STRIKE.model_copy(update={"direction": direction})
    (struck,) = struck_balls(Scene(name="a", physics=SCENE.physics, balls=[ball_with(strike)]))
    ratio = struck.ball.mass / strike.end_mass
    behind = 1.0 - 0.3**2
    tangent = 2.5 * 0.3 * math.sqrt(behind) / (1.0 + ratio + 2.5 * behind)
    assert struck.squirt_angle == pytest.approx(-math.atan(tangent), rel=1e-12)


def ball_with(strike: Strike) -> Ball:
    return Ball(id="cue", position=(0.0, 0.0), strike=strike)

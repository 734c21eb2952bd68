"""Backward error: strokes that are known are found again."""

import math

import numpy as np
import pytest
from toy_engines import cut, other_shot, roll

from ghostball.engine import Ball, Scene, simulate
from ghostball.validation import find_scene
from ghostball.validation.diagnose.attribution import NoCueBallError, attribute, backward_error
from ghostball.validation.diagnose.attribution._backward import changed_shot, cue_ball
from ghostball.validation.truth.known_shot import known_shot

SHOTS = {
    "cut": cut(),
    "swerve": find_scene("sliding-swerve"),
    "half-ball": find_scene("half-ball-cut"),
}


@pytest.mark.parametrize("scene", SHOTS.values(), ids=SHOTS)
@pytest.mark.parametrize("speed", [0.0, 1e-3, -2e-3])
@pytest.mark.parametrize("degrees", [0.01, -0.003])
def test_a_shot_that_is_off_is_off_by_that(scene, speed, degrees):
    played = simulate(changed_shot(scene, 0, speed, math.radians(degrees))).rest_positions[:, :2]
    found = backward_error(known_shot(scene), played, None)
    assert found.degrees == pytest.approx(degrees, rel=1e-6)
    assert found.speed == pytest.approx(speed, rel=1e-6, abs=1e-9)
    assert found.unexplained < 1e-10
    assert found.ball == "cue"


def test_attribution_says_it_too():
    found = attribute(cut(), other_shot(turn=math.radians(0.01)))
    assert found.backward.degrees == pytest.approx(0.01, rel=1e-6)
    assert found.backward.unexplained < 1e-10


def test_before_the_end_too():
    scene = cut()
    stopped = changed_shot(scene, 0, 0.0, 1e-4).model_copy(update={"t_max": 0.8})
    found = backward_error(known_shot(scene), simulate(stopped).rest_positions[:, :2], 0.8)
    assert found.turn == pytest.approx(1e-4, rel=1e-6)


def test_what_no_stroke_does_is_left_unexplained():
    known = known_shot(cut())
    aside = known.positions(None) + np.array([[0.0, 0.0], [0.0, 0.0]])
    away = aside + np.array([[3e-3, 0.0], [-3e-3, 4e-3]])
    found = backward_error(known, away, None)
    assert found.unexplained > 1e-3
    # No neighbouring stroke is better.
    for speed, turn in ((1e-5, 0.0), (-1e-5, 0.0), (0.0, 1e-5), (0.0, -1e-5)):
        near = simulate(changed_shot(known.scene, 0, found.speed + speed, found.turn + turn))
        best = simulate(changed_shot(known.scene, 0, found.speed, found.turn))
        left, least = (np.sum((run.rest_positions[:, :2] - away) ** 2) for run in (near, best))
        assert left > least


def test_a_rolling_ball_still_rolls_and_a_sliding_one_keeps_its_spin_relative_to_its_way():
    rolling = changed_shot(cut(), 0, 0.1, 0.3)
    assert rolling.rolls.all()
    sliding = find_scene("masse")
    turned = changed_shot(sliding, 0, 0.0, math.pi / 2)
    w, before = turned.angular_velocities[0], sliding.angular_velocities[0]
    np.testing.assert_allclose(w, [-before[1], before[0], before[2]], atol=1e-12)


def test_the_cue_ball_is_the_fastest():
    slow, fast = ((0.5, 0.0), (0.0, 2.0))
    balls = [
        Ball(id="a", position=(0.0, 0.0), velocity=slow),
        Ball(id="b", position=(1.0, 0.0), velocity=fast),
    ]
    assert cue_ball(roll(balls=balls)) == 1


def test_no_cue_ball_is_refused_with_the_reason():
    equal = [
        Ball(id=i, position=(x, 0.0), velocity=(1.0, 0.0)) for i, x in (("a", 0.0), ("b", 1.0))
    ]
    with pytest.raises(NoCueBallError, match='"a", "b" are equally fast at 1 m/s'):
        cue_ball(roll(balls=equal))
    with pytest.raises(NoCueBallError, match="no ball moves"):
        cue_ball(Scene(name="still", balls=[Ball(id="a", position=(0.0, 0.0))]))
    found = attribute(roll(balls=equal), other_shot())
    assert found.backward is None
    assert "equally fast" in found.no_backward

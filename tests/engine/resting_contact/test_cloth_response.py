"""Tests of the cloth's friction, and of air, on balls in contact with different decelerations."""

import math

import numpy as np
import pytest
from shots import R

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.model import Ball, Physics, Scene
from ghostball.validation.scenes.library import find_scene


@pytest.mark.parametrize("motion", ["sliding", "rolling"])
@pytest.mark.parametrize("n", [2, st.MOST_DIRECT + 2], ids=["followed", "in steps"])
def test_a_line_that_rolls_in_air_is_slowed_as_a_whole(n, motion):
    """Closed form: each ball pushes the next, which more friction slows; air acts on all equally.

    p' = -(a + b p^2), where a is the mean of the rolling frictions, and b is the quadratic
    coefficient of rolling friction plus the part of air drag that the cloth leaves.
    """
    frictions, v, t = np.linspace(0.01, 0.03, n), 2.0, 0.05
    physics = Physics(
        motion=motion,
        air_drag=0.05,
        rolling_friction_quadratic=0.05,
        **({"ball_friction": 0.0} if motion == "sliding" else {}),
    )
    balls = [
        Ball(id=f"b{k}", position=(2 * R * k, 0.0), velocity=(v, 0.0), rolling_friction=friction)
        for k, friction in enumerate(frictions)
    ]
    result = simulate(Scene(name="line", balls=balls, physics=physics, t_max=t), record="events")
    assert result.work["contact_steps"] > 2
    assert (result.work.get("contact_pieces", 0) > 0) == (n == 2)
    a, b = 9.81 * np.mean(frictions), 0.05 * (1.0 + (5.0 / 7.0 if motion == "sliding" else 1.0))
    first = np.arctan(v * np.sqrt(b / a))
    last = first - np.sqrt(a * b) * t
    end = result.sample([t])
    off = 1e-6 if n == 2 else 2e-5
    gone = end.positions[0, :, 0] - [ball.position[0] for ball in balls]
    assert end.velocities[0, :, 0] == pytest.approx(np.sqrt(a / b) * np.tan(last), rel=0.0, abs=off)
    assert gone == pytest.approx(np.log(np.cos(last) / np.cos(first)) / b, rel=0.0, abs=off * t)


def test_a_pushed_ball_parts_where_the_other_is_slowed_more():
    """A ball pushes another until it rolls, and then decelerates more: the contact opens.

    During the slide, both have the acceleration (5 mu_s - 7 mu_f) g / 12, with mu_f the rolling
    friction of the front ball, as in the shipped scene `push`. The slide ends when a t = R w -
    (5/2) mu_s g t. Then each ball rolls alone.

    Our engine ends a slip at once if the cloth would end it within `STOP_DISTANCE`: a slip of up to
    sqrt(2 mu_s g 2e-10 m) = 3e-5 m/s. Then 2/7 of it are taken from the rear ball instead of from
    both balls: 8e-6 m/s, or v dv / (mu_r g) = 8 um of its rolling distance.
    """
    push = find_scene("push")
    rear, front = push.balls
    braked = rear.model_copy(update={"rolling_friction": 0.04})
    scene: Scene = push.model_copy(update={"name": "parting", "balls": (braked, front)})
    g, slide = scene.physics.gravity, float(scene.sliding_frictions[0])
    of_front = float(scene.rolling_frictions[1])
    together = (5.0 * slide - 7.0 * of_front) * g / 12.0
    rolls = rear.radius * float(scene.angular_velocities[0, 1]) / (together + 2.5 * slide * g)
    speed = together * rolls
    ways = 0.5 * speed * rolls + speed * speed / (2.0 * scene.rolling_frictions * g)
    result = simulate(scene)
    off = result.rest_positions[:, 0] - scene.positions[:, 0] - ways
    assert ways[1] - ways[0] > 4.0 * rear.radius
    assert np.max(np.abs(off)) <= 1e-5
    assert math.isclose(result.rest_time, rolls + speed / (of_front * g), abs_tol=5e-6)
    assert not any(result.collision_counts.values())

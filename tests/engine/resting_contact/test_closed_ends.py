"""Shots whose end has a closed form where a proof ends early: at a tie, or in lasting contact."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Scene
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import closed_form


@pytest.mark.parametrize(
    ("name", "distance", "duration"),
    [
        ("corner-exact", 1e-14, 1e-14),
        ("frozen-to-cushion", 1e-14, 1e-14),
        ("three-ball-symmetric", 1e-14, 1e-14),
        ("push", 1e-6, 5e-6),
        ("wedged", 1e-12, 1e-5),
    ],
)
def test_a_shot_ends_as_its_closed_form_says(name, distance, duration):
    """Within [m] and [s] what the scene's own criteria say, and why."""
    scene = find_scene(name)
    form, result = closed_form(scene), simulate(scene)
    assert form is not None
    places = np.array([[float(x), float(y)] for x, y in form.rest_positions])
    assert np.max(np.abs(result.rest_positions[:, :2] - places)) <= distance
    assert abs(result.rest_time - float(form.rest_time)) <= duration
    assert dict(result.collision_counts) == form.collision_counts


def test_a_pushed_ball_parts_where_the_other_is_slowed_more():
    """Of a ball that pushes another until it rolls, and then is slowed more: the contact opens.

    While it slides, both go with (5 mu_s - 7 mu_f) g / 12, mu_f the rolling friction of the front
    ball, as in the shipped scene `push`; the slide ends where a t = R w - (5/2) mu_s g t. From
    there each rolls out alone.

    Our engine ends a slip at once that the cloth would end within `STOP_WAY`: one of up to
    sqrt(2 mu_s g 2e-10 m) = 3e-5 m/s, of which 2/7 come off the rear ball alone instead of off
    both: 8e-6 m/s, worth v dv / (mu_r g) = 8 um in its roll out.
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

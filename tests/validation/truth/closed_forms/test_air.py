"""Closed forms of balls in air, against numbers computed elsewhere."""

from __future__ import annotations

import math

import pytest

from ghostball.model import Physics
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import closed_form, has_closed_form


def test_the_numbers_of_one_ball_are_those_computed_elsewhere() -> None:
    form = closed_form(find_scene("air-slides"))
    assert form is not None
    # A stunned ball of 3 m/s slides 1.1168 m, and rolls on at 2.1344 m/s: ln(1 + q^2) / 2b.
    a, b = 0.01 * 9.81, 5 * 0.0041 / 7
    on = math.log1p(b * 2.1343833222613356**2 / a) / (2 * b)
    assert float(form.rest_positions[0][0]) == pytest.approx(1.1168116256280046 + on, rel=1e-13)


def test_a_scene_of_that_name_without_air_or_with_a_slip_across_has_none() -> None:
    scene = find_scene("air-slides")
    assert not has_closed_form(scene.model_copy(update={"physics": Physics(preset="pool")}))
    turned = scene.balls[0].model_copy(update={"angular_velocity": (1.0, 0.0, 0.0)})
    assert not has_closed_form(scene.model_copy(update={"balls": (turned, *scene.balls[1:])}))
    crossing = scene.balls[0].model_copy(update={"position": (0.0, 0.48)})
    assert not has_closed_form(scene.model_copy(update={"balls": (crossing, *scene.balls[1:])}))

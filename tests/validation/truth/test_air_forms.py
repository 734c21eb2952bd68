"""Closed forms of balls in air: against forces in small steps, and numbers computed elsewhere."""

from __future__ import annotations

import math

import pytest

from ghostball.engine import Physics, Scene
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import FORMS, closed_form, has_closed_form

IN_AIR = [name for name, form in FORMS.items() if form.air]


def rest_of(scene: Scene, i: int, h: float = 2e-3) -> tuple[float, float]:
    """Return where on its line and when ball i stops, by the forces on it in steps of Runge-Kutta.

    Motion along x: position, velocity, angular velocity about y; the cloth acts at the lowest
    point, and its grip keeps a ball that rolls from slipping.
    """
    physics, radius = scene.physics, float(scene.radii[i])
    k, extra = physics.air_drag, physics.rolling_friction_quadratic
    slides, g = physics.motion == "sliding", physics.gravity
    rolls = bool(scene.rolls[i])

    def rates(v: float, w: float) -> tuple[float, float]:  # `sense`: against what friction acts
        air = -k * abs(v) * v
        if not rolls:
            f = -physics.sliding_friction * g * sense
            return f + air, -2.5 * f / radius
        # The cloth's grip keeps v = R w, and takes 2/7 of what the air does.
        resisted = physics.rolling_friction * g + extra * v * v
        a = air * (5 / 7 if slides else 1.0) - sense * resisted
        return a, a / radius

    x, v, w = 0.0, float(scene.velocities[i, 0]), float(scene.angular_velocities[i, 1])
    t = 0.0
    while True:
        sense = math.copysign(1.0, v if rolls else v - radius * w)
        a1, b1 = rates(v, w)
        a2, b2 = rates(v + h / 2 * a1, w + h / 2 * b1)
        a3, b3 = rates(v + h / 2 * a2, w + h / 2 * b2)
        a4, b4 = rates(v + h * a3, w + h * b3)
        later, turning = (
            v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4),
            w + h / 6 * (b1 + 2 * b2 + 2 * b3 + b4),
        )
        way = h * v + h * h / 6 * (a1 + a2 + a3)
        if rolls and later * v <= 0.0:
            part = v / (v - later)
            return x + part * h * v / 2, t + part * h
        slip, left = v - radius * w, later - radius * turning
        if not rolls and left * slip <= 0.0:
            part, rolls = slip / (slip - left), True
            x += part * h * (v + part * (later - v) / 2)
            v, w, t = v + part * (later - v), w + part * (turning - w), t + part * h
            continue
        x, v, w, t = x + way, later, turning, t + h


@pytest.mark.parametrize("name", IN_AIR)
def test_agrees_with_forces_in_steps(name: str) -> None:
    """Breaks with a wrong part of the drag, a sign, or a slide that ends at another speed."""
    scene = find_scene(name)
    form = closed_form(scene)
    assert form is not None
    ends = [rest_of(scene, i) for i in range(len(scene.balls))]
    for (x, _), (there, _) in zip(ends, form.rest_positions, strict=True):
        assert x == pytest.approx(float(there), abs=2e-6)
    assert max(t for _, t in ends) == pytest.approx(float(form.rest_time), abs=1e-5)


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

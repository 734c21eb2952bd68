"""The derivative of a law whose coefficient changes with the speed."""

from __future__ import annotations

from changes import check_derivatives

from ghostball.validation.scenes.library import find_scene


def test_derivatives_through_a_restitution_that_falls_with_speed():
    scene = find_scene("three-cushions")
    physics = scene.physics.model_copy(update={"rolling_friction_quadratic": 0.0})
    check_derivatives(scene.model_copy(update={"physics": physics}))

"""The recorded motion of certified and integrated shots in air agrees with Ghostball's engine."""

import numpy as np
import pytest
from proofs import in_air, integrated_once
from shots import ball, random_cloth_shot, scene_of

from ghostball.engine import simulate
from ghostball.reference_adapters.certified import CertifiedSettings
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.scenes.library import find_scene

SHOTS = {
    "rolls": in_air(find_scene("break-7"), air_drag=0.0041, rolling_friction_quadratic=0.006),
    "slides in a line": find_scene("air-slides"),
    "slides": in_air(random_cloth_shot(3), air_drag=0.05),
    "slides without friction": in_air(
        find_scene("sliding-swerve"), t_max=1.0, air_drag=0.1, sliding_friction=0.0
    ),
}

INTEGRATED = ("slides in a line", "slides")
"""Integrated shots, which can't be certified."""


@pytest.mark.parametrize("name", SHOTS)
def test_the_recorded_motion_is_that_of_our_engine(name: str) -> None:
    # Fails for a piece that is too long for its series, a piece that ends early, or a wrong spin.
    scene = SHOTS[name]
    ours = simulate(scene, record="trajectory")
    if name in INTEGRATED:
        shot = integrated_once(scene)
        proved = result_of(scene, shot, CertifiedSettings(), "trajectory")
    else:
        proved = make_engine("certified").simulate(scene, record="trajectory")
    times = np.linspace(0.0, ours.rest_time, 301)
    for a, b in zip(ours.sample(times), proved.sample(times), strict=True):
        assert np.abs(a - b).max() < 1e-9


def test_a_slide_of_no_length_is_a_parabola() -> None:
    """Powers of the inverse slip must not overflow: a slip of 1e-17 m/s is a slip."""
    slow = ball((0, 0), (1e-17, 0.0), angular_velocity=(0.0, 0.0, 0.0))
    scene = scene_of(slow, preset="pool", air_drag=0.004)
    segments = integrated_once(scene).segments
    assert segments is not None
    assert np.isfinite(segments[0]).all()

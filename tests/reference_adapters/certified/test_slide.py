"""Slides in air can't be certified, except on a cloth without friction, and the error says so."""

import math

import pytest
from shots import POOL_TABLE, ball, scene_of

from ghostball.model import EventKind, UnsupportedSceneError
from ghostball.reference_adapters.certified import certify

POOL = {"preset": "pool", "air_drag": 0.0041, "gravity": 9.81, "sliding_friction": 0.2}


def test_a_slide_without_friction_goes_straight_on() -> None:
    scene = scene_of(
        ball((0, 0), (2.0, 0.0), angular_velocity=(10.0, 0.0, 0.0)), ball((0, 1)),
        **POOL | {"sliding_friction": 0.0, "air_drag": 0.5}, t_max=3.0,
    )  # fmt: skip
    certificate = certify(scene, cached=False)
    assert certificate.proved
    assert float(certificate.positions[0][0]) == pytest.approx(math.log(4.0) / 0.5, rel=1e-15)
    assert float(certificate.velocities[0][0]) == pytest.approx(0.5, rel=1e-15)
    assert float(certificate.spins[0][0]) == pytest.approx(10.0, rel=1e-15)


def test_a_shot_that_begins_with_a_slide_in_air_is_refused_by_name() -> None:
    scene = scene_of(ball((0, 0), (3.0, 0.0), angular_velocity=(-50.0, 60.0, 0.0)), **POOL)
    with pytest.raises(UnsupportedSceneError, match="no slides in air"):
        certify(scene, cached=False)


def test_a_proof_ends_where_a_slide_in_air_begins() -> None:
    """A rolling ball slides after its first cushion contact; the part before is certified."""
    scene = scene_of(ball((0.5, 0.5), (3.0, 1.0)), table=POOL_TABLE, **POOL)
    certificate = certify(scene, cached=False)
    assert certificate.ending == "ambiguous"
    assert "a slide in air has no closed form" in certificate.reason
    assert [event.kind for event in certificate.events] == []
    assert certificate.choices[0].kind is EventKind.BALL_CUSHION

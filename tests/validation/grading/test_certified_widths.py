"""Error growth along a proved flight, from the widths of its enclosures."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from shots import kept_scene

from ghostball.engine import simulate
from ghostball.model import Ball, Scene
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings, certify
from ghostball.validation.grading.certified_widths import (
    FlightGrowth,
    is_differentiated,
    width_sizes,
)
from ghostball.validation.grading.gradable import gradable
from ghostball.validation.grading.grading import grade
from ghostball.validation.grading.horizon import horizon
from ghostball.validation.grading.tolerances import ROUNDINGS, TOLERANCE, UNIT_ROUNDOFF
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene
from ghostball.validation.truth.scene_truth import truth_of


def width_horizon(scene: Scene, proof: Certificate) -> float:
    return horizon(FlightGrowth(scene, proof), TOLERANCE, ROUNDINGS * UNIT_ROUNDOFF)


FLIGHTS = ("flight-bounces", "flight-jump", "flight-leaves", "flight-throw")


@pytest.mark.parametrize("bits", [106, 212, 6784])
def test_widths_are_those_of_doubles_whatever_the_precision(bits: int) -> None:
    scene = find_scene("flight-throw")
    settings = CertifiedSettings(start_precision=bits, max_precision=max(bits, 3392), width=1.0)
    proof = certify(scene, settings, cached=False)
    (size,) = width_sizes(proof)
    # A throw over 20 m amplifies the rounding of a few numbers by at most a few thousand.
    assert 1.0 < size < 1e5
    assert width_horizon(scene, proof) == math.inf


def test_a_ball_that_nothing_concerns_is_not_displaced() -> None:
    proof = certify(find_scene("flight-jump"))
    sizes = width_sizes(proof)
    assert sizes[1] == 0.0
    assert (sizes[[0, 2]] > 0.0).all()


def test_the_place_of_a_ball_that_only_goes_straight_on_is_rounded() -> None:
    ball = {"id": "a", "position": (0.1, 0.3), "velocity": (0.3, 0.1)}
    physics = {"motion": "sliding", "airborne": True, "rolling_friction": 0.0}
    scene = Scene.model_validate({"name": "on", "physics": physics, "balls": [ball], "t_max": 0.7})
    proof = certify(scene, motion=True, cached=False)
    assert not proof.events
    found = grade(simulate(scene, record="trajectory"), proof)
    assert found.quality_factor is not None
    assert found.quality_factor < 4.0


def test_flights_are_graded_within_the_widths_of_their_proofs() -> None:
    for name in FLIGHTS:
        scene = find_scene(name)
        assert not is_differentiated(scene)
        proof = certify(scene, motion=True)
        found = grade(simulate(scene, record="trajectory"), proof)
        assert found.extent == "whole"
        assert (found.missing, found.invented) == ((), ())
        assert found.quality_factor is not None
        assert found.quality_factor < 32.0


def test_a_ball_that_ends_elsewhere_has_a_quality_that_says_so() -> None:
    scene = find_scene("flight-throw")
    (thrown,) = scene.balls
    aside = Ball(
        id="cue",
        position=(1e-9, *thrown.position[1:]),
        velocity=thrown.velocity,
        angular_velocity=thrown.angular_velocity,
    )
    moved = Scene(name="moved", physics=scene.physics, balls=[aside])
    proof = certify(scene, motion=True)
    found = grade(simulate(moved, record="trajectory"), proof, gradable(scene, proof))
    assert found.quality_factor is not None
    assert found.quality_factor > 32.0


def test_what_is_amplified_too_far_is_past_a_horizon() -> None:
    """The enclosures count as those of a proof with more bits, so that rounding has grown more."""
    scene = find_scene("flight-jump")
    proof = certify(scene, motion=True)
    horizons = [
        width_horizon(scene, replace(proof, precision=proof.precision + more))
        for more in (0, 24, 33, 10_000)
    ]
    assert horizons[0] == math.inf
    assert horizons[1] > horizons[2] > horizons[3]
    shaken = replace(proof, precision=proof.precision + 33)
    within = gradable(scene, shaken)
    assert (within.extent, within.until) == ("horizon", math.nextafter(horizons[2], 0.0))
    found = grade(simulate(scene, record="trajectory"), shaken, within)
    assert (found.missing, found.invented) == ((), ())
    assert found.quality_factor is None


def test_a_landing_within_a_rounding_of_a_bounce_is_negligible() -> None:
    """Ball 0 is hit twice simultaneously; at the second hit it is one rounding above the table."""
    scene = kept_scene("landing-at-a-bounce")
    result = simulate(scene, record="trajectory")
    found = grade(result, certify(scene, motion=True, cached=False))
    assert (found.missing, found.invented) == ((), ())


def test_the_truth_of_a_flight_without_a_closed_form_is_its_proof() -> None:
    truth = truth_of(find_scene("flight-jump"))
    assert truth.kind == "certified"
    assert truth.certificate is not None
    assert truth.certificate.proved
    assert truth.lateness is None
    # Rounding errors don't limit the comparison; errors of a time step do, from the collision on.
    assert truth.horizon_of(1e-9) == math.inf
    assert truth.horizon_of(1e-2) == pytest.approx(0.690024583668587)
    rest = truth_of(find_scene("flight-throw"))
    assert rest.kind == "closed form"
    assert "energy" in rest.independent


def test_a_flight_that_is_proved_in_part_is_graded_in_part() -> None:
    scene = random_scene(20, **PROVABLE, flight=("low", "jump", "drop", "on-top"))
    proof = certify(scene, motion=True, cached=False)
    assert proof.ending == "sustained contact"
    found = grade(simulate(scene, record="trajectory"), proof)
    assert found.extent == "certified part"
    assert (found.missing, found.invented) == ((), ())

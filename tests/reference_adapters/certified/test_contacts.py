"""Balls that touch at the start to within rounding, and resting contacts."""

from __future__ import annotations

import math
from collections import Counter

from proofs import engine_keys, keys, proved, widest
from shots import R, ball, scene_of

from ghostball.model import COLLISION_KINDS, CUSHIONS, EventKind, Table
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings, Choice, certify
from ghostball.validation.scenes.library import find_scene

BALL_BALL, BALL_CUSHION = EventKind.BALL_BALL, EventKind.BALL_CUSHION


def collisions(certificate: Certificate) -> list[tuple[str, int, int | str]]:
    return [
        (e.kind.label, e.a, CUSHIONS[e.b] if e.kind is BALL_CUSHION else e.b)
        for e in certificate.events
        if e.kind in COLLISION_KINDS
    ]


def test_a_ball_on_a_cushion_bounces_or_rolls_along_it():
    assert keys(proved(find_scene("rail-into")))[0] == (1, 0, 2)
    assert keys(proved(find_scene("rail-along"))) == [(3, 0, -1)]


def test_balls_in_contact_from_the_start_are_certified_up_to_it():
    scene = scene_of(
        ball((0.0, 0.0), angular_velocity=(0.0, 100.0, 0.0)),
        ball((2 * R, 0.0)),
        motion="sliding",
    )
    certificate = certify(scene)
    assert certificate.ending == "sustained contact"
    assert certificate.events == ()
    assert certificate.choices == (Choice(BALL_BALL, 0, 1),)
    assert 'in resting contact, from here on: ball-ball "b0" with "b1"' in certificate.reason


def test_a_ball_pushed_into_a_cushion_is_certified_up_to_it():
    scene = scene_of(
        ball((0.5, R), angular_velocity=(50.0, 0.0, 0.0)),
        table=Table(length=2.0, width=1.0),
        motion="sliding",
    )
    certificate = certify(scene)
    assert certificate.ending == "sustained contact"
    assert certificate.choices == (Choice(BALL_CUSHION, 0, 2),)


def test_bounces_under_topspin_end_in_sustained_contact():
    # Topspin drives the ball back into the ball that it hit, with ever lower bounces.
    scene = scene_of(
        ball((0.0, 0.0), (0.5, 0.0), angular_velocity=(0.0, 3000.0, 0.0)),
        ball((0.5, 0.0), mass=1e6),
        motion="sliding",
        ball_restitution=0.5,
    )
    certificate = certify(scene)
    assert certificate.ending == "sustained contact"
    collisions = [e for e in certificate.events if e.kind is BALL_BALL]
    assert len(collisions) > 2
    assert widest(certificate) <= CertifiedSettings().width


def test_impacts_without_end_at_one_instant_are_certified_up_to_where_the_model_ends_them():
    """A proof must not compute thousands of impacts that Ghostball's engine doesn't compute."""
    radius = 2.0**-5
    places = [(radius * (2 * k + 1), 0.5) for k in range(3)]
    scene = scene_of(
        ball(places[0], radius=radius),
        ball(places[1], radius=radius),
        ball(places[2], (-1.0, 0.0), radius=radius),
        table=Table(length=1.0, width=1.0),
        t_max=0.1,
        cushion="restitution",
        cushion_restitution=0.5,
        ball_restitution=0.1,
        rolling_friction=0.0,
    )
    proof = certify(scene, cached=False)
    assert proof.ending == "sustained contact"
    assert proof.reason.startswith("endless impacts at one instant")
    pairs = [{e.a, e.b} if e.kind is BALL_BALL else {e.a} for e in proof.events]
    assert max(Counter(k for pair in pairs for k in pair).values()) == 24
    assert keys(proof) == engine_keys(scene)[: len(proof.events)]


def test_bounces_under_sliding_friction_end_in_sustained_contact_too():
    """A proof must not compute bounces below double precision; here nothing slows rolling balls."""
    radius = 2.0**-5
    x = 0.5 + radius * math.sqrt(3.0)
    resting = [ball(place, radius=radius) for place in ((0.5, 0.0), (x, radius), (x, -radius))]
    spin = (0.0, 17.4, 0.0)
    scene = scene_of(
        ball((0.3, 0.0), (2.3, 0.0), radius=radius, angular_velocity=spin),
        *resting,
        t_max=0.6,
        motion="sliding",
        ball_friction="alciatore",
        ball_restitution=0.3,
        rolling_friction=0.0,
    )
    proof = certify(scene, cached=False)
    assert proof.ending == "sustained contact"
    assert proof.reason.startswith("ever lower bounces")

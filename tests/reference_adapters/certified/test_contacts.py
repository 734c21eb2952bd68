"""Balls that touch from the start, by a rounding more or less; and contacts that are sustained."""

from __future__ import annotations

from proofs import keys, proved, widest
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
    assert (
        'in resting contact, sustained from here on: ball-ball "b0" with "b1"' in certificate.reason
    )


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
    # Topspin drives the ball back into the one that it hit: ever lower, without end.
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

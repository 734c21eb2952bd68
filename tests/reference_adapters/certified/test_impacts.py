"""Impacts in the plane: the rotation of the line of centres decides whether balls separate."""

from __future__ import annotations

from proofs import keys, proved
from shots import ball, scene_of

from ghostball.reference_adapters.certified import certify


def test_balls_without_restitution_part_where_their_ways_turn():
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((0.5, 0.03)), ball_restitution=0.0)
    certificate = proved(scene)
    assert keys(certificate)[0] == (0, 0, 1)
    assert len(certificate.events) == 3


def test_topspin_presses_balls_without_restitution():
    scene = scene_of(
        ball((0.0, 0.0), (0.5, 0.0), angular_velocity=(0.0, 300.0, 0.0)),
        ball((0.5, 0.0)),
        motion="sliding",
        ball_restitution=0.0,
    )
    certificate = certify(scene)
    assert certificate.ending == "sustained contact"
    assert keys(certificate) == [(0, 0, 1)]

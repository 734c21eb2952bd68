"""Bodies that overlap by rounding: a contact now, later, or never."""

from __future__ import annotations

import math

from proofs import keys, proved
from shots import R, ball, scene_of

from ghostball.model import Table
from ghostball.reference_adapters.certified import certify


def test_balls_that_overlap_by_a_rounding_touch():
    overlap = math.nextafter(2 * R, 0.0)
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((overlap, 0.0)))
    assert keys(proved(scene))[0] == (0, 0, 1)
    scene = scene_of(ball((0.0, 0.0), (-1.0, 0.0)), ball((overlap, 0.0)))
    assert keys(proved(scene)) == [(3, 0, -1)]


def rail(vx, **fields):
    """Return a ball that overlaps the left cushion by rounding."""
    place = (math.nextafter(R, 0.0), 0.5)
    return scene_of(
        ball(place, (vx, 0.0), **fields), table=Table(length=2.0, width=1.0), motion="sliding"
    )


def test_a_ball_that_begins_beyond_a_cushion_by_a_rounding():
    into = proved(rail(-0.5))
    assert keys(into)[0] == (1, 0, 0)
    assert float(into.events[0].t) == 0.0
    assert (1, 0, 0) not in keys(proved(rail(0.5)))
    # Backspin brings the ball back, which is a separate contact.
    back = proved(rail(0.3, angular_velocity=(0.0, -120.0, 0.0)))
    assert keys(back)[0] == (1, 0, 0)
    assert float(back.events[0].t) > 0.1
    certificate = certify(rail(0.0, angular_velocity=(0.0, -60.0, 0.0)))
    assert (certificate.ending, certificate.events) == ("sustained contact", ())


def test_overlapping_balls_that_come_back_meet_again():
    overlap = math.nextafter(2 * R, 0.0)
    scene = scene_of(
        ball((0.0, 0.0)),
        ball((overlap, 0.0), (0.3, 0.0), angular_velocity=(0.0, -120.0, 0.0)),
        motion="sliding",
    )
    certificate = proved(scene)
    assert keys(certificate)[0] == (0, 0, 1)
    assert float(certificate.events[0].t) > 0.1

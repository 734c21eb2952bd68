"""Gaps to obstacles: corners, ends of sides, posts, noses."""

from __future__ import annotations

import math

import pytest
from mpmath import mp, mpf
from proofs import ELL, flying, integrated_once, met, middle, proved
from shots import R, ball, scene_of

from ghostball.model import EventKind, Table
from ghostball.reference_adapters.certified import (
    CertifiedSettings,
    certify,
)


def test_a_ball_meets_a_corner_that_points_into_the_table_as_a_point():
    """A ball that hits a corner head-on returns on its path; the corner has the name of a side."""
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 1.0)),
        table=Table.model_validate({"vertices": ELL}),
        cushion="mirror",
        rolling_friction=0.0,
        t_max=0.6,
    )
    certificate = proved(scene)
    assert met(certificate) == ["ball-cushion side-3"]
    (event,) = certificate.events
    at_corner = 0.5 - scene.radii[0] / math.sqrt(2.0)
    assert float(event.t) == pytest.approx(at_corner, rel=1e-15)
    for part, velocity in enumerate((-1.0, -1.0)):
        assert float(certificate.velocities[0][part]) == pytest.approx(velocity, rel=1e-15)


def test_a_ball_that_passes_the_end_of_a_side_does_not_meet_its_line():
    scene = scene_of(
        ball((0.5, 1.5), (0.0, -1.0)),
        ball((1.5, 0.5), (-1.0, 0.0)),
        table=Table.model_validate({"vertices": ELL}),
        rolling_friction=0.0,
        t_max=0.7,
    )
    assert met(proved(scene)) == []


@pytest.mark.parametrize("slip", [0.0, -20.0])
@pytest.mark.parametrize("air", [0.0, 0.2])
def test_a_ball_bounces_off_a_post(slip: float, air: float):
    """A ball on the line of centres hits the same post twice, with a cushion contact between."""
    post = {"length": 2.0, "width": 1.0, "posts": [{"centre": (1.0, 0.5), "radius": 0.1}]}
    scene = scene_of(
        ball((0.5, 0.5), (4.0, 0.0), angular_velocity=(0.0, slip, 0.0)),
        table=Table.model_validate(post),
        motion="sliding",
        air_drag=air,
    )
    post_then_left = ["ball-cushion post-1", "ball-cushion left"]
    known = integrated_once(scene) if air > 0.0 else proved(scene)
    assert met(known)[:3] == [*post_then_left, "ball-cushion post-1"]


G = 9.81


CLOTH, LEAVES = EventKind.BALL_CLOTH, EventKind.LEAVES_TABLE


TABLE = Table(length=2.54, width=1.27)


NO_SPIN = {"angular_velocity": (0.0, 0.0, 0.0)}


def test_a_ball_in_flight_meets_a_nose_at_the_root_of_a_quartic() -> None:
    height = 0.036
    balls = ball((2.0, 0.6), (3.0, 0.2, 0.6), **NO_SPIN)
    scene = flying(balls, table=TABLE, cushion="mirror", cushion_height=height)
    certificate = certify(scene, CertifiedSettings(max_events=40), cached=False)
    event = next(e for e in certificate.events if e.kind is EventKind.BALL_CUSHION)
    before = [e for e in certificate.events if e.t.upper < event.t.lower]
    assert all(e.kind is CLOTH for e in before)
    assert len(before) == 1
    # The second parabola starts at the landing, with half of the upward velocity.
    with mp.workdps(40):
        t0 = 2 * mpf(0.6) / mpf(G)
        up = mpf(0.6) / 2
        mu = mpf(scene.physics.sliding_friction)
        slip = mp.sqrt(mpf(3) ** 2 + mpf(0.2) ** 2)
        part = 1 - mu * mpf(1.5) * mpf(0.6) / slip
        vx = 3 * part
        x0 = mpf(2) + 3 * t0
        away, above = mpf(2.54) - x0, mpf(R) - mpf(height)
        g = mpf(G)

        def gap(s: mpf) -> mpf:
            rise = above + up * s - g * s * s / 2
            return (away - vx * s) ** 2 + rise**2 - mpf(R) ** 2

        s = mp.findroot(gap, (away - mpf(R)) / vx)
        assert abs(middle(event.t) - (t0 + s)) < mpf(10) ** -30

"""The precision of a proof is raised until everything is proved, or until a limit."""

from __future__ import annotations

import pytest
from proofs import SHOTS, keys, overlap, proved, widest
from shots import POOL_TABLE, ball, scene_of

from ghostball.model import UnsupportedSceneError
from ghostball.reference_adapters.certified import (
    CertifiedSettings,
    certify,
)


def test_positions_are_as_narrow_as_asked():
    for width in (1e-12, 1e-30, 1e-80):
        assert widest(proved(SHOTS["rolling"], width=width)) <= width


def test_the_cap_returns_what_was_proved():
    whole = proved(SHOTS["break"])
    part = certify(SHOTS["break"], CertifiedSettings(start_precision=30, max_precision=30))
    assert part.ending == "precision cap"
    assert "`max_precision`" in part.reason
    assert keys(part) == keys(whole)[: len(part.events)]
    assert all(
        overlap(one.t, other.t) for one, other in zip(part.events, whole.events, strict=False)
    )


def test_positions_that_stay_too_wide_reach_the_cap():
    certificate = certify(SHOTS["rolling"], CertifiedSettings(width=1e-40, max_precision=106))
    assert certificate.ending == "precision cap"
    assert "positions to 1e-40 m" in certificate.reason
    assert len(certificate.events) == len(proved(SHOTS["rolling"]).events)


def test_the_event_limit_returns_what_was_proved():
    whole = proved(SHOTS["rolling"])
    part = certify(SHOTS["rolling"], CertifiedSettings(max_events=3))
    assert part.ending == "event limit"
    assert "`max_events`" in part.reason
    assert keys(part) == keys(whole)[:3]


def test_the_time_limit_returns_what_was_proved():
    certificate = certify(POOL, CertifiedSettings(time_limit=1e-9))
    assert certificate.ending == "time limit"
    assert "`time_limit`" in certificate.reason
    assert not certificate.proved


POOL = scene_of(
    ball((0.6, 0.6), (2.0, 0.1), angular_velocity=(0.0, 0.0, 20.0)),
    ball((1.2, 0.62)),
    table=POOL_TABLE,
    preset="pool",
)


@pytest.mark.parametrize(
    ("physics", "reason"),
    [
        ({"motion": "sliding", "ball_impact": "mathavan2014", "ball_friction": 0.05}, "Mathavan"),
        ({"motion": "sliding", "cushion": "mathavan2010"}, "Mathavan 2010"),
        ({"motion": "sliding", "cushion": "stronge2000"}, "Stronge 2000"),
        ({"motion": "sliding", "airborne": True, "air_drag": 0.004}, "airborne balls"),
    ],
)
def test_what_has_no_closed_form_is_refused(physics, reason):
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 0.0)), ball((1.0, 0.5)), table=POOL_TABLE, t_max=1.0, **physics
    )
    with pytest.raises(UnsupportedSceneError, match=reason):
        certify(scene)

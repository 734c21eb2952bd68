"""The next event: one event, several independent events, or an undecided order."""

from __future__ import annotations

from proofs import keys, overlap, proved
from shots import R, ball, scene_of

from ghostball.model import EventKind
from ghostball.reference_adapters.certified import (
    CertifiedSettings,
    Choice,
    certify,
)
from ghostball.reference_adapters.certified.candidates import Candidate
from ghostball.validation.scenes.library import find_scene

BALL_BALL = EventKind.BALL_BALL


def test_two_collisions_that_no_number_tells_apart_are_ambiguous():
    # By symmetry they are simultaneous, but the numbers alone don't show this.
    scene = scene_of(
        ball((-0.5, 0.0), (1.0, 0.0)),
        ball((0.5, 0.03), (-1.0, 0.0)),
        ball((0.5, -0.03), (-1.0, 0.0)),
    )
    certificate = certify(scene)
    assert certificate.ending == "ambiguous"
    assert certificate.events == ()
    assert set(certificate.choices) == {Choice(BALL_BALL, 0, 1), Choice(BALL_BALL, 0, 2)}
    for part in ('"b0" with "b1"', '"b0" with "b2"', "at t = 0.5002"):
        assert part in certificate.reason
    assert certificate.precision == CertifiedSettings().max_precision
    # Nothing is reported after this: the final state is the initial state.
    assert float(certificate.t_end) == 0.0
    assert [float(x) for x in certificate.positions[0]] == [-0.5, 0.0]


def test_a_frozen_rack_is_ambiguous_where_roundings_decide():
    certificate = certify(find_scene("frozen-break"))
    assert certificate.ending == "ambiguous"
    struck = [(BALL_BALL, 0, 1), (BALL_BALL, 1, 2), (BALL_BALL, 1, 3), (BALL_BALL, 0, 1)]
    assert [e.key for e in certificate.events] == struck
    assert len(certificate.choices) == 2


def graze(offset):
    return scene_of(
        ball((0.0, 0.0), (1.0, 0.0)), ball((1.0, offset)), rolling_friction=0.0, t_max=2.0
    )


def test_an_exact_graze_is_ambiguous():
    certificate = certify(graze(2 * R))
    assert certificate.ending == "ambiguous"
    assert certificate.choices == (Choice(BALL_BALL, 0, 1),)
    assert "whether they touch" in certificate.reason
    assert "at t = 1 s" in certificate.reason or "at t = 0.99999" in certificate.reason


def test_a_thinner_graze_than_doubles_can_say_is_reported():
    # The ball misses by 1e-40 m, 2^-133 of the radius, far below double precision. A ball that
    # starts at y = 2 R minus a slope does this.
    slope = 2.0**-70
    scene = scene_of(
        ball((0.0, 0.0), (1.0, slope)), ball((1.0, 2 * R)), rolling_friction=0.0, t_max=2.0
    )
    assert keys(proved(scene)) == [(0, 0, 1)]
    scene = scene_of(
        ball((0.0, 0.0), (1.0, -slope)), ball((1.0, 2 * R)), rolling_friction=0.0, t_max=2.0
    )
    assert proved(scene).events == ()


def test_independent_events_of_one_instant_pass_as_a_tie():
    # After the impact of a rolling ball on a resting ball, both slide equally long.
    certificate = proved(find_scene("half-ball-rolling"))
    tied = [e for e in certificate.events if e.tie]
    assert [e.kind for e in tied] == [EventKind.SLIDE_TO_ROLL]
    following = certificate.events[certificate.events.index(tied[0]) + 1]
    assert following.kind is EventKind.SLIDE_TO_ROLL
    assert following.a != tied[0].a
    assert overlap(tied[0].t, following.t)


def test_mirrored_pairs_are_proved_with_the_same_enclosures():
    scene = scene_of(
        ball((0.0, 0.5), (1.0, 0.0)),
        ball((0.5, 0.51)),
        ball((0.0, -0.5), (1.0, 0.0)),
        ball((0.5, -0.51)),
    )
    certificate = proved(scene)
    upper = [e.t for e in certificate.events if e.a < 2]
    lower = [e.t for e in certificate.events if e.a >= 2]
    assert len(upper) == len(lower) == 3
    for one, other in zip(upper, lower, strict=True):
        assert overlap(one, other)


def test_a_tie_near_a_third_ball_is_ambiguous():
    # Both collisions are simultaneous, and the two balls that are hit touch each other.
    scene = scene_of(
        ball((-0.5, 0.0), (1.0, 0.0), radius=0.03125),
        ball((0.0, 0.0), radius=0.03125),
        ball((0.0625, 0.0), radius=0.03125),
        ball((0.5625, 0.0), (-1.0, 0.0), radius=0.03125),
    )
    certificate = certify(scene)
    assert certificate.ending == "ambiguous"
    assert "whether the order matters" in certificate.reason


def test_searched_candidates_per_event_do_not_grow_with_the_shot(monkeypatch):
    """Count the searches: searching all earlier candidates once took hours for 31 415 events."""
    looks, whole = [], Candidate.is_void
    monkeypatch.setattr(
        Candidate, "is_void", lambda one, bodies: looks.append(1) or whole(one, bodies)
    )
    proof = certify(find_scene("galperin-2"), cached=False)
    assert len(proof.events) == 314
    assert len(looks) < 20 * 4 * len(proof.events)  # at most four precisions are tried

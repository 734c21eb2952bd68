"""What is proved: closed forms, the oracle and our engine agree; what can't be decided is named."""

from __future__ import annotations

import math
from fractions import Fraction
from types import SimpleNamespace

import pytest
from flint import arb
from mpmath import mpf, workdps
from oracle import solve
from shots import POOL_TABLE, R, ball, random_break, random_cloth_shot, random_shot, scene_of

from ghostball.engine import simulate
from ghostball.model import COLLISION_KINDS, CUSHIONS, EventKind, Table, UnsupportedSceneError
from ghostball.reference_adapters.certified import (
    Certificate,
    CertifiedSettings,
    Choice,
    Enclosure,
    certify,
    gaps as gaps_module,
)
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.reference_adapters.certified.run import TIE_BITS, Run
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.closed_forms import FORMS, closed_form

BALL_BALL, BALL_CUSHION = EventKind.BALL_BALL, EventKind.BALL_CUSHION

NO_FORM_TO_COMPARE = {
    # Without an answer in exact numbers, or with laws that have no closed form.
    "mathavan-cut",
    "corner-exact",
    "three-ball-symmetric",
    "frozen-triangle",
    "push",
    "push-line",
    "wedged",
    # In the air with drag: refused by name.
    "air-drop",
}
SLOW_FORMS = {"galperin-3", "galperin-4"}
BY_HAND = {"cradle", "frozen-to-cushion", "stun-shot"}
"""Forms that take gaps and slips of a rounding for 0."""

FAST_FORMS = sorted(set(FORMS) - NO_FORM_TO_COMPARE - SLOW_FORMS)


def mp_of(value: Fraction) -> mpf:
    return mpf(value.numerator) / value.denominator


def holds(enclosure: Enclosure, value: mpf, room: mpf) -> bool:
    return abs(mp_of(enclosure.mid) - value) <= mp_of(enclosure.rad) + room


def proved(scene, **settings) -> Certificate:
    certificate = certify(scene, CertifiedSettings(**settings))
    assert certificate.proved, certificate.reason
    return certificate


def collisions(certificate: Certificate) -> list[tuple[str, int, int | str]]:
    return [
        (e.kind.label, e.a, CUSHIONS[e.b] if e.kind is BALL_CUSHION else e.b)
        for e in certificate.events
        if e.kind in COLLISION_KINDS
    ]


def keys(certificate: Certificate) -> list[tuple[int, int, int]]:
    return [(int(e.kind), e.a, e.b) for e in certificate.events]


def engine_keys(scene) -> list[tuple[int, int, int]]:
    events = simulate(scene, record="events").events
    assert events is not None
    return [(int(e["kind"]), int(e["a"]), int(e["b"])) for e in events]


# -- closed forms --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FAST_FORMS)
def test_closed_forms_lie_within_the_enclosures(name):
    check_form(name)


def check_form(name):
    scene = find_scene(name)
    form = closed_form(scene)
    assert form is not None
    certificate = proved(scene, width=1e-45)
    with workdps(60):
        # 50 digits, less what the shot amplifies their rounding by; roundings of the scene's own
        # numbers where the form takes them for 0.
        room = mpf(10) ** -15 if name in BY_HAND else mpf(10) ** -38
        for position, expected in zip(certificate.positions, form.rest_positions, strict=True):
            # Without the height, which a form has not, and which is exactly the radius.
            for enclosure, value in zip(position[:2], expected, strict=True):
                assert holds(enclosure, value, room)
                assert enclosure.width <= 1e-45
        assert holds(certificate.t_end, form.rest_time, room)
    assert tuple(collisions(certificate)) == form.event_sequence


# -- enclosures ----------------------------------------------------------------------------------


SHOTS = {
    "rolling": random_shot(7, 5),
    "unequal": random_shot(6, 4, ball_restitution=0.9),
    "sliding": random_cloth_shot(3),
    "break": random_break(5, n=7),
    "gas": random_shot(11, 4, rolling_friction=0.0, t_max=3.0),
}


def encloses(enclosure: Enclosure, narrower: Enclosure) -> bool:
    return enclosure.lower <= narrower.lower and narrower.upper <= enclosure.upper


def widest(certificate: Certificate) -> float:
    """Width of the widest enclosure of a position at the end [m]."""
    return max(one.width for position in certificate.positions for one in position)


@pytest.mark.parametrize("name", SHOTS)
def test_a_higher_precision_lies_within_a_lower_one(name):
    scene = SHOTS[name]
    coarse, fine = (
        proved(scene, start_precision=bits, max_precision=bits, width=1.0) for bits in (212, 424)
    )
    assert keys(coarse) == keys(fine)
    for one, other in zip(coarse.events, fine.events, strict=True):
        assert encloses(one.t, other.t)
    for one, other in zip(coarse.positions, fine.positions, strict=True):
        for enclosure, narrower in zip(one, other, strict=True):
            assert encloses(enclosure, narrower)
    for one, other in zip(coarse.spins, fine.spins, strict=True):
        for enclosure, narrower in zip(one, other, strict=True):
            assert encloses(enclosure, narrower)
    assert encloses(coarse.t_end, fine.t_end)


def test_positions_are_as_narrow_as_asked():
    for width in (1e-12, 1e-30, 1e-80):
        assert widest(proved(SHOTS["rolling"], width=width)) <= width


@pytest.mark.parametrize("name", SHOTS)
def test_a_search_in_doubles_changes_nothing(name, monkeypatch):
    fast = proved(SHOTS[name])
    # With a margin that nothing passes every gap is searched in balls.
    monkeypatch.setattr(gaps_module, "DOUBLES_ERROR", math.inf)
    thorough = certify(SHOTS[name], cached=False)
    assert keys(fast) == keys(thorough)
    assert all(
        one.t.lower <= other.t.upper and other.t.lower <= one.t.upper
        for one, other in zip(fast.events, thorough.events, strict=True)
    )


@pytest.mark.parametrize("seed", [*range(8), 130, 219])
def test_random_shots_on_the_cloth_agree_with_the_oracle(seed):
    check_against_the_oracle(random_cloth_shot(seed))


@pytest.mark.parametrize("seed", range(8))
def test_a_restitution_that_falls_with_speed_agrees_with_the_oracle(seed):
    scene = random_cloth_shot(seed)
    law = {"cushion_restitution_loss": 0.15}
    if scene.physics.cushion == "mirror":
        law |= {"cushion": "restitution", "cushion_restitution": 0.95}
    physics = scene.physics.model_copy(update=law)
    check_against_the_oracle(scene.model_copy(update={"physics": physics}))


def check_against_the_oracle(scene):
    certificate = certify(scene, CertifiedSettings(width=1e-40))
    if certificate.ending == "sustained contact":
        pytest.skip("the oracle has no sustained contact")
    assert certificate.proved, certificate.reason
    truth = solve(scene)
    # Independent events of one instant have no order: the oracle takes them by their indices.
    mine, theirs = sorted(keys(certificate)), sorted(tuple(map(int, e.key)) for e in truth.events)
    assert mine == theirs
    if not any(event.tie for event in certificate.events):
        assert keys(certificate) == [tuple(map(int, e.key)) for e in truth.events]
    with workdps(60):
        for position, exact in zip(certificate.positions, truth.positions, strict=True):
            for enclosure, value in zip(position, exact[:2], strict=True):
                assert holds(enclosure, value, mpf(10) ** -25)
        for spin, exact in zip(certificate.spins, truth.spins, strict=True):
            for enclosure, value in zip(spin, exact, strict=True):
                assert holds(enclosure, value, mpf(10) ** -22)


# -- our engine ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["head-on", "half-ball-rolling", "corner-double-bounce", "throw-alciatore", "masse"]
)
def test_our_engine_finds_the_proved_events(name):
    scene = find_scene(name)
    certificate = proved(scene)
    assert keys(certificate) == engine_keys(scene)
    result = simulate(scene)
    for position, found in zip(certificate.positions, result.rest_positions, strict=True):
        for enclosure, x in zip(position, found, strict=False):
            assert abs(float(enclosure.mid - Fraction(float(x)))) < 1e-14


# -- what can't be decided -------------------------------------------------------------------------


def test_two_collisions_at_one_instant_are_ambiguous():
    certificate = certify(find_scene("three-ball-symmetric"))
    assert certificate.ending == "ambiguous"
    assert certificate.events == ()
    assert set(certificate.choices) == {Choice(BALL_BALL, 0, 1), Choice(BALL_BALL, 0, 2)}
    for part in ('"cue" with "left"', '"cue" with "right"', "at t = 1.06"):
        assert part in certificate.reason
    assert certificate.precision == CertifiedSettings().max_precision
    # Nothing is reported beyond: the state is that at the start.
    assert float(certificate.t_end) == 0.0
    assert [float(x) for x in certificate.positions[0]] == [-0.5, 0.0]


def test_a_corner_is_ambiguous():
    certificate = certify(find_scene("corner-exact"))
    assert certificate.ending == "ambiguous"
    assert set(certificate.choices) == {Choice(BALL_CUSHION, 0, 0), Choice(BALL_CUSHION, 0, 2)}


def test_a_frozen_rack_is_ambiguous_from_its_first_collision():
    certificate = certify(find_scene("frozen-break"))
    assert certificate.ending == "ambiguous"
    assert [e.key for e in certificate.events] == [(BALL_BALL, 0, 1)]
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
    # 1e-40 m too far: the miss is decided by 2^-133 of the radius, beyond double precision. A ball
    # that starts with a y of 2 R less a slope does that.
    slope = 2.0**-70
    scene = scene_of(
        ball((0.0, 0.0), (1.0, slope)), ball((1.0, 2 * R)), rolling_friction=0.0, t_max=2.0
    )
    assert keys(proved(scene)) == [(0, 0, 1)]
    scene = scene_of(
        ball((0.0, 0.0), (1.0, -slope)), ball((1.0, 2 * R)), rolling_friction=0.0, t_max=2.0
    )
    assert proved(scene).events == ()


def test_an_event_at_t_max_is_still_one():
    # From 1/2 m to where the ball of 1/4 m touches the line x = 0, at 1 m/s: exactly 1/4 s.
    scene = scene_of(
        ball((0.5, 0.5), (-1.0, 0.0), radius=0.25),
        table=Table(length=4.0, width=4.0),
        rolling_friction=0.0,
        t_max=0.25,
    )
    assert keys(proved(scene)) == [(1, 0, 0)] == engine_keys(scene)


def test_an_end_near_t_max_is_distinguished_from_it():
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.5, gravity=2.0, t_max=1.0)
    assert keys(proved(scene)) == [(3, 0, -1)]
    scene = scene_of(
        ball((0.0, 0.0), (0.6, 0.8)), rolling_friction=0.5, gravity=2.0, t_max=math.hypot(0.6, 0.8)
    )
    assert certify(scene).proved  # off by a rounding, which is resolved


def test_independent_events_of_one_instant_pass_as_a_tie():
    # A rolling cue ball and a resting one slide equally long after their impact.
    certificate = proved(find_scene("half-ball-rolling"))
    tied = [e for e in certificate.events if e.tie]
    assert [e.kind for e in tied] == [EventKind.SLIDE_TO_ROLL]
    following = certificate.events[certificate.events.index(tied[0]) + 1]
    assert following.kind is EventKind.SLIDE_TO_ROLL
    assert following.a != tied[0].a
    assert tied[0].t.lower <= following.t.upper
    assert following.t.lower <= tied[0].t.upper


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
        assert one.lower <= other.upper
        assert other.lower <= one.upper


def test_a_tie_near_a_third_ball_is_ambiguous():
    # Both collisions come at one instant, and the two balls that are hit touch each other.
    scene = scene_of(
        ball((-0.5, 0.0), (1.0, 0.0), radius=0.03125),
        ball((0.0, 0.0), radius=0.03125),
        ball((0.0625, 0.0), radius=0.03125),
        ball((0.5625, 0.0), (-1.0, 0.0), radius=0.03125),
    )
    certificate = certify(scene)
    assert certificate.ending == "ambiguous"
    assert "whether the order matters" in certificate.reason


def test_balls_that_overlap_by_a_rounding_touch():
    overlap = math.nextafter(2 * R, 0.0)
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((overlap, 0.0)))
    assert keys(proved(scene))[0] == (0, 0, 1)
    scene = scene_of(ball((0.0, 0.0), (-1.0, 0.0)), ball((overlap, 0.0)))
    assert keys(proved(scene)) == [(3, 0, -1)]


def rail(vx, **fields):
    """Return a ball that is beyond the left cushion by a rounding."""
    place = (math.nextafter(R, 0.0), 0.5)
    return scene_of(
        ball(place, (vx, 0.0), **fields), table=Table(length=2.0, width=1.0), motion="sliding"
    )


def test_a_ball_that_begins_beyond_a_cushion_by_a_rounding():
    into = proved(rail(-0.5))
    assert keys(into)[0] == (1, 0, 0)
    assert float(into.events[0].t) == 0.0
    assert (1, 0, 0) not in keys(proved(rail(0.5)))
    # Backspin brings it back: that is a meeting of its own.
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


def test_a_ball_spins_on_the_spot_where_the_cloth_does_not_rub():
    scene = scene_of(
        ball((0.0, 0.0), angular_velocity=(0.0, 10.0, 0.0)),
        ball((1.0, 0.0), angular_velocity=(0.0, 0.0, 5.0)),
        motion="sliding",
        sliding_friction=0.0,
        t_max=3.0,
    )
    certificate = proved(scene)
    assert certificate.rested
    assert certificate.events == ()
    assert float(certificate.spins[0][1]) == 10.0
    assert simulate(scene).status.complete


def test_a_ball_on_a_cushion_bounces_or_rolls_along_it():
    assert keys(proved(find_scene("rail-into")))[0] == (1, 0, 2)
    assert keys(proved(find_scene("rail-along"))) == [(3, 0, -1)]


# -- sustained contact ---------------------------------------------------------------------------


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


# -- limits --------------------------------------------------------------------------------------


def test_the_cap_returns_what_was_proved():
    whole = proved(SHOTS["break"])
    part = certify(SHOTS["break"], CertifiedSettings(start_precision=30, max_precision=30))
    assert part.ending == "precision cap"
    assert "`max_precision`" in part.reason
    assert keys(part) == keys(whole)[: len(part.events)]
    assert all(
        one.t.lower <= other.t.upper and other.t.lower <= one.t.upper
        for one, other in zip(part.events, whole.events, strict=False)
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


def test_the_end_waits_for_the_last_spin():
    certificate = proved(scene_of(ball((0.0, 0.0), angular_velocity=(0, 0, 20)), motion="sliding"))
    assert certificate.events == ()
    assert certificate.rested
    assert float(certificate.t_end) == 2.0
    assert float(certificate.spins[0][2]) == 0.0


@pytest.mark.parametrize(
    ("physics", "reason"),
    [
        ({"motion": "sliding", "ball_impact": "mathavan2014", "ball_friction": 0.05}, "Mathavan"),
        ({"motion": "sliding", "cushion": "mathavan2010"}, "Mathavan 2010"),
        ({"motion": "sliding", "airborne": True, "air_drag": 0.004}, "leave the cloth"),
    ],
)
def test_what_has_no_closed_form_is_refused(physics, reason):
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 0.0)), ball((1.0, 0.5)), table=POOL_TABLE, t_max=1.0, **physics
    )
    with pytest.raises(UnsupportedSceneError, match=reason):
        certify(scene)


@pytest.mark.parametrize(("speed", "separate"), [(1.0, True), (1e28, True), (1e32, False)])
def test_a_tie_passes_only_where_no_ball_is_fast_enough_to_reach_it(speed, separate):
    """Breaks where balls are taken to be slower than scenes may have them: here 1 m is left."""
    scene = scene_of(ball((0.0, 0.0)), ball((1.0, 0.0), (0.0, speed)), t_max=1.0)
    one = SimpleNamespace(balls=(0,))
    assert Run(problem_of(scene), 200)._isolated(one, arb(0), 2.0**-TIE_BITS) is separate

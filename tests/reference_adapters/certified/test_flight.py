"""Certified flight: worked examples and series, Ghostball's engine on random jumps, open cases."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from flint import arb
from mpmath import mp, mpf
from proofs import after, flying, jump, keys, middle, proved
from shots import R, ball

from ghostball.engine import simulate
from ghostball.model import EventKind, Table
from ghostball.reference_adapters.certified import (
    Certificate,
    CertifiedSettings,
    certify,
)
from ghostball.reference_adapters.certified.arithmetic import UndecidedError, working_precision
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.reference_adapters.certified.flight import (
    LOWEST_BOUNCE,
    BouncingBody,
    FlightState,
    FlyingBody,
    answered_by_table,
)
from ghostball.reference_adapters.certified.motion import Body, constants_of
from ghostball.reference_adapters.certified.problem import problem_of

G = 9.81
CLOTH, LEAVES = EventKind.BALL_CLOTH, EventKind.LEAVES_TABLE
TABLE = Table(length=2.54, width=1.27)


def constants(**physics):
    scene = flying(ball((0.0, 0.0), (1.0, 0.0)), **physics)
    return constants_of(problem_of(scene).balls[0], problem_of(scene))


def state(velocity, spin, up, radius=R) -> FlightState:
    (vx, vy), (wx, wy, wz) = velocity, spin
    slip = (arb(vx) - arb(radius) * wy, arb(vy) + arb(radius) * wx)
    zero = arb(0)
    return FlightState((zero, zero), zero, (arb(vx), arb(vy)), arb(up), slip, arb(wz))


def spin_of(body: Body) -> tuple[float, float, float]:
    """Return the angular velocity, from u = (vx - R wy, vy + R wx)."""
    radius = body.constants.radius
    wx, wy = (body.uy - body.vy) / radius, (body.vx - body.ux) / radius
    return float(wx), float(wy), float(body.wz)


# -- one ball and the table ----------------------------------------------------------------------


def test_a_dropped_ball_lands_and_bounces_as_a_geometric_series_says() -> None:
    height, e = 0.125, 0.75
    scene = flying(ball((0.5, 0.0, R + height)), table_restitution=e)
    certificate = proved(scene, width=1e-40)
    assert all(event.kind is CLOTH for event in certificate.events)
    with mp.workdps(60):
        g, rise = mpf(G), mpf(R + height) - mpf(R)
        fall = mp.sqrt(2 * rise / g)
        landings = [fall * (1 + 2 * sum(mpf(e) ** k for k in range(1, n + 1))) for n in range(80)]
        *bounces, end = certificate.events
        for event, expected in zip(bounces, landings, strict=False):
            assert abs(middle(event.t) - expected) < mpf(10) ** -38
        assert abs(middle(end.t) - fall * (1 + mpf(e)) / (1 - mpf(e))) < mpf(10) ** -38
        # The last separate bounce is the last one higher than the lowest bounce: e^2n h.
        heights = [mpf(e) ** (2 * n) * rise for n in range(len(bounces) + 1)]
        assert heights[-2] > LOWEST_BOUNCE * 2 * R >= heights[-1]
    assert [float(x) for x in certificate.positions[0]] == [0.5, 0.0, R]


def test_a_thrown_ball_lands_where_its_parabola_does() -> None:
    scene = flying(ball((0.1, -0.2, 0.3), (1.5, 0.25, 2.0), angular_velocity=(5.0, 50.0, 7.0)))
    certificate = after(scene, 1)
    with mp.workdps(40):
        g, rise = mpf(G), mpf(0.3) - mpf(R)
        t = (2 + mp.sqrt(4 + 2 * g * rise)) / g
        assert abs(middle(certificate.t_end) - t) < mpf(10) ** -30
        x, y, z = (middle(e) for e in certificate.positions[0])
        assert abs(x - (mpf(0.1) + mpf(1.5) * t)) < mpf(10) ** -30
        assert abs(y - (mpf(-0.2) + mpf(0.25) * t)) < mpf(10) ** -30
        assert z == mpf(R)
        # In the air, nothing slows the vertical spin.
        assert middle(certificate.spins[0][2]) == 7


@pytest.mark.parametrize(
    ("before", "velocity", "up", "spin"),
    [
        # Worked example for mu 0.2 and e 0.5: the ball slips, sticks, slips.
        (((2, 0), (0, 0, 0), -1), (1.7, 0), 0.5, (0, 26.246719160104987, 0)),
        (((0.5, 0), (0, 0, 40), -2), (0.35714285714285714, 0), 1, (0, 12.498437695288089, 40)),
        (
            ((1, 0.5), (20, -30, 10), -1),
            (0.74014490651493903, 0.35008225458648925),
            0.5,
            (6.88383679671822, -7.2655211299159254, 10),
        ),
    ],
)
def test_the_table_returns_half_of_the_speed_and_rubs(before, velocity, up, spin) -> None:
    with working_precision(106):
        body = answered_by_table(constants(sliding_friction=0.2), state(*before), arb(0), 1)
        assert isinstance(body, FlyingBody)
        assert (float(body.vx), float(body.vy)) == pytest.approx(velocity, rel=1e-15, abs=1e-15)
        assert float(body.up) == pytest.approx(up, rel=1e-15)
        assert spin_of(body) == pytest.approx(spin, rel=1e-14, abs=1e-14)


@pytest.mark.parametrize("slip", [1e-3, 1e-4, 3e-5, 1e-6])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.9])
def test_bounces_that_are_not_followed_come_to_what_each_of_them_does(e, slip) -> None:
    """Some balls slip in all bounces, some stick in one bounce."""
    up, mu = 1.5e-4, 0.2
    with working_precision(212), mp.workdps(60):
        start = state((0.5, slip), (0, 0.5 / R, 3.0), up)
        given = constants(sliding_friction=mu, table_restitution=e)
        body = answered_by_table(given, start, arb(0), 1)
        assert isinstance(body, BouncingBody)
        assert body.end_kind is CLOTH
        assert body.duration is not None
        ended = body.after_phase(body.duration, 2)
        # Impact by impact until the end; the slip is along y except for rounding.
        ux, uy = (mpf(str(u.mid().str(60, radius=False))) for u in start.slip)
        size = mp.sqrt(ux * ux + uy * uy)
        left, displacement, lasts, speed = size, mpf(0), mpf(0), mpf(up)
        taken = mpf(0)
        while speed > mpf(10) ** -55:
            duration = 2 * speed / mpf(G)
            displacement -= taken * duration
            lasts += duration
            impulse = min(mpf(mu) * (1 + mpf(e)) * speed, 2 * left / 7)
            taken += impulse
            left -= 7 * impulse / 2
            speed *= mpf(e)
            if e == 0.0:
                break
        assert abs(mpf(float(body.duration)) - lasts) < 1e-18
        assert float(ended.vy) == pytest.approx(slip - float(taken * uy / size), abs=1e-17)
        expected = float(mpf(slip) * lasts + displacement * uy / size)
        assert float(ended.y) == pytest.approx(expected, abs=1e-20)
        assert float(ended.uy) == pytest.approx(float(left * uy / size), abs=1e-16)
        assert (left == 0 or left < mpf(10) ** -40) == (ended.uy.is_zero() and ended.ux.is_zero())


@pytest.mark.parametrize(
    ("rise", "up", "what"),
    [(arb(0, 1e-9), 1.0, "on the table"), (arb(0), arb(0, 1e-9), "pushed onto the table")],
)
def test_an_undecided_reaction_of_the_table_is_an_error(rise, up, what) -> None:
    with working_precision(53):
        doubtful = state((1, 0), (0, 0, 0), 0)._replace(rise=rise, up=arb(up))
        with pytest.raises(UndecidedError, match=what):
            answered_by_table(constants(), doubtful, arb(0), 1)


# -- noses ---------------------------------------------------------------------------------------


def test_a_ball_that_flies_over_a_cushion_leaves_the_table_there() -> None:
    scene = flying(ball((2.25, 0.6), (3.0, 0.0, 1.5)), table=TABLE, cushion_height=0.036)
    certificate = proved(scene)
    assert keys(certificate) == [(int(LEAVES), 0, 1)]
    with mp.workdps(40):
        t = (mpf(2.54) - mpf(2.25)) / 3
        assert abs(middle(certificate.t_end) - t) < mpf(10) ** -28
        z = mpf(R) + mpf(1.5) * t - mpf(G) * t * t / 2
        assert abs(middle(certificate.positions[0][2]) - z) < mpf(10) ** -28
    assert all(float(v) == 0.0 for v in certificate.velocities[0])


# -- our engine ----------------------------------------------------------------------------------


def check_against_the_engine(number: int, **having: str) -> Certificate:
    scene = jump(number, **having)
    certificate = certify(scene, CertifiedSettings(time_limit=60.0), motion=True, cached=False)
    result = simulate(scene, record="trajectory")
    assert result.events is not None
    known = certificate.events_proved
    found = result.events[:known]
    assert keys(certificate) == [tuple(row) for row in found[["kind", "a", "b"]].tolist()]
    t = np.array([float(e.t) for e in certificate.events])
    # If friction pushes a ball to a cushion, its bounces amplify rounding by a thousand or more.
    assert found["t"] == pytest.approx(t, rel=1e-5, abs=1e-11)
    if certificate.proved:
        proof = result_of(scene, certificate, CertifiedSettings(), "trajectory")
        times = np.linspace(0.0, min(0.6, proof.rest_time), 50)
        for mine, theirs in zip(proof.sample(times), result.sample(times), strict=True):
            assert mine == pytest.approx(theirs, rel=1e-5, abs=1e-6)
        assert proof.rest_positions == pytest.approx(result.rest_positions, abs=1e-7)
    return certificate


@pytest.mark.parametrize("number", range(6, 12))  # 5 has two simultaneous landings
def test_random_jumps_agree_with_our_engine(number) -> None:
    check_against_the_engine(number)


@pytest.mark.parametrize("number", range(2))
def test_random_jumps_off_cushions_whose_restitution_falls_agree_with_our_engine(number) -> None:
    check_against_the_engine(number, cushion="falling", table="small")


# -- what isn't decided ----------------------------------------------------------------------------


def test_a_ball_that_comes_to_lie_on_another_is_named() -> None:
    scene = flying(ball((0.0, 0.0)), ball((0.0, 0.0, 3 * R + 0.1)))
    certificate = certify(scene, cached=False)
    assert certificate.ending == "sustained contact"
    assert "an airborne ball rests on a ball" in certificate.reason
    assert '"b0" with "b1"' in certificate.reason
    assert certificate.events_proved > 0


def test_two_balls_that_meet_a_third_at_one_instant_are_ambiguous() -> None:
    scene = flying(
        ball((-0.25, 0.0, 0.2), (1.0, 0.0, 1.0)),
        ball((0.25, 0.0, 0.2), (-1.0, 0.0, 1.0)),
        ball((0.0, 0.2, 0.2), (0.0, 0.0, 1.0)),
        ball((0.0, -0.2, 0.2), (0.0, 0.0, 1.0)),
    )
    certificate = certify(scene, cached=False)
    assert keys(certificate)[0] == (int(EventKind.BALL_BALL), 0, 1)
    fall = flying(
        ball((-0.03, 0.0, 0.2)), ball((0.03, 0.0, 0.2)), ball((0.0, 0.0)), ball_restitution=1.0
    )
    certificate = certify(fall, cached=False)
    assert certificate.ending == "ambiguous"
    assert "what comes first" in certificate.reason
    assert certificate.events_proved == 0


def test_bounces_that_lose_nothing_end_with_the_time_given() -> None:
    scene = flying(ball((0.0, 0.0, 0.2)), table_restitution=1.0, t_max=3.0)
    certificate = proved(scene)
    times = [float(e.t) for e in certificate.events]
    first = math.sqrt(2.0 * (0.2 - R) / G)
    assert np.diff(times) == pytest.approx(2.0 * first, rel=1e-12)
    assert all(before < after for before, after in pairwise(times))

"""The ball-ball impact on the cloth: published shots, the cloth's part, a naive oracle."""

from __future__ import annotations

import math

import pytest
from ball_impacts import (
    EPS,
    SNOOKER_BALL,
    Motion,
    after,
    energy,
    frictions,
    gained,
    impact_of,
    impacts,
    laws,
    restitutions,
    shot,
)
from hypothesis import given
from kernels import entry_to
from published_steps import stepped
from shots import R

from ghostball.engine.impacts.laws.ball_frictional import frictional
from ghostball.engine.impacts.laws.ball_mathavan2014 import mathavan2014
from ghostball.engine.impacts.laws.friction_curve import alciatore_friction
from ghostball.engine.impacts.laws.interface import BallImpact

frictional, mathavan2014, alciatore_friction = map(
    entry_to, (frictional, mathavan2014, alciatore_friction)
)

# --- the cloth's part ---------------------------------------------------------------------------


@pytest.mark.parametrize(("v", "cut"), [(1.539, 33.83), (1.032, 26.36), (1.731, 46.5)])
def test_the_published_steps_lead_here_as_they_get_smaller(v: float, cut: float):
    """The paper's algorithm at shots of its tables; fails if the lifted ball can't rise."""
    radius, cut = SNOOKER_BALL[0], math.radians(cut)
    i = impact_of(
        shot(cut, v, 1.0, radius=radius),
        ball_a=SNOOKER_BALL,
        ball_b=SNOOKER_BALL,
    )
    balls = [m.rolling(radius) for m in after(i, mathavan2014(i, laws(0.89, 0.05)))]
    coarse, fine = (
        stepped(
            *(v, cut),
            steps=steps,
            lands=True,
            restitution=0.89,
            ball_friction=0.05,
            cloth_friction=SNOOKER_BALL[2],
        )
        for steps in (1000, 2000)
    )
    for velocity, once, twice in zip(balls, coarse, fine, strict=True):
        limit = [2.0 * b - a for a, b in zip(once, twice, strict=True)]
        assert velocity == pytest.approx(limit, abs=1e-7)


def test_follow_presses_the_object_ball_and_draw_the_cue_ball():
    """The cloth then rubs against the pressed ball's own slip, and leaves the other alone."""
    follow = mathavan2014(impact_of(shot(0.0, 1.0, 1.0)), laws(0.95, 0.06))
    assert follow.up < 0.0
    assert follow.b_cloth_n < 0.0  # it slips forward as soon as it is hit
    assert (follow.a_cloth_n, follow.a_cloth_t) == (0.0, 0.0)
    draw = mathavan2014(impact_of(shot(0.0, 1.0, -1.0)), laws(0.95, 0.06))
    assert draw.up > 0.0
    assert draw.a_cloth_n < 0.0
    assert (draw.b_cloth_n, draw.b_cloth_t) == (0.0, 0.0)


def test_the_cloth_does_not_take_part_without_vertical_slip():
    i = impact_of((1.0, 0.4, 5.0, 0.0, 3.0), (0.0, 0.2, -3.0, 0.0, 1.0))
    assert mathavan2014(i, laws(0.9, 0.06)) == frictional(i, laws(0.9, 0.06))


def test_without_the_cloth_s_friction_the_normal_impulse_is_that_of_restitution():
    smooth = (R, 0.17, 0.0)
    i = impact_of(shot(0.4, 1.0, 1.0), ball_a=smooth, ball_b=smooth)
    for e in (0.0, 0.5, 1.0):
        p = mathavan2014(i, laws(e, 0.06))
        assert p.normal == pytest.approx((1.0 + e) * i.a_vn, rel=4.0 * EPS)
        assert p[3:] == pytest.approx((0.0, 0.0, 0.0, 0.0), abs=2.0 * EPS)


def test_a_speed_dependent_coefficient_is_that_of_the_slip_before():
    i = impact_of(shot(0.4, 1.0, 1.0))
    slip = math.hypot(i.a_vt, R * i.a_wt)
    constant = mathavan2014(i, laws(0.95, alciatore_friction(slip)))
    assert mathavan2014(i, laws(0.95, "alciatore")) == pytest.approx(constant, rel=1e-12)


@pytest.mark.parametrize("approach", [10.0**-k for k in range(18)])
def test_however_slow_the_approach_beside_the_spin(approach):
    """Slips a billion times the approach are known to their rounding, no better."""
    i = impact_of((approach, 0.3, -4.0, 7.0, 131.0), (0.0, 0.3, -4.0, 6.0, 0.0))
    p = mathavan2014(i, laws(0.4, 0.06))
    assert 1.3 * approach <= p.normal <= 1.5 * approach
    assert math.hypot(p.along, p.up) <= 0.06 * p.normal + 1e-14
    assert gained(i, p) <= 8.0 * EPS * energy(i, i[:5], i[8:13])


# --- a naive oracle -----------------------------------------------------------------------------


def naive(i: BallImpact, e: float, mu: float) -> list[float]:
    """Integrate the equations in all twelve speeds, by small steps (Runge-Kutta) of the impulse.

    The vertical speeds of a and b come last; the cloth lets them only rise. The steps shrink
    towards the ends of slips, where the equations are singular.
    """
    to_a, to_b = i.b_mass / (i.a_mass + i.b_mass), i.a_mass / (i.a_mass + i.b_mass)
    approach = i.a_vn - i.b_vn

    def slips(s):
        a, b = Motion(*s[:5]), Motion(*s[5:10])
        along = a.vt - b.vt + i.a_radius * a.wz + i.b_radius * b.wz
        up = s[10] - s[11] - (i.a_radius * a.wt + i.b_radius * b.wt)
        cloth_a = (a.vn - i.a_radius * a.wt, a.vt + i.a_radius * a.wn)
        cloth_b = (b.vn - i.b_radius * b.wt, b.vt + i.b_radius * b.wn)
        return along, up, cloth_a, cloth_b

    def rub(limit, slip, push):
        if math.hypot(*slip) < 1e-13 * approach:
            slip = push
        return tuple(-limit * x / math.hypot(*slip) for x in slip)

    def rates(s, stuck):
        along, up, cloth_a, cloth_b = slips(s)
        ft = fz = 0.0
        ca = cb = (0.0, 0.0)
        if not stuck:
            ft, fz = (mu * x / math.hypot(along, up) for x in (along, up))
            if fz < 0.0:
                cb = rub(-i.b_cloth * to_b * fz, cloth_b, (1.0 - 2.5 * fz, ft))
            if fz > 0.0:
                ca = rub(i.a_cloth * to_a * fz, cloth_a, (-1.0 - 2.5 * fz, -ft))
        ka, kb = 2.5 / i.a_radius, 2.5 / i.b_radius
        return (
            *(-to_a + ca[0], -to_a * ft + ca[1]),
            *(ka * ca[1], ka * (to_a * fz - ca[0]), -ka * to_a * ft),
            *(to_b + cb[0], to_b * ft + cb[1]),
            *(kb * cb[1], kb * (to_b * fz - cb[0]), -kb * to_b * ft),
            *(max(-to_a * fz, 0.0), max(to_b * fz, 0.0)),
            s[0] - s[5],  # work
            *(1.0, ft, fz, *ca, *cb),
        )

    def step(s, h, stuck):
        k1 = rates(s, stuck)
        k2 = rates([x + h / 2 * k for x, k in zip(s, k1, strict=True)], stuck)
        k3 = rates([x + h / 2 * k for x, k in zip(s, k2, strict=True)], stuck)
        k4 = rates([x + h * k for x, k in zip(s, k3, strict=True)], stuck)
        zipped = zip(s, k1, k2, k3, k4, strict=True)
        return [x + h / 6 * (p + 2 * q + 2 * r + t) for x, p, q, r, t in zipped]

    def phase(s, left):
        stuck = False
        while True:
            along, up, cloth_a, cloth_b = slips(s)
            slip = math.hypot(along, up)
            stuck = stuck or slip < 1e-11 * approach
            h = approach / 1000
            if not stuck:
                cloth = math.hypot(*(cloth_a if up > 0.0 else cloth_b))
                h = min(h, 0.03 * slip / mu, max(0.03 * cloth, 1e-9 * approach))
            following = step(s, h, stuck)
            if left(following) <= 0.0:
                low, high = 0.0, h
                for _ in range(55):
                    middle = (low + high) / 2
                    low, high = (
                        (middle, high) if left(step(s, middle, stuck)) > 0.0 else (low, middle)
                    )
                return step(s, low, stuck)
            s = following

    s = phase([*i[:5], *i[8:13], *[0.0] * 10], lambda s: s[0] - s[5])
    stored = s[12]
    if e > 0.0:
        s = phase(s, lambda s: s[12] - stored * (1.0 - e * e))
    return s[13:]


ODD_BALL = (0.02, 0.4, 0.35)


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("i", "e", "mu"),
    [
        (impact_of(shot(0.3, 2.0, 1.0)), 0.95, 0.06),  # the ordinary shot
        (impact_of(shot(1.4, 2.0, -1.0, 0.3)), 0.95, 0.06),  # thin, with draw
        (impact_of(shot(0.0, 1.0, 1.0)), 1.0, 0.06),  # along a line: all turns on signs
        (impact_of(shot(0.0, 1.0, 0.3)), 0.95, 0.06),  # slip ends in restitution
        (impact_of(shot(0.0, 1.0, -0.1)), 0.95, 0.06),  # slip ends in compression
        (impact_of(shot(0.3, 1.0, 0.1)), 0.5, 0.06),  # the same, sideways too
        (impact_of(shot(0.2, 1.0, 1.0), (0.0, 0.0, 0.0, 9.0, 0.0)), 0.9, 0.06),  # cloth slip
        (impact_of(shot(0.0, 1.0, 1.0), (0.0, 0.0, 0.0, 9.0, 0.0)), 0.9, 0.06),  # ... through 0
        (impact_of(shot(0.0, 1.0, 0.8), (0.0, 0.0, 0.0, 35.0, 0.0)), 0.9, 1.0),  # much friction
        (impact_of(shot(1e-3, 1.0, 1.0), (0.0, 0.0, 0.0, 9.0, 0.0)), 0.9, 0.06),  # close by 0
        (impact_of(shot(0.3, 1.0, 1.0), ball_b=ODD_BALL), 0.9, 0.06),
        (impact_of(shot(0.3, 1.0, -1.0), (0.1, 0.2, 1.0, 2.0, 3.0), ODD_BALL), 0.9, 0.06),
        (impact_of(shot(0.3, 1.0, 1.0, -0.3), ball_b=ODD_BALL), 0.0, 0.5),  # much, and sideways
        (impact_of(shot(1.55, 1.0, 1.0)), 1e-3, 0.01),  # hardly any
    ],
)
def test_the_integration_agrees_with_the_naive_one(i: BallImpact, e: float, mu: float):
    """Fails if an equation differs, or the integration is less accurate than it says."""
    p = mathavan2014(i, laws(e, mu))
    assert p == pytest.approx(naive(i, e, mu), abs=1e-7 * (i.a_vn - i.b_vn), rel=0.0)


@given(i=impacts, e=restitutions, mu=frictions)
def test_the_cloth_rubs_one_ball_no_more_than_it_is_pressed(i: BallImpact, e: float, mu):
    """The total is bounded by the coefficient times the vertical impulse on that ball."""
    p = mathavan2014(i, laws(e, mu))
    rounding = 1e-7 * (i.a_vn - i.b_vn) + 8.0 * EPS * (abs(p.up) + R * (abs(i.a_wt) + abs(i.b_wt)))
    on_a, on_b = math.hypot(p.a_cloth_n, p.a_cloth_t), math.hypot(p.b_cloth_n, p.b_cloth_t)
    share_b = i.a_mass / (i.a_mass + i.b_mass)
    assert on_a <= i.a_cloth * (1.0 - share_b) * max(p.up, 0.0) + rounding
    assert on_b <= i.b_cloth * share_b * max(-p.up, 0.0) + rounding

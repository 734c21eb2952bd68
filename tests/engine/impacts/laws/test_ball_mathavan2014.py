"""The ball-ball impact on the cloth: published shots, and the cloth's part."""

from __future__ import annotations

import math

import pytest
from ball_impacts import (
    EPS,
    SNOOKER_BALL,
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


@given(i=impacts, e=restitutions, mu=frictions)
def test_the_cloth_rubs_one_ball_no_more_than_it_is_pressed(i: BallImpact, e: float, mu):
    """The total is bounded by the coefficient times the vertical impulse on that ball."""
    p = mathavan2014(i, laws(e, mu))
    rounding = 1e-7 * (i.a_vn - i.b_vn) + 8.0 * EPS * (abs(p.up) + R * (abs(i.a_wt) + abs(i.b_wt)))
    on_a, on_b = math.hypot(p.a_cloth_n, p.a_cloth_t), math.hypot(p.b_cloth_n, p.b_cloth_t)
    share_b = i.a_mass / (i.a_mass + i.b_mass)
    assert on_a <= i.a_cloth * (1.0 - share_b) * max(p.up, 0.0) + rounding
    assert on_b <= i.b_cloth * share_b * max(-p.up, 0.0) + rounding

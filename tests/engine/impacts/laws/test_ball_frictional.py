"""Tests of the law "frictional" for balls, and of the properties it shares with mathavan2014.

A law is tested by its effect on the balls, as `BallImpulse` defines it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from ball_impacts import (
    EPS,
    POOL_BALL,
    after,
    any_frictions,
    energy,
    gained,
    impact_of,
    impacts,
    laws,
    mirrored,
    restitutions,
    shot,
)
from hypothesis import assume, given
from kernels import entry_to
from shots import R

from ghostball.engine.core.state import Laws
from ghostball.engine.impacts.laws.ball_frictional import frictional
from ghostball.engine.impacts.laws.ball_mathavan2014 import mathavan2014
from ghostball.engine.impacts.laws.friction_curve import alciatore_friction
from ghostball.engine.impacts.laws.interface import BallImpact, BallImpulse

frictional, mathavan2014, alciatore_friction = map(
    entry_to, (frictional, mathavan2014, alciatore_friction)
)

Law = Callable[[BallImpact, Laws], BallImpulse]
both_laws = pytest.mark.parametrize("law", [frictional, mathavan2014])


# --- closed forms -------------------------------------------------------------------------------


@both_laws
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.95, 1.0])
def test_without_friction_only_the_normal_impulse_acts(law: Law, restitution: float):
    """Bit-identical: scenes without friction between balls must not depend on the friction code."""
    i = impact_of(shot(0.7, 1.3, 1.0, 0.4), (-0.2, 0.1, 3.0, -2.0, 5.0))
    normal = (1.0 + restitution) * (i.a.vn - i.b.vn)
    assert law(i, laws(restitution, 0.0)) == (normal, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@both_laws
@pytest.mark.parametrize("cut", [0.05, 0.3, 0.7, 1.2])
@pytest.mark.parametrize("side", [-0.5, 0.0, 0.4, 0.8])
@pytest.mark.parametrize("friction", [0.06, "alciatore"])
def test_a_stunned_ball_throws_as_published(law: Law, cut: float, side: float, friction):
    """Alciatore's proof A.14. Fails for a wrong sign, sticking limit or slip in the curve."""
    v = 1.7
    i = impact_of(shot(cut, v, side=side))
    _, b = after(i, law(i, laws(1.0, friction)))
    slip = v * math.sin(cut) + v * side
    mu = alciatore_friction(abs(slip)) if friction == "alciatore" else friction
    part = min(mu * v * math.cos(cut) / abs(slip), 1.0 / 7.0)
    throw = part * slip / (v * math.cos(cut))
    assert b.vt / b.vn == pytest.approx(throw, rel=1e-14)


@both_laws
def test_gearing_spin_throws_nothing(law: Law):
    """With R wz = -v sin(cut) in this frame, the surfaces touch without slip."""
    vn, vt = 1.0, 0.75
    i = impact_of((vn, vt, 0.0, 0.0, -vt / 0.03125), ball_a=(0.03125, 0.17, 0.2))
    assert law(i, laws(0.95, 0.06)) == (1.95, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@both_laws
@pytest.mark.parametrize("ball_b", [POOL_BALL, (0.02, 0.05, 0.2)])
@pytest.mark.parametrize("vt", [0.05, 2.0])
def test_the_energy_lost_to_a_sideways_slip_is_the_closed_form(law: Law, ball_b, vt: float):
    """Sticking dissipates m U^2/7, slipping mu J U - (7/4)(mu J)^2 / m, with the reduced mass m."""
    e, mu, vn = 0.9, 0.06, 1.0
    i = impact_of((vn, vt, 0.0, 0.0, 0.0), ball_b=ball_b)
    mass = i.a.mass * i.b.mass / (i.a.mass + i.b.mass)
    friction = mu * mass * (1.0 + e) * vn
    slips = vt > 3.5 * (1.0 + e) * mu * vn
    assert slips == (vt == 2.0)
    loss = friction * vt - 1.75 * friction**2 / mass if slips else mass * vt**2 / 7.0
    loss += 0.5 * mass * (1.0 - e * e) * vn * vn
    assert -gained(i, law(i, laws(e, mu))) == pytest.approx(loss, rel=1e-13)


def test_friction_acts_along_the_slip_with_the_coefficient():
    """Fails if the two components of friction are limited separately."""
    i = impact_of(shot(0.6, 2.0, 1.0, 0.3))
    p = frictional(i, laws(0.9, 0.05))
    along, up = i.a.vt + R * i.a.wz, -R * i.a.wt
    assert math.hypot(p.along, p.up) == pytest.approx(0.05 * p.normal, rel=1e-15)
    assert p.along * up == pytest.approx(p.up * along, rel=1e-15)
    assert p.along > 0.0
    assert p.up < 0.0  # the front of a rolling ball moves down, and drags b's surface down


@pytest.mark.parametrize("scale", [2.0**-600, 2.0**-40, 2.0**500])
@both_laws
def test_the_scale_of_speeds_changes_nothing_bit_for_bit(law: Law, scale: float):
    """Fails if a square over- or underflows, or if a tolerance has a unit."""
    i = impact_of(shot(0.4, 1.1, 1.0, 0.2), (0.1, -0.2, 3.0, 1.0, -4.0))
    scaled = impact_of([scale * x for x in i.a[:5]], [scale * x for x in i.b[:5]])
    p = law(i, laws(0.9, 0.06))
    assert law(scaled, laws(0.9, 0.06)) == tuple(scale * x for x in p)


@both_laws
def test_slip_too_small_to_square_is_still_ended(law: Law):
    i = impact_of((1.0, 1e-200, 0.0, 0.0, 0.0))
    p = law(i, laws(1.0, 0.06))
    assert p.along == pytest.approx(2.0 / 7.0 * 1e-200, rel=1e-14)


# --- properties ---------------------------------------------------------------------------------


@both_laws
@given(i=impacts, e=restitutions, mu=any_frictions)
def test_energy_never_rises(law: Law, i: BallImpact, e: float, mu: float | str):
    assume(law is frictional or mu != 5.0)  # mathavan2014 does not describe it
    assert gained(i, law(i, laws(e, mu))) <= 8.0 * EPS * energy(i, i.a[:5], i.b[:5])


@both_laws
@given(i=impacts, e=restitutions, mu=any_frictions)
def test_a_mirror_image_is_mirrored_bit_for_bit(law: Law, i: BallImpact, e: float, mu):
    assume(law is frictional or mu != 5.0)  # mathavan2014 does not describe it
    p, image = law(i, laws(e, mu)), law(mirrored(i), laws(e, mu))
    signs = (1, -1, 1, 1, -1, 1, -1)
    assert image == tuple(sign * x for sign, x in zip(signs, p, strict=True))

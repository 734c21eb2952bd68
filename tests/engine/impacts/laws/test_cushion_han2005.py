"""Tests of the contract of all cushion laws; closed forms of all except mathavan2010.

They fail for a wrong sign in a torque, a cushion that pulls, an energy gain, or a left-right bias.
"""

import math

import pytest
from cushion_impacts import (
    R,
    cushion_of,
    cushions,
    energy,
    impact_of,
    impacts,
    outcome,
    reflected,
    rolling,
)
from hypothesis import assume, given, settings, strategies as st
from kernels import entry_to

from ghostball.engine.impacts.laws.cushion_han2005 import frictional, han2005
from ghostball.engine.impacts.laws.cushion_mathavan2010 import mathavan2010
from ghostball.engine.impacts.laws.cushion_restitution import restitution

frictional, han2005, mathavan2010, restitution = map(
    entry_to, (frictional, han2005, mathavan2010, restitution)
)


def stronge2000(impact, cushion, ratio=1.76):
    return han2005(impact, cushion._replace(ratio=ratio))


ALL = (restitution, frictional, han2005, mathavan2010, stronge2000)
FRICTIONAL = ALL[1:-1]
every_law = pytest.mark.parametrize("law", ALL)
frictional_laws = pytest.mark.parametrize("law", FRICTIONAL)


@every_law
@settings(max_examples=200)
@given(impacts, cushions)
def test_energy_never_rises_and_the_ball_leaves(law, impact, cushion):
    after = law(impact, cushion)
    assert all(map(math.isfinite, after))
    assert after.vn <= 0.0
    assert energy(after) <= energy(impact) * (1.0 + 1e-12)


@pytest.mark.parametrize("law", [frictional, han2005, stronge2000])
@given(impacts, cushions)
def test_in_space_the_nose_returns_e_of_the_closing_speed(law, impact, cushion):
    """The upward impulse counts as a velocity. Shots in which the ball is wedged are left out."""
    after = law(impact, cushion)
    assume(after.vn < 0.0)
    sine = (cushion.height - R) / R if law is not frictional else 0.0
    cosine = math.sqrt(1.0 - sine * sine)
    closing = cosine * after.vn + sine * after.up
    expected = -cushion.restitution * cosine * impact.vn
    assert closing == pytest.approx(expected, abs=1e-13 * sum(map(abs, outcome(impact))))


@every_law
@given(impacts, cushions)
def test_the_mirror_image_has_the_mirrored_outcome_to_the_bit(law, impact, cushion):
    after = law(impact, cushion)
    mirrored = law(reflected(impact), cushion)
    assert (mirrored.vn, mirrored.wt) == (after.vn, after.wt)
    assert (mirrored.vt, mirrored.wn, mirrored.wz) == (-after.vt, -after.wn, -after.wz)


@every_law
@given(impacts, cushions, st.integers(-20, 20))
def test_speeds_times_a_power_of_two_scale_the_outcome_to_the_bit(law, impact, cushion, k):
    factor = 2.0**k
    fields = ("vn", "vt", "wn", "wt", "wz")
    faster = impact._replace(**{f: factor * getattr(impact, f) for f in fields})
    assert law(faster, cushion) == tuple(factor * x for x in law(impact, cushion))


@every_law
@given(impacts, cushions, st.integers(-6, 6))
def test_sizes_times_a_power_of_two_keep_the_speeds_to_the_bit(law, impact, cushion, k):
    factor = 2.0**k
    larger = impact._replace(
        radius=factor * R, mass=3.0, **{w: getattr(impact, w) / factor for w in ("wn", "wt", "wz")}
    )
    higher = cushion._replace(height=factor * cushion.height)
    assert outcome(law(larger, higher), factor * R) == outcome(law(impact, cushion))


@frictional_laws
def test_english_that_runs_with_the_ball_widens_its_rebound_and_check_narrows_it(law):
    # The ball moves towards +n and +t. Friction at a cushion ahead is along t, like -(vt + R wz).
    cushion = cushion_of(friction=0.1)
    along = [law(rolling(1.0, 1.0, side), cushion).vt for side in (-3.0, 0.0, 3.0)]
    assert along[0] > along[1] > along[2]
    assert law(rolling(1.0, 1.0, -3.0), cushion).vt > 1.0
    # Check side becomes running side; friction reduces both.
    spins = [R * law(rolling(1.0, 1.0, side), cushion).wz for side in (-3.0, 0.0, 3.0)]
    assert -3.0 < spins[0] < spins[1] < 0.0 < spins[2] < 3.0


def published_han(impact, cushion, sine):
    """Han's equations, corrected, for a mass of 1: X into the cushion, Y along it, Z up."""
    theta = math.asin(sine)
    sin, cos, r = math.sin(theta), math.cos(theta), impact.radius
    inertia, a, b = 0.4 * r**2, 3.5, 1.0
    sx = impact.vn * sin + r * impact.wt
    sy = -impact.vt - r * impact.wz * cos + r * impact.wn * sin
    push = (1.0 + cushion.restitution) * impact.vn * cos / b
    slip = math.hypot(sx, sy)
    if slip / a <= cushion.friction * push:
        px, py = sx / a, sy / a
    else:
        px, py = (cushion.friction * push * s / slip for s in (sx, sy))
    x, y, z = -px * sin - push * cos, py, px * cos - push * sin
    return [
        impact.vn + x,
        impact.vt + y,
        r * (impact.wn - r * y * sin / inertia),
        r * (impact.wt + r * (x * sin - z * cos) / inertia),
        r * (impact.wz + r * y * cos / inertia),
    ]


@settings(max_examples=300)
@given(impacts, cushions)
def test_han_and_frictional_are_the_published_equations_with_vn_bounded(impact, cushion):
    for law, sine in ((han2005, cushion.height / R - 1.0), (frictional, 0.0)):
        expected = published_han(impact, cushion, sine)
        expected[0] = min(expected[0], 0.0)
        size = 1e-13 * (impact.vn + sum(map(abs, outcome(impact))))
        assert outcome(law(impact, cushion)) == pytest.approx(expected, abs=size)


def test_frictional_that_sticks_ends_the_slip_and_takes_two_sevenths_of_it():
    # Without topspin, all slip is along the cushion: 0.3 + 0.2 = 0.5, and 0.4 (1 + 0.9) > 1/7.
    after = frictional(impact_of(1.0, 0.3, wz=0.2 / R), cushion_of(e=0.9, friction=0.4))
    assert after.vn == -0.9
    assert after.vt == pytest.approx(0.3 - 1 / 7, rel=1e-15)
    assert R * after.wz == pytest.approx(0.2 - 2.5 / 7, rel=1e-15)
    assert after.vt + R * after.wz == pytest.approx(0.0, abs=1e-15)
    assert (after.wn, after.wt) == (0.0, 0.0)


def test_frictional_that_slips_takes_its_friction_times_the_push():
    # 0.1 (1 + 0.9) = 0.19, along (0.6, 0.8): topspin 3 and side 4 in a slip of 5.
    after = frictional(impact_of(1.0, 4.0, wt=3.0 / R), cushion_of(e=0.9, friction=0.1))
    assert after.vn == -0.9
    assert after.vt == pytest.approx(4.0 - 0.8 * 0.19, rel=1e-15)
    assert R * after.wt == pytest.approx(3.0 - 2.5 * 0.6 * 0.19, rel=1e-15)
    assert R * after.wz == pytest.approx(-2.5 * 0.8 * 0.19, rel=1e-15)


@pytest.mark.parametrize("approach", [0.5, 1.0, 2.0])
def test_han_of_a_rolling_carom_ball_with_the_fitted_constants(approach):
    # Han's fits of the constants, for a carom ball; the ball rolls head on, so its slip at the nose
    # is (1 + sine) vn, in the plane of n and z.
    radius, theta = 0.03275, math.asin(0.2)
    e = 0.39 + 0.257 * approach - 0.044 * approach**2
    friction = 0.471 - 0.241 * theta
    impact = impact_of(approach, wt=approach / radius, radius=radius)
    after = han2005(impact, cushion_of(e=e, friction=friction, height=1.2 * radius))
    cosine = math.sqrt(0.96)
    rub = min(2 / 7 * 1.2 * approach, friction * (1 + e) * cosine * approach)
    assert rub == 2 / 7 * 1.2 * approach  # the friction limit is not reached
    assert after.vn == pytest.approx(approach * (0.04 - 0.96 * e) - 0.2 * rub, rel=1e-14)
    assert radius * after.wt == pytest.approx(approach - 2.5 * rub, rel=1e-14)


def test_han_bounds_vn_where_the_ball_would_still_approach():
    # Without friction, this happens if sine^2 > e / (1 + e), which is 1/5 for e = 1/4.
    limit = math.sqrt(0.2)
    below, above = (
        han2005(impact_of(1.0, 0.5, wz=3.0), cushion_of(e=0.25, friction=0.0, height=(1 + s) * R))
        for s in (limit - 1e-6, limit + 1e-6)
    )
    assert -1e-5 < below.vn < 0.0
    assert above.vn == 0.0
    assert below[1:5] == above[1:5] == (0.5, 0.0, 0.0, 3.0)
    # With friction: strong backspin under a high nose, with the constants of a real table.
    drawn = impact_of(1.0, wt=-60.0 / R)
    assert published_han(drawn, cushion_of(e=0.2, friction=0.5), 0.4)[0] > 0.0
    assert han2005(drawn, cushion_of(e=0.2, friction=0.5)).vn == 0.0

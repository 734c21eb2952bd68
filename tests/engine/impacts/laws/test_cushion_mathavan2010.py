"""Mathavan's law against closed forms, the published equations in small steps, and its limits.

Broken by: a wrong sign, a slip that chatters or jumps over 0, a step that is too long, a cloth that
pulls the ball down, a phase that ends early.
"""

import math
import random

import pytest
from cushion_impacts import (
    R,
    chattered,
    cushion_of,
    energy,
    followed,
    impact_of,
    in_plane,
    outcome,
    rolling,
)
from hypothesis import example, given, settings, strategies as st
from kernels import entry_to

from ghostball.engine.impacts.laws.cushion_mathavan2010 import mathavan2010

mathavan2010 = entry_to(mathavan2010)

ACCURACY = 1e-7  # of the speed of approach, as the law states

height = st.one_of(st.sampled_from([1.0, 1.27, 1.4]), st.floats(0.3, 1.8))


@settings(max_examples=300)
@given(
    topspin=st.one_of(st.sampled_from([0.0, 1.0, -0.4]), st.floats(-3.0, 3.0)),
    cloth=st.one_of(st.sampled_from([0.0, 0.212]), st.floats(0.0, 0.8)),
    friction=st.one_of(st.sampled_from([0.0, 0.14]), st.floats(0.0, 0.9)),
    e=st.one_of(st.sampled_from([0.0, 0.98, 1.0]), st.floats(0.0, 1.0)),
    height=height,
)
# A slip on the cloth that ends with compression; a rebound of less than rounding.
@example(topspin=0.0, cloth=1e-20, friction=0.0, e=0.0, height=1.27)
@example(topspin=0.0, cloth=0.0, friction=0.0, e=3.4e-156, height=1.0)
def test_a_ball_in_one_plane_follows_the_closed_form(topspin, cloth, friction, e, height):
    # Slips end, stick and start again at both contacts, and the ball jams, in some of these.
    impact = impact_of(1.0, wt=topspin / R, cloth=cloth)
    cushion = cushion_of(e, friction, height * R)
    after = outcome(mathavan2010(impact, cushion))
    assert after == pytest.approx(in_plane(impact, cushion), abs=ACCURACY)
    assert (after[1], after[2], after[4]) == (0.0, 0.0, 0.0)


def test_a_head_on_ball_without_friction_keeps_e_of_its_speed():
    for e in (0.0, 1e-6, 0.5, 1.0):
        after = mathavan2010(impact_of(1.0, cloth=0.0), cushion_of(e=e, friction=0.0))
        assert outcome(after) == pytest.approx((-e, 0.0, 0.0, 0.0, 0.0), abs=ACCURACY)


def test_a_rolling_ball_that_slips_throughout():
    # Head on at mid-ball with e = 1: the nose lifts the ball, so the cloth has no part, and its
    # friction mu takes 5/2 mu (1 + e) vn of the topspin R wt and nothing of vn.
    after = mathavan2010(rolling(1.0, 0.0), cushion_of(e=1.0, friction=0.14, height=R))
    assert after.vn == pytest.approx(-1.0, abs=ACCURACY)
    assert R * after.wt == pytest.approx(1.0 - 2.5 * 0.14 * 2.0, abs=ACCURACY)


@pytest.mark.parametrize(
    ("impact", "cushion"),
    [
        (rolling(1.0, 1.0), cushion_of()),
        (rolling(1.0, -0.4, 1.5), cushion_of()),
        (rolling(1.0, 2.0, 0.5), cushion_of(e=1.0)),
        (rolling(1.0, 2.0, 0.5), cushion_of(e=0.0)),
        (rolling(1.0, 0.7), cushion_of(0.8, 0.2, 0.9 * R)),
        (impact_of(1.0, 1.0), cushion_of()),
        (impact_of(1.0, 0.5, 3.0, 20.0, 30.0), cushion_of(0.9, 0.2)),
    ],
)
def test_slips_that_turn_follow_the_published_equations(impact, cushion):
    expected = followed(impact, cushion)
    assert outcome(mathavan2010(impact, cushion)) == pytest.approx(expected, abs=ACCURACY)


@pytest.mark.compiled
@pytest.mark.parametrize(
    ("impact", "cushion"),
    [
        # The slip at the nose turns, ends and sticks in compression, and slips in the rebound.
        (impact_of(1.0, 0.2), cushion_of()),
        (impact_of(1.0, 0.3, 0.7 / R, -0.5 / R, 0.2 / R), cushion_of(0.98, 0.3)),
        # Pool.
        (rolling(1.0, 0.5, -1.0), cushion_of(0.85, 0.2, 1.27 * R)),
        (impact_of(1.0, 0.4, 0.2 / R, -0.6 / R, 0.3 / R), cushion_of(0.9, 0.2, 1.27 * R)),
        # The slip on the cloth ends and sticks.
        (impact_of(1.0, 0.05, 0.0, 0.9 / R, 0.3 / R, cloth=0.5), cushion_of(0.9, 0.1, 1.5 * R)),
    ],
)
def test_slips_that_end_follow_the_published_equations(impact, cushion):
    # 60 000 uniform steps in all, per speed of approach.
    expected = chattered(impact, cushion, 20_000)
    assert outcome(mathavan2010(impact, cushion)) == pytest.approx(expected, abs=ACCURACY)


def test_a_ball_that_both_contacts_can_hold_jams():
    # Both coefficients against the tangent of half the angle between cushion and cloth.
    jam = math.sqrt(0.84) / 1.4
    held = mathavan2010(impact_of(1.0, cloth=jam + 1e-3), cushion_of(e=1.0, friction=jam + 1e-3))
    assert outcome(held) == pytest.approx((0.0, 0.0, 0.0, 0.0, 0.0), abs=ACCURACY)
    slips = mathavan2010(impact_of(1.0, cloth=0.2), cushion_of(e=1.0, friction=jam + 1e-3))
    assert slips.vn < -0.5


@given(vt=st.floats(-2.0, 2.0), topspin=st.floats(0.0, 2.0), height=st.floats(0.5, 1.0))
def test_the_cloth_has_no_part_where_the_nose_lifts_the_ball(vt, topspin, height):
    after = [
        outcome(
            mathavan2010(
                impact_of(1.0, vt, wt=(topspin + 0.5) / R, cloth=cloth),
                cushion_of(height=height * R),
            )
        )
        for cloth in (0.0, 0.3)
    ]
    assert after[1] == pytest.approx(after[0], abs=ACCURACY)


@pytest.mark.compiled
def test_it_ends_for_every_ball_however_it_spins():
    chance = random.Random(5)
    for _ in range(500):
        vn, vt, wn, wt, wz = (10.0 ** chance.uniform(-5, 2) for _ in range(5))
        impact = impact_of(
            vn,
            chance.choice((-1, 1)) * vt,
            chance.choice((-1, 1)) * wn / R,
            chance.choice((-1, 1)) * wt / R,
            chance.choice((-1, 1)) * wz / R,
            cloth=chance.uniform(0.0, 2.0),
        )
        cushion = cushion_of(
            chance.random(), chance.uniform(0.0, 2.0), chance.uniform(0.02, 1.98) * R
        )
        after = mathavan2010(impact, cushion)
        assert all(map(math.isfinite, after))
        assert after.vn <= 0.0
        assert energy(after) <= energy(impact) * (1.0 + 1e-12)


@pytest.mark.parametrize("vn", [0.0, 5e-324, 1e-310, 1e-200, 1e-139, 1e-30])
@pytest.mark.parametrize("spins", [(0.0, 0.0, 0.0, 0.0), (1.0, -1 / R, 0.0, 2.0), (1.0, 0, 3, 2)])
def test_an_approach_that_vanishes_changes_nothing_that_counts(vn, spins):
    impact = impact_of(vn, *map(float, spins))
    after = mathavan2010(impact, cushion_of())
    assert -vn <= after.vn <= 0.0
    assert outcome(after) == pytest.approx(outcome(impact), abs=10 * vn)

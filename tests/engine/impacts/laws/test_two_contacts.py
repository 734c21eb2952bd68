"""Tests of friction at two contacts: both can hold a ball, and one without load has no effect."""

import math

import pytest
from cushion_impacts import R, cushion_of, impact_of, outcome
from hypothesis import given, strategies as st
from kernels import entry_to

from ghostball.engine.impacts.laws.cushion_mathavan2010 import mathavan2010

mathavan2010 = entry_to(mathavan2010)
ACCURACY = 1e-7  # relative to the approach speed, as the law states


def test_a_ball_that_both_contacts_can_hold_jams():
    # The ball jams if both coefficients exceed the tangent of half the angle between cushion and
    # cloth.
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

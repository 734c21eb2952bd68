"""Tests of lengths and masses of any magnitude, and of the rules for closed gaps."""

from __future__ import annotations

import math

from hypothesis import given, strategies as st

from ghostball.engine.core.tolerances import APPROACH_ROUNDING, CONTACT_REACH, LEAST_SPEED
from ghostball.engine.motion.geometry import in_contact, reduced_mass, rounding_of, speed_of

masses = st.floats(1e-300, 1e300)
speeds = st.floats(-1e10, 1e10)


@given(a=masses, b=masses)
def test_a_reduced_mass_is_the_same_for_both_and_between_half_and_all_of_the_lighter(a, b):
    found = reduced_mass(a, b)
    assert found == reduced_mass(b, a)
    assert 0.5 * min(a, b) <= found <= min(a, b)


@given(x=speeds, y=speeds, k=st.integers(-500, 500))
def test_a_length_scales_by_powers_of_two(x, y, k):
    x, y = (v if abs(v) > 1e-100 else 0.0 for v in (x, y))
    found = speed_of(x, y)
    assert speed_of(math.ldexp(x, k), math.ldexp(y, k)) == math.ldexp(found, k)
    assert math.isclose(found, math.hypot(x, y), rel_tol=1e-15)


def test_a_length_neither_over_nor_underflows():
    assert math.isclose(speed_of(3e200, 4e200), 5e200, rel_tol=1e-15)
    assert speed_of(5e-324, 0.0) == 5e-324
    assert speed_of(0.0, 0.0) == 0.0


def test_an_approach_by_rounding_is_none():
    assert rounding_of(1.0) == APPROACH_ROUNDING
    assert rounding_of(0.0) == LEAST_SPEED


def test_a_gap_is_closed_where_it_is_near_and_what_opens_it_falls_back():
    tolerance, pull = 1e-12, 3.0
    bounce = math.sqrt(2.0 * pull * tolerance)  # a bounce as high as the tolerance
    assert in_contact(CONTACT_REACH * tolerance, 0.99 * bounce, tolerance, pull, 0.0)
    assert not in_contact(CONTACT_REACH * tolerance, 1.01 * bounce, tolerance, pull, 0.0)
    assert not in_contact(1.01 * CONTACT_REACH * tolerance, 0.0, tolerance, pull, 0.0)
    assert in_contact(0.0, 1e-15, tolerance, 0.0, 1e-15)  # the rate is only rounding
    assert not in_contact(0.0, 1e-15, tolerance, 0.0, 0.0)

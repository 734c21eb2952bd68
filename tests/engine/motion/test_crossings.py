"""Tests of the times at which gaps close: against roots with many digits, and never late."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, strategies as st
from mpmath import mp, mpf, workdps

from ghostball.engine.motion.crossings import first_bent_crossing, first_crossing, first_meeting

ROUNDING = 16.0 * 2.0**-52

numbers = st.one_of(st.sampled_from([0.0, 1.0, -1.0]), st.floats(-10.0, 10.0)).map(
    lambda x: x if abs(x) > 1e-6 else 0.0
)
gaps = numbers.map(abs)


def exact(gap: float, rate: float, acceleration: float) -> float:
    """Return the first s > 0 at which the gap falls to 0; 0 if it is closed and closing."""
    if gap == 0.0 and rate < 0.0:
        return 0.0
    with workdps(60):
        g, v, a = mpf(gap), mpf(rate), mpf(acceleration)
        square = v * v - 2 * a * g
        if square < 0 or (a == 0 and v >= 0):
            return math.inf
        roots = [(-v + sign * mp.sqrt(square)) / a for sign in (1, -1)] if a else [-g / v]
        return float(min((s for s in roots if s > 0), default=mp.inf))


@given(gap=gaps, rate=numbers, acceleration=numbers)
def test_a_gap_closes_at_the_first_root_to_all_digits(gap, rate, acceleration):
    square = rate * rate - 2.0 * acceleration * gap
    found, wanted = first_crossing(gap, rate, acceleration), exact(gap, rate, acceleration)
    if abs(square) > 1e-6 * max(rate * rate, 1e-6):  # otherwise rounding decides if it closes
        assert found == wanted or abs(found - wanted) <= 1e-8 * wanted


def test_small_gaps_and_overlaps_lose_no_digits():
    for gap in (1e-3, 1e-9, 1e-15):
        assert abs(first_crossing(gap, -1.0, 0.5) / exact(gap, -1.0, 0.5) - 1.0) <= ROUNDING
    assert first_crossing(-1e-18, -1.0, 0.5) == 0.0  # an overlap by rounding
    assert first_crossing(-1e-18, 1.0, -0.5) == 4.0


@given(gap=gaps, rate=numbers, acceleration=numbers, jerk=gaps, left=st.floats(0.1, 5.0))
def test_a_bound_is_never_later_than_the_bent_gap_closes(gap, rate, acceleration, jerk, left):
    soonest = first_bent_crossing(gap, rate, acceleration, jerk, left)
    times = np.linspace(0.0, min(soonest, left), 200)[1:-1]
    bent = gap + times * (rate + times * (acceleration / 2.0 - jerk * times / 6.0))
    assert np.all(bent >= -1e-9 * (1.0 + gap))


@given(
    to=st.floats(-3.0, 3.0),
    slant=st.floats(-1.4, 1.4),
    speed=st.floats(0.01, 10.0),
    s=st.floats(0.0, 5.0),
    reach=st.floats(0.01, 1.0),
)
def test_balls_meet_when_they_were_made_to(to, slant, speed, s, reach):
    """The balls are moved back from their contact, with surfaces closing at up to 80 degrees."""
    vx, vy = -speed * math.cos(to + slant), -speed * math.sin(to + slant)
    x, y = reach * math.cos(to) - s * vx, reach * math.sin(to) - s * vy
    assert abs(first_meeting(x, y, vx, vy, reach) - s) <= 1e-12 * (1.0 + s)
    assert first_meeting(x, y, -vx, -vy, reach) == math.inf
    beside = 2.1 * reach / speed  # distance across the line, larger than the reach
    assert first_meeting(x - beside * vy, y + beside * vx, vx, vy, reach) == math.inf

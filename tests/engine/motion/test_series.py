"""Tests of power series of motion in air against closed forms."""

import math

import numpy as np
import pytest
from mpmath import atan, mpf, sqrt, tan, workdps

from ghostball.engine.core import state as st
from ghostball.engine.motion.series import (
    DEGREE,
    STRAIGHT_DEGREE,
    extend_speed,
    first_zero,
    shorter,
    straight_series,
)

COUNTERS = np.zeros(st.COUNTERS, dtype=np.int64)


def speed_at(speed, a, b, t):
    """Closed form of dv/dt = -(a + b v^2), with 30 digits, because it cancels near pi / 2."""
    with workdps(30):
        a, b = mpf(a), mpf(b)
        return float(sqrt(a / b) * tan(atan(speed * sqrt(b / a)) - sqrt(a * b) * t))


def stop_of(speed, a, b):
    return math.atan(speed * math.sqrt(b / a)) / math.sqrt(a * b)


@pytest.mark.parametrize("speed", [1e-3, 1.0, 12.0])
@pytest.mark.parametrize(("a", "b"), [(0.1, 0.003), (2.0, 0.01), (1e-3, 0.5)])
def test_straight_motion_in_air_agrees_with_the_closed_form(speed, a, b):
    p = np.zeros(STRAIGHT_DEGREE + 1)
    duration = min(straight_series(p, speed, a, b), stop_of(speed, a, b))
    for part in (0.25, 0.5, 1.0):
        expected = speed_at(speed, a, b, part * duration)
        found = np.polynomial.polynomial.polyval(part * duration, p)
        assert found == pytest.approx(expected, abs=8e-16 * speed)


def test_without_air_one_piece_holds_for_ever():
    p = np.zeros(STRAIGHT_DEGREE + 1)
    assert straight_series(p, 2.0, 0.5, 0.0) == math.inf
    assert p[:3].tolist() == [2.0, -0.5, 0.0]
    assert first_zero(COUNTERS, p, 10.0) == 4.0
    assert first_zero(COUNTERS, p, math.inf) == 4.0
    assert first_zero(COUNTERS, p, 3.0) == math.inf


@pytest.mark.parametrize("b", [0.01, 1.0])
def test_the_speed_vanishes_at_the_time_of_the_closed_form(b):
    p = np.zeros(STRAIGHT_DEGREE + 1)
    duration = straight_series(p, 0.01, 0.1, b)
    expected = stop_of(0.01, 0.1, b)
    assert expected < duration
    assert first_zero(COUNTERS, p, duration) == pytest.approx(expected, rel=1e-15)


def test_what_never_slows_never_stops():
    p = np.zeros(STRAIGHT_DEGREE + 1)
    p[0] = 1.0
    assert first_zero(COUNTERS, p, 10.0) == math.inf


def test_a_speed_has_the_powers_of_the_root_of_its_parts_squares():
    """For (1 + t)^2 + (2 - t)^2, the binomial series gives the first powers of the root."""
    row = np.zeros((3, DEGREE + 2))
    row[1, :2], row[2, :2] = (1.0, 1.0), (2.0, -1.0)
    row[0, 0] = math.sqrt(5.0)
    for n in range(1, 9):
        extend_speed(row, 0, 1, 2, n)
    square = np.polynomial.polynomial.polypow(row[0, :9], 2)[:9]
    assert square == pytest.approx([5.0, -2.0, 2.0, *([0.0] * 6)], abs=1e-14)


@pytest.mark.parametrize("excess", [1e-34, 1e-20, 1e-3, 0.5, 0.999999])
def test_a_piece_is_shortened_by_at_least_the_root_of_its_excess(excess):
    root = excess ** (1.0 / DEGREE)
    assert 0.9 * root <= shorter(excess) <= root


@pytest.mark.parametrize("excess", [1.0, 7.0, math.inf])
def test_a_piece_is_never_made_longer(excess):
    assert shorter(excess) == 1.0

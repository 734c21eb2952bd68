"""Numbers as intervals: exact if possible, otherwise containing the exact value, or undecided."""

from __future__ import annotations

import time
from fractions import Fraction

import pytest
from flint import arb, ctx

from ghostball.reference_adapters.certified.arithmetic import (
    OutOfTimeError,
    UndecidedError,
    check_time,
    computing_until,
    enclosure_of,
    exactly,
    length,
    unit,
    working_precision,
)


@pytest.mark.parametrize("value", [0.1, -(2.0**-1074), 1e300, 0.0])
def test_a_double_is_the_rational_that_it_is(value):
    assert Fraction(int(exactly(value).p), int(exactly(value).q)) == Fraction(value)
    assert enclosure_of(arb(value)).contains(value)
    assert enclosure_of(arb(value)).width == 0.0


@pytest.mark.parametrize("bits", [53, 300])
def test_lengths_and_directions_hold_the_true_ones(bits):
    before = ctx.prec
    with working_precision(bits):
        size, (x, y) = length(arb(1), arb(2)), unit(arb(1), arb(2), "which way")
        assert (size * size).contains(5)
        assert (x * x + y * y).contains(1)
        assert (5 * y * y).contains(4)
        assert float(size.rad()) < 2.0 ** (4 - bits)
    assert ctx.prec == before


def test_along_an_axis_they_are_exact():
    x = arb(0.1) / 3
    for size in (length(-x, arb(0)), length(arb(0), x)):
        assert (size.mid(), size.rad()) == (x.mid(), x.rad())
    assert unit(arb(0), -x, "which way") == (0, -1)


def test_a_vector_that_may_be_0_has_no_direction():
    blurred = arb(0, 1e-20)
    assert length(blurred, blurred).contains(0)
    for x, y in ((blurred, blurred), (blurred, arb(0)), (arb(0), arb(0))):
        with pytest.raises(UndecidedError, match="which way"):
            unit(x, y, "which way")


def test_computing_ends_at_its_deadline_and_the_one_around_it_holds_again():
    with computing_until(time.perf_counter() + 1e6):
        with computing_until(time.perf_counter() - 1.0), pytest.raises(OutOfTimeError):
            check_time()
        check_time()

"""The first entry of a gap is isolated or undecided, but never missed."""

from __future__ import annotations

import pytest
from flint import arb
from hypothesis import given, strategies as st
from mpmath import mpf, workdps
from oracle_roots import first_entry as oracle_entry

from ghostball.reference_adapters.certified.arithmetic import working_precision
from ghostball.reference_adapters.certified.roots import (
    NONE,
    ROOT,
    UNSURE,
    first_entry,
    first_entry_in_doubles,
    refined,
)

QUADRATIC = [2.0, -3.0, 1.0]  # (s - 1)(s - 2): entry at 1


def value_of(gap):
    return lambda s: sum((c * s**k for k, c in enumerate(gap)), arb(0))


def slope_of(gap):
    return lambda s: sum((k * c * s ** (k - 1) for k, c in enumerate(gap) if k), arb(0))


def padded(gap):
    return (*gap, *[0.0] * (5 - len(gap)))


@pytest.mark.parametrize("bits", [53, 106, 424])
def test_a_root_is_enclosed_to_the_precision_at_hand(bits):
    with working_precision(bits):
        gap = [arb(-2), arb(0), arb(1)]  # s^2 - 2, whose negative falls through 0
        gap = [-c for c in gap]
        found = first_entry(gap, arb(0.0), arb(3.0), bits)
        assert found.verdict == ROOT
        root = refined(value_of(gap), slope_of(gap), found.low, found.high)
        assert root is not None
        assert root.contains(arb(2).sqrt().mid()) or root.overlaps(arb(2).sqrt())
        assert float(root.rad()) < 2.0 ** (5 - bits)


def test_of_two_roots_the_entry_is_found_and_the_exit_is_not():
    with working_precision(106):
        gap = [arb(c) for c in QUADRATIC]
        found = first_entry(gap, arb(0.0), arb(10.0), 106)
        assert found.verdict == ROOT
        assert found.low <= 1.0 <= found.high < 2.0
        assert first_entry(gap, arb(0.0), arb(0.875), 106).verdict == NONE
        assert first_entry(gap, arb(2.125), arb(10.0), 106).verdict == NONE


@pytest.mark.parametrize("bits", [53, 212])
def test_a_double_root_stays_unsure(bits):
    with working_precision(bits):
        found = first_entry([arb(1), arb(-2), arb(1)], arb(0.0), arb(3.0), bits)  # (s - 1)^2
    assert found.verdict == UNSURE
    assert found.low <= 1.0
    # Before the bracket, an entry is excluded, as far as the precision resolves a square.
    assert 1.0 - float(found.low) < 2.0 ** (4 - bits / 2)


def test_nearly_a_double_root_is_decided_in_enough_precision():
    for sign, verdict in ((1, NONE), (-1, ROOT)):
        with working_precision(212):
            gap = [arb(1) + sign * arb((1, -60)), arb(-2), arb(1)]
            assert first_entry(gap, arb(0.0), arb(3.0), 212).verdict == verdict


def test_wide_coefficients_are_unsure_where_the_sign_is():
    with working_precision(106):
        gap = [arb(1, 0.25), arb(-1)]
        found = first_entry(gap, arb(0.0), arb(4.0), 106)
        # The root is somewhere in [0.75, 1.25], and is a single entry in any case.
        assert found.verdict == ROOT
        assert found.low <= 0.75
        assert found.high >= 1.25
        assert first_entry([arb(0, 0.25), arb(-1)], arb(0.0), arb(4.0), 106).verdict == UNSURE


@given(st.lists(st.floats(-10.0, 10.0), min_size=5, max_size=5), st.floats(0.1, 10.0))
def test_a_fast_search_never_contradicts_an_exact_one(gap, high):
    size = sum(abs(c) * high**k for k, c in enumerate(gap))
    gap[0] = abs(gap[0]) + 1e-3
    found = first_entry_in_doubles(gap, high, lambda s: 1e-10 * (size + 1.0))
    with workdps(50):
        exact = oracle_entry([mpf(c) for c in gap], mpf(high))
        if found.verdict == NONE:
            assert exact is None or abs(exact - high) < 1e-6
        elif found.verdict == ROOT:
            assert exact is not None
            assert float(found.low) <= exact <= float(found.high)
        elif exact is not None:
            assert float(found.low) <= exact
    with working_precision(212):
        proved = first_entry([arb(c) for c in gap], arb(0.0), arb(high), 212)
    if UNSURE not in (found.verdict, proved.verdict):
        assert found.verdict == proved.verdict


def test_fast_search_of_a_cushion():
    found = first_entry_in_doubles(padded(QUADRATIC), 10.0, lambda s: 1e-12)
    assert found.verdict == ROOT
    assert found.low <= 1.0 <= found.high < 2.0


def test_a_bracket_without_precision_gives_nothing():
    with working_precision(53):
        gap = [arb(1, 0.5), arb(-1, 0.999)]
        assert refined(value_of(gap), slope_of(gap), arb(0), arb(3)) is None

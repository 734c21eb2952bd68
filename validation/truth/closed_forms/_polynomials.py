"""Find the first sign change of a polynomial in multiprecision: the time at which a gap closes."""

from __future__ import annotations

from itertools import pairwise

from mpmath import mp, mpf

Polynomial = tuple[mpf, ...]
"""Coefficients, constant first."""


def first_fall_below_zero(polynomial: Polynomial, end: mpf, slack: mpf) -> mpf | None:
    """Return the point at which the polynomial first falls through 0 on [0, end], or None.

    Between consecutive roots of its derivative, a polynomial is monotone, so each such interval
    contains at most one root. Touching balls that approach are at the root already: the value at
    the start of the interval may be `slack` below 0.
    """
    edges = [mp.mpf(0), *_roots(_derivative(polynomial), mp.mpf(0), end), end]
    for low, high in pairwise(edges):
        at_low, at_high = _value(polynomial, low), _value(polynomial, high)
        if at_high < 0 and at_high < at_low and at_low > -slack:
            return _root(polynomial, low, high) if at_low > 0 else low
    return None


def _roots(polynomial: Polynomial, low: mpf, high: mpf) -> list[mpf]:
    """Return the sign changes of the polynomial between `low` and `high`, in order."""
    if len(polynomial) < 2:
        return []
    edges = [low, *_roots(_derivative(polynomial), low, high), high]
    return [
        _root(polynomial, a, b)
        for a, b in pairwise(edges)
        if (_value(polynomial, a) < 0) != (_value(polynomial, b) < 0)
    ]


def _root(polynomial: Polynomial, low: mpf, high: mpf) -> mpf:
    """Return the only sign change in [low, high], to the last digit.

    It uses Newton's step if this stays inside the bracket, else bisection; the bracket shrinks at
    each step. The error after a step is proportional to its square, so the search ends with a step
    that changes only the last quarter of the digits. Rounding may prevent shorter steps.
    """
    derivative = _derivative(polynomial)
    starts_below = _value(polynomial, low) < 0
    resolved = mp.eps**0.75
    at = (low + high) / 2
    for _ in range(mp.prec + 10):
        value, slope = _value(polynomial, at), _value(derivative, at)
        if (value < 0) == starts_below:
            low = at
        else:
            high = at
        step = value / slope if slope != 0 else mp.inf
        newer = at - step
        if abs(step) <= resolved * abs(at):
            return min(max(newer, low), high)
        if not low <= newer <= high:
            newer = (low + high) / 2
            if newer == at:
                return newer
        at = newer
    return at


def _value(polynomial: Polynomial, t: mpf) -> mpf:
    total = mp.mpf(0)
    for coefficient in reversed(polynomial):
        total = total * t + coefficient
    return total


def _derivative(polynomial: Polynomial) -> Polynomial:
    return tuple(k * coefficient for k, coefficient in enumerate(polynomial) if k > 0)

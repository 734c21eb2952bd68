"""Find the first sign change of a polynomial in multiprecision: the time at which a gap closes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from mpmath import mp, mpf

Polynomial = tuple[mpf, ...]
"""Coefficients, constant first."""

_MOST_STEPS: Final = 60
_RESOLVED: Final = 1e-12
"""Largest number of steps in double precision, and the relative step that ends them."""


def first_fall_below_zero(polynomial: Polynomial, end: mpf, slack: mpf) -> mpf | None:
    """Return the point at which the polynomial first falls through 0 on [0, end], or None.

    Between consecutive roots of its derivative, a polynomial is monotone, so each such interval
    contains at most one root. Touching balls that approach are at the root already: the value at
    the start of the interval may be `slack` below 0.
    """
    edges = [mp.mpf(0), *_roots(_derivative(polynomial), mp.mpf(0), end), end]
    values = [_value(polynomial, edge) for edge in edges]
    for (low, high), (at_low, at_high) in zip(pairwise(edges), pairwise(values), strict=True):
        if at_high < 0 and at_high < at_low and at_low > -slack:
            return _root(polynomial, low, high) if at_low > 0 else low
    return None


def _roots(polynomial: Polynomial, low: mpf, high: mpf) -> list[mpf]:
    """Return the sign changes of the polynomial between `low` and `high`, in order."""
    if len(polynomial) < 2:
        return []
    edges = [low, *_roots(_derivative(polynomial), low, high), high]
    below = [_value(polynomial, edge) < 0 for edge in edges]
    return [
        _root(polynomial, a, b)
        for (a, b), (at_a, at_b) in zip(pairwise(edges), pairwise(below), strict=True)
        if at_a != at_b
    ]


def _root(polynomial: Polynomial, low: mpf, high: mpf) -> mpf:
    """Return the only sign change in [low, high], to the last digit.

    The search starts at the sign change in double precision, which saves most of its steps. It uses
    Newton's step if this stays inside the bracket, else bisection; the bracket shrinks at each
    step. The error after a step is proportional to its square, so the search ends with a step that
    changes only the last quarter of the digits. Rounding may prevent shorter steps.
    """
    derivative = _derivative(polynomial)
    starts_below = _value(polynomial, low) < 0
    resolved = mp.eps**0.75
    rounded = [float(one) for one in polynomial]
    at = mp.mpf(_root_in_doubles(rounded, float(low), float(high), starts_below))
    if not low < at < high:
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


def _root_in_doubles(
    polynomial: Sequence[float], low: float, high: float, starts_below: bool
) -> float:
    """Return about the only sign change in [low, high]; any number if rounding hides it.

    The steps are those of `_root`.
    """
    at = 0.5 * (low + high)
    for _ in range(_MOST_STEPS):
        value = slope = 0.0
        for coefficient in reversed(polynomial):
            slope = slope * at + value
            value = value * at + coefficient
        if (value < 0.0) == starts_below:
            low = at
        else:
            high = at
        newer = at - value / slope if slope != 0.0 else math.inf
        if not low < newer < high:
            newer = 0.5 * (low + high)
        if abs(newer - at) <= _RESOLVED * abs(at):
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

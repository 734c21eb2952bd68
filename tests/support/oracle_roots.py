"""The oracle's root finder: when a polynomial in time falls below zero, in mpf.

Between two neighbouring stationary points a polynomial is monotone, so it has one root there or
none. The stationary points are found the same way, from the derivative's.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from mpmath import mpf

Polynomial = list[Any]
"""Coefficients from the constant up."""

CLOSE = mpf(2) ** -140
"""How close to a root Newton must have come, in widths of the bracket that it began from."""


def first_entry(gap: Polynomial, horizon: Any) -> Any | None:
    """Time in [0, horizon) at which `gap` goes from positive to negative, first; or None.

    Touching (or overlapping by rounding) and approaching is an entry now; touching and receding
    isn't, nor is touching without approach.
    """
    if gap[0] <= 0 and gap[1] < 0:
        return mpf(0)
    points = [mpf(0), *_sign_changes(_derivative(gap), horizon), horizon]
    for low, high in pairwise(points):
        if _value(gap, low) > 0 > _value(gap, high):
            return _root_between(gap, low, high)
    return None


def _sign_changes(p: Polynomial, horizon: Any) -> list[Any]:
    """Every point in (0, horizon) where `p` changes sign, in order."""
    if len(p) <= 1:
        return []
    points = [mpf(0), *_sign_changes(_derivative(p), horizon), horizon]
    roots = []
    for low, high in pairwise(points):
        at_low, at_high = _value(p, low), _value(p, high)
        if at_low * at_high < 0:
            roots.append(_root_between(p, low, high))
        elif at_low == 0 and low > 0:
            roots.append(low)
    return roots


def _root_between(p: Polynomial, low: Any, high: Any) -> Any:
    """Root of `p`, monotone from `low` to `high`: some halvings, then Newton doubles the digits.

    Eight halvings do where `p` changes its sign right around what Newton finds; elsewhere, as at a
    nearly double root, it takes 64.
    """
    rising = _value(p, high) > 0
    slope = _derivative(p)
    for halvings in (8, 56):
        for _ in range(halvings):
            middle = (low + high) / 2
            if (_value(p, middle) > 0) == rising:
                high = middle
            else:
                low = middle
        t = (low + high) / 2
        for _ in range(6):
            # Never out of the bracket: a nearly double root keeps the bisected digits.
            t = min(max(t - _value(p, t) / (_value(slope, t) or mpf(1)), low), high)
        around = (high - low) * CLOSE
        if _value(p, t - around) * _value(p, t + around) < 0:
            break
    return t


def _derivative(p: Polynomial) -> Polynomial:
    return [k * c for k, c in enumerate(p)][1:]


def _value(p: Polynomial, t: Any) -> Any:
    value = mpf(0)
    for c in reversed(p):
        value = value * t + c
    return value

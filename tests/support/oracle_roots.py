"""The oracle's root finder: the time at which a polynomial falls below zero, in mpf numbers.

Between two neighbouring stationary points a polynomial is monotonic, so it has at most one root
there. The stationary points are the roots of the derivative, found in the same way.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from mpmath import mpf

Polynomial = list[Any]
"""Coefficients, the constant first."""

CLOSE = mpf(2) ** -140
"""Distance from a root at which the sign must differ, relative to the bisected bracket."""


def first_entry(gap: Polynomial, horizon: Any) -> Any | None:
    """Return the first time in [0, horizon) at which `gap` becomes negative, or None.

    Bodies that touch (or overlap by rounding) and approach have an entry at 0. Bodies that touch
    and separate, or touch without approaching, have none at 0.
    """
    if gap[0] <= 0 and gap[1] < 0:
        return mpf(0)
    points = [mpf(0), *_sign_changes(_derivative(gap), horizon), horizon]
    for low, high in pairwise(points):
        if _value(gap, low) > 0 > _value(gap, high):
            return _root_between(gap, low, high)
    return None


def _sign_changes(p: Polynomial, horizon: Any) -> list[Any]:
    """Return all points in (0, horizon) at which `p` changes its sign, in order."""
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
    """Return the root of `p`, which is monotonic from `low` to `high`, by bisection and Newton.

    Eight bisections suffice if `p` changes its sign close to the result of Newton's method. At a
    nearly double root, 64 are needed.
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
            # Newton must stay in the bracket: at a nearly double root, the bisected digits stay.
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

"""Isolate the first time at which a gap closes, with proof.

A gap is a polynomial in time of degree 4 or less. In Bernstein form on an interval, its values lie
between its smallest and its largest coefficient, and its number of roots is at most the number of
sign changes of the coefficients (Descartes; Rouillier and Zimmermann 2004). So positive
coefficients exclude the interval, and + ... + - ... - isolates one root, which is an entry; any
other interval is divided. The same search runs in doubles, with a margin far above their errors,
and in interval arithmetic without a margin.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import comb
from typing import Any, NamedTuple

from flint import arb, arb_poly, ctx

from ghostball.reference_adapters.certified.arithmetic import ZERO

NONE = 0
"""The gap stays open."""
ROOT = 1
"""The gap closes exactly once within the bracket, and not before it."""
UNSURE = 2
"""The gap stays open up to the start of the bracket; after it, the search is undecided."""

_RATIOS = {
    n: tuple(tuple((comb(i, k), comb(n, k)) for k in range(i + 1)) for i in range(n + 1))
    for n in range(5)
}

_CUTS = (0.486, 0.523, 0.461)
"""Fractions at which an interval is divided; not 1/2, where scenes of simple numbers have roots.

A root at the end of an interval can't be isolated: it stays at an end after every division.
"""

_MOST_PIECES = 80
"""Number of intervals after which a search in doubles ends with UNSURE."""

_SMALL_STEP = 2.0**-30
"""Size of a Newton step, in units of the bracket, that leaves the bracket only by rounding."""

Margin = Callable[[float], float]


class Bracket(NamedTuple):
    """The result of a search: a verdict and its interval [s], with exact ends."""

    verdict: int
    low: arb
    high: arb


def first_entry_in_doubles(gap: Sequence[float], high: float, margin: Margin) -> Bracket:
    """Search in doubles for the first entry of a gap in [0, high].

    `gap`: coefficients, the constant first [m^2, m^2/s ...].
    `high`: end of the search [s].
    `margin`: error bound of a Bernstein coefficient on an interval that ends at a given time.
    """
    stack, pieces = [(0.0, high)], _MOST_PIECES
    while stack:
        start, end = stack.pop()
        allowed = margin(end)
        signs = _signs(_bernstein(gap, start, end), allowed)
        if signs == _ALL_POSITIVE:
            continue
        if signs == _ONE_ENTRY:
            return _bracket(ROOT, start, end)
        pieces -= 1
        if pieces <= 0:
            return _bracket(UNSURE, start, high)
        middle = start + _CUTS[0] * (end - start)
        stack.append((middle, end))
        stack.append((start, middle))
    return unreached(high)


def _bracket(verdict: int, low: float, high: float) -> Bracket:
    return Bracket(verdict, arb(low), arb(high))


def unsearched(high: float) -> Bracket:
    """Return the bracket of a search that wasn't performed."""
    return _bracket(UNSURE, 0.0, high)


def unreached(high: float) -> Bracket:
    """Return the bracket of a gap that certainly stays open."""
    return _bracket(NONE, high, high)


def first_entry(gap: Sequence[arb], low: arb, high: arb, bits: int) -> Bracket:
    """Search in interval arithmetic for the first entry of a gap in [low, high] [s], both exact.

    Contract: ends with UNSURE at intervals of 2^-`bits` of the first one.
    """
    gap = _trimmed(gap)
    ratios = _RATIOS[len(gap) - 1]
    stack = [(low, high)]
    narrow = ((high - low) * arb((1, -bits))).upper()
    while stack:
        start, end = stack.pop()
        signs = _signs(_bernstein_of_balls(gap, start, end, ratios), 0)
        if signs == _ALL_POSITIVE:
            continue
        if signs == _ONE_ENTRY:
            return Bracket(ROOT, start, end)
        middle = _cut(gap, start, end)
        if end - start <= narrow or not start < middle < end:
            return Bracket(UNSURE, start, high)
        stack.append((middle, end))
        stack.append((start, middle))
    return Bracket(NONE, high, high)


def _cut(gap: Sequence[arb], start: arb, end: arb) -> arb:
    """Return a time at which to divide an interval, not at a root."""
    middle, value = start, arb_poly(gap)
    for part in _CUTS:
        middle = (start + part * (end - start)).mid()
        if not value(middle).contains(0):
            break
    return middle


def refined(
    value: Callable[[arb], arb], slope: Callable[[arb], arb], low: arb, high: arb
) -> arb | None:
    """Enclose the single root in a bracket as precisely as possible.

    `value`, `slope`: a function with exactly one root in [low, high], where it decreases through 0,
        and its derivative; for an interval, the range.
    `low`, `high`: [s].

    Returns an interval [s]: the image of an interval under the interval Newton step, if the
    interval contains this image. Every function that the coefficients enclose then has exactly one
    root there.
    """
    start, end = low, high
    x = ((start + end) / 2).mid()
    for _ in range(400):
        at = value(x)
        if at > 0:
            start = x
        elif at < 0:
            end = x
        else:
            break  # x is a root to the present precision
        rate = slope(x)
        step = at / rate if rate < 0 else ZERO
        new = (x - step).mid()
        if not (rate < 0 and start < new < end):
            if rate < 0 and abs(step) < _SMALL_STEP * (end - start):
                break  # outside only by rounding
            new = ((start + end) / 2).mid()
            if not start < new < end:
                break
        x = new
    at, rate = value(x), slope(x)
    if not rate < 0:
        return None
    reach = (2 * abs(at / rate)).upper() + abs(x) * arb((1, -2 * ctx.prec))
    for _ in range(8):
        ball = arb(x, reach)
        rate = slope(ball)
        if not rate < 0:
            return None
        image = x - at / rate
        if ball.contains(image):
            # Only the root in the bracket is known to be the first.
            return image if low <= ball.lower() and ball.upper() <= high else None
        reach = 4 * reach
    return None


_ALL_POSITIVE = 1
_ONE_ENTRY = 2
_OPEN = 3


def _signs(coefficients: Sequence[Any], margin: float) -> int:
    """Classify coefficients: all positive, surely one change from + to -, or neither.

    One coefficient between the last positive and the first negative may have any sign.
    """
    count = len(coefficients)
    positive = 0
    while positive < count and coefficients[positive] > margin:
        positive += 1
    if positive == count:
        return _ALL_POSITIVE
    if positive == 0:
        return _OPEN
    rest = positive if coefficients[positive] < -margin else positive + 1
    if rest == count:
        return _OPEN
    for k in range(rest, count):
        if not coefficients[k] < -margin:
            return _OPEN
    return _ONE_ENTRY


def _bernstein(gap: Sequence[float], low: float, high: float) -> tuple[float, ...]:
    """Return the Bernstein coefficients of a polynomial of degree 4 on [low, high].

    Written without loops, because the function runs some hundred times for each event.
    """
    c0, c1, c2, c3, c4 = gap
    if low != 0.0:
        # In powers of (s - low), by repeated Horner schemes.
        d3 = c3 + low * c4
        d2 = c2 + low * d3
        d1 = c1 + low * d2
        c0 += low * d1
        e3 = d3 + low * c4
        e2 = d2 + low * e3
        c1 = d1 + low * e2
        f3 = e3 + low * c4
        c2 = e2 + low * f3
        c3 = f3 + low * c4
    width = high - low
    square = width * width
    c1 *= width
    c2 *= square
    c3 *= width * square
    c4 *= square * square
    return (
        c0,
        c0 + 0.25 * c1,
        c0 + 0.5 * c1 + c2 / 6.0,
        c0 + 0.75 * c1 + 0.5 * c2 + 0.25 * c3,
        c0 + c1 + c2 + c3 + c4,
    )


def _bernstein_of_balls(
    gap: Sequence[arb], low: arb, high: arb, ratios: Sequence[Sequence[tuple[int, int]]]
) -> list[arb]:
    """Return the Bernstein coefficients as intervals; quotients such as 1/6 aren't doubles."""
    shifted = _shifted(gap, low)
    width = high - low
    scale = arb(1)
    for k in range(1, len(shifted)):
        scale = scale * width
        shifted[k] = shifted[k] * scale
    coefficients = []
    for row in ratios:
        total = shifted[0]
        for (over, under), c in zip(row[1:], shifted[1:], strict=False):
            total = total + c * over / under
        coefficients.append(total)
    return coefficients


def _shifted(gap: Sequence[arb], by: arb) -> list[arb]:
    """Return the coefficients in powers of (s - by)."""
    shifted = list(gap)
    if not by.is_zero():
        degree = len(shifted) - 1
        for j in range(degree):
            for k in range(degree - 1, j - 1, -1):
                shifted[k] = shifted[k] + by * shifted[k + 1]
    return shifted


def _trimmed(gap: Sequence[arb]) -> Sequence[arb]:
    """Return the coefficients up to the highest that isn't exactly 0, for narrower intervals."""
    count = len(gap)
    while count > 1 and gap[count - 1].is_zero():
        count -= 1
    return gap[:count]

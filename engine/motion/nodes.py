"""Tables for pieces of a slide that are found at nodes (`motion.turn`): constants of the geometry.

A piece takes a slide until a part P of its slip is left, one of `PARTS`. What turns the slip's
direction is singular at the slide's end. With x the time in units of the piece's length, about
y = 1 - (1 - P) x is left of the slip, and

    sigma = (m - y) / (m + y),  m = sqrt(P),

takes [P, 1] to [-1 / rho, 1 / rho] and the end, y = 0, to 1: rho = (1 + m) / (1 - m), which is also
the sum of the half axes of the ellipse with foci at -1 and 1 through the end, [P, 1] taken to
[-1, 1] straight. So a polynomial of degree n in x errs like rho^-n, one in sigma like
(rho + sqrt(rho^2 - 1))^-n (Trefethen 2013, chapter 8): the motion is found at few nodes in sigma
(`NODES`), and then taken to more points in x (`POINTS`), from which come the powers of the time.

All is made of + - * / and square roots, of Python's numbers or of numpy's elementwise: the bits are
the same on every machine.
"""

from __future__ import annotations

import math

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.state import FloatArray

PARTS = (0.55, 0.4, 0.3, 0.22, 0.16, 0.12)
"""What is left of a slip at the end of a piece, in parts of it: the longest piece comes last."""

NODES = 16
"""At how many instants a motion is found: the first of them is where the piece begins."""

POINTS = st.NODES_TERMS
"""How many powers of the time a piece has beyond its acceleration at first, from as many points.

Shifted to the piece's beginning, powers of Chebyshev polynomials up to 19 have coefficients up to
2e14, all integers that doubles hold. What they multiply is as small as what the piece leaves out,
so that they lose no digits; of a few degrees more they would."""

_SAMPLES = 24
"""Of an integrand between two nodes: a rule that is exact for polynomials of as many terms."""

_HALF_PI = 1.5707963267948966


def _cosine(numerator: int, denominator: int) -> float:
    """Return the cosine of pi times a fraction between 0 and 2, by its power series."""
    numerator = min(numerator, 2 * denominator - numerator)
    if 2 * numerator > denominator:
        return -_cosine(denominator - numerator, denominator)
    x = 2.0 * _HALF_PI * numerator / denominator
    total = 0.0
    for n in range(24, 0, -2):
        total = (1.0 + total) * -(x * x) / (n * (n - 1))
    return 1.0 + total


def _grid() -> FloatArray:
    """Return the nodes in rho sigma: extrema of a Chebyshev polynomial, on [-1, 1]."""
    last = NODES - 1
    return np.array([-_cosine(j, last) for j in range(NODES)])


GRID = _grid()

POINT = np.array([0.5 - 0.5 * _cosine(2 * j + 1, 2 * POINTS) for j in range(POINTS)])
"""The points on [0, 1]: zeros of a Chebyshev polynomial, so that 0, where all is known, is none."""

OVER_POINT = 1.0 / POINT


def _lagrange(part: float, x: FloatArray) -> list[FloatArray]:
    """Return, by node, the polynomial in sigma that is 1 there and 0 at the others, at times x.

    By the barycentric formula (Berrut and Trefethen 2004, equations 4.2 and 5.4).
    """
    middle = math.sqrt(part)
    rho = (1.0 + middle) / (1.0 - middle)
    y = 1.0 - (1.0 - part) * x
    at = rho * (middle - y) / (middle + y)
    parts, total = [], np.zeros_like(x)
    for j in range(NODES):
        weight = (1.0 if j % 2 == 0 else -1.0) * (0.5 if j in (0, NODES - 1) else 1.0)
        parts.append(weight / (at - GRID[j]))
        total = total + parts[-1]
    return [one / total for one in parts]


def _times(part: float) -> FloatArray:
    """Return the times of the nodes, in units of the piece's length."""
    middle = math.sqrt(part)
    at = GRID * ((1.0 - middle) / (1.0 + middle))
    times = (1.0 - middle * (1.0 - at) / (1.0 + at)) / (1.0 - part)
    times[0], times[-1] = 0.0, 1.0
    return times


def _fejer() -> tuple[FloatArray, FloatArray]:
    """Return the samples on [0, 1] and the weights of Fejér's first rule (Waldvogel 2006, 2)."""
    n = _SAMPLES
    # Each cosine is asked for a dozen times.
    cosines = [_cosine(j, n) for j in range(2 * n)]
    samples, weights = np.zeros(n), np.zeros(n)
    for k in range(n):
        samples[k] = 0.5 - 0.5 * _cosine(2 * k + 1, 2 * n)
        weight = 1.0
        for j in range(1, n // 2 + 1):
            weight -= 2.0 * cosines[j * (2 * k + 1) % (2 * n)] / (4.0 * j * j - 1.0)
        weights[k] = weight / n
    return samples, weights


_SAMPLE, _WEIGHT = _fejer()


def _integrals(part: float) -> FloatArray:
    """Return (NODES, NODES): integrals of each node's polynomial from the beginning to each node.

    By `_fejer` between neighbours.
    """
    times = _times(part)
    lengths = times[1:] - times[:-1]
    at = times[:-1, None] + lengths[:, None] * _SAMPLE
    found = np.zeros((NODES, NODES))
    for i, values in enumerate(_lagrange(part, at)):
        total = np.zeros(NODES - 1)
        for k in range(_SAMPLES):
            total = total + _WEIGHT[k] * values[:, k]
        for j in range(1, NODES):
            found[i, j] = found[i, j - 1] + lengths[j - 1] * total[j - 1]
    return found


def _chebyshev_values() -> FloatArray:
    """Return (POINTS, POINTS): by point and degree, what takes values to Chebyshev coefficients."""
    cosines = [_cosine(turns, 2 * POINTS) for turns in range(4 * POINTS)]
    found = np.zeros((POINTS, POINTS))
    for j in range(POINTS):
        for n in range(POINTS):
            turns = n * (2 * (POINTS - 1 - j) + 1) % (4 * POINTS)
            found[j, n] = (1.0 if n == 0 else 2.0) / POINTS * cosines[turns]
    return found


def _chebyshev_powers() -> FloatArray:
    """Return (POINTS, POINTS): by degree and power, Chebyshev's polynomials of 2 x - 1.

    By T_{n+1} = (4 x - 2) T_n - T_{n-1}.
    """
    rows = [[1], [-1, 2]]
    while len(rows) < POINTS:
        one, before = rows[-1], rows[-2]
        row = [-2 * c for c in one] + [0]
        for power, c in enumerate(one):
            row[power + 1] += 4 * c
        for power, c in enumerate(before):
            row[power] -= c
        rows.append(row)
    found = np.zeros((POINTS, POINTS))
    for n, row in enumerate(rows):
        found[n, : len(row)] = row
    return found


def _rho(part: float) -> float:
    middle = math.sqrt(part)
    return (1.0 + middle) / (1.0 - middle)


def _steepest(part: float) -> float:
    """Return rho of the ellipse in sigma through where the slip ends."""
    rho = _rho(part)
    return rho + math.sqrt(rho * rho - 1.0)


def _falls_to(part: float) -> float:
    """Return rho^-POINTS."""
    power = 1.0
    for _ in range(POINTS):
        power /= _rho(part)
    return power


TIMES = np.array([_times(part) for part in PARTS])
INTEGRALS = np.array([_integrals(part) for part in PARTS])
"""By part, node and node."""


def _turned(part: int) -> FloatArray:
    """Return -log y at the nodes, over its rate at first."""
    total = np.zeros(NODES)
    for node in range(NODES):
        rate = 1.0 / (1.0 - TAKEN[part] * TIMES[part, node])
        total = total + rate * INTEGRALS[part, node]
    return total


TAKEN = np.array([1.0 - part for part in PARTS])

TURNED = np.array([_turned(part) for part in range(len(PARTS))])
"""By part and node, how far the slip's direction has about turned, in units of its rate at first
times the piece's length."""

TO_POINTS = np.array([np.array(_lagrange(part, POINT)) for part in PARTS])
"""By part, node and point: what takes values at the nodes to the points."""

TO_CHEBYSHEV = _chebyshev_values()
TO_POWERS = _chebyshev_powers()

SPAN = np.array([(1.0 - part) / math.sqrt(part) for part in PARTS])
"""No less than -log of what is left: as many times its rate does the slip's direction turn."""

FALLS_TO = np.array([_falls_to(part) for part in PARTS])
OVER_RHO = np.array([1.0 / _rho(part) for part in PARTS])
BEYOND = np.array([1.0 / (_rho(part) - 1.0) for part in PARTS])
"""rho^-1 + rho^-2 + ..., by part."""

BEYOND_NODES = np.array([1.0 / (_steepest(part) - 1.0) for part in PARTS])

BENDS = np.array([1.0 + 2.0 * n * n for n in range(POINTS)])
"""By degree n, what T_n(2 x - 1) may add to d/dx (x T_n): at most 1 + 2 n^2 on [0, 1]."""

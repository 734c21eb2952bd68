"""Whether two samples come from one distribution: energy distance, permutations, Holm's correction.

The energy distance of Székely and Rizzo (2013, J. Stat. Plan. Inference 143, 1249),

    E = 2 <|X - Y|> - <|X - X'|> - <|Y - Y'|>,

is 0 only where both distributions are the same, in any number of dimensions; on a line it is twice
the integral of the squared difference of the distribution functions. As a part of what it could be
at most, E / (2 <|X - Y|>), in [0, 1], it says how large a difference is, which a p-value doesn't:
with enough members every difference is significant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SEED = 20_130_801
"""Of the permutations: the same samples give the same p-values."""

CHANCE = 0.95
"""Part of the permutations that stay below `TwoSample.chance`."""

_AT_ONCE = 4_000_000
"""Numbers of the permutations that are held at once: 32 MB."""

_ROUNDING = 1e-12
"""Of the mean distance: two permutations that differ by less give the same value, rounded."""


@dataclass(frozen=True)
class TwoSample:
    """What two samples say of their distributions.

    Attributes
    ----------
    distance : float
        Energy distance, in the unit of the samples.
    effect : float [1]
        It as a part of 2 <|X - Y|>: 0 where the samples are the same, 1 where each is a point.
    chance : float [1]
        What `effect` stays below in 95 % of all ways to part the pooled samples: two samples of one
        distribution have an effect too.
    p : float
        Part of the ways to part the pooled samples that are as far apart as these, or farther. The
        samples themselves are one of the ways, so that it is never 0.
    """

    distance: float
    effect: float
    chance: float
    p: float


def distances(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the distance of each row of x from each row of y.

    Parameters
    ----------
    x, y : (n, d), (m, d) float64

    Returns
    -------
    (n, m) float64
    """
    # Dimension by dimension: all at once would need d times the memory, and |x|^2 - 2 x y + |y|^2
    # would leave rounding between equal points.
    squares = np.zeros((len(x), len(y)))
    for a, b in zip(x.T, y.T, strict=True):
        squares += np.subtract.outer(a, b) ** 2
    return np.asarray(np.sqrt(squares))


def two_sample_tests(
    samples: Sequence[tuple[FloatArray, FloatArray]], permutations: int
) -> list[TwoSample]:
    """Test for each pair of samples whether both come from one distribution.

    Parameters
    ----------
    samples : sequence of ((n, d), (m, d)) float64
        Several quantities of the same n and m members; d may differ between them.
    permutations : int
        Ways to part the pooled samples that are tried, beside the one that was observed.

    Notes
    -----
    The members are parted anew at random into n and m, each quantity in the same ways. The sums of
    distances are taken once, as a matrix D: for a choice c of n members, as a vector of 0 and 1,
    c D c is the sum within it, and row sums give the other two.

    Where x and y are paired, member by member, as those of two engines are, the pairing is not
    used: the question is whether the distributions differ, not whether any member does. Pairs that
    are alike make the samples more alike than independent ones are, and so p-values larger.
    """
    n, m = len(samples[0][0]), len(samples[0][1])
    pooled = [np.concatenate(pair) for pair in samples]
    matrices = [distances(both, both) for both in pooled]
    observed = np.zeros((1, n + m))
    observed[0, :n] = 1.0
    found: list[list[tuple[FloatArray, FloatArray]]] = [[_parted(d, observed)] for d in matrices]
    generator = np.random.Generator(np.random.PCG64(SEED))
    left = permutations
    while left > 0:
        count = min(left, max(1, _AT_ONCE // (n + m)))
        choices = np.zeros((count, n + m))
        chosen = np.argsort(generator.random((count, n + m)), axis=1)[:, :n]
        np.put_along_axis(choices, chosen, 1.0, axis=1)
        for parts, matrix in zip(found, matrices, strict=True):
            parts.append(_parted(matrix, choices))
        left -= count
    return [_tested(*map(np.concatenate, zip(*parts, strict=True))) for parts in found]


def _parted(matrix: FloatArray, choices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return energy distance and mean distance across for each choice of rows, each (k,)."""
    n = int(choices[0].sum())
    m = len(matrix) - n
    within = np.einsum("ij,ij->i", choices @ matrix, choices)
    rows = choices @ matrix.sum(axis=1)
    across = (rows - within) / (n * m)
    beyond = float(matrix.sum()) - 2.0 * rows + within
    return 2.0 * across - within / n**2 - beyond / m**2, across


def _tested(energy: FloatArray, across: FloatArray) -> TwoSample:
    """Return the test of the first value against the others."""
    noise = _ROUNDING * float(across.max())
    # How far equal samples are apart is up to how the machine's matrix products add: no distance.
    energy = np.where(energy > noise, energy, 0.0)
    effects = np.divide(energy, 2.0 * across, out=np.zeros_like(energy), where=across > 0.0)
    as_far = int(np.count_nonzero(energy >= energy[0] - noise))  # the first is one of them
    return TwoSample(
        distance=float(energy[0]),
        effect=float(effects[0]),
        chance=float(np.quantile(effects, CHANCE)),
        p=as_far / len(energy),
    )


def smallest_p(n: int, m: int) -> float:
    """Return the least p-value that samples of n and m can have, however many permutations.

    Exchanging equally large samples changes nothing, so that the observed way to part them then
    counts twice.
    """
    return (2 if n == m else 1) / math.comb(n + m, n)


def holm(p: Sequence[float]) -> list[float]:
    """Return p-values corrected for their number, in their order.

    Source: S. Holm (1979), Scand. J. Statist. 6, 65. Where all below some level are rejected, the
    chance of any false rejection is at most that level, however the tests depend on each other.
    """
    order = sorted(range(len(p)), key=lambda k: p[k])
    corrected, largest = [0.0] * len(p), 0.0
    for rank, k in enumerate(order):
        largest = max(largest, min(1.0, (len(p) - rank) * p[k]))
        corrected[k] = largest
    return corrected

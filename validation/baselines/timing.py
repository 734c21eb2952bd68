"""Run times of two revisions that ran by turns: slower only where there is no doubt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median
from typing import Final

from ghostball.validation.baselines.regression import TimeChange, Timing

ROUNDS: Final = 15
"""Samples of a scene: each by turns with all others, so that a slow moment hits all."""

RUNS: Final = 5
"""Runs whose median is one sample: a run takes some ten microseconds."""

SLOWER: Final = 1.2
"""A scene that takes so many times as long is slower.

Two processes that run the same code differ by up to a tenth, for memory lies elsewhere in each.
"""


def median_interval(values: Sequence[float], confidence: float = 0.95) -> tuple[float, float]:
    """Return the interval that holds the median of what `values` are samples of, so surely.

    By order statistics (Conover 1999, section 3.2), whatever the distribution; (-inf, inf) where
    there are too few samples to be as sure.
    """
    ordered, n = sorted(values), len(values)
    tail, rank = 0.0, 0
    while rank < (n + 1) // 2:
        tail += math.comb(n, rank) / 2.0**n
        if 2.0 * tail > 1.0 - confidence:
            break
        rank += 1
    if rank == 0:
        return -math.inf, math.inf
    return ordered[rank - 1], ordered[n - rank]


def timing_of(samples: Sequence[float]) -> Timing:
    """Return what samples of a run time came to; the interval of a few is their range."""
    low, high = median_interval(samples)
    return Timing(
        median=median(samples),
        low=max(low, min(samples)),
        high=min(high, max(samples)),
        samples=len(samples),
    )


def compare_samples(base: Sequence[float], head: Sequence[float]) -> TimeChange:
    """Compare run times that two revisions took by turns: samples of one round are a pair."""
    ratios = [b / a for a, b in zip(base, head, strict=True)]
    low, high = median_interval(ratios, 0.999)
    ratio = median(ratios)
    slower = low > SLOWER
    return TimeChange(
        base=timing_of(base),
        head=timing_of(head),
        ratio=ratio,
        ratio_low=max(low, min(ratios)),
        ratio_high=min(high, max(ratios)),
        slower=slower,
        words=f"{ratio:.2f} times as slow, {low:.2f} at least" if slower else "",
    )

"""What a ladder of steps converges to, how fast, and how sure that is."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

ORDERS = np.linspace(0.2, 4.5, 431)
"""Orders that are tried."""

FEWEST_LEVELS = 4
"""Levels without which nothing is extrapolated: a fit of three has nothing left to be judged by."""

FLAT = 1e-8
"""Changes along a ladder below which the step doesn't matter [m].

A landed step ends within 1e-10 m of a contact, of which a shot makes up to a hundred times as much;
1e5 steps of 1e-16 m of rounding make 1e-11 m.
"""

FLAT_PART = 0.01
"""The same as a part of what is left of the difference at the finest step."""

FALL = 0.5
"""Largest part of the error at the first step that the last one, or the uncertainty, may have."""

Outcome = Literal["fitted", "flat", "not converged"]


@dataclass(frozen=True, eq=False)
class Extrapolation:
    """What a ladder says of zero step.

    Attributes
    ----------
    outcome : "fitted", "flat" or "not converged"
        Flat: the step doesn't matter.
    limit : (n, 2) float64 [m]
        Positions at zero step; of no meaning where it is not converged.
    uncertainty : float [m]
        By how much the limit of any ball changes when a level or a start phase is left out, or may
        change with all start phases between those that were run.
    order : float or None [1]
        As fitted; None where flat.
    order_low, order_high : float or None [1]
        Its range over the same changes.
    order_used : float or None [1]
        What the limit was taken with: the nearest whole order within that range, else the order as
        fitted.
    """

    outcome: Outcome
    limit: FloatArray
    uncertainty: float
    order: float | None = None
    order_low: float | None = None
    order_high: float | None = None
    order_used: float | None = None


def largest_distance(a: FloatArray, b: FloatArray) -> float:
    """Return the largest distance of a ball between two states (n, 2) [m]."""
    return float(np.max(np.hypot(*(a - b).T)))


def extrapolate(
    steps: Sequence[float], states: Sequence[FloatArray], truth: FloatArray
) -> Extrapolation:
    """Extrapolate states to zero step.

    Parameters
    ----------
    steps : sequence of float [s]
        Of each level, falling.
    states : sequence of (p, n, 2) float64 [m]
        Of each level, from p start phases, none of them empty.
    truth : (n, 2) float64 [m]
        True positions; they decide nothing but whether changes are too small to matter.

    Notes
    -----
    x(h) = limit + slope h^order, one order for all coordinates, by least squares. The mean of the
    start phases stands for a level: p phases spread evenly over a step leave of a sawtooth of
    height c h at most c h / 2p, so levels are weighed by 1 / h. The order is fitted first, and its
    range found by leaving out each level, and each start phase of every level. Errors of steps
    grow in whole powers of the step, so where the range holds such an order the limit is taken
    with the nearest, by linear least squares; else with the fitted one. The uncertainty is the
    larger of the range that is seen over the same changes, and of what the start phases may leave
    in all levels together; it has no Gaussian meaning.
    """
    if len(steps) < FEWEST_LEVELS:
        return Extrapolation("not converged", states[-1][0], math.inf)
    everything = np.concatenate(states)
    mean = everything.mean(axis=0)
    spread = max(largest_distance(one, mean) for one in everything)
    if spread <= max(FLAT, FLAT_PART * largest_distance(mean, truth)):
        return Extrapolation("flat", mean, spread)
    h = np.array(steps)
    shape = mean.shape
    means = np.array([level.mean(axis=0).ravel() for level in states])
    variants = list(_variants(h, states, means))
    order = _best_order(h, means)
    orders = [order, *(_best_order(*variant) for variant in variants)]
    low, high = min(orders), max(orders)
    whole = max(1.0, round(order))
    used = whole if low <= whole <= high else order
    limit = _limit(h, means, used).reshape(shape)
    uncertainty = max(
        _left_by_phases(h, states, used),
        *(largest_distance(limit, _limit(*variant, used).reshape(shape)) for variant in variants),
    )
    first, last = (max(largest_distance(one, limit) for one in states[k]) for k in (0, -1))
    converged = max(uncertainty, last) <= FALL * first
    return Extrapolation(
        "fitted" if converged else "not converged", limit, uncertainty, order, low, high, used
    )


def _variants(
    h: FloatArray, states: Sequence[FloatArray], means: FloatArray
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the ladder without one level, and without one start phase of every level."""
    for left_out in range(len(h)):
        keep = np.arange(len(h)) != left_out
        yield h[keep], means[keep]
    for phase in range(max(len(level) for level in states)):
        rows = []
        for level in states:
            kept = np.delete(level, phase % len(level), axis=0) if len(level) > 1 else level
            rows.append(kept.mean(axis=0).ravel())
        yield h, np.array(rows)


def _best_order(h: FloatArray, means: FloatArray) -> float:
    """Return the order that leaves the smallest residual of means (k, m)."""
    residuals = [_solve(h, means, order)[1] for order in ORDERS]
    return float(ORDERS[int(np.argmin(residuals))])


def _limit(h: FloatArray, means: FloatArray, order: float) -> FloatArray:
    return _solve(h, means, order)[0]


def _left_by_phases(h: FloatArray, states: Sequence[FloatArray], order: float) -> float:
    """Return by how much the limit may be off where each level is by what its phases leave [m].

    That is the range of its states over twice their number; a level with one phase has the range
    of the one before, in proportion to the step.
    """
    left, width = [], 0.0
    for k, level in enumerate(states):
        if len(level) > 1:
            width = max(largest_distance(a, b) for a in level for b in level) / h[k]
        left.append(width * h[k] / (2.0 * len(level)))
    # The limit is linear in the means: what each of them counts is that of a unit change of it.
    counts = [_limit(h, unit[:, np.newaxis], order)[0] for unit in np.eye(len(h))]
    return float(np.abs(counts) @ np.array(left))


def _solve(h: FloatArray, means: FloatArray, order: float) -> tuple[FloatArray, float]:
    """Return the limit (m,) of the best fit with an order, and its weighed residual."""
    weights = (h[-1] / h)[:, np.newaxis]
    # About the finest level: of positions about a metre, changes of a nanometre must be left.
    target = weights * (means - means[-1])
    design = weights * np.column_stack((np.ones_like(h), (h / h[0]) ** order))
    solution, *_ = np.linalg.lstsq(design, target, rcond=None)
    return means[-1] + solution[0], float(np.sum((target - design @ solution) ** 2))

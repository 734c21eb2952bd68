"""What a ladder of steps converges to, how fast, and how sure that is."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.validation.diagnose.attribution import largest_distance

FloatArray = NDArray[np.float64]

ORDERS = np.round(np.linspace(0.2, 4.5, 431), 2)
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

WHOLE_ORDERS = (1.0, 2.0, 3.0, 4.0)

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
        By how much the limit of any ball may be off; see `extrapolate`.
    order : float or None [1]
        As fitted; None where flat.
    order_low, order_high : float or None [1]
        The range of those that fit as well as the start phases let it be known.
    order_used : float or None [1]
        What the limit was taken with: the lowest whole order within that range, else the order as
        fitted.
    """

    outcome: Outcome
    limit: FloatArray
    uncertainty: float
    order: float | None = None
    order_low: float | None = None
    order_high: float | None = None
    order_used: float | None = None


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
    height c h at most c h / 2p, so levels are weighed by p / h. The order is fitted; its range is
    that of all orders that leave no more at any level than the phases may. Errors of steps grow in
    whole powers of the step, and contacts that are seen late make them grow in the first, so the
    limit is taken with the lowest whole order of that range, by linear least squares; where it has
    none, with the fitted one. The uncertainty is the largest of what the phases may leave in all
    levels together, of the range of the limit over the whole orders in that of the order and the
    one nearest to it, and of that over leaving out a level; it has no Gaussian meaning. Where a
    shot has many collisions, their lateness adds up to no single sawtooth, and it may be too small.
    """
    if len(steps) < FEWEST_LEVELS:
        return Extrapolation("not converged", states[-1][0], math.inf)
    everything = np.concatenate(states)
    mean = everything.mean(axis=0)
    spread = max(largest_distance(one, mean) for one in everything)
    if spread <= max(FLAT, FLAT_PART * largest_distance(mean, truth)):
        return Extrapolation("flat", mean, spread)
    ladder = _Ladder.of(steps, states)
    order = _best_order(ladder)
    possible = [float(p) for p in ORDERS if _explains(ladder, float(p))]
    low, high = min([order, *possible]), max([order, *possible])
    used = next((p for p in WHOLE_ORDERS if low <= p <= high), order)
    shape = mean.shape
    limit = _limit(ladder, used)
    nearest = min(WHOLE_ORDERS, key=lambda p: abs(p - order))
    others = [_limit(ladder, p) for p in WHOLE_ORDERS if low <= p <= high or p == nearest]
    others += [_limit(one, used) for one in _without_a_level(ladder)]
    uncertainty = max(
        _left_by_phases(ladder, used),
        *(largest_distance(one.reshape(shape), limit.reshape(shape)) for one in others),
    )
    limit = limit.reshape(shape)
    first, last = (max(largest_distance(one, limit) for one in states[k]) for k in (0, -1))
    converged = max(uncertainty, last) <= FALL * first
    return Extrapolation(
        "fitted" if converged else "not converged", limit, uncertainty, order, low, high, used
    )


@dataclass(frozen=True, eq=False)
class _Ladder:
    """Levels: steps (k,), means (k, m), start phases (k,), how far off these leave them (k,)."""

    h: FloatArray
    means: FloatArray
    phases: FloatArray
    left: FloatArray

    @classmethod
    def of(cls, steps: Sequence[float], states: Sequence[FloatArray]) -> _Ladder:
        """Make it of states (p, n, 2) at each step."""
        left, height = [], 0.0  # of the sawtooth, over the step
        for h, level in zip(steps, states, strict=True):
            p = len(level)
            if p > 1:
                # p phases, evenly spread, are a p-th of a sawtooth short of its whole height.
                seen = max(largest_distance(a, b) for a in level for b in level)
                height = seen * p / (p - 1) / h
            left.append(height * h / (2.0 * p))
        return cls(
            np.array(steps),
            np.array([level.mean(axis=0).ravel() for level in states]),
            np.array([float(len(level)) for level in states]),
            np.array(left),
        )

    def of_units(self) -> _Ladder:
        """Return one whose solution says how much each level counts in that of this one."""
        return _Ladder(self.h, np.eye(len(self.h)), self.phases, self.left)


def _without_a_level(ladder: _Ladder) -> Iterator[_Ladder]:
    for left_out in range(len(ladder.h)):
        keep = np.arange(len(ladder.h)) != left_out
        yield _Ladder(ladder.h[keep], ladder.means[keep], ladder.phases[keep], ladder.left[keep])


def _best_order(ladder: _Ladder) -> float:
    """Return the order that leaves the smallest residual."""
    residuals = [float(np.sum(_solve(ladder, order)[1] ** 2)) for order in ORDERS]
    return float(ORDERS[int(np.argmin(residuals))])


def _explains(ladder: _Ladder, order: float) -> bool:
    """Whether a fit with an order leaves at every level no more than the start phases may leave."""
    _, residual = _solve(ladder, order)
    distances = np.hypot(residual[:, 0::2], residual[:, 1::2]).max(axis=1)
    # The residual is linear in the means, too, and what the phases leave there is bounded.
    _, counts = _solve(ladder.of_units(), order)
    return bool(np.all(distances <= np.abs(counts) @ ladder.left))


def _limit(ladder: _Ladder, order: float) -> FloatArray:
    return _solve(ladder, order)[0]


def _left_by_phases(ladder: _Ladder, order: float) -> float:
    """Return by how much the limit may be off where each level is by what its phases leave [m]."""
    return float(np.abs(_limit(ladder.of_units(), order)) @ ladder.left)


def _solve(ladder: _Ladder, order: float) -> tuple[FloatArray, FloatArray]:
    """Return the limit (m,) of the best fit with an order, and its weighed residual (k, m)."""
    weights = ladder.phases / ladder.h
    w = (weights / weights[-1])[:, np.newaxis]
    # About the finest level: of positions about a metre, changes of a nanometre must be left.
    target = w * (ladder.means - ladder.means[-1])
    design = w * np.column_stack((np.ones_like(ladder.h), (ladder.h / ladder.h[0]) ** order))
    solution, *_ = np.linalg.lstsq(design, target, rcond=None)
    residual: FloatArray = target - design @ solution
    return ladder.means[-1] + solution[0], residual

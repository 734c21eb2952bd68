"""Decisions of a fit by its misfit: between cushion laws, and over heights of the cushion nose."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Final

import numpy as np

from ghostball.model.impact_laws import LawEntry
from ghostball.validation.measured.fit.fields import own_fields
from ghostball.validation.measured.fit.least_squares import Field, Solution, goodness

LARGEST_CORRELATION: Final = 0.95
"""Correlation above which two values can't be distinguished: one compensates for the other."""
_DISTINCT_DEVIATIONS = 2.0
"""Standard deviations by which a law must fit worse to count as worse than the best one."""
_MOST_SPREADS = 2
"""Range of the tested nose heights, in standard deviations from the mean."""
_HOPELESS_MISFIT = 5.0
"""Misfit difference from the best height above which no further height is tested in this direction.
"""
MOST_HEIGHTS: Final = 2 * _MOST_SPREADS + 1
"""Largest number of tested nose heights."""


def solutions_around(
    first: int, near: Solution, solve: Callable[[int, Solution], Solution]
) -> dict[int, Solution]:
    """Return solutions for several heights of the nose, in the form for `mean_of`.

    `first`: the first height, in standard deviations from the mean; further heights on both sides
        follow, until one fits much worse.
    `near`: start of the first search.
    `solve`: solves for a height, starting at another solution.
    """
    first = min(max(first, -_MOST_SPREADS), _MOST_SPREADS)
    tried: dict[int, Solution] = {}
    for spreads in (range(first, _MOST_SPREADS + 1), range(first - 1, -_MOST_SPREADS - 1, -1)):
        last = tried.get(first, near)
        for each in spreads:
            last = tried[each] = solve(each, last)
            least = min(one.misfit for one in tried.values())
            worse = (last.misfit - least) / max(goodness([last]), 1.0)
            if worse + each**2 > _HOPELESS_MISFIT:
                break
    return tried


def mean_of(tried: Mapping[int, Solution]) -> tuple[Solution, float, int]:
    """Return the mean of solutions for several values of an assumed quantity.

    `tried`: by the deviation of the value from its mean, in standard deviations, in steps of one.
        Each solution is weighted by its probability, and values between two neighbours are taken
        into account.

    Returns the mean solution; the mean deviation of the value, in standard deviations; and the
    deviation of the best fit.
    """
    order = sorted(tried)
    solutions = [tried[each] for each in order]
    misfits = np.array([one.misfit for one in solutions])
    misfits /= max(min(goodness([one]) for one in solutions), 1.0)
    weights = np.exp(-0.5 * (misfits - np.min(misfits) + np.array(order) ** 2))
    weights /= np.sum(weights)
    values = np.array([one.values for one in solutions])
    mean = weights @ values
    slopes = np.gradient(values, axis=0) if len(order) > 1 else np.zeros_like(values)
    covariance = np.zeros_like(solutions[0].covariance)
    for weight, one, off, slope in zip(weights, solutions, values - mean, slopes, strict=True):
        between = np.outer(off, off) + np.outer(slope, slope) / 12.0
        covariance += weight * (one.covariance + between)
    best = int(np.argmax(weights))
    found = replace(solutions[best], values=mean, covariance=covariance)
    return found, float(weights @ order), order[best]


def pairs_alike(fields: Sequence[Field], solution: Solution) -> list[tuple[str, str]]:
    """Return the pairs of fields that can't be distinguished: one compensates for the other."""
    errors = solution.errors
    scale = np.where((errors > 0.0) & np.isfinite(errors), errors, 1.0)
    correlation = solution.covariance / np.outer(scale, scale)
    return [
        (fields[i].name, fields[j].name)
        for i, j in combinations(range(len(fields)), 2)
        if abs(correlation[i, j]) >= LARGEST_CORRELATION
    ]


def laws_alike(solutions: dict[str, Solution]) -> list[str]:
    """Return the laws that the contacts can't distinguish, the best one first.

    A law is worse than the best one if its misfit is larger by more than twice the variation from
    contact to contact (Vuong 1989).
    """
    misfits = {name: one.misfits for name, one in solutions.items()}
    order = sorted(misfits, key=lambda name: float(np.sum(misfits[name])))
    best = misfits[order[0]]
    alike = [order[0]]
    for name in order[1:]:
        worse = misfits[name] - best
        if np.sum(worse) <= _DISTINCT_DEVIATIONS * np.sqrt(len(worse)) * np.std(worse):
            alike.append(name)
    return alike


def moves_by_law(
    laws: Sequence[LawEntry],
    fields: Sequence[Field],
    solutions: dict[str, Solution],
    chosen: str,
    alike: Sequence[str],
) -> dict[str, float]:
    """Return the largest change of each value under any other law that fits equally well."""
    values = {
        law.name: by_name(own_fields(law, fields), solutions[law.name])
        for law in laws
        if law.name in alike
    }
    return {
        name: max(abs(other[name] - value) for other in values.values() if name in other)
        for name, value in values[chosen].items()
    }


def by_name(fields: Sequence[Field], solution: Solution) -> dict[str, float]:
    """Return the values of a solution by the names of their fields."""
    return dict(zip([one.name for one in fields], map(float, solution.values), strict=True))

"""The result of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ghostball.model import Physics
from ghostball.validation.measured.fit.events import FitEvent
from ghostball.validation.measured.fit.least_squares import Assumed, Solution, goodness

Assumptions = dict[str, Assumed]
"""Assumptions about fields that aren't fitted, by name."""


@dataclass(frozen=True)
class Fit:
    """The fitted physics, and the uncertainty of each fitted value."""

    physics: Physics
    errors: dict[str, float]
    """The standard error of each fitted field."""
    solutions: dict[str, Solution]
    """The solution for each family of events."""
    families: dict[str, Sequence[FitEvent]]
    """The fitted events, by family."""
    counts: dict[str, int]
    """Number of clean events in each family, including those with too few for a fit."""
    noise: float  # of a coordinate of a sample [m]
    laws: dict[str, float]
    """The goodness of each tested cushion law; empty if the law was given."""
    laws_alike: list[str]
    """Laws that the tracks can't distinguish from the best one, including it."""
    not_told_apart: list[tuple[str, str]]
    not_told: dict[str, str]
    """Fields that the tracks don't determine, and why."""
    assumed: Assumptions
    """Fields that affect the events but aren't fitted. The errors include their spread."""
    ends: list[str]
    """Fields with a best value at a limit of their range."""

    @property
    def goodness(self) -> float:
        """The misfit for each degree of freedom: 1 if only noise is left."""
        return goodness(list(self.solutions.values()))

    @property
    def unsettled(self) -> list[str]:
        """The families whose search did not converge."""
        return [name for name, one in self.solutions.items() if not one.settled]

"""What a fit found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ghostball.model import Physics
from ghostball.validation.measured.fit.events import Event
from ghostball.validation.measured.fit.least_squares import Assumed, Solution, goodness

Assumptions = dict[str, Assumed]
"""What is assumed of fields that aren't fitted, by their names."""


@dataclass(frozen=True)
class Fit:
    """What was found: the physics, and how sure each fitted value of it is."""

    physics: Physics
    errors: dict[str, float]
    """The standard error of each fitted field."""
    solutions: dict[str, Solution]
    """What was found of each family of events."""
    families: dict[str, Sequence[Event]]
    """The events that were fitted, by what they are."""
    counts: dict[str, int]
    """How many clean events there were of each family, those too few for a fit as well."""
    noise: float  # of the tracks, of a coordinate of a sample [m]
    laws: dict[str, float]
    """The goodness of each law of cushions that was tried; none where one was given."""
    laws_alike: list[str]
    """Those of them that the tracks don't tell from the best, with it."""
    not_told_apart: list[tuple[str, str]]
    not_told: dict[str, str]
    """Fields that the tracks tell nothing about, and why."""
    assumed: Assumptions
    """Fields that affect the events but aren't fitted. The errors allow for their spread."""
    ends: list[str]
    """Fields whose best value is the end of what is allowed."""

    @property
    def goodness(self) -> float:
        """The misfit for each number seen more than fitted: 1 where only noise is left."""
        return goodness(list(self.solutions.values()))

    @property
    def unsettled(self) -> list[str]:
        """The families whose search did not end at the best values."""
        return [name for name, one in self.solutions.items() if not one.settled]

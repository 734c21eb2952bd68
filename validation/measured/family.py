"""Figures of one kind, measured and played: how far an engine is off, or what it lacks."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, Field, model_validator

from ghostball.validation.measured.facts import Facts, Row


class Measured(BaseModel, frozen=True, allow_inf_nan=False):
    """One figure that was measured, and what a model makes of it.

    `error`: one standard error of the measurement and of the spread of tables together; None where
    neither is known. `what` says of what the figure is, where a family has several at one place.
    """

    at: float
    value: float
    error: Annotated[float, Field(gt=0.0)] | None
    played: float
    what: str = ""

    @classmethod
    def of(cls, row: Row, played: float) -> Self:
        """Return what a row of the facts says, and what a model makes of it."""
        return cls(at=row.place, value=row.value, error=row.uncertainty, played=played)

    @property
    def difference(self) -> float:
        """How far the model is above the measurement, in the figure's unit."""
        return self.played - self.value

    @property
    def errors_off(self) -> float:
        """How many standard errors the model is above the measurement.

        Raises `ValueError` where none is known.
        """
        if self.error is None:
            raise ValueError("this measurement has no standard error, only a `difference`")
        return self.difference / self.error


class Family(BaseModel, frozen=True):
    """Figures of one kind; or why an engine has none of them.

    `grades`: whether an error of each is known; where it isn't, there is a typical difference and
    nothing else to go by. `failed`: whether there are none because the engine crashed, hung or
    raised.
    """

    name: str
    short: str
    title: str
    quantity: str
    unit: str
    against: str
    citation: str
    conditions: str = ""
    grades: bool = True
    settings: dict[str, str | float] = {}
    figures: tuple[Measured, ...] = ()
    lacks: str = ""
    failed: bool = False

    @property
    def typical(self) -> float:
        """The root of the mean square of how many standard errors the figures are off.

        Raises `ValueError` where the family doesn't grade.
        """
        return float(np.sqrt(np.mean([one.errors_off**2 for one in self.figures])))

    @property
    def most(self) -> float:
        """How many standard errors the worst of them is off.

        Raises `ValueError` where the family doesn't grade.
        """
        return max(abs(one.errors_off) for one in self.figures)

    @property
    def typical_difference(self) -> float:
        """The root of the mean square of how far the figures are off, in their unit."""
        return float(np.sqrt(np.mean([one.difference**2 for one in self.figures])))

    def lacking(self, why: str, *, failed: bool = False) -> Family:
        """Return it without figures, and why: the engine lacks something, or it failed."""
        return self.model_copy(update={"lacks": why, "failed": failed})


class Likeness(BaseModel, frozen=True):
    """What one engine makes of all that was measured."""

    label: str
    families: tuple[Family, ...]

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        for one in self.families:
            if bool(one.figures) == bool(one.lacks):
                raise ValueError(
                    f"family {one.name!r}: must have either `figures` or, in `lacks`, the reason "
                    "why it has none"
                )
            if one.grades and any(figure.error is None for figure in one.figures):
                raise ValueError(
                    f"family {one.name!r}: where it `grades`, each of its `figures` must have an "
                    "`error`, got null. Give it, or set `grades` to false"
                )
        return self

    @property
    def graded(self) -> tuple[Family, ...]:
        """The families that count in what is said of the engine as a whole."""
        return tuple(family for family in self.families if family.grades)

    @property
    def typical(self) -> float | None:
        """The largest of what its graded families are typically off; None where it has none."""
        return max((one.typical for one in self.graded if not one.lacks), default=None)


def families_in(facts: Facts) -> list[Family]:
    """Return the families of facts without figures: they say what the facts say, or their own."""
    shared = facts.model_dump(include={*Family.model_fields})
    return [
        Family.model_validate(shared | heading.model_dump(exclude_none=True))
        for heading in facts.families
    ]

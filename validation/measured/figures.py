"""Measured figures of one kind with the values of an engine, or the reason why it has none."""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, Field, model_validator

from ghostball.validation.measured.facts import FactRow, Facts


class ComparedFigure(BaseModel, frozen=True, allow_inf_nan=False):
    """One measured figure, and the value of a model.

    `error`: standard error of the measurement, the spread of tables and the uncertainty of measured
        inputs together (u_val of ASME V&V 20); None if all are unknown.
    `played`: the value of the model.
    `what`: describes the figure, if a family has several for one value of `against`.
    """

    at: float
    value: float
    error: Annotated[float, Field(gt=0.0)] | None
    played: float
    what: str = ""

    @classmethod
    def of(cls, row: FactRow, played: float) -> Self:
        """Return the figure of a row of the facts, with the value of a model."""
        return cls(at=row.place, value=row.value, error=row.uncertainty, played=played)

    @property
    def difference(self) -> float:
        """Value of the model minus the measured value, in the figure's unit."""
        return self.played - self.value

    @property
    def errors_off(self) -> float:
        """Value of the model minus the measured value, in standard errors.

        Raises `ValueError` if no error is known.
        """
        if self.error is None:
            raise ValueError("this measurement has no standard error, only a `difference`")
        return self.difference / self.error


class FigureFamily(BaseModel, frozen=True):
    """Figures of one kind; or why an engine has none.

    `grades`: whether the error of each figure is known; otherwise only differences can be given.
    `lacks`: why there are no figures; else "".
    `failed`: whether there are none because the engine crashed, hung or raised.
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
    figures: tuple[ComparedFigure, ...] = ()
    lacks: str = ""
    failed: bool = False

    @property
    def typical(self) -> float:
        """The rms difference of the figures, in standard errors.

        Raises `ValueError` if errors are unknown.
        """
        return float(np.sqrt(np.mean([one.errors_off**2 for one in self.figures])))

    @property
    def most(self) -> float:
        """The largest difference of a figure, in standard errors.

        Raises `ValueError` if errors are unknown.
        """
        return max(abs(one.errors_off) for one in self.figures)

    @property
    def is_within_known(self) -> bool | None:
        """Whether no figure is off by more than two standard errors; None if errors are unknown."""
        if not self.figures or any(one.error is None for one in self.figures):
            return None
        return self.most <= 2.0

    @property
    def typical_difference(self) -> float:
        """The rms difference of the figures, in their unit."""
        return float(np.sqrt(np.mean([one.difference**2 for one in self.figures])))

    def lacking(self, why: str, *, failed: bool = False) -> FigureFamily:
        """Return the family without figures, and why: the engine lacks a feature, or it failed."""
        return self.model_copy(update={"lacks": why, "failed": failed})


class TableAgreement(BaseModel, frozen=True):
    """The agreement of one engine with all measurements."""

    label: str
    families: tuple[FigureFamily, ...]

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
                    f"family {one.name!r}: if it `grades`, each of its `figures` must have an "
                    "`error`, got null. Give it, or set `grades` to false"
                )
        return self

    @property
    def graded(self) -> tuple[FigureFamily, ...]:
        """The families that count for the engine as a whole: those with known errors."""
        return tuple(family for family in self.families if family.grades)

    @property
    def typical(self) -> float | None:
        """The largest typical difference of its graded families; None if it has none."""
        return max((one.typical for one in self.graded if not one.lacks), default=None)


def families_in(facts: Facts) -> list[FigureFamily]:
    """Return the families of facts without figures, with the fields of the facts or their own."""
    shared = facts.model_dump(include={*FigureFamily.model_fields})
    return [
        FigureFamily.model_validate(shared | heading.model_dump(exclude_none=True))
        for heading in facts.families
    ]

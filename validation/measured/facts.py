"""Tables of measured facts: binned values with their errors, conditions and citation."""

from __future__ import annotations

import math
import tomllib
from importlib.resources import files
from statistics import mean, stdev
from typing import Any, Self

from pydantic import BaseModel, Field, ValidationError, model_validator

from ghostball.model import GhostballError


class FactsError(GhostballError):
    """A table of facts with invalid content."""


class QuantityAndUnit(BaseModel, frozen=True, extra="forbid"):
    """A quantity and its unit."""

    quantity: str
    unit: str


class Heading(BaseModel, frozen=True, extra="forbid"):
    """The heading of a family of figures; fields given here replace those of its facts."""

    name: str
    short: str
    title: str | None = None
    quantity: str | None = None
    unit: str | None = None
    against: str | None = None


class FactRow(BaseModel, frozen=True, extra="forbid"):
    """One figure: for the range from `low` to `high`, with the mean `at`; or for the number `at`.

    If several tables were measured, `of_each` holds the figure of each; `value` is their mean, and
    `spread` their standard deviation.

    If events were counted, `count` of `of` is a share; `value` is this share, and `error` its
    binomial standard error. The error is that of the share (count + 1/2) / (of + 1), because the
    usual formula gives 0 for a count of 0 (Brown, Cai and DasGupta 2001, Stat. Sci. 16, 101).
    """

    what: str = Field(default="", description="what was measured, if rows differ in it")
    value: float
    error: float | None = Field(default=None, gt=0.0, description="one standard error")
    spread: float | None = Field(
        default=None, gt=0.0, description="one standard deviation from table to table"
    )
    inputs: float | None = Field(
        default=None,
        gt=0.0,
        description="standard uncertainty of a simulated value, from inputs that aren't known",
    )
    of_each: tuple[float, ...] = ()
    count: int | None = None
    of: int | None = None
    without_scratch: bool = Field(
        default=False, description="whether breaks that pocket the cue ball don't count"
    )
    at: float | None = None
    low: float | None = None
    high: float | None = None
    given: dict[str, float] = {}
    also: dict[str, float] = {}

    @model_validator(mode="before")
    @classmethod
    def _of_tables(cls, data: Any) -> Any:
        """Compute mean and standard deviation over several tables."""
        if not isinstance(data, dict) or "of_each" not in data:
            return data
        each = data["of_each"]
        if "value" in data or "spread" in data:
            raise ValueError("`value` and `spread` follow from `of_each`: remove them")
        if not isinstance(each, list) or len(each) < 2 or not all(map(_is_number, each)):
            raise ValueError("`of_each` must be a list of two numbers or more")
        return {**data, "value": mean(each), "spread": stdev(each)}

    @model_validator(mode="before")
    @classmethod
    def _of_counts(cls, data: Any) -> Any:
        """Compute a share and its error from counts."""
        if not isinstance(data, dict) or not {"count", "of"} & data.keys():
            return data
        count, of = data.get("count"), data.get("of")
        if "value" in data or "error" in data:
            raise ValueError("`value` and `error` follow from `count` and `of`: remove them")
        if type(count) is not int or type(of) is not int or not 0 <= count <= of or of == 0:
            raise ValueError("`count` and `of` must be whole numbers, 0 <= count <= of, of > 0")
        return {**data, "value": count / of, "error": binomial_error(count, of)}

    @model_validator(mode="after")
    def _is_somewhere(self) -> Self:
        low, high, at = self.low, self.high, self.at
        if (low is None) != (high is None) or (low is None and at is None):
            raise ValueError("a row needs `at`, or `low` and `high`")
        if low is not None and high is not None and not low <= (low if at is None else at) < high:
            raise ValueError("a row needs `low` below `high`, and `at` between them")
        return self

    @property
    def place(self) -> float:
        """The value of `against` for the figure: the mean if known, else the range's centre."""
        if self.at is not None:
            return self.at
        assert self.low is not None
        assert self.high is not None
        return (self.low + self.high) / 2.0

    @property
    def uncertainty(self) -> float | None:
        """Combined standard error of measurement, spread and inputs; None: unknown."""
        known = [one for one in (self.error, self.spread, self.inputs) if one is not None]
        return math.hypot(*known) if known else None


def binomial_error(count: int, of: int) -> float:
    """Return the standard error of the share `count` / `of`, see `FactRow`."""
    share = (count + 0.5) / (of + 1)
    return math.sqrt(share * (1.0 - share) / of)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


class Facts(BaseModel, frozen=True, extra="forbid"):
    """The results of one measurement, row by row.

    `against`: the quantity of `at`, `low` and `high`.
    `given`: further conditions of each row; `also`: further results of each row, without an error.
    `tables`: names of the tables in `of_each`.
    `families`: the families of figures for the comparison of engines.
    `grades`: whether engines may be judged by the figures; otherwise `conditions` states why not.
    """

    title: str
    quantity: str
    unit: str
    against: str
    given: dict[str, str] = {}
    also: dict[str, QuantityAndUnit] = {}
    tables: tuple[str, ...] = ()
    families: tuple[Heading, ...] = ()
    citation: str = Field(min_length=20)
    conditions: str = Field(min_length=20)
    grades: bool
    rows: tuple[FactRow, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _rows_are_whole(self) -> Self:
        for name in ("given", "also"):
            wanted = set(getattr(self, name))
            if any(set(getattr(row, name)) != wanted for row in self.rows):
                raise ValueError(f"each row must give exactly the quantities that `{name}` lists")
        if any(len(row.of_each) != len(self.tables) for row in self.rows):
            raise ValueError("each row must give in `of_each` one figure for each of the `tables`")
        return self

    @model_validator(mode="after")
    def _grades_by_errors(self) -> Self:
        if self.grades and any(row.uncertainty is None for row in self.rows):
            raise ValueError("facts that grade need the `error` of each row, or several `tables`")
        if self.grades and self.also:
            raise ValueError("facts that grade have no `also`: it has no errors")
        return self


def names_of_facts() -> list[str]:
    """Return the names of all tables of facts."""
    folder = files("ghostball.validation.measured") / "facts"
    return sorted(
        file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml")
    )


def facts_of(name: str) -> Facts:
    """Return the table of facts with a name.

    Raises `FactsError` if there is none.
    """
    known = names_of_facts()
    if name not in known:
        raise FactsError(f'no facts called "{name}". Known facts: {", ".join(known)}')
    file = files("ghostball.validation.measured") / "facts" / f"{name}.toml"
    return parsed(file.read_text(encoding="utf-8"), f"{name}.toml")


def parsed(text: str, name: str) -> Facts:
    """Return the content of the text of a table.

    Raises `FactsError` with the file, the field and the rule, if it is invalid.
    """
    try:
        return Facts.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise FactsError(f"{name}: not TOML: {error}") from error
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "the table"
        raise FactsError(f"{name}: {place}: {first['msg']}") from error

"""Tables of measured facts: binned figures with their errors, conditions and citation."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from ghostball.model import GhostballError


class FactsError(GhostballError):
    """A table of facts that isn't there, or that says something else than it must."""


class Row(BaseModel):
    """One figure: of all that lies from `low` to `high`, on average `at`; or at one number."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    value: float
    error: float | None = Field(default=None, gt=0.0, description="one standard error")
    at: float | None = None
    low: float | None = None
    high: float | None = None

    @model_validator(mode="after")
    def _is_somewhere(self) -> Self:
        low, high, at = self.low, self.high, self.at
        if (low is None) != (high is None) or (low is None and at is None):
            raise ValueError("a row needs `at`, or `low` and `high`")
        if low is not None and high is not None and not low <= (low if at is None else at) < high:
            raise ValueError("a row needs `low` below `high`, and `at` between them")
        return self


class Hit(BaseModel):
    """A rolling ball hits one at rest: speeds [m/s], and angles from the way it came [degrees].

    The speeds and angles of both balls afterwards are those once they roll.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    speed: float = Field(gt=0.0)
    cut: float = Field(ge=0.0, lt=90.0)
    cue_speed: float = Field(ge=0.0)
    object_speed: float = Field(gt=0.0)
    cue_angle: float = Field(ge=0.0, le=180.0)
    object_angle: float = Field(ge=0.0, lt=90.0)


class Hits(BaseModel):
    """Hits that were measured, without errors, so that no engine may be judged by them."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str
    citation: str = Field(min_length=20)
    conditions: str = Field(min_length=20)
    grades: Literal[False]
    rows: tuple[Hit, ...] = Field(min_length=1)


class Facts(BaseModel):
    """What one measurement found, row by row.

    `against` says what `at`, `low` and `high` are. Only where `grades` is true may an engine be
    judged by the figures; elsewhere `conditions` says why not.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str
    quantity: str
    unit: str
    against: str
    citation: str = Field(min_length=20)
    conditions: str = Field(min_length=20)
    grades: bool
    rows: tuple[Row, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _grades_by_errors(self) -> Self:
        if self.grades and any(row.error is None for row in self.rows):
            raise ValueError("facts that grade need the `error` of each row")
        return self


_Kind = TypeVar("_Kind", Facts, Hits)


def names_of_facts() -> list[str]:
    """Return the names of all tables."""
    folder = files("ghostball.validation.measured") / "facts"
    return sorted(
        file.name.removesuffix(".toml") for file in folder.iterdir() if file.name.endswith(".toml")
    )


def facts_of(name: str) -> Facts:
    """Return the table of this name.

    Raises `FactsError` where there is none, or it is one of hits.
    """
    return parsed(_text(name), f"{name}.toml", Facts)


def hits_of(name: str) -> Hits:
    """Return the table of hits of this name.

    Raises `FactsError` where there is none, or it is none of hits.
    """
    return parsed(_text(name), f"{name}.toml", Hits)


def _text(name: str) -> str:
    known = names_of_facts()
    if name not in known:
        raise FactsError(f'no facts called "{name}"; there are {", ".join(known)}')
    file = files("ghostball.validation.measured") / "facts" / f"{name}.toml"
    return file.read_text(encoding="utf-8")


def parsed(text: str, name: str, kind: type[_Kind]) -> _Kind:
    """Return what the text of a table says.

    Raises `FactsError`, which names the file, the field and the rule, where it isn't one.
    """
    try:
        return kind.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise FactsError(f"{name}: not TOML: {error}") from error
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "the table"
        raise FactsError(f"{name}: {place}: {first['msg']}") from error

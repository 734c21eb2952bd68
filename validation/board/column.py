"""The columns of the board, as TOML lists them: each a question, its scenes, a metric, thresholds.

One has no scenes: it stands beside what is right, and tells how like a real table an engine can be.
`columns.toml` has those that distinguish engines, `reported.toml` the faults that people reported.
"""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Final, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    Field,
    ValidationError,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)

from ghostball.model import GhostballError
from ghostball.model.text_files import read_text
from ghostball.validation.checks.criterion import MetricName, Number, Sentence
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.results.files import describe_validation_error, toml_of
from ghostball.validation.results.records import AccuracyKind

FOLDER: Final = Path(str(files("ghostball.validation.board")))
"""Where the lists of columns lie, and in scenes/ what they play."""

ACCURACY: Final = "accuracy"
"""The metric of a column that shows the class of each run."""

LIKENESS: Final = "likeness"
"""What a column shows, in place of a metric, that tells how far off real tables an engine is."""


_OF_THE_START: Final = {"fastest": "m/s", "widest": "degrees"}
"""Picks that show a number of the scene's start in place of a metric, and its unit."""


def scene_path(name: str) -> Path:
    """Return the file of a scene of the board."""
    return FOLDER / "scenes" / f"{name}.toml"


def _known_scene(name: str) -> str:
    if scene_path(name).is_file():
        return name
    known = [path.stem for path in FOLDER.glob("scenes/*.toml")]
    close = get_close_matches(name, known, n=1)
    hint = f"Did you mean {close[0]!r}?" if close else f"Put a file {name}.toml there"
    raise ValueError(f"must be a scene of {scene_path(name).parent}, got {name!r}. {hint}")


def _metric_or_likeness(name: object, metric: ValidatorFunctionWrapHandler) -> str:
    return LIKENESS if name == LIKENESS else str(metric(name))


class _Model(BaseModel, frozen=True, extra="forbid", allow_inf_nan=False):
    """A part of a list of columns: no other fields than its own are read."""


class Settings(_Model):
    """What an engine is given, where it has it: a step [s], where steps end, or both."""

    step: Annotated[float, Field(gt=0.0)] | None = None
    contact_steps: Literal["fixed", "exact"] | None = None


class Column(_Model):
    """A column; `columns.toml` says what each field is."""

    id: Annotated[str, Field(pattern=r"^[a-z0-9-]+$")]
    title: Sentence
    question: Sentence
    metric: Annotated[MetricName, WrapValidator(_metric_or_likeness)]
    scenes: tuple[Annotated[str, AfterValidator(_known_scene)], ...] = ()
    settings: tuple[Settings, ...] = ()
    required: bool = False
    pick: Literal["worst", "least", "fastest", "widest"] = "worst"
    within: AccuracyKind | None = None
    above: Number | None = None
    good: Number | None = None
    fair: Number | None = None
    laws: Mapping[str, tuple[float, ...]] = Field(default_factory=dict)
    replay: bool = True
    thread: (
        Annotated[str, Field(pattern=r"^https://github\.com/[\w.-]+/[\w.-]+/(issues|pull)/\d+$")]
        | None
    ) = None
    cause: str = ""
    cure: str = ""

    @property
    def unit(self) -> str:
        """The unit of what it shows; "" for a pure number."""
        if self.metric == LIKENESS:
            return "standard errors"
        if self.pick in _OF_THE_START:
            return _OF_THE_START[self.pick]
        unit = "m" if self.metric == ACCURACY else METRICS[self.metric].unit
        return "" if unit == "1" else unit

    @model_validator(mode="after")
    def _belongs_together(self) -> Self:
        if self.metric == LIKENESS:
            given = self.model_dump(exclude_defaults=True).keys()
            if more := sorted(given - {"id", "title", "question", "metric"}):
                raise ValueError(
                    f"column {self.id!r}: metric {LIKENESS!r} must have no `{more[0]}`: it plays "
                    "what was measured on real tables, and nothing of it is right. Leave it out"
                )
            return self
        if not self.scenes:
            raise ValueError(
                f"column {self.id!r}: `scenes` must name at least one, got none. Name a file of "
                f"{FOLDER / 'scenes'}"
            )
        limits = (self.good, self.fair) != (None, None)
        if self.metric == ACCURACY and (limits or self.pick not in ("worst", "widest")):
            raise ValueError(
                f"column {self.id!r}: metric 'accuracy' must have no `good`, `fair` or `pick`, but "
                '"widest": its classes are those of every run. Leave them out'
            )
        if self.pick == "widest" and self.metric != ACCURACY:
            raise ValueError(
                f"column {self.id!r}: `pick` = 'widest' must have the metric 'accuracy', got "
                f"{self.metric!r}: what counts is whether a shot is right. Set it"
            )
        if self.metric != ACCURACY and self.good is None:
            raise ValueError(
                f"column {self.id!r}: `good` must be given, up to which {self.metric!r} is right"
            )
        if self.good is not None and self.fair is not None and self.fair < self.good:
            raise ValueError(
                f"column {self.id!r}: `fair` must be at least `good`, got {self.fair!r} below "
                f"{self.good!r}. Swap them"
            )
        for field, picks in (("within", ("least", "widest")), ("above", ("fastest",))):
            if (getattr(self, field) is None) == (self.pick in picks):
                raise ValueError(
                    f"column {self.id!r}: `{field}` and `pick` = {' or '.join(map(repr, picks))} "
                    "must come together"
                )
        return self


class _Columns(_Model):
    column: tuple[Column, ...]

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        names = [one.id for one in self.column]
        if repeated := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"`id` must differ, got {', '.join(repeated)} again. Rename one")
        return self


def load_columns(path: Path) -> dict[str, Column]:
    """Read a list of columns, by their ids.

    Raises `GhostballError` where it can't be read, is no TOML, or breaks a rule.
    """
    try:
        found = _Columns.model_validate(toml_of(read_text(path)))
    except ValidationError as error:
        raise GhostballError(f"{path}: {describe_validation_error(error)}") from None
    except (OSError, ValueError) as error:
        raise GhostballError(f"{path}: can't read the columns: {error}. Mend it there") from None
    return {one.id: one for one in found.column}


QUESTIONS: Final = load_columns(FOLDER / "columns.toml")
"""What distinguishes engines, in the order of the board."""

FAULTS: Final = load_columns(FOLDER / "reported.toml")
"""What people reported of engines, by the repository and the number of the thread."""

COLUMNS: Final = {**QUESTIONS, **FAULTS}
"""All of them, by the names that `--column` takes."""

"""Pass criteria: what each engine must reach in a scene, beside the scene, with the reason.

    truth = "closed-form"            # or "certified", "engine"; left out: the first there is

    [[criteria]]
    engines = ["ghostball"]          # "pymunk" is any pymunk; "pymunk:mode=landed" only such ones
    metric  = "rest_error_max"
    at_most = 1e-13                  # or at_least, or equals
    reason  = "what a few roundings of a 2.5 m table leave"

Where several criteria on a metric cover an engine, those whose selector states the most settings
win, and replace the others.

What holds for every scene is in `scenes/common.expect.toml`; a scene's own criterion on a metric
replaces that for the engines that it covers.
"""

from __future__ import annotations

import tomllib
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    AfterValidator,
    AllowInfNan,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    Strict,
    ValidationError,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ghostball.engine import GhostballError
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.registry import parse_spec
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.results.records import Check, LimitKind
from ghostball.validation.scenes.library import FOLDER
from ghostball.validation.truth.scene_truth import WantedTruth

SUFFIX = ".expect.toml"
"""Ending of a criteria file's name: `break-16.toml` has its criteria in `break-16.expect.toml`."""

COMMON = FOLDER / f"common{SUFFIX}"
"""The criteria of every scene."""

LIMIT_KINDS: tuple[LimitKind, ...] = ("at_most", "at_least", "equals")


class CriteriaError(GhostballError, ValueError):
    """A criteria file that breaks a rule, or criteria that contradict each other."""


class Selector(BaseModel):
    """Which engines a criterion covers: a name, and settings that must have these values."""

    model_config = ConfigDict(frozen=True)

    engine: str
    settings: tuple[tuple[str, str], ...] = ()

    @classmethod
    def parse(cls, text: object) -> Selector:
        """Read `NAME` or `NAME:key=value,...`."""
        if isinstance(text, Selector):
            return text
        if not isinstance(text, str):
            raise PydanticCustomError("selector", "must be an engine's name in quotes")
        try:
            name, settings = parse_spec(text)
        except EngineError as error:
            raise PydanticCustomError("selector", "{why}", {"why": str(error)}) from None
        return cls(engine=name, settings=tuple(sorted(settings.items())))

    def __str__(self) -> str:
        pairs = ",".join(f"{key}={value}" for key, value in self.settings)
        return f"{self.engine}:{pairs}" if pairs else self.engine

    def covers(self, engine: str, settings: Mapping[str, Any]) -> bool:
        """Whether an engine with these effective settings is meant.

        Raises
        ------
        CriteriaError
            Where the engine has no such setting: the selector could never match.
        """
        if engine != self.engine:
            return False
        for key, _ in self.settings:
            if key not in settings:
                raise CriteriaError(
                    f"`engines`: `{self}` names the setting `{key}`, which engine `{engine}` "
                    f"lacks. Its settings: {', '.join(settings) or 'none'}"
                )
        return all(_same(settings[key], text) for key, text in self.settings)


def _known_metric(name: str) -> str:
    if name not in METRICS:
        close = get_close_matches(name, METRICS, n=1)
        hint = f"did you mean `{close[0]}`?" if close else f"known: {', '.join(METRICS)}"
        raise PydanticCustomError("metric", "is not a known metric; {hint}", {"hint": hint})
    return name


Number = Annotated[int, Strict()] | Annotated[float, Strict(), AllowInfNan(False)]
Sentence = Annotated[str, Strict(), Field(pattern=r"\S")]


class Criterion(BaseModel):
    """One limit on one metric for the engines that it covers.

    `if_measured` criteria are judged only where the metric has a value; where it has none, the
    record says why, and nothing passes; but a run that stops early, or whose value isn't finite,
    fails them. Without it, no value is a failure. A `past_horizon` criterion judges
    how a shot ends also where the engine can't be expected to predict that.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    engines: Annotated[
        tuple[Annotated[Selector, BeforeValidator(Selector.parse)], ...], Field(min_length=1)
    ]
    metric: Annotated[str, Strict(), AfterValidator(_known_metric)]
    at_most: Number | None = None
    at_least: Number | None = None
    equals: Number | None = None
    if_measured: Annotated[bool, Strict()] = False
    past_horizon: Annotated[bool, Strict()] = False
    reason: Sentence

    @model_validator(mode="after")
    def _one_limit(self) -> Self:
        given = [kind for kind in LIMIT_KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            raise PydanticCustomError(
                "limit",
                "must give exactly one of `at_most`, `at_least` and `equals`, got {given}",
                {"given": " and ".join(f"`{kind}`" for kind in given) or "none of them"},
            )
        return self

    @property
    def limit_kind(self) -> LimitKind:
        """Which of the three limits is given."""
        return next(kind for kind in LIMIT_KINDS if getattr(self, kind) is not None)

    @property
    def limit(self) -> int | float:
        """The limit, in the unit of the metric."""
        limit: int | float = getattr(self, self.limit_kind)
        return limit

    def allows(self, value: int | float) -> bool:
        """Whether `value` keeps the limit; nan never does."""
        if self.limit_kind == "at_most":
            return value <= self.limit
        if self.limit_kind == "at_least":
            return value >= self.limit
        return value == self.limit

    def check(self, value: int | float | None, note: str = "", *, reference: bool = False) -> Check:
        """Judge a measured value.

        A value that could not be computed fails: a criterion that nothing can violate guards
        nothing. With `reference` there is no verdict, for the value compares truth with itself.
        """
        passed: bool | None = value is not None and self.allows(value)
        if reference:
            passed, note = None, "our engine is the truth here: compared with itself"
        return Check(
            metric=self.metric,
            value=value,
            limit_kind=self.limit_kind,
            limit=self.limit,
            unit=METRICS[self.metric].unit,
            passed=passed,
            reason=self.reason,
            note=note,
        )


class Criteria(BaseModel):
    """All criteria of a scene, and which truth it is measured against.

    A scene that states its `truth` must be proved to its end where it can be proved at all, or for
    as many events as it states in `proved`: what a proof doesn't say isn't judged.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    truth: WantedTruth | None = None
    proved: Annotated[int, Field(strict=True, ge=0)] | None = None
    criteria: tuple[Criterion, ...] = ()

    @property
    def least_proved(self) -> int | None:
        """Events that must be proved of the scene; None: all, to its end."""
        return 0 if self.truth is None and self.proved is None else self.proved

    @model_validator(mode="after")
    def _no_repetition(self) -> Self:
        seen: set[tuple[Selector, str, LimitKind]] = set()
        for i, criterion in enumerate(self.criteria):
            for selector in criterion.engines:
                key = (selector, criterion.metric, criterion.limit_kind)
                if key in seen:
                    raise PydanticCustomError(
                        "repeated",
                        "`criteria[{i}]` repeats `{limit}` on `{metric}` for `{selector}`. "
                        "Remove one of the two",
                        {
                            "i": i,
                            "limit": criterion.limit_kind,
                            "metric": criterion.metric,
                            "selector": str(selector),
                        },
                    )
                seen.add(key)
        return self

    @classmethod
    def load(cls, path: str | Path) -> Criteria:
        """Read a criteria file.

        Raises
        ------
        CriteriaError
            Where it can't be read, isn't TOML, or breaks a rule.
        """
        source = Path(path)
        try:
            data = tomllib.loads(source.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            raise CriteriaError(f"{source}: can't read the criteria: {error}") from None
        except tomllib.TOMLDecodeError as error:
            raise CriteriaError(f"{source}: not valid TOML: {error}. Mend it there") from None
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            raise CriteriaError(_describe(error, source)) from None

    def applying_to(self, engine: str, settings: Mapping[str, Any]) -> tuple[Criterion, ...]:
        """Return the criteria that hold for an engine with these effective settings.

        Raises
        ------
        CriteriaError
            Where two selectors, equally specific, set the same kind of limit on a metric.
        """
        covering: dict[str, list[tuple[int, Criterion]]] = defaultdict(list)
        for criterion in self.criteria:
            matching = [s for s in criterion.engines if s.covers(engine, settings)]
            if matching:
                stated = max(len(selector.settings) for selector in matching)
                covering[criterion.metric].append((stated, criterion))
        chosen: list[Criterion] = []
        for metric, found in covering.items():
            most = max(stated for stated, _ in found)
            winners = [criterion for stated, criterion in found if stated == most]
            kinds = [criterion.limit_kind for criterion in winners]
            if len(set(kinds)) < len(kinds):
                raise CriteriaError(
                    f"two criteria on `{metric}`, equally specific, cover engine `{engine}` with "
                    f"settings {dict(settings)}. State one more setting in one of them"
                )
            chosen.extend(winners)
        return tuple(chosen)

    def over_common(
        self, common: Criteria, engine: str, settings: Mapping[str, Any]
    ) -> tuple[Criterion, ...]:
        """Return the criteria that hold for an engine, with the common ones on other metrics.

        Raises
        ------
        CriteriaError
            As `applying_to`.
        """
        own = self.applying_to(engine, settings)
        limited = {criterion.metric for criterion in own}
        others = common.applying_to(engine, settings)
        return own + tuple(other for other in others if other.metric not in limited)

    def check_engines(self, known: Iterable[str], source: str) -> None:
        """Make sure that every selector names an installed engine: a typo would check nothing.

        Raises
        ------
        CriteriaError
        """
        names = tuple(known)
        for i, criterion in enumerate(self.criteria):
            for selector in criterion.engines:
                if selector.engine not in names:
                    close = get_close_matches(selector.engine, names, n=1)
                    hint = f"Did you mean `{close[0]}`? " if close else ""
                    raise CriteriaError(
                        f"{source}: `criteria[{i}].engines` must name installed engines, got "
                        f'"{selector}". {hint}Known engines: {", ".join(names)}'
                    )


@cache
def common_criteria() -> Criteria:
    """Return the criteria of every scene."""
    return Criteria.load(COMMON)


def criteria_beside(scene_path: str | Path) -> Criteria:
    """Return the criteria that lie beside a scene file; none where there is no such file.

    Raises
    ------
    CriteriaError
        Where there is a file and it is refused.
    """
    path = Path(scene_path)
    beside = path.with_name(path.name.removesuffix(".toml") + SUFFIX)
    return Criteria.load(beside) if beside.exists() else Criteria()


def _same(value: Any, text: str) -> bool:
    """Whether a setting's value is what `text` spells: 0.001 is "1e-3", True is "true"."""
    if isinstance(value, bool):
        return text.lower() == str(value).lower()
    if isinstance(value, int | float):
        try:
            return float(text) == float(value)
        except ValueError:
            return False
    return text == str(value)


def _describe(error: ValidationError, source: Path) -> str:
    return "\n".join(f"{source}: {_sentence(problem)}" for problem in _one_per_field(error))


def _one_per_field(error: ValidationError) -> Sequence[Mapping[str, Any]]:
    fields: dict[str, Mapping[str, Any]] = {}
    for problem in error.errors():  # both branches of a number report the same field
        fields.setdefault(_field_of(problem), problem)
    return list(fields.values())


def _field_of(problem: Mapping[str, Any]) -> str:
    name = ""
    for part in problem["loc"]:
        if isinstance(part, int):
            name += f"[{part}]"
        elif part not in ("int", "float"):
            name += f".{part}" if name else part
    return name


def _sentence(problem: Mapping[str, Any]) -> str:
    field, kind = _field_of(problem), problem["type"]
    if kind == "extra_forbidden":
        model = Criterion if "." in field else Criteria
        return f"`{field}` is not a known field. Known here: {', '.join(model.model_fields)}"
    if kind == "missing":
        return f"`{field}` must be given"
    if kind == "string_pattern_mismatch":
        return f"`{field}` must say why the limit is what it is, got {problem['input']!r}"
    message = str(problem["msg"]).replace("Input should", "must", 1)
    if kind in ("limit", "repeated"):
        return f"`{field}` {message}" if field else message
    return f"`{field}` {message}, got {problem['input']!r}"

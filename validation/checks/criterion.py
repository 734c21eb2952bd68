"""One limit on one metric, one rule by which limits are computed, and whom they hold for."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import Annotated, Any, Final, Literal, Self, get_args

from pydantic import (
    AfterValidator,
    AllowInfNan,
    BaseModel,
    BeforeValidator,
    Field,
    Strict,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ghostball.model import EventKind, GhostballError
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.registry import number_of, parse_spec, spec_of
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.results.records import ACCURACY_KINDS, Check, LimitKind

LIMITS: Final[Mapping[LimitKind, Callable[[float, float], bool]]] = {
    "at_most": operator.le,
    "at_least": operator.ge,
    "equals": operator.eq,
}
"""Each kind of limit with its comparison; nan fails every limit."""

EVERY = "*"
"""Selects every engine."""

Claim = Literal["rounding", "exact", "less"]
"""What an engine claims of itself in a scene, by its capabilities and its `resolution`.

"rounding": every feature is exact, and it states that balls are off by rounding alone. "exact":
every feature is exact, and it states nothing of how far off balls may be, or that it has no step
and they are off by less than 1 um. "less": it states a step, or that it represents a feature
approximately.
"""

CLAIMS: tuple[Claim, ...] = get_args(Claim)


class CriteriaError(GhostballError, ValueError):
    """A criteria file that breaks a rule, or criteria that contradict each other."""


class Selector(BaseModel, frozen=True):
    """Which engines a criterion covers: a name, and settings that must have these values.

    The name "*" covers every engine; with settings, every one that has them.
    """

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
        return spec_of(self.engine, dict(self.settings))

    def covers(self, engine: str, settings: Mapping[str, Any]) -> bool:
        """Whether an engine with these effective settings is meant.

        Raises `CriteriaError` where the engine that is named has no such setting: the selector
        could never match.
        """
        if self.engine == EVERY:
            return all(
                key in settings and _same(settings[key], text) for key, text in self.settings
            )
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
        hint = f"Did you mean `{close[0]}`?" if close else f"Known metrics: {', '.join(METRICS)}"
        raise PydanticCustomError(
            "metric", "must be a known metric, got '{name}'. {hint}", {"name": name, "hint": hint}
        )
    return name


MetricName = Annotated[str, Strict(), AfterValidator(_known_metric)]
Number = Annotated[int, Strict()] | Annotated[float, Strict(), AllowInfNan(False)]


def _not_blank(text: str) -> str:
    if not text.strip():
        raise ValueError(f"must not be blank, got {text!r}")
    return text


Sentence = Annotated[str, Strict(), AfterValidator(_not_blank)]


class ForEngines(BaseModel, frozen=True, extra="forbid"):
    """What is said of some engines, and why."""

    engines: Annotated[
        tuple[Annotated[Selector, BeforeValidator(Selector.parse)], ...], Field(min_length=1)
    ]
    reason: Sentence
    at: Annotated[str, Field(exclude=True, repr=False)] = ""
    """File and line where it stands; "" where it is of no file."""

    def covers(self, engine: str, settings: Mapping[str, Any]) -> bool:
        """Whether an engine with these effective settings is among them; see `Selector.covers`."""
        return any(selector.covers(engine, settings) for selector in self.engines)


class Criterion(ForEngines):
    """One limit on one metric for the engines that it covers.

    A criterion with `claiming` covers only engines that claim this of themselves; "exact" also
    covers those that claim "rounding".

    A metric may have no value, or one that is measured against our own engine. Then a criterion
    with `if_measured` is skipped, and the record says why; any other criterion fails. A run that
    stops early, or whose value isn't finite, fails both.

    A `past_horizon` criterion judges how a shot ends also where the engine can't be expected to
    predict that. Limits on `accuracy` are classes, such as "nanometres".

    With `of` = "touching" the limit is that many times the distance within which balls of the scene
    touch, for all that double precision can tell: `step_limits.touching`. With `of` = "step" it is
    that many times the sum of this distance and the way of the fastest ball in a time step of the
    engine. The way counts as the radius of the smallest ball if the way is longer, or if the engine
    has no time step: `step_limits.travel`.
    """

    claiming: Claim | None = None

    metric: MetricName
    at_most: Number | None = None
    at_least: Number | None = None
    equals: Number | None = None
    of: Literal["touching", "step"] | None = None
    if_measured: Annotated[bool, Strict()] = False
    past_horizon: Annotated[bool, Strict()] = False

    @model_validator(mode="before")
    @classmethod
    def _limits_by_name(cls, values: Any) -> Any:
        """Put the rank of a class in place of its name."""
        if not isinstance(values, Mapping) or values.get("metric") != "accuracy":
            return values
        return dict(values) | {
            kind: _rank(values[kind]) for kind in LIMITS if isinstance(values.get(kind), str)
        }

    @model_validator(mode="after")
    def _one_limit(self) -> Self:
        given = [kind for kind in LIMITS if getattr(self, kind) is not None]
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
        return next(kind for kind in LIMITS if getattr(self, kind) is not None)

    @property
    def limit(self) -> int | float:
        """The limit, in the unit of the metric."""
        limit: int | float = getattr(self, self.limit_kind)
        return limit

    def specificity(self, selector: Selector) -> tuple[bool, int, int]:
        """Return how much one of its selectors says: of several criteria, the most wins."""
        claims = 0 if self.claiming is None else 2 if self.claiming == "rounding" else 1
        return selector.engine != EVERY, len(selector.settings), claims

    def holds_for(self, claim: Claim) -> bool:
        """Whether an engine that claims this is meant."""
        return self.claiming in (None, claim) or (self.claiming, claim) == ("exact", "rounding")

    def allows(self, value: int | float) -> bool:
        """Whether `value` keeps the limit; nan never does."""
        return LIMITS[self.limit_kind](value, self.limit)

    def check(self, value: int | float | None, note: str = "", *, reference: bool = False) -> Check:
        """Judge a measured value.

        A value that could not be computed fails: a criterion that nothing can violate guards
        nothing. With `reference` there is no verdict, for the value compares truth with itself.
        """
        passed: bool | None = value is not None and self.allows(value)
        if reference:
            passed, note = (
                None,
                "Ghostball's engine is the reference here: this compares it with itself",
            )
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


class SharedCriterion(Criterion):
    """One limit that several shipped scenes have."""

    scenes: Annotated[tuple[Annotated[str, Strict()], ...], Field(min_length=2)]

    def alone(self) -> Criterion:
        """Return the limit as one scene has it."""
        return Criterion(**{name: getattr(self, name) for name in Criterion.model_fields})


class Excused(ForEngines):
    """Engines of which the common law asks nothing, and why: what they do is shown alone.

    Each is named: "*" with a setting would excuse whoever calls a setting so.
    """

    @model_validator(mode="after")
    def _named(self) -> Self:
        if found := next((one for one in self.engines if one.engine == EVERY), None):
            raise PydanticCustomError(
                "excused",
                "must name the excused engines one by one, got '{found}' in `engines`, which "
                "matches every engine",
                {"found": str(found)},
            )
        return self


class StepRule(ForEngines):
    """Engines whose limits are computed from their step; see `step_limits`.

    `late`: the events that they see up to a step late: "ball-ball", "ball-cushion",
        "slide-to-roll".
    `energy_noise`: what they may make of energy, over the first.
    `drifts`: whether their motion between contacts errs by up to v dt, also where contacts are in
        time.
    """

    late: tuple[Literal["ball-ball", "ball-cushion", "slide-to-roll"], ...]
    energy_noise: Annotated[float, Strict(), Field(gt=0.0, lt=1.0)]
    drifts: Annotated[bool, Strict()] = False

    @property
    def kinds(self) -> tuple[EventKind, ...]:
        """The kinds of the events that they see late."""
        return tuple(kind for kind in EventKind if kind.label in self.late)


class BeyondStep(ForEngines):
    """Engines of which no limit is computed in a scene: they err there by more than a step.

    `reason`: what else they get wrong.
    """


def _rank(name: str) -> int:
    """Return the rank of a class of accuracy, from the best, 0."""
    if name not in ACCURACY_KINDS:
        raise PydanticCustomError(
            "class",
            "must be a class of `accuracy`, got '{name}'. From the best: {known}",
            {"name": name, "known": ", ".join(ACCURACY_KINDS)},
        )
    return ACCURACY_KINDS.index(name)


def _same(value: Any, text: str) -> bool:
    """Whether a setting's value is what `text` spells: 0.001 is "1e-3", True is "true"."""
    if isinstance(value, bool):
        return text.lower() == str(value).lower()
    if isinstance(value, int | float):
        return number_of(text) == float(value)
    return text == str(value)

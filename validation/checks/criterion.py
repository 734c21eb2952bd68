"""A limit on a metric, the rule for computed limits, and the engines that they apply to."""

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
"""The selector of every engine."""

Claim = Literal["rounding", "exact", "less"]
"""The claim of an engine in a scene, from its capabilities and its `resolution`.

"rounding": every feature is exact, and the engine states that positions have rounding errors only.
"exact": every feature is exact, and the engine either states no resolution, or states that it has
no time step and errors below 1 um. "less": it states a time step, or supports a feature only
approximately.
"""

CLAIMS: tuple[Claim, ...] = get_args(Claim)


class CriteriaError(GhostballError, ValueError):
    """A criteria file that breaks a rule, or criteria that contradict each other."""


class Selector(BaseModel, frozen=True):
    """The engines that a criterion covers: a name, and settings with required values.

    The name "*" covers every engine; with settings, every engine with these settings.
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
        """Return True if an engine with these settings is covered.

        Raises `CriteriaError` if the named engine has no such setting, so the selector could never
        match.
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
    """A statement about some engines, with its reason."""

    engines: Annotated[
        tuple[Annotated[Selector, BeforeValidator(Selector.parse)], ...], Field(min_length=1)
    ]
    reason: Sentence
    at: Annotated[str, Field(exclude=True, repr=False)] = ""
    """File and line of the statement; "" if it isn't from a file."""

    def covers(self, engine: str, settings: Mapping[str, Any]) -> bool:
        """Return True if an engine with these settings is covered; see `Selector.covers`."""
        return any(selector.covers(engine, settings) for selector in self.engines)


class Criterion(ForEngines):
    """One limit on one metric for the engines that it covers.

    A criterion with `claiming` covers only engines with this claim; "exact" also covers the claim
    "rounding".

    If a metric has no value, a criterion with `if_measured` is skipped, and the record states why;
    any other criterion fails. If a run stops early, or the value isn't finite, both kinds fail. A
    value that compares Ghostball's engine with itself gives no verdict.

    A criterion with `past_horizon` judges the end of a shot even if the engine can't be expected to
    predict it. Limits on `accuracy` are classes, such as "nanometres".

    With `of` = "touching", the limit is a multiple of the gap below which balls of the scene count
    as touching in double precision: `step_limits.touching`. With `of` = "step", it is a multiple of
    this gap plus the path of the fastest ball in one time step of the engine. This path counts as
    at most the radius of the smallest ball, and as that radius for an engine without a time step:
    `step_limits.travel`.
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
        """Replace the name of a class by its rank."""
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
        """The kind of the limit that is given."""
        return next(kind for kind in LIMITS if getattr(self, kind) is not None)

    @property
    def limit(self) -> int | float:
        """The limit, in the unit of the metric."""
        limit: int | float = getattr(self, self.limit_kind)
        return limit

    def specificity(self, selector: Selector) -> tuple[bool, int, int]:
        """Return how specific the criterion is with one of its selectors; the largest wins."""
        claims = 0 if self.claiming is None else 2 if self.claiming == "rounding" else 1
        return selector.engine != EVERY, len(selector.settings), claims

    def holds_for(self, claim: Claim) -> bool:
        """Return True if the criterion covers engines with this claim."""
        return self.claiming in (None, claim) or (self.claiming, claim) == ("exact", "rounding")

    def allows(self, value: int | float) -> bool:
        """Return True if `value` is within the limit; nan never is."""
        return LIMITS[self.limit_kind](value, self.limit)

    def check(self, value: int | float | None, note: str = "", *, reference: bool = False) -> Check:
        """Judge a measured value.

        A missing value fails, because a criterion that can't fail checks nothing. With `reference`
        there is no verdict, because the value compares the reference with itself.
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
    """A limit that several shipped scenes share."""

    scenes: Annotated[tuple[Annotated[str, Strict()], ...], Field(min_length=2)]

    def alone(self) -> Criterion:
        """Return the limit for one scene."""
        return Criterion(**{name: getattr(self, name) for name in Criterion.model_fields})


class Excused(ForEngines):
    """Engines to which the common limits don't apply, with the reason; results are only shown.

    Each engine is named: "*" with a setting would excuse any engine with a setting of that name.
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
    """Engines with limits computed from their time step; see `step_limits`.

    `late`: the kinds of events that they detect up to one step late: "ball-ball", "ball-cushion",
        "slide-to-roll".
    `energy_noise`: allowed energy gain, divided by the initial energy.
    `drifts`: whether the position error of their motion between contacts is up to v dt, even if
        contacts are detected in time.
    """

    late: tuple[Literal["ball-ball", "ball-cushion", "slide-to-roll"], ...]
    energy_noise: Annotated[float, Strict(), Field(gt=0.0, lt=1.0)]
    drifts: Annotated[bool, Strict()] = False

    @property
    def kinds(self) -> tuple[EventKind, ...]:
        """The kinds of the events that they detect late."""
        return tuple(kind for kind in EventKind if kind.label in self.late)


class BeyondStep(ForEngines):
    """Engines without computed limits in a scene: their time step doesn't explain their errors.

    `reason`: the other cause of the errors.
    """


def _rank(name: str) -> int:
    """Return the rank of an accuracy class; 0 is the best."""
    if name not in ACCURACY_KINDS:
        raise PydanticCustomError(
            "class",
            "must be a class of `accuracy`, got '{name}'. From the best: {known}",
            {"name": name, "known": ", ".join(ACCURACY_KINDS)},
        )
    return ACCURACY_KINDS.index(name)


def _same(value: Any, text: str) -> bool:
    """Return True if `text` spells the value of a setting: "1e-3" for 0.001, "true" for True."""
    if isinstance(value, bool):
        return text.lower() == str(value).lower()
    if isinstance(value, int | float):
        return number_of(text) == float(value)
    return text == str(value)

"""Pass criteria: the limits for each engine in a scene, in a file beside the scene, with reasons.

    truth = "closed-form"   # or "certified", "integration", "engine", "none"; see `truth_of`

    [[criteria]]
    engines = ["ghostball"]          # "pymunk": any settings; "pymunk:contact_steps=exact": these
    metric  = "rest_error_max"
    at_most = 1e-13                  # or at_least, or equals
    reason  = "a few roundings of a 2.5 m table"

If several criteria on a metric cover an engine, the most specific ones replace the others: first
those that name the engine, then those with the most settings in their selector, then those that
state a claim.

Limits for every engine in every scene are in `scenes/common.expect.toml`, for `engines = ["*"]`;
`requirements` defines which limit applies if a scene states one, too. Limits that several shipped
scenes share are in `scenes/shared.expect.toml`, once.

    [[criteria]]
    engines = ["*"]
    claiming = "exact"               # or "rounding", "less": what the engine claims
    metric  = "accuracy"
    at_most = "nanometres"           # a class, by name
    if_measured = true
    reason  = "..."

    [[excused]]                      # the common limits don't apply to these engines
    engines = ["pymunk:config=naive"]      # each by its name
    reason = "..."

For engines in a `[[steps]]` table, in the file of a scene or of all scenes, limits on the outcome
of a shot are computed from their time step, for metrics without a limit in the scene; see
`step_limits`.

    [[steps]]
    engines = ["my-engine"]
    late = ["ball-ball", "ball-cushion"]     # events detected up to one step late
    energy_noise = 1e-9
    reason = "..."

    [[beyond_step]]                          # no limits are computed for these in this scene
    engines = ["pybullet"]
    reason = "..."
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

from pydantic import BaseModel, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from ghostball.model.text_files import read_text
from ghostball.validation.checks.criterion import (
    EVERY,
    BeyondStep,
    Claim,
    CriteriaError,
    Criterion,
    Excused,
    Selector,
    SharedCriterion,
    StepRule,
)
from ghostball.validation.checks.relations import WORDS, bits_of, factor_of
from ghostball.validation.results.files import describe_problem, field_of, toml_of
from ghostball.validation.results.records import LimitKind
from ghostball.validation.scenes.library import CRITERIA_SUFFIX, FOLDER
from ghostball.validation.truth.scene_truth import WantedTruth

COMMON = FOLDER / f"common{CRITERIA_SUFFIX}"
"""The file with the criteria of every scene."""

SHARED = FOLDER / f"shared{CRITERIA_SUFFIX}"
"""The file with the criteria that several shipped scenes share; each row names its scenes."""

RELATED = FOLDER / f"relations{CRITERIA_SUFFIX}"
"""The file with the criteria of relations between shots, which apply on request."""

_Model = TypeVar("_Model", bound=BaseModel)


class SharedCriteria(BaseModel, frozen=True, extra="forbid"):
    """The criteria that several shipped scenes share."""

    criteria: tuple[SharedCriterion, ...] = ()


class Criteria(BaseModel, frozen=True, extra="forbid"):
    """All criteria of a scene, and the kind of reference result that it needs.

    If a scene states `truth`, and its features can be certified, the shot must be certified to its
    end, or for as many events as `proved` states. The part that isn't certified isn't judged.
    """

    truth: WantedTruth | None = None
    proved: Annotated[int, Field(strict=True, ge=0)] | None = None
    criteria: tuple[Criterion, ...] = ()
    steps: tuple[StepRule, ...] = ()
    beyond_step: tuple[BeyondStep, ...] = ()
    excused: tuple[Excused, ...] = ()

    @property
    def least_certified(self) -> int | None:
        """Number of events that must be certified; None: all, to the end."""
        return 0 if self.truth is None and self.proved is None else self.proved

    @model_validator(mode="after")
    def _no_contradiction(self) -> Self:
        seen: dict[tuple[Selector, str, Claim | None], dict[LimitKind, float]] = defaultdict(dict)
        for i, criterion in enumerate(self.criteria):
            for selector in criterion.engines:
                limits = seen[selector, criterion.metric, criterion.claiming]
                what = {"i": i, "metric": criterion.metric, "selector": str(selector)}
                if criterion.limit_kind in limits:
                    raise PydanticCustomError(
                        "repeated",
                        "`criteria[{i}]` repeats `{limit}` on `{metric}` for `{selector}`. "
                        "Remove one of the two",
                        what | {"limit": criterion.limit_kind},
                    )
                limits[criterion.limit_kind] = criterion.limit
                exact = limits.get("equals", math.nan)
                low, high = limits.get("at_least", exact), limits.get("at_most", exact)
                if low > high or not (math.isnan(exact) or low <= exact <= high):
                    raise PydanticCustomError(
                        "repeated",
                        "`criteria[{i}]`: limits on `{metric}` for `{selector}` must be in order, "
                        "`at_least` <= `equals` <= `at_most`, got {limits}. Change one of them",
                        what | {"limits": ", ".join(f"{k} {v:g}" for k, v in limits.items())},
                    )
        return self

    @classmethod
    def load(cls, path: str | Path) -> Criteria:
        """Read a criteria file.

        Raises `CriteriaError` if it can't be read, isn't valid TOML, or breaks a rule.
        """
        return _load(cls, Path(path))

    def applying_to(
        self, engine: str, settings: Mapping[str, Any], claim: Claim | None = None
    ) -> tuple[Criterion, ...]:
        """Return the criteria that apply to an engine with these settings.

        `claim`: the claim of the engine in the scene; None: only criteria that don't depend on a
            claim.

        Raises `CriteriaError` if two equally specific selectors set the same kind of limit on a
        metric.
        """
        covering: dict[str, list[tuple[tuple[bool, int, int], Criterion]]] = defaultdict(list)
        for criterion in self.criteria:
            if criterion.claiming is not None and (claim is None or not criterion.holds_for(claim)):
                continue
            matching = [s for s in criterion.engines if s.covers(engine, settings)]
            if matching:
                said = max(map(criterion.specificity, matching))
                covering[criterion.metric].append((said, criterion))
        chosen: list[Criterion] = []
        for metric, found in covering.items():
            most = max(said for said, _ in found)
            winners = [criterion for said, criterion in found if said == most]
            kinds = [criterion.limit_kind for criterion in winners]
            if len(set(kinds)) < len(kinds):
                listed = ", ".join(f"{key}={value}" for key, value in settings.items()) or "none"
                raise CriteriaError(
                    f"two limits on `{metric}` apply equally to engine `{engine}` with settings "
                    f"{listed}. Add a setting to one of them"
                )
            chosen.extend(winners)
        return tuple(chosen)

    def excuse(self, engine: str, settings: Mapping[str, Any]) -> str:
        """Return why the common limits don't apply to an engine; "" if they apply."""
        return next((one.reason for one in self.excused if one.covers(engine, settings)), "")

    def step_rule(
        self, engine: str, settings: Mapping[str, Any], *wider: Criteria
    ) -> StepRule | None:
        """Return the rule for the computed limits of an engine, or None if there is none.

        It is the first rule that covers the engine: in this scene, then in the `wider` criteria.
        """
        rules: list[StepRule | BeyondStep] = [*self.beyond_step, *self.steps]
        rules += [rule for criteria in wider for rule in criteria.steps]
        found = next((rule for rule in rules if rule.covers(engine, settings)), None)
        return found if isinstance(found, StepRule) else None

    def check_engines(self, known: Iterable[str], source: str) -> None:
        """Check that every selector names an installed engine, to detect misspelt names."""
        names = tuple(known)
        for table in _MODELS:
            for i, row in enumerate(getattr(self, table)):
                unknown = [one for one in row.engines if one.engine not in (*names, EVERY)]
                if unknown:
                    close = get_close_matches(unknown[0].engine, names, n=1)
                    hint = f"Did you mean `{close[0]}`? " if close else ""
                    raise CriteriaError(
                        f"{row.at or source}: `{table}[{i}].engines` must name installed engines, "
                        f'got "{unknown[0]}". {hint}Known engines: {", ".join(names)}; "{EVERY}" '
                        "stands for every engine"
                    )


@cache
def common_criteria() -> Criteria:
    """Return the criteria of every scene."""
    return Criteria.load(COMMON)


def criteria_beside(scene_path: str | Path) -> Criteria:
    """Return the criteria in the file beside a scene file; empty without such a file.

    Raises `CriteriaError` if the file is invalid.
    """
    path = Path(scene_path)
    name = path.name.removesuffix(".toml")
    beside = path.with_name(name + CRITERIA_SUFFIX)
    own = Criteria.load(beside) if beside.exists() else Criteria()
    if path.parent != FOLDER:
        return own
    shared = tuple(one.alone() for one in shared_criteria().criteria if name in one.scenes)
    # Built from the fields, so that both parts are checked for contradictions.
    return Criteria(**(dict(own) | {"criteria": (*own.criteria, *shared)}))


def relation_criteria(names: Sequence[str] = ()) -> Criteria:
    """Return the criteria of relations between shots; without names, those of all relations.

    Raises `CriteriaError` if there is no such relation.
    """
    for name in names:
        if name not in WORDS:
            close = get_close_matches(name, WORDS, n=1)
            hint = f"Did you mean {close[0]}? " if close else ""
            raise CriteriaError(
                f"`relations` must name known relations, got {name!r}. {hint}"
                f"Known: {', '.join(WORDS)}"
            )
    wanted = {metric for name in names or WORDS for metric in (factor_of(name), bits_of(name))}
    whole = Criteria.load(RELATED)
    return Criteria(criteria=tuple(one for one in whole.criteria if one.metric in wanted))


@cache
def shared_criteria() -> SharedCriteria:
    """Return the criteria that several shipped scenes share."""
    return _load(SharedCriteria, SHARED)


def _load(model: type[_Model], source: Path) -> _Model:
    """Read a criteria file; see `Criteria.load`."""
    try:
        text = read_text(source)
        data = toml_of(text)
    except (OSError, UnicodeDecodeError) as error:
        raise CriteriaError(f"{source}: can't read the limits: {error}") from None
    except ValueError as error:
        raise CriteriaError(f"{source}: not valid TOML: {error}. Fix the syntax there") from None
    lines = _lines_of_tables(text)
    for table in _MODELS:
        rows = data.get(table)
        for row, line in zip(rows if isinstance(rows, list) else (), lines[table], strict=False):
            if isinstance(row, dict):
                row["at"] = f"{source}:{line}"
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise CriteriaError("\n".join(_described(error, source, text, lines))) from None


def _lines_of_tables(text: str) -> Mapping[str, Sequence[int]]:
    """Return the line numbers of the rows of each table."""
    lines: dict[str, list[int]] = {table: [] for table in _MODELS}
    for number, line in enumerate(text.splitlines(), start=1):
        head = re.match(r"\s*\[\[\s*(\w+)\s*\]\]", line)
        if head is not None and head[1] in lines:
            lines[head[1]].append(number)
    return lines


def _line_of_field(text: str, head: int, field: Sequence[int | str]) -> int:
    """Return the line that sets a field of a row, or `head`, the line of the row's head."""
    for number, line in enumerate(text.splitlines()[head:], start=head + 1):
        if line.lstrip().startswith("[["):
            break
        if field and re.match(rf"\s*{re.escape(str(field[0]))}\s*=", line):
            return number
    return head


_MODELS: Mapping[str, type[BaseModel]] = {
    "criteria": Criterion,
    "steps": StepRule,
    "beyond_step": BeyondStep,
    "excused": Excused,
}
"""The model for the rows of each table."""


def _described(
    error: ValidationError, source: Path, text: str, lines: Mapping[str, Sequence[int]]
) -> Iterator[str]:
    """Yield the problems of a file with their lines: the line of the field, or that of its row.

    For a field of type int or float there are two problems; the one about float is described.
    """
    fields = {field_of(problem): problem for problem in error.errors()}
    for problem in fields.values():
        table, row = (*problem["loc"], "", "")[:2]
        if problem["type"] == "repeated":
            table, row = "criteria", problem["ctx"]["i"]
        known = table in lines and isinstance(row, int) and row < len(lines[str(table)])
        at = str(source)
        if known:
            at += f":{_line_of_field(text, lines[str(table)][int(row)], problem['loc'][2:3])}"
        model = _MODELS.get(str(table), Criteria) if len(problem["loc"]) > 1 else Criteria
        names = [name for name in model.model_fields if name != "at"]
        yield f"{at}: {describe_problem(problem, names)}"

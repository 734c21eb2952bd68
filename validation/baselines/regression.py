"""The result of comparing an engine with its accepted baselines, and its storage.

*Base* is the accepted result, *head* is the present result.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal

from pydantic import BaseModel, Field, TypeAdapter

from ghostball.model.scene.fields import SceneName
from ghostball.validation.results.database import (
    get_document,
    has_database,
    put_document,
    reading,
    record_of,
    transaction,
    writing,
)
from ghostball.validation.results.fields import EnvironmentValues

SCHEMA: Final = 12
"""Version of a stored comparison."""

Answer = Literal["unchanged", "rounding", "better", "changed", "worse", "wrong collisions"]
"""The answers of `compare.compare` for two records of one scene."""

Change = Literal[Answer, "no-baseline", "not-comparable", "not-deterministic"]
"""The change of a scene: an answer of `compare`, or why there is none."""

UNCOMPARED: Final = ("no-baseline", "not-comparable")
"""The changes of scenes without a baseline, or with a baseline that can't be compared."""

FailOn = Literal["changed", "worse", "limits"]
"""Changes that count as failures, the strictest choice first.

The help of `ghostball regress --fail-on` says what each choice means.
"""

LENIENT: Final[dict[FailOn, str]] = {
    "worse": "only changes for the worse count as failures",
    "limits": "only failed limits count as failures",
}
"""Sentences that the output shows for the less strict choices."""


class StrictModel(BaseModel, frozen=True, extra="forbid", populate_by_name=True):
    """Base class of stored parts of a comparison or baseline; unknown fields are refused."""


class FirstDifference(StrictModel):
    """The first event that differs.

    `index` counts events from 0; `words` describes the difference in one sentence, with ball ids.
    """

    index: int
    before_horizon: bool
    words: str


class ValueChange(StrictModel):
    """A metric or a work counter that differs; a side without a value is None."""

    name: str
    unit: str
    base: int | float | None
    head: int | float | None

    @property
    def words(self) -> str:
        """Both values with their unit and all digits, because they may differ in the last one."""
        base, head = ("none" if one is None else repr(one) for one in (self.base, self.head))
        return f"{self.name} {base} -> {head}" + ("" if self.unit == "1" else f" {self.unit}")


class SceneChange(StrictModel):
    """The change of one scene.

    `label`: the engine, or both engines of a comparison of two; "" in a comparison with baselines.
    `summary`: one sentence: what changed and by how much.
    `broken`: the limits that the head fails, one sentence each.
    `horizon` [s]: time up to which the two runs can be compared; None: to the end.
    `first_difference`: None if all events are equal, times included.
    `base_error`, `head_error` [m]: largest rest position error; None if unknown.
    `base_is_exact`, `head_is_exact`: whether this error is no larger than rounding.
    `metrics`: metrics that differ, without run times; `counters`: work counters that differ.
    `base_hash`, `head_hash`: hash of events and rest positions; "" if there is no result.
    `rest_base`, `rest_head` ((x, y, z), ...) [m] or None: rest positions, in the order of the
        scene.
    `command`: command that shows the difference, or simulates the scene again.
    """

    scene: SceneName
    title: str
    label: str = ""
    change: Change
    failed: bool = False
    summary: str
    broken: tuple[str, ...] = ()
    horizon: float | None = None
    first_difference: FirstDifference | None = None
    base_error: float | None = None
    head_error: float | None = None
    base_is_exact: bool = False
    head_is_exact: bool = False
    metrics: tuple[ValueChange, ...] = ()
    counters: tuple[ValueChange, ...] = ()
    base_hash: str = ""
    head_hash: str = ""
    rest_base: tuple[tuple[float, float, float], ...] | None = None
    rest_head: tuple[tuple[float, float, float], ...] | None = None
    command: str = ""

    def fails(self, fail_on: FailOn, *, ours: bool) -> bool:
        """Return True if this change counts as a failure.

        `ours`: True for Ghostball's engine, which promises identical bits: a difference by rounding
            then fails too, until somebody accepts it.
        """
        # no result, or a result with NaN or infinity
        lost = self.change == "worse" and not self.head_hash
        if self.broken or lost or fail_on == "limits":
            return bool(self.broken) or lost
        if self.change in ("worse", "wrong collisions", "not-deterministic"):
            return True
        passing = ("unchanged", *UNCOMPARED, *(() if ours else ("rounding",)))
        return fail_on == "changed" and (self.change not in passing or bool(self.counters))

    @property
    def words(self) -> str:
        """The change in words; for an unchanged result that fails, the reason of the failure."""
        if self.change == "unchanged" and (self.counters or self.failed):
            return f"same result, {'different work counters' if self.counters else 'limits failed'}"
        return self.change

    @property
    def moved(self) -> bool:
        """Return True if the result, or a work counter, differs from the baseline."""
        return self.change != "unchanged" or bool(self.counters)

    @property
    def can_be_accepted(self) -> bool:
        """Return True if the result, or a work counter, differs, and the result is reproducible."""
        return self.moved and bool(self.head_hash) and self.change != "not-deterministic"


class Regression(StrictModel):
    """A comparison of all scenes of an engine with their baselines.

    `label`: the engine with its settings, as the user wrote it.
    `engine`: the key of the engine in its baselines.
    `head`: the environment of the comparison (`validation.results.environment`).
    `outcome`: "no-baseline" if nothing failed, but a scene could not be compared; this is not a
        pass.
    `unjudged`: why no limit judges any of the runs; "" if a limit does.
    `warnings`: facts that a user should know but that don't fail the comparison, a sentence each.
    """

    schema_version: Literal[12] = Field(default=SCHEMA, alias="schema")
    kind: Literal["regression"] = "regression"
    label: str = "ghostball"
    engine: str = "ghostball"
    head: EnvironmentValues
    fail_on: FailOn = "changed"
    outcome: Literal["passed", "failed", "no-baseline"]
    scenes: tuple[SceneChange, ...]
    unjudged: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def moved(self) -> tuple[SceneChange, ...]:
        """The failed scenes with a changed result or work counter."""
        return tuple(change for change in self.scenes if change.failed and change.moved)

    @property
    def broken(self) -> tuple[SceneChange, ...]:
        """The scenes with failed limits: these results are wrong, not only different."""
        return tuple(change for change in self.scenes if change.broken)

    def scene(self, name: str) -> SceneChange | None:
        """Return the change of a scene, or None if the scene wasn't compared."""
        return next((change for change in self.scenes if change.scene == name), None)


def save_regressions(regressions: Sequence[Regression], folder: Path) -> None:
    """Store comparisons in a results folder, one per engine, replacing the earlier ones."""
    with writing(folder) as database, transaction(database):
        text = _LIST.dump_json([*regressions], by_alias=True).decode()
        put_document(database, "regression", text)


def load_regressions(folder: Path) -> list[Regression]:
    """Read the comparisons in a results folder, in the order of the engines.

    Raises `ResultsError` if the database is cut short, damaged or of another version.
    """
    if not has_database(folder):
        return []
    with reading(folder) as database:
        text = get_document(database, "regression")
    if text is None:
        return []
    found: list[Regression] = record_of(_LIST, text, f"{folder}: its comparison")
    return found


def load_regression(folder: Path, engine: str | None = None) -> Regression | None:
    """Read the comparison of an engine; by default the first that fails, or the first of all.

    Returns None if there is no comparison.
    """
    found = load_regressions(folder)
    if engine is not None:
        return next((one for one in found if one.engine == engine), None)
    return next((one for one in found if one.outcome == "failed"), found[0] if found else None)


_LIST = TypeAdapter(list[Regression])

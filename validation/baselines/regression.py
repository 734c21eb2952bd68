"""What a comparison of an engine with its accepted baselines found, kept in a results folder.

*Base* is what was accepted; *head* is the engine as it is now.
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

SCHEMA: Final = 11
"""Version of a stored comparison."""

Answer = Literal["unchanged", "rounding", "better", "changed", "worse", "wrong collisions"]
"""What `compare.compare` says of two records of one scene."""

Change = Literal[Answer, "no-baseline", "not-comparable", "not-deterministic"]
"""What became of a scene: an answer, or why there is none."""

UNCOMPARED: Final = ("no-baseline", "not-comparable")
"""Changes that say that there was nothing to compare with."""

FailOn = Literal["changed", "worse", "limits"]
"""What of a comparison fails its gate, the strictest first.

"changed": every change. "worse": of these only a larger error, wrong collisions, failed limits, and
an engine that isn't deterministic. "limits": only failed limits, and shots that the engine did not
finish; then no baseline is needed either.
"""

LENIENT: Final[dict[FailOn, str]] = {
    "worse": "only changes for the worse count as failures",
    "limits": "only failed limits count as failures",
}
"""What a gate that isn't the strictest says of itself."""


class Model(BaseModel, frozen=True, extra="forbid", populate_by_name=True):
    """A part of a comparison, or of a baseline: no other fields than its own are read."""


class FirstDifference(Model):
    """The first event that differs.

    `index` counts events from 0; `words` says it in one sentence with the balls' ids.
    """

    index: int
    before_horizon: bool
    words: str


class Quantity(Model):
    """A metric or a work counter that differs; None on a side where it has no value."""

    name: str
    unit: str
    base: int | float | None
    head: int | float | None

    @property
    def words(self) -> str:
        """Both values with their unit, to all digits, because they may differ in the last."""
        base, head = ("none" if one is None else repr(one) for one in (self.base, self.head))
        return f"{self.name} {base} -> {head}" + ("" if self.unit == "1" else f" {self.unit}")


class SceneChange(Model):
    """What became of one scene.

    `label`: the engine, or both; "" where the comparison is of one engine.
    `summary`: one sentence: what changed and by how much.
    `broken`: the limits that the head fails, one sentence each.
    `horizon` [s]: until when both sides can be compared; None: to the end.
    `first_difference`: None if all events are the same, instants included.
    `base_error`, `head_error` [m]: largest rest error; None where it isn't known.
    `metrics`: those that differ, run times apart; `counters`: the work counters that differ.
    `base_hash`, `head_hash`: of events and rest positions, to the bit; "" where there is none.
    `rest_base`, `rest_head` ((x, y, z), ...) [m] or None: rest positions, in the scene's order.
    `command`: what shows the difference, or the scene, again.
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
    metrics: tuple[Quantity, ...] = ()
    counters: tuple[Quantity, ...] = ()
    base_hash: str = ""
    head_hash: str = ""
    rest_base: tuple[tuple[float, float, float], ...] | None = None
    rest_head: tuple[tuple[float, float, float], ...] | None = None
    command: str = ""

    def fails(self, fail_on: FailOn, *, ours: bool) -> bool:
        """Return True if it fails a gate.

        `ours`: whether it is Ghostball's own engine, which promises its bits: then rounding fails
            too until somebody accepts it.
        """
        lost = self.change == "worse" and not self.head_hash  # it didn't run, or to no numbers
        if self.broken or lost or fail_on == "limits":
            return bool(self.broken) or lost
        if self.change in ("worse", "wrong collisions", "not-deterministic"):
            return True
        passing = ("unchanged", *UNCOMPARED, *(() if ours else ("rounding",)))
        return fail_on == "changed" and (self.change not in passing or bool(self.counters))

    @property
    def words(self) -> str:
        """What became of it; the same bits may fail too, and then it says for what."""
        if self.change == "unchanged" and (self.counters or self.failed):
            return f"same result, {'different work counters' if self.counters else 'limits failed'}"
        return self.change

    @property
    def moved(self) -> bool:
        """Whether the engine did something else than its baseline says, or at another cost."""
        return self.change != "unchanged" or bool(self.counters)

    @property
    def can_be_accepted(self) -> bool:
        """Whether the engine did something else than its baseline says, and would do so again."""
        return self.moved and bool(self.head_hash) and self.change != "not-deterministic"


class Regression(Model):
    """A whole comparison.

    `label`: which engine, as it was asked for.
    `engine`: what its baselines call it.
    `head`: the environment of the comparison (`validation.results.environment`).
    `outcome`: "no-baseline" if nothing failed, but some scene could not be compared: that is no
        pass.
    `unjudged`: why no limit judges any of the runs; "" where one does.
    `warnings`: what doesn't fail the gate but should be known, one sentence each.
    """

    schema_version: Literal[11] = Field(default=SCHEMA, alias="schema")
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
        """The scenes that fail for what moved, not for their limits alone."""
        return tuple(change for change in self.scenes if change.failed and change.moved)

    @property
    def broken(self) -> tuple[SceneChange, ...]:
        """The scenes in which limits fail: these are wrong, not only different."""
        return tuple(change for change in self.scenes if change.broken)

    def scene(self, name: str) -> SceneChange | None:
        """Return what became of a scene, or None where it wasn't compared."""
        return next((change for change in self.scenes if change.scene == name), None)


def save_regressions(regressions: Sequence[Regression], folder: Path) -> None:
    """Store them in a results folder, one of each engine, in place of earlier ones."""
    with writing(folder) as database, transaction(database):
        text = _LIST.dump_json([*regressions], by_alias=True).decode()
        put_document(database, "regression", text)


def load_regressions(folder: Path) -> list[Regression]:
    """Read them from a results folder, in the order of the engines; none where there is none.

    Raises `ResultsError` where the folder's database is cut short, damaged or of another version.
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
    """Read that of an engine, else the first that fails, else the first; None if there is none."""
    found = load_regressions(folder)
    if engine is not None:
        return next((one for one in found if one.engine == engine), None)
    return next((one for one in found if one.outcome == "failed"), found[0] if found else None)


_LIST = TypeAdapter(list[Regression])

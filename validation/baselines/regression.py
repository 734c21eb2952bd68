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

SCHEMA: Final = 9
"""Version of a stored comparison."""

Change = Literal[
    "identical",
    "rounding-only",
    "better",
    "results-changed",
    "worse",
    "no-baseline",
    "not-comparable",
    "not-deterministic",
]
"""What became of a scene, from the mildest on.

"identical": the same bits. "rounding-only": the same events up to the predictability horizon, and
no state there differs by more than rounding explains. "results-changed": something else moved, and
truth can't say which is right, or says that both are. "better", "worse": it moved, and towards the
truth, or away from it beyond the band that was accepted. "not-deterministic": the engine does
something else each time that it plays the shot.
"""

Level = Literal["off", "warn", "error"]

FailOn = Literal["changed", "worse", "limits"]
"""What of a comparison fails its gate, the strictest first.

"changed": whatever moved out of its band. "worse": of that, only what moved away from the truth,
breaks its limits, or is another shot each time. "limits": only broken limits of truth, and shots
that the engine didn't play; then no baseline is needed either.
"""


LENIENT: Final[dict[FailOn, str]] = {
    "worse": "of what moved, only what is worse fails",
    "limits": "of what moved, nothing fails but for broken limits",
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
    """A metric or a work counter on both sides, and the band in which it is accepted.

    `level` says what leaving the band means; `why` where the band comes from. A bound that is None
    isn't there; a value that is None could not be measured.
    """

    name: str
    unit: str
    base: int | float | None
    head: int | float | None
    low: int | float | None = None
    high: int | float | None = None
    level: Level
    within: bool
    why: str


UNCOMPARED: Final = ("no-baseline", "not-comparable")
"""Changes that say that there was nothing to compare with."""


def moved_text(quantity: Quantity) -> str:
    """Say in one sentence where a quantity was, where it is, and where it may be."""
    base, head, low, high = (
        _number(quantity, value)
        for value in (quantity.base, quantity.head, quantity.low, quantity.high)
    )
    band = {
        (True, True): f"within [{low}, {high}]",
        (True, False): f"at least {low}",
        (False, True): f"at most {high}",
        (False, False): f"{base}, as it was",
    }[quantity.low is not None, quantity.high is not None]
    return f"{quantity.name} must be {band}, got {head} (before: {base})"


def _number(quantity: Quantity, value: float | int | None) -> str:
    """Return a value of a quantity with its unit, to all digits, for it may differ in the last."""
    number = "nothing" if value is None else repr(value)
    return number if quantity.unit == "1" else f"{number} {quantity.unit}"


def rest_error_in(metrics: Sequence[Quantity]) -> Quantity | None:
    """Return how far off the truth the worst ball ended, and ends, of a scene's metrics."""
    return next((one for one in metrics if one.name == "rest_error_max"), None)


class SceneChange(Model):
    """What became of one scene.

    `summary`: one sentence: what moved and by how much.
    `broken`: the limits of truth that the head breaks, one sentence each.
    `horizon` [s]: until when both sides can be compared; None: to the end.
    `first_difference`: None where all events are alike, instants included.
    `metrics`, `counters`: all of them, moved or not.
    `base_hash`, `head_hash`: of events and rest positions, to the bit; "" where there is none.
    `rest_base`, `rest_head` ((x, y, z), ...) [m] or None: where the balls come to rest, in the
        scene's order.
    `candidate`: the baseline that accepting it would write, as TOML; "" where there is nothing to
        accept.
    `command`: what shows the difference, or the scene, again.
    """

    scene: SceneName
    title: str
    change: Change
    failed: bool
    summary: str
    broken: tuple[str, ...] = ()
    horizon: float | None = None
    first_difference: FirstDifference | None = None
    metrics: tuple[Quantity, ...] = ()
    counters: tuple[Quantity, ...] = ()
    base_hash: str = ""
    head_hash: str = ""
    rest_base: tuple[tuple[float, float, float], ...] | None = None
    rest_head: tuple[tuple[float, float, float], ...] | None = None
    candidate: str = ""
    command: str = ""

    def judged(self, fail_on: FailOn) -> SceneChange:
        """Return the same as a gate judges it that is no stricter than `fail_on`."""
        lost = self.change == "worse" and not self.head_hash  # it didn't run, or to no numbers
        fails = bool(self.broken) or lost or fail_on == "changed"
        fails |= fail_on == "worse" and self.change in ("worse", "not-deterministic")
        return self if fails or not self.failed else self.model_copy(update={"failed": False})

    @property
    def rest_error(self) -> Quantity | None:
        """How far off the truth the worst ball ended, and ends; None where it wasn't asked for."""
        return rest_error_in(self.metrics)

    @property
    def left_band(self) -> bool:
        """Whether a number that may not move did."""
        quantities = (*self.metrics, *self.counters)
        return any(one.level == "error" and not one.within for one in quantities)

    @property
    def moved(self) -> bool:
        """Whether something is other than its baseline says: broken limits alone are not."""
        quantities = (*self.metrics, *self.counters)
        return self.change != "identical" or any(not one.within for one in quantities)


class Regression(Model):
    """A whole comparison.

    `label`: which engine, as it was asked for.
    `engine`: what its baselines call it.
    `base`, `head`: what is kept of the environment that the baselines were accepted in, and the
        environment now (`validation.results.environment.describe_environment`).
    `outcome`: the last where nothing failed, but some scene could not be compared: that is no pass.
    `stale`: baselines of scenes that are no more.
    `unjudged`: why no limit judges any of the runs; "" where one does.
    `warnings`: what doesn't fail the gate but should be known, one sentence each.
    """

    schema_version: Literal[9] = Field(default=SCHEMA, alias="schema")
    kind: Literal["regression"] = "regression"
    label: str = "ghostball"
    engine: str = "ghostball"
    base: EnvironmentValues
    head: EnvironmentValues
    fail_on: FailOn = "changed"
    outcome: Literal["passed", "failed", "no-baseline"]
    scenes: tuple[SceneChange, ...]
    stale: tuple[str, ...] = ()
    unjudged: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def moved(self) -> tuple[SceneChange, ...]:
        """The scenes that fail for what moved, not for their limits alone."""
        return tuple(change for change in self.scenes if change.failed and change.moved)

    @property
    def broken(self) -> tuple[SceneChange, ...]:
        """The scenes in which limits of truth are broken: these are wrong, not only other."""
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

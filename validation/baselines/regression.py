"""What a comparison of two states of one engine found, kept in a results folder.

*Base* is what was accepted, or another revision; *head* is the engine as it is now.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Final, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from ghostball.engine.scene.fields import SceneName
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

SCHEMA: Final = 5
"""Version of what `ghostball regress --format json` prints."""

BASELINES: Final = "baselines"
"""What a comparison with them says that it is against."""

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


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)


class LoggedEvent(_Model):
    """One event: instant [s], kind ("ball-ball"), balls by index; `b` a cushion's name, or None."""

    t: float
    kind: str
    a: int
    b: int | str | None = None


class FirstDifference(_Model):
    """The first event that differs; None on the side whose log has ended there.

    `index` counts events from 0; `words` says it in one sentence with the balls' ids.
    """

    index: int
    base: LoggedEvent | None
    head: LoggedEvent | None
    before_horizon: bool
    words: str


class Quantity(_Model):
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


class Timing(_Model):
    """Run time of a scene [s]: the median, and the interval that holds it 95 times in 100."""

    median: float
    low: float
    high: float
    samples: int


class TimeChange(_Model):
    """Run times of one scene in two revisions that ran by turns; `ratio` is head over base.

    `slower` says so beyond doubt: the whole interval of the ratio's median, which holds it 999
    times in 1000, for many scenes are looked at, lies above `validation.baselines.timing.SLOWER`.
    """

    base: Timing
    head: Timing
    ratio: float
    ratio_low: float
    ratio_high: float
    slower: bool = False
    words: str = ""


class SceneChange(_Model):
    """What became of one scene.

    Attributes
    ----------
    change : Change
    failed : bool
        Whether it fails the gate.
    summary : str
        One sentence: what moved and by how much.
    broken : tuple of str
        The limits of truth that the head breaks, one sentence each.
    horizon : float [s] or None
        Until when both sides can be compared; None: to the end.
    first_difference : FirstDifference or None
        None where all events are alike, instants included.
    metrics, counters : tuple of Quantity
        All of them, moved or not.
    base_hash, head_hash : str
        Of events and rest positions, to the bit; "" where there is none.
    rest_base, rest_head : ((x, y, z), ...) [m] or None
        Where the balls come to rest, in the scene's order.
    candidate : str
        The baseline that accepting it would write, as TOML; "" where there is nothing to accept.
    time : TimeChange or None
    command : str
        What shows the difference, or the scene, again.
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
    time: TimeChange | None = None
    command: str = ""


class Regression(_Model):
    """A whole comparison.

    Attributes
    ----------
    label : str
        Which engine, as it was asked for.
    engine : str
        What its baselines call it.
    against : str
        "baselines", or the revision that was asked for.
    base, head : dict
        Environments (`validation.results.environment.describe_environment`); of baselines, what is
        kept of the one that they were accepted in.
    outcome : "passed", "failed" or "no-baseline"
        The last where nothing failed, but some scene could not be compared: that is no pass.
    scenes : tuple of SceneChange
    stale : tuple of str
        Baselines of scenes that are no more.
    warnings : tuple of str
        What doesn't fail the gate but should be known, one sentence each.
    judged : bool
        Whether it is the gate; `ghostball validate` only shows what moved.
    """

    schema_version: Literal[5] = Field(default=SCHEMA, alias="schema")
    kind: Literal["regression"] = "regression"
    label: str = "ghostball"
    engine: str = "ghostball"
    against: str
    base: EnvironmentValues
    head: EnvironmentValues
    outcome: Literal["passed", "failed", "no-baseline"]
    scenes: tuple[SceneChange, ...]
    stale: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    judged: bool = True

    @property
    def accepted(self) -> bool:
        """Whether the base is what was accepted, not another revision."""
        return self.against == BASELINES

    @property
    def broken(self) -> tuple[SceneChange, ...]:
        """The scenes in which limits of truth are broken: these are wrong, not only other."""
        return tuple(change for change in self.scenes if change.broken)

    def scene(self, name: str) -> SceneChange | None:
        """Return what became of a scene, or None where it wasn't compared."""
        return next((change for change in self.scenes if change.scene == name), None)


def regressions_json(regressions: Sequence[Regression]) -> str:
    """Return what `ghostball regress --format json` prints: one JSON object, on one line.

    That of one engine is its comparison; that of several has theirs in `regressions`, in the order
    in which the engines were asked for.
    """
    if len(regressions) == 1:
        return regressions[0].model_dump_json(by_alias=True)
    found = [one.model_dump(mode="json", by_alias=True) for one in regressions]
    return json.dumps({"schema": SCHEMA, "kind": "regressions", "regressions": found})


def save_regression(regression: Regression, folder: Path) -> None:
    """Store it in a results folder, in place of an earlier one.

    Raises
    ------
    ResultsError
    """
    with writing(folder) as database, transaction(database):
        put_document(database, "regression", regression.model_dump_json(by_alias=True))


def load_regression(folder: Path) -> Regression | None:
    """Read it from a results folder; None where there is none.

    Raises
    ------
    ResultsError
        Where the folder's database is cut short, damaged or of another version.
    """
    if not has_database(folder):
        return None
    with reading(folder) as database:
        text = get_document(database, "regression")
    if text is None:
        return None
    found: Regression = record_of(TypeAdapter(Regression), text, f"{folder}: its comparison")
    return found

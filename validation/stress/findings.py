"""What a stress run found, and the folder that keeps it: a database, and the worst cases."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import ConfigDict, Field, TypeAdapter

from ghostball.model import Scene
from ghostball.validation.results.database import (
    current_records,
    documents_in,
    get_document,
    reading,
    record_of,
)
from ghostball.validation.results.fields import Definition, EnvironmentValues
from ghostball.validation.results.files import ResultsError, cannot_write
from ghostball.validation.results.record_store import RecordStore, RunState
from ghostball.validation.stress.trial import CRASHED, Suite

WORST_FOLDER: Final = "worst"

Outcome = Literal["survived", "broken", "not-judged", "not-representable", "unavailable", "failed"]
"""Whether every shot held; not all did; no limit covers what the engine did; the engine can't be
asked that; it can't run here; the harness couldn't judge it, which says nothing of the engine."""

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9+=., _-]*$")]
"""Of a family or a trial: part of the names of files, so that it must be no path."""

Key = tuple[str, str, str]
"""Family, trial and label."""


@dataclass(frozen=True)
class Finding:
    """What became of one trial on one engine.

    `family`, `trial`, `label`: `label` is the engine with its settings.
    `outcome`: see `Outcome`. A crash, or a trial that took too long, is "broken".
    `faults`: what broke; for the last four outcomes, why.
    `severity`, `shots`, `broken`, `values`: as in a `Verdict`.
    `seconds`: wall time; 0 where its process crashed or was ended.
    `scene`: definition of the shot that broke worst, or came nearest.
    """

    family: Name
    trial: Name
    label: str
    outcome: Outcome
    faults: tuple[str, ...] = ()
    severity: float = 0.0
    shots: int = 0
    broken: int = 0
    values: dict[str, Any] = field(default_factory=dict)
    seconds: float = 0.0
    scene: Definition | None = None

    __pydantic_config__ = ConfigDict(extra="forbid")

    @property
    def key(self) -> Key:
        """Family, trial and label."""
        return self.family, self.trial, self.label


@dataclass(frozen=True)
class StressRun:
    """What was asked for, where and with what.

    `environment`: as of a run of the suite.
    `code_hash`: of the code that ran, and of the shipped scenes; "" where it isn't known.
    `asked`: keys of all that was asked for, by this run or an earlier one of the same code, in
        order.
    `run`, `state`: of the last run: what tells it from any other, and how far it came.
    """

    suite: Suite
    families: tuple[Name, ...]
    labels: tuple[str, ...]
    environment: EnvironmentValues
    code_hash: str = ""
    asked: tuple[Key, ...] = ()
    run: str = ""
    state: RunState = "complete"

    __pydantic_config__ = ConfigDict(extra="forbid")


RUN: Final = TypeAdapter(StressRun)
_FINDING: Final = TypeAdapter(Finding)


@dataclass(frozen=True)
class StressFolder:
    """What a folder holds.

    `findings`: in the order in which they were asked for: family by family, trial by trial, engine
    by engine.
    """

    path: Path
    run: StressRun
    findings: list[Finding]

    @property
    def missing(self) -> set[Key]:
        """What was asked for and not come to."""
        return set(self.run.asked) - {one.key for one in self.findings}

    @property
    def planned(self) -> int:
        """How many findings there are once every trial was come to."""
        return len(self.findings) + len(self.missing)

    @property
    def whole(self) -> bool:
        """Whether every trial was come to that this run or an earlier one was asked for."""
        return not self.missing

    @classmethod
    def load(cls, folder: str | Path) -> StressFolder:
        """Read a folder.

        Raises `ResultsError` where there is none, or its database is cut short, damaged or of
        another version.
        """
        path = Path(folder)
        with reading(path) as database:
            text = get_document(database, "stress")
            rows = current_records(database, StressWriter.kind)
        if text is None:
            raise ResultsError(
                f"{folder}: not a folder of `ghostball stress`: it holds no findings"
            )
        run: StressRun = record_of(RUN, text, f"{folder}: what was tried")
        what = f"{folder}: a finding"
        findings = [record_of(_FINDING, one, what) for one, _ in rows]
        place = {key: number for number, key in enumerate(run.asked)}
        findings.sort(key=lambda one: place.get(one.key, len(place)))
        return cls(path, run, findings)

    def of(self, family: str, label: str) -> list[Finding]:
        """Return what was found in a family on an engine."""
        return [one for one in self.findings if (one.family, one.label) == (family, label)]

    def worst(self, family: str, label: str) -> Finding | None:
        """Return the worst case with a shot that shows it; None where there is none."""
        found = self.of(family, label)
        broken = [one for one in found if one.outcome == "broken"]
        shown = [one for one in broken or found if one.scene is not None]
        return max(shown, key=lambda one: one.severity, default=None)


class StressWriter(RecordStore[Finding, Finding]):
    """Writes findings as they come."""

    kind = "finding"
    adapter = _FINDING
    what = "a finding"
    document = "stress"
    others_stay = True

    def name_of(self, record: Finding) -> Key:
        """Return family, trial and label."""
        return record.key

    def stands(self, record: Finding) -> bool:
        """Whether trying it again would find the same: a crash may have had another cause."""
        return record.severity < CRASHED and record.outcome not in ("unavailable", "failed")

    def earlier(self, suite: Suite) -> StressRun | None:
        """Return what earlier runs of a suite by the same code were asked for; None without one.

        Raises `ResultsError` where what is there can't be read, or is of another suite: nothing is
        overwritten then.
        """
        if not is_stress_folder(self.path):
            return None
        run = StressFolder.load(self.path).run
        if run.suite != suite:
            raise ResultsError(
                f"{self.path}: holds what suite {run.suite} found, which stays as it is. "
                "Choose another `--out`, or remove it"
            )
        return run if run.code_hash == self.code != "" else None


def is_stress_folder(path: Path) -> bool:
    """Whether a folder holds what a stress run found.

    Raises `ResultsError` where its database is cut short, damaged or of another version.
    """
    return "stress" in documents_in(path)


def save_worst(folder: StressFolder) -> None:
    """Save the worst case of each family and engine as a scene file, in place of earlier ones."""
    place = folder.path / WORST_FOLDER
    try:
        place.mkdir(exist_ok=True)
        for old in place.glob("*.toml"):
            old.unlink()
        for family in folder.run.families:
            for label in folder.run.labels:
                worst = folder.worst(family, label)
                if worst is not None and worst.scene is not None:
                    Scene.model_validate(worst.scene).save(place / f"{stem_of(family, label)}.toml")
    except OSError as error:
        raise cannot_write(folder.path, error) from error


def stem_of(family: str, label: str) -> str:
    """Return the name of a worst case's file, without its ending."""
    safe = "".join(c if c.isalnum() or c in "-+=.," else "_" for c in label)
    return f"{family}-{safe}"

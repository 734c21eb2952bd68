"""What a stress run found, and the folder that keeps it: a database, and the worst cases."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import ConfigDict, Field, TypeAdapter

from ghostball.engine import Scene
from ghostball.validation.results.database import (
    DATABASE,
    LOCK,
    documents_in,
    get_document,
    has_database,
    put_document,
    reading,
    record_of,
    reserved,
    transaction,
    writing,
)
from ghostball.validation.results.fields import Definition, EnvironmentValues
from ghostball.validation.results.files import ResultsError, cannot_write
from ghostball.validation.stress.trial import Suite

WORST_FOLDER: Final = "worst"

Outcome = Literal["survived", "broken", "not-representable", "unavailable", "failed"]
"""Whether every shot held; not all did; the engine can't be asked that; it can't run here; the
harness couldn't judge it, which says nothing of the engine."""

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9+=., _-]*$")]
"""Of a family or a trial: part of the names of files, so that it must be no path."""

Key = tuple[str, str, str]
"""Family, trial and label."""


@dataclass(frozen=True)
class Finding:
    """What became of one trial on one engine.

    Attributes
    ----------
    family, trial, label : str
        `label` is the engine with its settings.
    outcome : str
        See `Outcome`. A crash, or a trial that took too long, is "broken".
    faults : tuple of str
        What broke; for the last three outcomes, why.
    severity, shots, broken, values
        As in a `Verdict`.
    seconds : float
        Wall time; 0 where its process died or was ended.
    scene : mapping or None
        Definition of the shot that broke worst, or came nearest.
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

    Attributes
    ----------
    suite : "quick" or "full"
    families, labels : tuple of str
    environment : mapping
        As of a run of the suite.
    code_hash : str
        Of the code that ran, and of the shipped scenes; "" where it can't be told.
    missing : tuple of (str, str, str)
        Keys of what was asked for, by this run or an earlier one of the same code, and wasn't found
        yet when this was written.
    """

    suite: Suite
    families: tuple[Name, ...]
    labels: tuple[str, ...]
    environment: EnvironmentValues
    code_hash: str = ""
    missing: tuple[Key, ...] = ()

    __pydantic_config__ = ConfigDict(extra="forbid")


_RUN: Final = TypeAdapter(StressRun)
_FINDING: Final = TypeAdapter(Finding)


@dataclass(frozen=True)
class StressFolder:
    """What a folder holds.

    Attributes
    ----------
    path : Path
    run : StressRun
    findings : list of Finding
        In the order of the run: family by family, trial by trial, engine by engine.
    """

    path: Path
    run: StressRun
    findings: list[Finding]

    @property
    def missing(self) -> set[Key]:
        """What was asked for and not come to."""
        return set(self.run.missing) - {one.key for one in self.findings}

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

        Raises
        ------
        ResultsError
            Where there is none, or its database is cut short, damaged or of another version.
        """
        path = Path(folder)
        with reading(path) as database:
            text = get_document(database, "stress")
            texts = database.execute("SELECT record FROM findings ORDER BY id").fetchall()
        if text is None:
            raise ResultsError(
                f"{folder}: not a folder of `ghostball stress`: it holds no findings"
            )
        run: StressRun = record_of(_RUN, text, f"{folder}: what was tried")
        what = f"{folder}: a finding"
        return cls(path, run, [record_of(_FINDING, one, what) for (one,) in texts])

    def of(self, family: str, label: str) -> list[Finding]:
        """Return what was found in a family on an engine."""
        return [one for one in self.findings if (one.family, one.label) == (family, label)]

    def worst(self, family: str, label: str) -> Finding | None:
        """Return the worst case with a shot that shows it; None where there is none."""
        found = self.of(family, label)
        broken = [one for one in found if one.outcome == "broken"]
        shown = [one for one in broken or found if one.scene is not None]
        return max(shown, key=lambda one: one.severity, default=None)


class StressWriter:
    """Writes findings as they come: a kill costs no more than the one in hand.

    Within `reserved`, which keeps other runs out of the folder.

    Parameters
    ----------
    path : Path
        Made where it isn't there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._database: sqlite3.Connection | None = None

    @contextmanager
    def reserved(self) -> Iterator[None]:
        """Keep other runs out of the folder while the block runs.

        Raises
        ------
        ResultsError
            Where another run is in it, it can't be written, or holds something else.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            known = (WORST_FOLDER, LOCK, DATABASE, "stress.md", "figures")
            names = sorted(one.name for one in self.path.iterdir())
            strangers = [name for name in names if not name.startswith(known)]
        except OSError as error:
            raise cannot_write(self.path, error) from error
        if strangers and not has_database(self.path):
            raise ResultsError(
                f"{self.path}: holds something else ({strangers[0]}), which stays as it is. Choose "
                "another `--out`, or empty it"
            )
        with reserved(self.path), writing(self.path) as self._database:
            yield

    def earlier(self, suite: Suite) -> StressFolder | None:
        """Return what earlier runs of a suite left in the folder; None where it is new.

        Raises
        ------
        ResultsError
            Where what is there can't be read: nothing is overwritten then.
        """
        if not is_stress_folder(self.path):
            return None
        folder = StressFolder.load(self.path)
        if folder.run.suite != suite:
            raise ResultsError(
                f"{self.path}: holds what suite {folder.run.suite} found, which stays as it is. "
                "Choose another `--out`, or remove it"
            )
        return folder

    def begin(self, run: StressRun, kept: Iterable[Finding]) -> None:
        """Note what is asked for, and keep of what is there what is taken over."""
        with self._changing() as database:
            database.execute("DELETE FROM findings")
            put_document(database, "stress", _RUN.dump_json(run))
            for finding in kept:
                _insert(database, finding)

    def add(self, finding: Finding) -> None:
        """Add a finding."""
        with self._changing() as database:
            _insert(database, finding)

    def finish(self, run: StressRun, findings: Sequence[Finding]) -> None:
        """Store all in the order of the run, and each family's worst case as a scene file."""
        self.begin(run, findings)
        save_worst(StressFolder(self.path, run, list(findings)))

    @contextmanager
    def _changing(self) -> Iterator[sqlite3.Connection]:
        assert self._database is not None, "reserved() comes first"
        with transaction(self._database):
            yield self._database


def is_stress_folder(path: Path) -> bool:
    """Whether a folder holds what a stress run found.

    Raises
    ------
    ResultsError
        Where its database is cut short, damaged or of another version.
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


def _insert(database: sqlite3.Connection, finding: Finding) -> None:
    text = _FINDING.dump_json(finding).decode()
    database.execute("INSERT INTO findings (record) VALUES (?)", [text])

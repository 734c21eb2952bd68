"""What one run of the suite found, in its results folder: complete enough to report from alone.

A case and its motion are committed together before the run says that the case is done, and what
earlier runs found stays until a case of this one takes its place: so a run that is interrupted or
killed, or finds the disk full, leaves a folder that reads back, and a next one goes on from there.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal
from uuid import uuid4

from pydantic import AfterValidator, Field, TypeAdapter

from ghostball.engine.scene.fields import SceneName
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
from ghostball.validation.results.fields import Environment
from ghostball.validation.results.files import BOARD, ResultsError, cannot_write
from ghostball.validation.results.frames import frame_of
from ghostball.validation.results.motions import forget_sides, motion_of_case, put_motion
from ghostball.validation.results.records import (
    CERTIFIED,
    CLOSED_FORM,
    INDEPENDENT,
    OUR_ENGINE,
    CaseRecord,
    Check,
    Motion,
)

if TYPE_CHECKING:
    import sqlite3

__all__ = [
    "CERTIFIED",
    "CLOSED_FORM",
    "INDEPENDENT",
    "OUR_ENGINE",
    "CaseRecord",
    "Check",
    "Motion",
    "Results",
    "ResultsError",
    "ResultsWriter",
    "has_results",
]

_PROBE = f"{LOCK}.probe"
"""Written and removed, to see whether a folder can be written; what may stay there is ours."""

RunState = Literal["running", "complete", "interrupted"]

Pair = tuple[str, str]
"""A scene's name and an engine's label."""


class _Suite(Environment):
    """What is read of what a run was asked for, and how it ended."""

    run: str = ""
    state: RunState
    scenes: tuple[SceneName, ...] = ()
    engines: tuple[str, ...] = ()
    engine_settings: dict[str, dict[str, Any] | None] = Field(default_factory=dict)
    metrics: tuple[str, ...] = ()


def _as_suite(values: dict[str, Any]) -> dict[str, Any]:
    _Suite.model_validate(values)
    return values


def _of_one_scene(case: CaseRecord) -> CaseRecord:
    """Refuse a case whose parts are of another scene than it says, or of another number of balls.

    Raises
    ------
    ValueError
    """
    if case.definition["name"] != case.scene:
        raise ValueError(f"`definition.name` must be {case.scene!r}, the name of its scene")
    n = len(case.definition["balls"])
    shapes = {"truth_positions": (n, 3), "rest_positions": (n, 3), "ball_errors": (n,)}
    for name, shape in shapes.items():
        array = getattr(case, name)
        if array is not None and array.shape != shape:
            raise ValueError(f"`{name}` must have the shape {shape}, got {array.shape}")
    return case


_RECORD: Final = TypeAdapter(Annotated[CaseRecord, AfterValidator(_of_one_scene)])
_SUITE: Final = TypeAdapter(Annotated[dict[str, Any], AfterValidator(_as_suite)])


@dataclass(frozen=True, eq=False)
class Results:
    """What a run of the suite left in a folder.

    Attributes
    ----------
    path : Path
        Of the folder.
    cases : list of CaseRecord
        In order of completion.
    environment : dict
        Machine, versions, command line ..., what was asked for, and how the run ended.
    """

    path: Path
    cases: list[CaseRecord]
    environment: dict[str, Any]

    @classmethod
    def open(cls, path: str | Path) -> Results:
        """Read the results in a folder.

        Raises
        ------
        ResultsError
            Where there are none, or their database is cut short, damaged or of another version.
        """
        folder = Path(path)
        with reading(folder) as database:
            environment = get_document(database, "suite")
            rows = database.execute(
                "SELECT record, taken_over FROM cases WHERE current ORDER BY id"
            ).fetchall()
        if environment is None:
            raise ResultsError(
                f"{folder}: holds no results of the suite. Run `ghostball validate --out {path}`"
            )
        cases = [_case_of(folder, *row) for row in rows]
        asked: dict[str, Any] = record_of(_SUITE, environment, f"{folder}: what was asked for")
        return cls(folder, cases, asked)

    @property
    def state(self) -> RunState:
        """How the run ended: "complete" or "interrupted"; "running" also where it was killed."""
        state: RunState = self.environment["state"]
        return state

    @property
    def planned(self) -> int:
        """How many cases there would have been; those that are there where nothing says."""
        asked = [len(self.environment.get(key, ())) for key in ("scenes", "engines")]
        return asked[0] * asked[1] or len(self.cases)

    @property
    def scene_names(self) -> list[str]:
        """Scenes in the order in which the run was asked for them; only those with a case."""
        return self._in_order("scenes", [case.scene for case in self.cases])

    @property
    def labels(self) -> list[str]:
        """Engines in the order in which the run was asked for them; only those with a case."""
        return self._in_order("engines", [case.label for case in self.cases])

    def case(self, scene: str, label: str) -> CaseRecord | None:
        """Return the case of a scene and an engine label, or None where there is none."""
        for case in self.cases:
            if case.scene == scene and case.label == label:
                return case
        return None

    def motion(self, case: CaseRecord) -> Motion | None:
        """Read the sampled motion of a case, or None where it did not run.

        Raises
        ------
        ResultsError
            Where it is damaged.
        """
        return motion_of_case(self.path, case.scene, case.label)

    def to_frame(self, table: str = "cases") -> Any:
        """Return a table as a data frame, of polars where that is installed, else of pandas.

        Parameters
        ----------
        table : str
            One of `validation.results.frames.TABLES`, such as "cases", "checks" or "events".

        Raises
        ------
        GhostballError
            Where there is no such table, or neither library is installed.
        """
        return frame_of(self.path, table)

    def _in_order(self, key: str, present: list[str]) -> list[str]:
        asked = [str(name) for name in self.environment.get(key, ())]
        return [name for name in dict.fromkeys(asked + present) if name in set(present)]


class ResultsWriter:
    """Writes a results folder, case by case.

    Making one checks that the folder may be used and can be written, and changes nothing in it;
    earlier results stay until `begin`. From there, or from `reserved`, to `finish` no other run, of
    this process or another, gets into the folder.

    Raises
    ------
    ResultsError
        Where the path is no folder, can't be made or written, or holds something else.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._run = uuid4().hex
        self._environment: dict[str, Any] = {}
        self._held = ExitStack()
        self._database: sqlite3.Connection | None = None
        self._is_reserved = False
        self._prepare()

    @contextmanager
    def reserved(self) -> Iterator[None]:
        """Keep other runs out, from before the folder is read: what was read stays true.

        Raises
        ------
        ResultsError
            Where another one is in it, or what is there can't be read.
        """
        with reserved(self.path):
            documents_in(self.path)  # what can't be read is refused before anything runs
            self._is_reserved = True
            try:
                yield
            finally:
                self._is_reserved = False
                self._held.close()

    def begin(self, environment: Mapping[str, Any], taken_over: Collection[Pair] = ()) -> None:
        """Start anew: what earlier runs found is kept aside, but for what is taken over.

        Parameters
        ----------
        environment : mapping
        taken_over : collection of (str, str)
            Scene and label of the earlier cases that are results of this run too.

        Raises
        ------
        ResultsError
            Where another run writes into the folder, or it can't be written.
        """
        if not self._is_reserved:
            self._held.enter_context(reserved(self.path))
        database = self._database = self._held.enter_context(writing(self.path))
        with transaction(database):
            database.execute("UPDATE cases SET current = 0, taken_over = 0")
            database.executemany(
                "UPDATE cases SET current = 1, taken_over = 1 WHERE scene = ? AND label = ?",
                taken_over,
            )
            # Of other results than these.
            database.execute("DELETE FROM documents WHERE name = 'regression'")
            forget_sides(database)
            self._environment = {**environment, "run": self._run, "state": "running"}
            put_document(database, "suite", json.dumps(self._environment))

    def write(self, record: CaseRecord, motion: Motion | None) -> None:
        """Add a case in place of what an earlier run found; `begin` must have been called."""
        assert self._database is not None, "begin() comes first"
        with transaction(self._database):
            execute = self._database.execute
            execute("DELETE FROM cases WHERE scene = ? AND label = ?", [record.scene, record.label])
            text = _RECORD.dump_json(record).decode()
            number = execute("INSERT INTO cases (record, current) VALUES (?, 1)", [text]).lastrowid
            if motion is not None:
                put_motion(self._database, motion, case_id=number)

    def finish(self, state: RunState, *, still_of_use: str | None = None) -> None:
        """Note how the run ended, and let other runs in; where it never began, change nothing.

        Parameters
        ----------
        state : RunState
        still_of_use : str, optional
            Hash of the code whose earlier cases stay kept aside; all do where it is left out.
        """
        try:
            if self._database is not None and self.begun:
                with transaction(self._database):
                    about = self._environment | {"state": state}
                    put_document(self._database, "suite", json.dumps(about))
                    if still_of_use is not None:
                        self._database.execute(
                            "DELETE FROM cases WHERE NOT current AND code_hash != ?", [still_of_use]
                        )
        finally:
            self._database = None
            self._held.close()

    @property
    def begun(self) -> bool:
        """Whether earlier results gave way to those of this run, be they none so far."""
        if not has_database(self.path):
            return False
        with reading(self.path) as database:
            return self._run in (get_document(database, "suite") or "")

    def _prepare(self) -> None:
        try:
            if self.path.exists() and not self.path.is_dir():
                raise ResultsError(f"{self.path}: not a folder. Choose another `--out`")
            self.path.mkdir(parents=True, exist_ok=True)
            others = (path for path in self.path.iterdir() if not _is_ours(path))
            if not has_database(self.path) and any(True for _ in others):
                raise ResultsError(
                    f"{self.path}: not empty and not a results folder of ours, so nothing in it "
                    "is replaced. Choose another `--out`, or empty it"
                )
            # Killed between the two, a run must not leave what the next takes for a user's file.
            probe = self.path / _PROBE
            probe.touch()
            probe.unlink(missing_ok=True)  # another run may have been quicker
        except OSError as error:
            raise cannot_write(self.path, error) from error


def _is_ours(path: Path) -> bool:
    """Whether a path in a results folder is one of its files, or results of another command.

    Such as out/regress, or out/regress/ENGINE, in out; or out/board.
    """
    if not path.is_dir():
        return path.name.startswith((LOCK, DATABASE))
    inside = list(path.iterdir())
    if [one.name for one in inside] == [BOARD]:
        return True
    return has_database(path) or (bool(inside) and all(map(has_database, inside)))


def has_results(folder: Path) -> bool:
    """Whether a folder holds results of the suite.

    Raises
    ------
    ResultsError
        Where its database is cut short, damaged or of another version.
    """
    return "suite" in documents_in(folder)


def reusable_cases(folder: Path, code_hash: str) -> tuple[int, dict[str, CaseRecord]]:
    """Return how many cases a folder holds that the same code could reuse, and those by some code.

    The latter by the hash of their inputs.

    Raises
    ------
    ResultsError
        As of `has_results`.
    """
    if not has_database(folder):
        return 0, {}
    with reading(folder) as database:
        (stored,) = database.execute(
            "SELECT count(*) FROM cases WHERE inputs_hash != ''"
        ).fetchone()
        rows = database.execute(
            "SELECT inputs_hash, record FROM cases WHERE inputs_hash != '' AND code_hash = ?",
            [code_hash],
        ).fetchall()
    return stored, {inputs: _case_of(folder, text) for inputs, text in rows}


def _case_of(folder: Path, text: str, taken_over: int = 0) -> CaseRecord:
    case: CaseRecord = record_of(_RECORD, text, f"{folder}: a case")
    return replace(case, taken_over=True) if taken_over else case

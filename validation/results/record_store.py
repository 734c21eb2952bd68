"""The records of one kind in a results folder, written as they come by `runs.runner.run`.

A record is committed before the run says that it is done, and what earlier runs found stays until a
record of this one takes its place: so a run that is interrupted or killed, or finds the disk full,
leaves a folder that reads back, and a next one continues from there.
"""

from __future__ import annotations

import json
import sqlite3
from abc import abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, ClassVar, Generic, Literal, TypeVar
from uuid import uuid4

from pydantic import TypeAdapter

from ghostball.validation.results.database import (
    DATABASE,
    LOCK,
    Document,
    Kind,
    current_records,
    documents_in,
    get_document,
    has_database,
    name_text,
    put_document,
    reading,
    record_of,
    reserved,
    transaction,
    writing,
)
from ghostball.validation.results.files import ResultsError, cannot_write

W = TypeVar("W")
R = TypeVar("R")

Name = tuple[str, ...]
"""What a task is called: it tells it from all others of its kind, such as a scene and an engine."""

RunState = Literal["running", "complete", "interrupted"]

_PROBE = f"{LOCK}.probe"
"""Written and removed, to see whether a folder can be written; what may stay there is ours."""


class RecordStore(Generic[W, R]):
    """Writes the records of one kind into a folder; a subclass says what they are.

    Making one checks that the folder may be used and can be written, and changes nothing in it;
    earlier records stay until `begin`. From there, or from `reserved`, to `finish` no other run, of
    this process or another, gets into the folder.

    `code`: hash of the code that makes the records; "" where it isn't known, and nothing is reused.
    `code_of`: returns the hash of all code that makes the record of a name, an engine's own
        included; left out, `code`.

    `adapter`: reads and writes a record as JSON.
    `what`: what a record is called where it is damaged.
    `document`: what says what a run was asked for, and how it ended; None where nothing does.
    `others_stay`: whether records by the same code that a run isn't asked for are a part of what it
        leaves.

    Raises `ResultsError` where the path is no folder, can't be made or written, or holds something
    else.
    """

    kind: ClassVar[Kind]
    adapter: ClassVar[TypeAdapter[Any]]
    what: ClassVar[str]
    document: ClassVar[Document | None] = None
    others_stay: ClassVar[bool] = False

    def __init__(
        self, path: str | Path, code: str = "", code_of: Callable[[Name], str] | None = None
    ) -> None:
        self.path, self.code = Path(path), code
        self._code_of = code_of or (lambda _: code)
        self._run = uuid4().hex
        self._about: dict[str, Any] = {}
        self._held = ExitStack()
        self._database: sqlite3.Connection | None = None
        self._is_reserved = self._has_begun = False
        self._prepare()

    @abstractmethod
    def name_of(self, record: R) -> Name:
        """Return what the task of a record is called."""

    def record_of(self, given: W) -> R:
        """Return the record of what a task gave: that itself, unless something lies beside it."""
        record: Any = given
        return record  # type: ignore[no-any-return]

    def stands(self, record: R) -> bool:  # noqa: ARG002
        """Whether the task would come to the same again: not to a failure, or a limit of time."""
        return True

    def reused(self, record: R) -> R:
        """Return a record of an earlier run as one of this run has it."""
        return record

    def put_beside(self, database: sqlite3.Connection, number: int, given: W) -> None:
        """Store what goes with a record, whose row has this number; within a `transaction`."""

    @contextmanager
    def reserved(self) -> Iterator[None]:
        """Keep other runs out, from before the folder is read: what was read stays true.

        Raises `ResultsError` where another one is in it, or what is there can't be read.
        """
        with reserved(self.path):
            documents_in(self.path)  # what can't be read is refused before anything runs
            self._is_reserved = True
            try:
                yield
            finally:
                self._is_reserved = False
                self._held.close()

    def known(self) -> tuple[int, dict[str, R]]:
        """Return how many records may be reused by some code, and those by this one, by key.

        Raises `ResultsError` where they can't be read.
        """
        if not has_database(self.path):
            return 0, {}
        with reading(self.path) as database:
            (stored,) = database.execute(
                "SELECT count(*) FROM records WHERE kind = ? AND key != ''", [self.kind]
            ).fetchone()
            rows = database.execute(
                "SELECT key, record FROM records WHERE kind = ? AND key != '' AND code = ?",
                [self.kind, self.code],
            ).fetchall()
        return stored, {key: self.reused(self._read(text)) for key, text in rows}

    def current(self) -> dict[Name, R]:
        """Return the records of the last run by name: those reused, then as they were written.

        Raises `ResultsError` where they can't be read.
        """
        if not has_database(self.path):
            return {}
        with reading(self.path) as database:
            rows = current_records(database, self.kind)
        found = (
            self.reused(self._read(text)) if reused else self._read(text) for text, reused in rows
        )
        return {self.name_of(record): record for record in found}

    def begin(self, about: Mapping[str, Any], reused: Collection[Name] = ()) -> None:
        """Start anew: what earlier runs found is kept aside, but for what is reused.

        `about`: what the document says, as plain values; how far the run is comes to it.

        Raises `ResultsError` where another run writes into the folder, or it can't be written.
        """
        if not self._is_reserved:
            self._held.enter_context(reserved(self.path))
        database = self._database = self._held.enter_context(writing(self.path))
        with transaction(database):
            there = database.execute(
                "SELECT name, code FROM records WHERE kind = ? AND current", [self.kind]
            ).fetchall()
            database.execute(
                "UPDATE records SET current = 0, reused = 0 WHERE kind = ?", [self.kind]
            )
            database.executemany(
                "UPDATE records SET current = 1 WHERE kind = ? AND name = ?",
                [(self.kind, name) for name, code in there if self._stays(name, code)],
            )
            database.executemany(
                "UPDATE records SET current = 1, reused = 1 WHERE kind = ? AND name = ?",
                [(self.kind, name_text(name)) for name in reused],
            )
            self.forget(database)
            self._about = {**about, "run": self._run}
            self._note(database, "running")
        self._has_begun = True

    def forget(self, database: sqlite3.Connection) -> None:
        """Remove what is of other records than these are to be; within a `transaction`."""

    def write(self, given: W, key: str = "") -> R:
        """Add a record in place of what an earlier run found; `begin` must have been called.

        `key`: hash of all that it depends on besides the code; "" where it must be made again.
        """
        assert self._database is not None, "begin() comes first"
        record = self.record_of(given)
        name, code = name_text(self.name_of(record)), self._code_of(self.name_of(record))
        reusable = self.code and self.stands(record)
        text = self.adapter.dump_json(record).decode()
        with transaction(self._database):
            execute = self._database.execute
            execute("DELETE FROM records WHERE kind = ? AND name = ?", [self.kind, name])
            number = execute(
                "INSERT INTO records (kind, name, key, code, current, record) "
                "VALUES (?, ?, ?, ?, 1, ?)",
                [self.kind, name, key if reusable else "", code, text],
            ).lastrowid
            assert number is not None
            self.put_beside(self._database, number, given)
        return record

    def finish(self, state: RunState) -> None:
        """Note how the run ended, and let other runs in; where it never began, change nothing.

        What the code of a whole run could never reuse goes: the folder would grow by each edit.
        """
        try:
            if self._database is not None and self._has_begun:
                with transaction(self._database):
                    self._note(self._database, state)
                    if state == "complete" and self.code:
                        self._database.execute(
                            "DELETE FROM records WHERE kind = ? AND NOT current "
                            "AND (code != ? OR key = '')",
                            [self.kind, self.code],
                        )
        finally:
            self._database = None
            self._held.close()

    @property
    def begun(self) -> bool:
        """Whether earlier records gave way to those of this run, be they none so far."""
        if self.document is None or not has_database(self.path):
            return self._has_begun
        with reading(self.path) as database:
            return self._run in (get_document(database, self.document) or "")

    def _stays(self, name: str, code: str) -> bool:
        """Return True if a record of an earlier run also belongs to the results of this run."""
        return self.others_stay and code != "" and code == self._code_of(tuple(json.loads(name)))

    def _note(self, database: sqlite3.Connection, state: RunState) -> None:
        if self.document is not None:
            put_document(database, self.document, json.dumps(self._about | {"state": state}))

    def _read(self, text: str) -> R:
        record: R = record_of(self.adapter, text, f"{self.path}: {self.what}")
        return record

    def _prepare(self) -> None:
        try:
            if self.path.exists() and not self.path.is_dir():
                raise ResultsError(f"{self.path}: not a folder. Choose another `--out`")
            self.path.mkdir(parents=True, exist_ok=True)
            others = (path for path in self.path.iterdir() if not _is_ours(path))
            if not has_database(self.path) and any(True for _ in others):
                raise ResultsError(
                    f"{self.path}: not empty and not a Ghostball results folder, so nothing was "
                    "overwritten. Choose another `--out`, or empty it"
                )
            # Killed between the two, a run must not leave what the next takes for a user's file.
            probe = self.path / _PROBE
            probe.touch()
            probe.unlink(missing_ok=True)  # another run may have been faster
        except OSError as error:
            raise cannot_write(self.path, error) from error


def _is_ours(path: Path) -> bool:
    """Whether a path in a results folder is one of its files, or results of another command.

    Such as out/against/REVISION in out.
    """
    if not path.is_dir():
        return path.name.startswith((LOCK, DATABASE))
    inside = list(path.iterdir())
    return has_database(path) or (bool(inside) and all(map(has_database, inside)))

"""The records of one kind in a results folder; `runs.runner.run` writes each one when it is ready.

A record is committed before the run reports it as finished, and results of earlier runs stay until
a record of this run replaces them. A run that is interrupted, killed, or stopped by a full disk
therefore leaves a readable folder, and the next run continues from there.
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
"""Name of a task, unique among tasks of its kind, such as a scene and an engine."""

RunState = Literal["running", "complete", "interrupted"]

_PROBE = f"{LOCK}.probe"
"""File that is created and removed to test whether a folder is writable; a leftover is harmless."""


class RecordStore(Generic[W, R]):
    """Writes the records of one kind into a folder; a subclass defines the kind.

    The constructor checks that the folder can be used and written, and changes nothing in it.
    Earlier records stay until `begin`. From `begin`, or from `reserved`, until `finish`, a lock
    keeps other runs out, in this process or another.

    `code`: hash of the code that makes the records; "" if unknown: then nothing is reused.
    `code_of`: returns the hash of all code that makes the record of a name, including that of an
        external engine; default: `code`.
    `adapter`: reads and writes a record as JSON.
    `what`: name of the records in messages about damaged ones.
    `document`: name of the document with the options and the state of a run; None: no document.
    `others_stay`: whether the results of this run also contain stored records of the same code that
        this run doesn't make.

    Raises `ResultsError` if the path isn't a folder, can't be created or written, or holds other
    files.
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
        """Return the name of the task of a record."""

    def record_of(self, given: W) -> R:
        """Return the record in a task's result: the result itself, unless it has other parts."""
        record: Any = given
        return record  # type: ignore[no-any-return]

    def is_repeatable(self, record: R) -> bool:  # noqa: ARG002
        """Return True if running the task again would give the same record."""
        return True

    def reused(self, record: R) -> R:
        """Return a record of an earlier run in the form that it has in this run."""
        return record

    def put_beside(self, database: sqlite3.Connection, number: int, given: W) -> None:
        """Store parts that belong to the record in row `number`; called within a `transaction`."""

    @contextmanager
    def reserved(self) -> Iterator[None]:
        """Lock the folder before it is read, so that its content can't change afterwards.

        Raises `ResultsError` if another run holds the lock, or if the results can't be read.
        """
        with reserved(self.path):
            documents_in(self.path)  # unreadable results are refused before anything runs
            self._is_reserved = True
            try:
                yield
            finally:
                self._is_reserved = False
                self._held.close()

    def known(self) -> tuple[int, dict[str, R]]:
        """Return the number of reusable records of any code, and by key those of the present code.

        Raises `ResultsError` if they can't be read.
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
        """Return the records of the last run by name: reused records first, then in order.

        Raises `ResultsError` if they can't be read.
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
        """Start a run: earlier records are kept but no longer current, except reused records.

        `about`: content of the document, as plain values; the state of the run is added.

        Raises `ResultsError` if another run is writing into the folder, or if it can't be written.
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
        """Remove documents that belong to the earlier records; within a `transaction`."""

    def write(self, given: W, key: str = "") -> R:
        """Store a record in place of an earlier one with its name; call `begin` first.

        `key`: hash of everything that the record depends on besides the code; "" if it can't be
            reused.
        """
        assert self._database is not None, "begin() comes first"
        record = self.record_of(given)
        name, code = name_text(self.name_of(record)), self._code_of(self.name_of(record))
        reusable = self.code and self.is_repeatable(record)
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
        """Store how the run ended, and release the lock; without `begin`, change nothing.

        After a complete run, records of other code are removed: otherwise the folder would grow
        with every edit of the code.
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
        """Whether the records of this run, possibly none so far, replaced earlier ones."""
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
            # A run killed between the two lines must not leave a file that the next run takes for
            # the user's.
            probe = self.path / _PROBE
            probe.touch()
            probe.unlink(missing_ok=True)  # another run may have removed it
        except OSError as error:
            raise cannot_write(self.path, error) from error


def _is_ours(path: Path) -> bool:
    """Return True if a path in a results folder is a file of Ghostball, or a results subfolder.

    For example, out/against/REVISION is a results subfolder of out.
    """
    if not path.is_dir():
        return path.name.startswith((LOCK, DATABASE))
    inside = list(path.iterdir())
    return has_database(path) or (bool(inside) and all(map(has_database, inside)))

"""The database of a results folder: one SQLite file, changed in transactions.

A committed transaction survives a kill and a full disk; an uncommitted one leaves no trace. Other
processes may read while a run writes. A record of any kind is a row that holds the record as JSON.
Views provide its searchable fields as columns, so queries need no code of Ghostball:

    sqlite3 out/results.db "SELECT scene, label, value FROM checks WHERE NOT passed"
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, Final, Literal
from urllib.parse import quote

from filelock import FileLock, Timeout
from pydantic import TypeAdapter, ValidationError

from ghostball.validation.results.files import ResultsError, cannot_write, describe_validation_error

DATABASE: Final = "results.db"
LOCK: Final = ".lock"

SCHEMA: Final = 15
"""Version of the tables and of the records in them; other versions are refused."""

APPLICATION: Final = int.from_bytes(b"ball")
"""Marks a database of Ghostball: SQLite stores this number in the header of the file."""

Document = Literal["suite", "regression"]
"""Contents that a folder has once: for each kind of run, its options and how it ended."""

Kind = Literal["case", "likeness"]
"""Kinds of records; a folder has many of each kind, each with its own name."""

_TABLES = """
CREATE TABLE documents (
    name TEXT PRIMARY KEY,
    content TEXT NOT NULL CHECK (json_valid(content))
);

-- `current`: the record belongs to the last run of its kind; other records are kept for later runs.
-- `key`: hash of everything that a record depends on besides the code; "" if it can't be reused.
CREATE TABLE records (
    id INTEGER PRIMARY KEY,
    kind TEXT NOT NULL,
    name TEXT NOT NULL,
    key TEXT NOT NULL,
    code TEXT NOT NULL,
    current INTEGER NOT NULL,
    reused INTEGER NOT NULL DEFAULT 0,
    record TEXT NOT NULL CHECK (json_valid(record)),
    UNIQUE (kind, name)
);
CREATE TABLE motions (
    id INTEGER PRIMARY KEY,
    record_id INTEGER UNIQUE REFERENCES records ON DELETE CASCADE,
    content BLOB NOT NULL
);
-- The time has no column type: SQLite would store -0.0 in a REAL column as 0.0.
CREATE TABLE events (
    motion_id INTEGER NOT NULL REFERENCES motions ON DELETE CASCADE,
    t NOT NULL,
    kind TEXT NOT NULL,
    a INTEGER NOT NULL,
    b INTEGER NOT NULL
);
CREATE INDEX events_of_motion ON events (motion_id);
CREATE VIEW cases AS
    SELECT id, record, reused,
        json_extract(record, '$.scene') AS scene,
        json_extract(record, '$.label') AS label,
        json_extract(record, '$.accuracy.kind') AS accuracy
    FROM records WHERE kind = 'case' AND current;
CREATE VIEW metrics AS
    SELECT scene, label, json_each.key AS name, json_each.value AS value
    FROM cases, json_each(record, '$.metrics');
CREATE VIEW checks AS
    SELECT scene, label,
        json_extract(json_each.value, '$.metric') AS metric,
        json_extract(json_each.value, '$.value') AS value,
        json_extract(json_each.value, '$.unit') AS unit,
        json_extract(json_each.value, '$.limit_kind') AS limit_kind,
        json_extract(json_each.value, '$.limit') AS "limit",
        json_extract(json_each.value, '$.passed') AS passed,
        json_extract(json_each.value, '$.reason') AS reason,
        json_extract(json_each.value, '$.note') AS note
    FROM cases, json_each(record, '$.checks');
"""


def has_database(folder: Path) -> bool:
    """Return True if a folder holds a results database, even a damaged or outdated one."""
    return (folder / DATABASE).is_file()


@contextmanager
def reading(folder: Path) -> Iterator[sqlite3.Connection]:
    """Open the database of a folder for reading.

    Raises `ResultsError` if there is no database, or if it is cut short, damaged, or of another
    version.
    """
    path = folder / DATABASE
    if not path.is_file():
        raise ResultsError(
            f"{folder}: not a results folder: it has no {DATABASE}. Name the folder that "
            "`ghostball validate --out` wrote"
            if folder.is_dir()
            else f"{folder}: no such results folder. Create one with `ghostball validate --out "
            f"{folder}`"
        )
    # Not opened read-only, because the next process that opens it must roll back killed
    # transactions.
    with _explained(path), closing(_connect(path, "rw")) as database:
        _check(database, path)
        database.execute("PRAGMA query_only = ON")
        # One transaction: everything read until the end is from one state, even while a run writes.
        database.execute("BEGIN")
        yield database


@contextmanager
def writing(folder: Path) -> Iterator[sqlite3.Connection]:
    """Open or create the database of a folder for changes; each change needs a `transaction`.

    Raises `ResultsError` in the cases of `reading`, or if the folder can't be written.
    """
    path = folder / DATABASE
    with _explained(path):
        if not path.exists():
            _create(path)
    with _explained(path), closing(_connect(path, "rw")) as database:
        _check(database, path)
        # WAL mode: commits need not wait for the disk, and readers need not wait for a run.
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("PRAGMA synchronous = NORMAL")
        database.execute("PRAGMA foreign_keys = ON")
        try:
            yield database
        finally:
            # Back to a single file, which can be copied, and read from a read-only folder. While
            # another process reads it, it stays in WAL mode, which is equally safe.
            with suppress(sqlite3.OperationalError):
                database.execute("PRAGMA busy_timeout = 0")
                database.execute("PRAGMA journal_mode = DELETE")


@contextmanager
def transaction(database: sqlite3.Connection) -> Iterator[None]:
    """Change a database completely or not at all, whatever is raised in the block (even Ctrl-C).

    Raises `ResultsError` if the disk is full, or if another process is writing.
    """
    (_, _, path) = database.execute("PRAGMA database_list").fetchone()
    with _explained(Path(path)), database:
        database.execute("BEGIN IMMEDIATE")
        yield


@contextmanager
def reserved(folder: Path) -> Iterator[None]:
    """Lock a folder for this run. The operating system releases the lock when the process ends.

    Raises `ResultsError` if another run holds the lock, or if the folder can't be written.
    """
    with ExitStack() as held:
        try:
            held.enter_context(FileLock(folder / LOCK, timeout=0, thread_local=False))
        except Timeout:
            raise ResultsError(
                f"{folder}: another run is writing to this folder. Wait until that run finishes, "
                "or choose another `--out`"
            ) from None
        except OSError as error:
            raise cannot_write(folder, error) from error
        yield


def documents_in(folder: Path) -> frozenset[str]:
    """Return the kinds of runs that a folder holds results of; empty without a database."""
    if not has_database(folder):
        return frozenset()
    with reading(folder) as database:
        return frozenset(name for (name,) in database.execute("SELECT name FROM documents"))


def get_document(database: sqlite3.Connection, name: Document) -> str | None:
    """Return a document as JSON, or None if it doesn't exist."""
    found = database.execute("SELECT content FROM documents WHERE name = ?", [name]).fetchone()
    return None if found is None else str(found[0])


def put_document(database: sqlite3.Connection, name: Document, content: str) -> None:
    """Store a document in place of the earlier one; call it within a `transaction`."""
    database.execute("INSERT OR REPLACE INTO documents VALUES (?, ?)", [name, content])


def current_records(database: sqlite3.Connection, kind: Kind) -> list[tuple[str, bool]]:
    """Return the records of a kind from the last run, as JSON, and whether each one is reused."""
    return [
        (str(text), bool(reused))
        for text, reused in database.execute(
            "SELECT record, reused FROM records WHERE kind = ? AND current ORDER BY id", [kind]
        )
    ]


def name_text(name: Sequence[str]) -> str:
    """Return the name of a record in the form that its row stores."""
    return json.dumps(list(name), ensure_ascii=False)


def record_of(adapter: TypeAdapter[Any], text: str, what: str) -> Any:
    """Read a record; it is valid unless somebody edited the database.

    Raises `ResultsError` if it is invalid; `what` names the record in the message.
    """
    try:
        return adapter.validate_json(text)
    except ValidationError as error:
        raise ResultsError(
            f"{what} is damaged: {describe_validation_error(error)}. {REMEDY}"
        ) from None


REMEDY: Final = "Move the file away, or choose another `--out`, and run again"
"""Remedy for stored results that can't be read: a sentence without its full stop."""


def _create(path: Path) -> None:
    """Create a database without rows; it gets its final name only when it is complete."""
    part = path.with_name(f"{path.name}.part")
    try:
        part.unlink(missing_ok=True)
        with closing(_connect(part, "rwc")) as database:
            database.executescript(
                f"BEGIN; {_TABLES} PRAGMA application_id = {APPLICATION};"
                f"PRAGMA user_version = {SCHEMA}; COMMIT"
            )
        part.replace(path)
    except OSError as error:
        raise cannot_write(path.parent, error) from error


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    # The connection may be closed by another thread than its creator; two threads never use it at
    # once.
    return sqlite3.connect(
        f"file:{quote(str(path))}?mode={mode}",
        uri=True,
        isolation_level=None,
        check_same_thread=False,
    )


def _check(database: sqlite3.Connection, path: Path) -> None:
    (application,) = database.execute("PRAGMA application_id").fetchone()
    (version,) = database.execute("PRAGMA user_version").fetchone()
    if application != APPLICATION:
        raise ResultsError(f"{path}: contains no Ghostball results. {REMEDY}")
    if version != SCHEMA:
        raise ResultsError(
            f"{path}: its version must be {SCHEMA}, got {version}: a different version of "
            f"Ghostball wrote it. {REMEDY}"
        )
    if not _tables_of(_TABLES) <= _tables(database):
        raise _damaged(path, "its tables are wrong")
    state = path.stat()
    _check_pages(path, state.st_size, state.st_mtime_ns)


# A report reads the motion of each case, so an unchanged file is checked only once. A comparison
# alternates between two databases, so several results are cached.
@lru_cache(maxsize=4)
def _check_pages(path: Path, *_: int) -> None:
    """Let SQLite check all pages, and that the rows obey the constraints of their tables."""
    with closing(_connect(path, "rw")) as database:
        (said,) = database.execute("PRAGMA quick_check(1)").fetchone()
    if said != "ok":
        raise _damaged(path, " ".join(said.split()))


def _tables(database: sqlite3.Connection) -> frozenset[str]:
    """Return the SQL statements that created the tables; a user may have added tables."""
    return frozenset(sql for (sql,) in database.execute("SELECT sql FROM sqlite_schema") if sql)


@cache
def _tables_of(script: str) -> frozenset[str]:
    with closing(sqlite3.connect(":memory:")) as database:
        database.executescript(script)
        return _tables(database)


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Replace errors of SQLite by a `ResultsError` with one line that explains the problem."""
    try:
        yield
    except UnicodeDecodeError as error:  # in a name that SQLite quotes in its message
        raise _damaged(path, error) from None
    except sqlite3.Error as error:
        # For text that isn't UTF-8, Python itself raises an error without a code.
        code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_CORRUPT) & 0xFF
        if code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB):
            raise _damaged(path, error) from None
        if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
            raise ResultsError(
                f"{path}: another process is writing to this file. Try again later"
            ) from None
        if code in _DISK_ERRORS:
            raise ResultsError(
                f"{path}: can't be read or written: {error}. Make room, or choose another `--out`"
            ) from None
        raise  # a bug of Ghostball


def _damaged(path: Path, why: object) -> ResultsError:
    return ResultsError(f"{path}: is truncated or damaged ({why}). {REMEDY}")


_DISK_ERRORS: Final = (
    *(sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_CANTOPEN),
    *(sqlite3.SQLITE_READONLY, sqlite3.SQLITE_PERM, sqlite3.SQLITE_NOLFS),
)

"""The database of a folder: changes are atomic, and unusable files are refused with a message."""

from __future__ import annotations

import json
import os
import re
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from ghostball.validation.results.database import (
    APPLICATION,
    DATABASE,
    LOCK,
    SCHEMA,
    documents_in,
    get_document,
    has_database,
    put_document,
    reading,
    reserved,
    transaction,
    writing,
)
from ghostball.validation.results.files import ResultsError


def put_suite(database: sqlite3.Connection, content: str) -> None:
    put_document(database, "suite", json.dumps(content))


def put(folder: Path, content: str) -> None:
    with writing(folder) as database, transaction(database):
        put_suite(database, content)


def got(folder: Path) -> str:
    with reading(folder) as database:
        return str(json.loads(get_document(database, "suite") or "null"))


def in_other_process(folder: Path, *lines: str) -> subprocess.Popen[str]:
    """Start a process that runs `lines`; they may use `folder` and the names of the module."""
    script = (
        "import os, sys, time; from pathlib import Path; folder = Path(sys.argv[1])\n"
        "from ghostball.validation.results.database import *\n"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", script + "\n".join(lines), str(folder)]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)


def test_what_is_written_reads_back_and_leaves_one_file(tmp_path: Path) -> None:
    assert not has_database(tmp_path)
    assert documents_in(tmp_path) == frozenset()
    put(tmp_path, "one")
    put(tmp_path, "two")
    assert got(tmp_path) == "two"
    assert documents_in(tmp_path) == {"suite"}
    assert [path.name for path in tmp_path.iterdir()] == [DATABASE]


@pytest.mark.parametrize("raised", [KeyboardInterrupt, ZeroDivisionError])
def test_a_change_is_whole_or_not_at_all(tmp_path: Path, raised: type[BaseException]) -> None:
    put(tmp_path, "before")
    with writing(tmp_path) as database:
        with pytest.raises(raised), transaction(database):  # noqa: PT012
            put_suite(database, "after")
            database.execute("DELETE FROM documents")
            raise raised
        with transaction(database):  # the next transaction starts without this change
            put_document(database, "regression", "{}")
    assert got(tmp_path) == "before"
    assert documents_in(tmp_path) == {"suite", "regression"}


def test_who_reads_sees_one_state_while_another_writes(tmp_path: Path) -> None:
    put(tmp_path, "before")
    with writing(tmp_path) as run, reading(tmp_path) as seen:
        before = get_document(seen, "suite")
        with transaction(run):
            put_suite(run, "after")
        assert get_document(seen, "suite") == before == '"before"'
        assert got(tmp_path) == "after"
        with pytest.raises(sqlite3.OperationalError, match="readonly"):
            seen.execute("DELETE FROM documents")
    assert got(tmp_path) == "after"


def test_a_killed_process_loses_nothing_that_it_had_committed(tmp_path: Path) -> None:
    process = in_other_process(
        tmp_path,
        "with writing(folder) as database:",
        "    with transaction(database): put_document(database, 'suite', '\"committed\"')",
        "    with transaction(database):",
        "        put_document(database, 'suite', '\"not yet\"')",
        "        os._exit(9)",
    )
    process.communicate()
    assert process.returncode == 9
    assert got(tmp_path) == "committed"
    put(tmp_path, "continues")
    assert got(tmp_path) == "continues"


# --- what can't be used


def refused(folder: Path) -> str:
    """Return the message about an unusable database, which is the same for reading and writing."""
    said = set()
    for use in (got, lambda one: put(one, "more")):
        with pytest.raises(ResultsError) as error:
            use(folder)
        said.add(str(error.value))
    (message,) = said
    assert "\n" not in message
    assert message.startswith(str(folder / DATABASE))
    return message


def cut_to(part: float) -> Callable[[Path], None]:
    return lambda path: os.truncate(path, int(part * path.stat().st_size))


def after(script: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        with closing(sqlite3.connect(path)) as database:
            database.executescript(script)

    return change


def anyones(path: Path) -> None:
    path.unlink()
    after("CREATE TABLE cases (record)")(path)


OTHER_VERSION = f"its version must be {SCHEMA}, got %d: a different version of Ghostball wrote it"
DAMAGE: list[tuple[Callable[[Path], object], str]] = [
    *((cut_to(part), "is truncated or damaged (") for part in (0.02, 0.3, 0.6, 0.99)),
    (lambda path: path.write_text("years of work\n" * 99), "damaged (file is not a database)"),
    (anyones, "contains no Ghostball results"),
    (after(f"PRAGMA user_version = {SCHEMA - 1}"), OTHER_VERSION % (SCHEMA - 1)),
    (after(f"PRAGMA user_version = {SCHEMA + 1}"), OTHER_VERSION % (SCHEMA + 1)),
    (after("DROP TABLE events"), "damaged (its tables are wrong)"),
    (
        after("PRAGMA ignore_check_constraints = ON; UPDATE documents SET content = 'no json'"),
        "damaged (CHECK constraint failed in documents)",
    ),
]
"""Damage to the file, and a part of the message."""


@pytest.mark.parametrize(("damage", "said"), DAMAGE)
def test_what_cannot_be_used_is_said_and_stays(
    tmp_path: Path, damage: Callable[[Path], object], said: str
) -> None:
    put(tmp_path, "x" * 50_000)
    path = tmp_path / DATABASE
    damage(path)
    left = path.read_bytes()
    message = refused(tmp_path)
    assert said in message
    assert message.endswith("Move the file away, or choose another `--out`, and run again")
    assert path.read_bytes() == left


def test_nobody_sees_a_database_before_it_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Fails if a process that reads the folder while a run starts finds a foreign database.
    with monkeypatch.context() as killed:
        killed.setattr(Path, "replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            put(tmp_path, "never")
    assert not has_database(tmp_path)
    put(tmp_path, "new")
    assert got(tmp_path) == "new"
    with sqlite3.connect(tmp_path / DATABASE) as ours:
        assert ours.execute("PRAGMA application_id").fetchone() == (APPLICATION,)
    ours.close()


def test_a_full_disk_is_said_and_loses_nothing(tmp_path: Path) -> None:
    put(tmp_path, "before")
    with pytest.raises(ResultsError) as error, writing(tmp_path) as database:  # noqa: PT012
        database.execute("PRAGMA max_page_count = 30")
        with transaction(database):
            put_suite(database, "x" * 1_000_000)
    message = "can't be read or written: database or disk is full. Make room, or choose another"
    assert message in str(error.value)
    assert got(tmp_path) == "before"


def test_a_change_while_another_process_changes_it_is_refused(tmp_path: Path) -> None:
    put(tmp_path, "before")
    with writing(tmp_path) as first, transaction(first):
        put_suite(first, "first")
        with writing(tmp_path) as second:
            second.execute("PRAGMA busy_timeout = 10")
            with (
                pytest.raises(ResultsError, match="another process is writing to this file"),
                transaction(second),
            ):
                pass
    assert got(tmp_path) == "first"


def test_a_reserved_folder_is_refused_to_others_and_the_lock_goes_with_the_process(
    tmp_path: Path,
) -> None:
    wanted = (
        f"^{re.escape(str(tmp_path))}: another run is writing to this folder. Wait .* another "
        f"`--out`$"
    )
    with reserved(tmp_path), pytest.raises(ResultsError, match=wanted), reserved(tmp_path):
        pass
    held = "with reserved(folder): print('held', flush=True); time.sleep(600)"
    with in_other_process(tmp_path, held) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "held\n"
            with (
                pytest.raises(ResultsError, match="another run is writing to this folder"),
                reserved(tmp_path),
            ):
                pass
        finally:
            process.kill()
    with reserved(tmp_path):
        pass
    assert {path.name for path in tmp_path.iterdir()} <= {LOCK}

"""The database of a folder: changed wholly or not at all; what can't be used is said in a line."""

from __future__ import annotations

import os
import re
import sqlite3
import subprocess
import sys
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


def put(folder: Path, content: str) -> None:
    with writing(folder) as database, transaction(database):
        put_document(database, "suite", content)


def got(folder: Path) -> str | None:
    with reading(folder) as database:
        return get_document(database, "suite")


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
            put_document(database, "suite", "after")
            database.execute("DELETE FROM documents")
            raise raised
        with transaction(database):  # the next one is free of it
            put_document(database, "regression", "beside")
    assert got(tmp_path) == "before"
    assert documents_in(tmp_path) == {"suite", "regression"}


def test_who_reads_sees_one_state_while_another_writes(tmp_path: Path) -> None:
    put(tmp_path, "before")
    with writing(tmp_path) as run, reading(tmp_path) as seen:
        assert get_document(seen, "suite") == "before"
        with transaction(run):
            put_document(run, "suite", "after")
        assert get_document(seen, "suite") == "before"
        assert got(tmp_path) == "after"
        with pytest.raises(sqlite3.OperationalError, match="readonly"):
            seen.execute("DELETE FROM documents")
    assert got(tmp_path) == "after"


def test_a_killed_process_loses_nothing_that_it_had_committed(tmp_path: Path) -> None:
    script = (
        "import os, sys; from pathlib import Path\n"
        "from ghostball.validation.results.database import *\n"
        "with writing(Path(sys.argv[1])) as database:\n"
        "    with transaction(database): put_document(database, 'suite', 'committed')\n"
        "    with transaction(database):\n"
        "        put_document(database, 'suite', 'not yet')\n"
        "        os._exit(9)\n"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", script, str(tmp_path)]
    assert subprocess.run(command, env=environment, check=False).returncode == 9
    assert got(tmp_path) == "committed"
    put(tmp_path, "continues")
    assert got(tmp_path) == "continues"


# --- what can't be used


def refused(folder: Path) -> str:
    """Return what is said of a database by who reads and by who writes it: the same, in a line."""
    said = set()
    for use in (got, lambda one: put(one, "more")):
        with pytest.raises(ResultsError) as error:
            use(folder)
        said.add(str(error.value))
    (message,) = said
    assert "\n" not in message
    assert message.startswith(str(folder / DATABASE))
    return message


@pytest.mark.parametrize("part", [0.02, 0.3, 0.6, 0.99])
def test_a_database_that_is_cut_short_is_said_to_be(tmp_path: Path, part: float) -> None:
    put(tmp_path, "x" * 50_000)
    path = tmp_path / DATABASE
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    left = path.read_bytes()
    message = refused(tmp_path)
    assert "is cut short or damaged" in message
    assert message.endswith("Move the file away, or choose another `--out`, and run again")
    assert path.read_bytes() == left


def test_what_is_no_database_is_said_and_stays(tmp_path: Path) -> None:
    (tmp_path / DATABASE).write_text("years of work, in a file of this name\n" * 100)
    assert "is cut short or damaged (file is not a database)" in refused(tmp_path)
    assert (tmp_path / DATABASE).read_text().startswith("years of work")


def test_anyones_database_is_not_taken_for_ours(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / DATABASE) as other:
        other.execute("CREATE TABLE cases (record)")
    other.close()
    assert "holds no results of ghostball" in refused(tmp_path)


@pytest.mark.parametrize("version", [SCHEMA - 1, SCHEMA + 1])
def test_another_version_is_refused(tmp_path: Path, version: int) -> None:
    put(tmp_path, "theirs")
    other = sqlite3.connect(tmp_path / DATABASE)
    other.execute(f"PRAGMA user_version = {version}")
    other.close()
    wanted = f"its version must be {SCHEMA}, got {version}: another version of ghostball wrote it"
    assert wanted in refused(tmp_path)


def test_nobody_sees_a_database_before_it_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Breaks where who looks at a folder while a run begins takes it for somebody else's.
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
            put_document(database, "suite", "x" * 1_000_000)
    message = "can't be read or written: database or disk is full. Make room, or choose another"
    assert message in str(error.value)
    assert got(tmp_path) == "before"


def test_a_change_while_another_process_changes_it_is_refused(tmp_path: Path) -> None:
    put(tmp_path, "before")
    with writing(tmp_path) as first, transaction(first):
        put_document(first, "suite", "first")
        with writing(tmp_path) as second:
            second.execute("PRAGMA busy_timeout = 10")
            with (
                pytest.raises(ResultsError, match="another process writes there"),
                transaction(second),
            ):
                pass
    assert got(tmp_path) == "first"


def test_a_reserved_folder_is_refused_to_others_and_the_lock_goes_with_the_process(
    tmp_path: Path,
) -> None:
    wanted = f"^{re.escape(str(tmp_path))}: another run writes there. Wait .* another `--out`$"
    with reserved(tmp_path), pytest.raises(ResultsError, match=wanted), reserved(tmp_path):
        pass
    script = (
        "import sys, time; from pathlib import Path\n"
        "from ghostball.validation.results.database import reserved\n"
        "with reserved(Path(sys.argv[1])): print('held', flush=True); time.sleep(600)"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", script, str(tmp_path)]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "held\n"
            with pytest.raises(ResultsError, match="another run writes there"), reserved(tmp_path):
                pass
        finally:
            process.kill()
    with reserved(tmp_path):
        pass
    assert {path.name for path in tmp_path.iterdir()} <= {LOCK}

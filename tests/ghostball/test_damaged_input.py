"""Damaged, nested or wrongly shaped files: a message of one line, exit status 2, never 3.

Each case is one fault in a valid file. If a fault happens to be a valid value, such as another
date, the command succeeds.
"""

from __future__ import annotations

import json
import random
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from damage import DEEP, VALUES, assert_refused_or_done, faults, reads, run, texts
from pydantic import TypeAdapter
from table_agreements import keep_likenesses, likeness

from ghostball.validation.baselines.baseline import load_baseline
from ghostball.validation.baselines.regression import Regression, SceneChange
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.results.database import DATABASE, transaction, writing

RECORDS = {"documents": "content", "records": "record"}
"""Columns with records, by table."""


# --- results ----------------------------------------------------------------------------------


def dumped(one):
    return TypeAdapter(type(one)).dump_json(one, by_alias=True).decode()


@pytest.fixture(scope="module")
def valid(tmp_path_factory):
    """A results folder with a record of each kind, and results of generated shots in it."""
    folder = tmp_path_factory.mktemp("valid")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ghostball.validation.parallel.pool.limit_of", lambda _: None)
        options = ("-e", "pymunk", "--jobs", "1", "--no-report", "--out", folder)
        status, output = run("validate", "stop", *options)
    assert status == 0, output
    environment = {"cpu": "a processor", "git": {"revision": "0" * 40, "dirty": False}}
    change = SceneChange(scene="stop", title="", change="unchanged", summary="the same")
    changed = Regression(head=environment, outcome="passed", scenes=(change,))
    with writing(folder) as database, transaction(database):
        text = f"[{dumped(changed)}]"
        database.execute("INSERT INTO documents VALUES (?, ?)", ["regression", text])
    beside = {"rebound": 1.0, "rolling": "it rolls none"}
    keep_likenesses(folder, [likeness(label, **beside) for label in ("pymunk", "my:Engine")])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ghostball.validation.parallel.pool.limit_of", lambda _: None)
        beside = ("-e", "pymunk", "--jobs", "1", "--out", folder / "stress")
        status, output = run("stress", "grazing/rolling-hit-1e-01", *beside)
    assert status == 0, output
    return folder


def rows_of(folder):
    """Return folder, table, number and text of each record."""
    return [
        (part, table, number, text)
        for part in (".", "stress")
        for table, column in RECORDS.items()
        for number, text in query(folder / part, f"SELECT rowid, {column} FROM {table}")
    ]


def query(folder, sql, given=()):
    with closing(sqlite3.connect(folder / DATABASE)) as database, database:
        return database.execute(sql, given).fetchall()


def with_fault(valid, folder, row, text):
    """Copy results, with one record replaced by a text."""
    part, table, number, _ = row
    shutil.copytree(valid, folder)
    try:
        sql = f"UPDATE {table} SET {RECORDS[table]} = ? WHERE rowid = ?"
        with closing(sqlite3.connect(folder / part / DATABASE)) as database, database:
            database.execute("PRAGMA ignore_check_constraints = ON")
            database.execute(sql, [text, number])
    except sqlite3.Error:  # the generated columns reject the text already
        shutil.rmtree(folder)
        return False
    return True


READERS = {
    "report": ("report", "--figures", "none", "--jobs", "1"),
    "summary": ("report", "--format", "json"),
    "export": ("report", "--export"),
}


def assert_records_are_checked(valid, tmp_path, reader, count, seed):
    rng = random.Random(seed)
    rows = rows_of(valid)
    assert {table for _, table, *_ in rows} == set(RECORDS)
    every = {row: list(texts(row[3])) for row in rows}
    refused = 0
    for number in range(count):
        row = rng.choice(rows)  # all records equally often, of any length
        folder = tmp_path / str(number)
        if with_fault(valid, folder, row, rng.choice(every[row])):
            options = (tmp_path / "out",) if reader == "export" else ()
            refused += assert_refused_or_done(*READERS[reader], *options, folder) == 2
            shutil.rmtree(folder)
    return refused


@pytest.mark.parametrize("reader", ["summary", "export"])
def test_a_record_of_another_shape_is_refused(valid, tmp_path, reader):
    # An export contains the records unchanged, if they are JSON.
    least = 2 if reader == "summary" else 1
    assert assert_records_are_checked(valid, tmp_path, reader, 20, seed=1) >= least


def test_a_report_of_a_record_of_another_shape_is_refused(valid, tmp_path):
    """Documents once weren't checked, and a missing field was reported as a bug of Ghostball."""
    assert assert_records_are_checked(valid, tmp_path, "report", 4, seed=2) > 2


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("seed", range(1))
def test_many_records_of_another_shape_are_refused(valid, tmp_path, reader, seed):
    least = 1 if reader == "export" else 20
    assert assert_records_are_checked(valid, tmp_path, reader, 100, seed=100 + seed) >= least


@pytest.mark.parametrize("seed", range(2))
def test_a_damaged_byte_is_no_bug_of_ghostball(valid, tmp_path, seed):
    """SQLite detects only some damage; invalid text raises an error in Python."""
    data = bytearray((valid / DATABASE).read_bytes())
    rng = random.Random(seed)
    used = [place for place, byte in enumerate(data) if byte]
    for _ in range(20):
        place = rng.choice(used)
        damaged = bytearray(data)
        damaged[place] ^= rng.randrange(1, 256)
        (tmp_path / DATABASE).write_bytes(damaged)
        assert_refused_or_done("report", "--format", "json", tmp_path)
        assert_refused_or_done("report", tmp_path, "--export", tmp_path / "out")


def test_a_text_that_is_no_text_names_the_file_and_what_to_do(valid, tmp_path):
    data = (valid / DATABASE).read_bytes()
    damaged = data.replace(b'"state": "complete"', b'"state": "compl\xffte"')
    assert damaged != data
    (tmp_path / DATABASE).write_bytes(damaged)
    status, output = run("report", tmp_path)
    assert status == 2
    assert f"error: {tmp_path / DATABASE}: is truncated or damaged" in output
    assert "Move the file away" in output


@pytest.mark.parametrize("name", ["{}/pwn", "../../../pwn", "a/b", ".."])
@pytest.mark.parametrize("kind", ["case", "varied", "stress"])
def test_no_name_in_a_record_leads_out_of_the_folder(valid, tmp_path, name, kind):
    """With a path as the name of a scene, a report once wrote its picture outside the folder."""
    folder = tmp_path / "a" / "b" / "results"
    shutil.copytree(valid, folder)
    name = name.format(tmp_path)
    field = "varied_from" if kind == "varied" else "scene"
    part = folder / ("stress" if kind == "stress" else ".")
    sql = f"UPDATE records SET record = json_set(record, '$.{field}', ?) WHERE kind = 'case'"
    query(part, sql, [name])
    before = {path for path in tmp_path.rglob("*") if not path.is_relative_to(folder)}
    status, output = run("report", folder, "--jobs", "1", "--figures", "none")
    assert status == 2, output
    assert f"`{field}" in output
    assert {path for path in tmp_path.rglob("*") if not path.is_relative_to(folder)} == before


# --- other files ------------------------------------------------------------------------------


@pytest.mark.parametrize("text", [DEEP, '{"a":' * 100_000, "\x00", "9" * 10_000, '["' + DEEP])
def test_a_deeply_nested_run_file_did_not_finish(tmp_path, text):
    # Python's JSON reader once raised an error that wasn't caught.
    (tmp_path / "runs.json").write_text(text)
    status, output = run("grade", tmp_path / "runs.json")
    assert status == 1
    assert output.startswith(f"did not finish: {tmp_path / 'runs.json'}")
    assert "Traceback" not in output


BASELINE = Path(__file__).parents[2] / "benchmarks/baselines/ghostball/stop.json"


@pytest.mark.checkout
def test_a_baseline_of_another_shape_is_refused(tmp_path):
    text = BASELINE.read_text("utf-8")
    values = [value for value in VALUES if value is not None and value != "\ud800"]
    whole = json.loads(text)
    every = ["", DEEP, text[: len(text) // 2]]
    every += map(json.dumps, random.Random(1).sample(list(faults(whole, values)), 150))
    file = tmp_path / "stop.json"
    assert reads(load_baseline, file, text)
    assert sum(reads(load_baseline, file, one) for one in every) < len(every) / 2


@pytest.mark.parametrize("text", ["truth = " + DEEP, "[[", "\x00", "checks = 3", "x = 1"])
def test_limits_of_another_shape_are_refused(tmp_path, text):
    assert not reads(Criteria.load, tmp_path / "shot.expect.toml", text)


@pytest.mark.parametrize("text", ["name = " + DEEP, "balls = [[", "\x00", "balls = 3"])
def test_a_scene_that_is_none_is_refused(tmp_path, text):
    (tmp_path / "scene.toml").write_text(text)
    assert assert_refused_or_done("run", tmp_path / "scene.toml") == 2

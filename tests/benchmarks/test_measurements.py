"""Fails where a measurement doesn't read back, or replaces or half writes a file."""

import json

import pytest

from benchmarks import measurements
from benchmarks.measurements import (
    check_target,
    load,
    save,
    store_path,
    stored_paths,
)
from benchmarks.racks import RacksMeasurement
from benchmarks.running import BenchError
from benchmarks.speed import Row, TargetsMeasurement

ENVIRONMENT = {"cpu": "AMD EPYC", "cores": 2, "date": "2026-01-01"}
ROW = Row(
    workload="sweep",
    title="t",
    quantity="kernel",
    unit="s",
    median=0.1,
    least=0.1,
    greatest=0.3,
    samples=3,
)
MEASURED = TargetsMeasurement(environment=ENVIRONMENT, rounds=3, rows=(ROW,))


def test_it_reads_back(tmp_path):
    path = tmp_path / "new" / "targets.json"
    save(MEASURED, path, "--out")
    assert load(path, TargetsMeasurement) == MEASURED
    assert json.loads(path.read_text())["schema"] == 1
    assert MEASURED.row("sweep", "kernel") is ROW
    assert MEASURED.row("sweep", "call") is None
    assert [p.name for p in path.parent.iterdir()] == ["targets.json"]


def test_another_kind_or_damage_is_refused_by_name(tmp_path):
    path = tmp_path / "targets.json"
    save(MEASURED, path, "--out")
    with pytest.raises(BenchError, match=r"targets.json: `kind`"):
        load(path, RacksMeasurement)
    path.write_text(path.read_text()[:-20])
    with pytest.raises(BenchError, match="Invalid JSON"):
        load(path, TargetsMeasurement)
    with pytest.raises(BenchError, match="can't read"):
        load(tmp_path / "nowhere.json", TargetsMeasurement)


def test_a_file_of_ours_may_be_replaced_and_no_other(tmp_path):
    ours, other = tmp_path / "targets.json", tmp_path / "notes.json"
    save(MEASURED, ours, "--out")
    check_target(ours, "targets", "--out")
    other.write_text('{"a": 1}')
    for path, kind in ((other, "targets"), (ours, "racks")):
        with pytest.raises(BenchError, match=f"holds no measurement of `{kind}`"):
            check_target(path, kind, "--out")
    assert other.read_text() == '{"a": 1}'


def test_a_path_that_cannot_be_written_is_refused_before(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError, match="can't write the file of `--out`"):
        check_target(tmp_path / "file" / "targets.json", "targets", "--out")
    (tmp_path / "targets.json").mkdir()
    with pytest.raises(BenchError, match="must be a file"):
        check_target(tmp_path / "targets.json", "targets", "--out")


def test_the_store_has_a_folder_for_each_machine(tmp_path, monkeypatch):
    monkeypatch.setattr(measurements, "STORE", tmp_path)
    path = store_path(ENVIRONMENT, "targets")
    assert path == tmp_path / "amd-epyc-2-cores" / "targets.json"
    assert stored_paths("targets") == []
    save(MEASURED, path, "--store")
    assert stored_paths("targets") == [path]

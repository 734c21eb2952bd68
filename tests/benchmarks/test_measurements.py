"""Fails where a measurement doesn't read back, or replaces or half writes a file."""

import json

import pytest

from benchmarks import measurements
from benchmarks.measurements import (
    check_target,
    load,
    machine_name,
    out_path,
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


def test_out_is_a_file_or_a_folder(tmp_path):
    assert out_path(tmp_path / "x.json", "racks") == tmp_path / "x.json"
    assert out_path(tmp_path, "racks") == tmp_path / "racks.json"


def test_a_file_of_ours_may_be_replaced_and_no_other(tmp_path):
    ours, other = tmp_path / "targets.json", tmp_path / "notes.json"
    save(MEASURED, ours, "--out")
    check_target(ours, "targets", "--out")
    other.write_text('{"a": 1}')
    for path, kind in ((other, "targets"), (ours, "racks")):
        with pytest.raises(BenchError, match=f"holds no measurement of `{kind}`"):
            check_target(path, kind, "--out")
    assert other.read_text() == '{"a": 1}'


@pytest.mark.parametrize(
    "text",
    [
        '{"kind": "notes", "about": {"kind": "targets"}}',
        '["kind", {"kind": "targets"}]',
        '// "kind": "targets"',
        '"kind"',
    ],
)
def test_a_file_that_only_mentions_the_kind_is_not_replaced(tmp_path, text):
    path = tmp_path / "targets.json"
    path.write_text(text)
    with pytest.raises(BenchError, match="holds no measurement of `targets`"):
        check_target(path, "targets", "--out")


def test_a_file_of_ours_is_told_however_it_is_laid_out(tmp_path):
    path = tmp_path / "targets.json"
    path.write_text(MEASURED.model_dump_json(indent=None, by_alias=True))
    check_target(path, "targets", "--out")


def test_a_check_leaves_nothing_behind(tmp_path):
    # Breaks where a run that is interrupted at once leaves an empty folder for a machine.
    (tmp_path / "kept").mkdir()
    check_target(tmp_path / "kept" / "new" / "newer" / "targets.json", "targets", "--store")
    assert [path.name for path in tmp_path.rglob("*")] == ["kept"]
    (tmp_path / "kept" / "file").write_text("")
    with pytest.raises(BenchError, match="can't write"):
        check_target(tmp_path / "kept" / "file" / "new" / "targets.json", "targets", "--store")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "kept"]


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


def test_a_machine_is_named_after_its_processor():
    name = machine_name({"cpu": "Intel(R) Core(TM) i7 @ 2.8GHz", "cores": 8})
    assert name == "intel-r-core-tm-i7-2-8ghz-8-cores"

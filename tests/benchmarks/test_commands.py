"""`python -m benchmarks`: what it prints and writes, and the exit status of every kind of input."""

import pytest
from typer.testing import CliRunner

from benchmarks import (
    accuracy as bench_accuracy,
    measurements,
    skips as bench_skips,
    speed,
)
from benchmarks.__main__ import app
from benchmarks.accuracy import AccuracyMeasurement
from benchmarks.racks import Player, RacksMeasurement
from benchmarks.skips import SkipsMeasurement
from benchmarks.speed import TargetsMeasurement, Workload

LOAD = Workload("break-pool", "t", lambda _: lambda _: {"kernel": 20e-6, "per_event": 560e-9})


@pytest.fixture
def bench(monkeypatch):
    """Run `python -m benchmarks` in this process, on a workload that takes no time."""
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr(speed, "WORKLOADS", (LOAD,))

    def run(*arguments):
        return CliRunner().invoke(app, [*map(str, arguments)])

    return run


def refused(result, *parts):
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    assert all(part in result.stderr for part in parts), result.stderr
    return True


def test_a_table_says_met_and_missed_and_by_how_much(bench):
    result = bench("targets", "--repeats", "2")
    assert result.exit_code == 0, result.output
    assert "met, 33 % better" in result.stdout
    assert "missed by 100 %" in result.stdout
    assert "≤ 30 µs" in result.stdout
    assert "1 of 2 targets met" in result.stdout


def test_it_writes_what_reads_back(bench, tmp_path):
    result = bench("targets", "--out", tmp_path / "new")
    assert result.exit_code == 0, result.output
    path = tmp_path / "new" / "targets.json"
    assert f"written: {path}" in result.stdout
    stored = measurements.load(path, TargetsMeasurement)
    assert stored.rounds == 15
    assert {"cpu", "cores", "git", "versions", "date"} <= stored.environment.keys()


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["targets", "brake"], ["must match a workload", "'brake'"]),
        (["targets", "--repeats", "0"], ["--repeats", "greater than or equal to 1"]),
        (
            ["racks", "--peer", "pooltol"],
            ["got 'pooltol'", "pooltool"],
        ),
        (["targets", "--store", "--smoke"], ["`--store`", "--smoke"]),
        (["targets", "--store", "break*"], ["`--store`", "single workloads"]),
        (["racks", "--store", "--smoke"], ["`--store`", "--smoke"]),
        (["skips", "nosuch"], ["nosuch"]),
        (["skips", "--store", "break-16"], ["`--store`", "single workloads"]),
        (["nonsense"], ["nonsense"]),
    ],
)
def test_bad_input_is_refused(bench, arguments, parts):
    assert refused(bench(*arguments), *parts)


@pytest.mark.parametrize("command", [["targets"], ["racks"]])
def test_a_file_that_is_not_ours_is_refused_before_measuring(bench, tmp_path, command):
    path = tmp_path / "notes.json"
    path.write_text("{}")
    assert refused(bench(*command, "--out", path), "notes.json: holds no measurement")
    assert path.read_text() == "{}"
    (tmp_path / "file").touch()
    assert refused(bench(*command, "--out", tmp_path / "file" / "x"), "can't write the file")


@pytest.mark.checkout
def test_an_interrupt_prints_and_writes_what_is_there_but_stores_nothing(
    bench, tmp_path, monkeypatch
):
    turns = iter(range(2))

    def sample(_):
        if next(turns) == 1:
            raise KeyboardInterrupt
        return {"kernel": 20e-6}

    load = Workload("break-pool", "t", lambda _: sample)
    monkeypatch.setattr(speed, "WORKLOADS", (load,))
    monkeypatch.setattr(measurements, "STORE", tmp_path / "store")
    (tmp_path / "store").mkdir()
    result = bench("targets", "--store", "--out", tmp_path / "x.json")
    assert result.exit_code == 130, result.output
    assert "met, 33 % better" in result.stdout
    assert "nothing is stored" in result.stderr
    assert measurements.load(tmp_path / "x.json", TargetsMeasurement).interrupted
    assert not list((tmp_path / "store").glob("*/*.json"))


def test_racks_prints_its_figures_and_who_could_not_and_writes(bench, tmp_path, monkeypatch):
    fakes = {
        "fake": Player("fake", "1.0", lambda _: 0.25),
        "gone": Player("gone", "", lambda _: 0.0, "absent", "get it"),
    }
    monkeypatch.setattr("benchmarks.__main__.peer", fakes.get)
    result = bench("racks", "--smoke", "--peer", "fake", "--peer", "gone", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "these times mean nothing" in result.stdout
    (line,) = (line for line in result.stdout.splitlines() if line.strip().startswith("fake"))
    assert line.split() == ["fake", "1.0", "2", *["250", "ms"] * 4]
    assert "absent: get it" in result.stdout
    stored = measurements.load(tmp_path / "racks.json", RacksMeasurement)
    assert [len(one.seconds) for one in stored.engines] == [2, 2, 0]


def test_accuracy_is_tabled_stored_and_a_fault_is_the_exit_status(monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "300")

    def run(*more):
        arguments = ["accuracy", "--shots", "10", "--jobs", "1", *more]
        return CliRunner().invoke(app, [*arguments, "--out", str(tmp_path)])

    result = run("--first", "7")
    assert result.exit_code == 0, result.output
    assert "10 shots from number 7" in result.stdout
    assert "0 not found, 0 invented" in result.stdout
    assert "python -m benchmarks accuracy --first" in result.stdout  # the worst, to be run again
    assert measurements.load(tmp_path / "accuracy.json", AccuracyMeasurement).shots == 10
    monkeypatch.setattr(bench_accuracy, "MAX_EVENTS", 1)
    result = run()
    assert result.exit_code == 1
    assert "breaks a limit" in result.stdout
    assert "Shots that break a limit" in result.stderr


def test_skips_are_tabled_and_a_defect_is_the_exit_status(bench, monkeypatch, tmp_path):
    honest = bench_skips.run
    monkeypatch.setattr(
        bench_skips, "run", lambda scene, record="rest", no_skip=(): honest(scene, record=record)
    )
    arguments = ["skips", "half-ball-cut", "--repeats", "1", "--out", tmp_path]
    result = bench(*arguments)
    assert result.exit_code == 0, result.output
    assert "same bits" in result.stdout
    kept = measurements.load(tmp_path / "skips.json", SkipsMeasurement)
    assert {row.scene for row in kept.rows} == {"half-ball-cut"}
    monkeypatch.setattr(bench_skips, "compare_answers", lambda on, off: ("differs", "planted"))
    result = bench(*arguments)
    assert result.exit_code == 1
    assert "differs: planted" in result.stdout
    assert "Answers that a skip changes" in result.stderr

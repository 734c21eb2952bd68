"""`python -m benchmarks`: its output, its files, and the exit status for each kind of input."""

import json

import pytest
from commands import refused
from typer.testing import CliRunner

from benchmarks import accuracy, commands, doors, skips, speed
from benchmarks.__main__ import app
from benchmarks.accuracy import AccuracyMeasurement
from benchmarks.doors import DoorsMeasurement
from benchmarks.racks import RacksMeasurement, TimedEngine
from benchmarks.skips import SkipsMeasurement
from benchmarks.speed import TargetsMeasurement
from benchmarks.workloads import Workload
from ghostball.model import Scene
from ghostball.validation.parallel.pool import Done
from ghostball.validation.results.measurement import MeasurementError

LOAD = Workload(
    "loose-racks",
    lambda _: lambda: {"kernel": 20e-6, "per_event": 560e-9},
    {"kernel": 30e-6, "per_event": 280e-9},
)


@pytest.fixture
def bench(monkeypatch):
    """Run `python -m benchmarks` in this process, with a very short workload."""
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.setattr(speed, "WORKLOADS", {LOAD.name: LOAD})

    def run(*arguments):
        return CliRunner().invoke(app, [*map(str, arguments)])

    return run


def test_targets_are_tabled_and_written(bench, tmp_path):
    result = bench("targets", "--repeats", "2", "--out", tmp_path / "new")
    assert result.exit_code == 0, result.output
    for part in ("met, 33 % better", "missed by 100 %", "≤ 30 µs", "1 of 2 targets met"):
        assert part in result.stdout
    path = tmp_path / "new" / "targets.json"
    assert f"written: {path}" in result.stdout
    assert TargetsMeasurement.load(path).rounds == 2


def test_racks_prints_its_figures_and_engines_that_failed(bench, tmp_path, monkeypatch):
    fakes = {
        "fake": TimedEngine("fake", "1.0", lambda _: 0.25),
        "gone": TimedEngine("gone", "", lambda _: 0.0, "get it"),
    }
    monkeypatch.setattr("benchmarks.racks.timed_peer", fakes.get)
    monkeypatch.setattr(
        "benchmarks.racks.timed_ghostball", lambda: TimedEngine("ours", "", lambda _: 1.0)
    )
    result = bench("racks", "--peer", "fake", "--peer", "gone", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    (line,) = (line for line in result.stdout.splitlines() if line.strip().startswith("fake"))
    assert line.split() == ["fake", "1.0", "100", *["250", "ms"] * 4]
    assert "get it" in result.stdout
    stored = RacksMeasurement.load(tmp_path / "racks.json")
    assert [len(one.seconds) for one in stored.engines] == [1000, 100, 0]


def test_shots_are_graded_and_a_fault_is_the_exit_status(bench, monkeypatch, tmp_path):
    arguments = ["accuracy", "--shots", "10", "--jobs", "1", "--out", tmp_path]
    result = bench(*arguments, "--first", "7")
    assert result.exit_code == 0, result.output
    assert "measuring: 10 of 10 done" in result.stderr
    assert "10 shots from number 7" in result.stdout
    assert "0 missed, 0 in another order; 0 wrong events" in result.stdout
    measured = AccuracyMeasurement.load(tmp_path / "accuracy.json")
    assert measured.shots == 10
    assert sum(measured.endings.values()) == sum(measured.extents.values()) == 10
    assert measured.events == measured.time_error_ulps.count > 40
    worst = measured.worst[0]
    assert worst.quality_factor == measured.quality_factor.greatest < 32
    assert worst.again in result.stdout  # to be run again
    again = accuracy.accuracy(1, first=worst.number, jobs=1)
    (shot,) = again.worst
    assert (shot.number, shot.scene, shot.quality_factor) == (
        worst.number,
        worst.scene,
        worst.quality_factor,
    )

    monkeypatch.setattr(accuracy, "MAX_EVENTS", 1)
    result = bench(*arguments)
    assert result.exit_code == 1
    assert "Shots that fail a common limit" in result.stderr
    measured = AccuracyMeasurement.load(tmp_path / "accuracy.json")
    assert measured.missing > 0
    row = measured.faulty[0]
    assert any("events_missing" in fault for fault in row.faults)
    assert any("did not finish" in fault for fault in row.faults)
    kept = json.loads((tmp_path / "accuracy.json").read_text("utf-8"))["faulty"][0]["scene"]
    assert Scene.model_validate(kept) == accuracy.shot_of(row.number)


def test_a_process_that_crashes_names_the_shot(monkeypatch):
    def dying(tasks, jobs, work):
        yield Done(tasks[0], None, "its process ended with signal 9", "")

    monkeypatch.setattr(commands, "run_tasks", dying)
    with pytest.raises(MeasurementError, match=r"^the measurement of shot 17: its process ended"):
        [*commands.in_processes([17], 1, str, "shot")]


def test_doors_compares_ways_to_compile(bench, monkeypatch, tmp_path):
    """The minimum of all rounds counts, so a sample slowed by other processes has no effect."""
    times = dict(zip(doors.WAYS, ([9.0, 8.0], [12.0, 14.0], [24.0, 28.0]), strict=True))
    monkeypatch.setattr(doors, "seconds_in_new_process", lambda way: times[way].pop())
    result = bench("doors", "--repeats", "2", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    (line,) = (line for line in result.stdout.splitlines() if "without both" in line)
    assert line.split() == ["without", "both", "24.0", "s", "3.00"]
    stored = DoorsMeasurement.load(tmp_path / "doors.json")
    assert [row.seconds for row in stored.rows] == [8.0, 12.0, 24.0]
    assert stored.rounds == 2


@pytest.mark.compiled
@pytest.mark.parametrize("way", doors.WAYS)
def test_each_way_to_compile_has_its_doors(monkeypatch, way):
    from ghostball.engine.library import build, numba_doors, plain_numba

    used = []

    def compile_nothing(*_):
        used.append((type(build.way()), numba_doors.by_common_types is kept))
        return b""

    kept = numba_doors.by_common_types
    monkeypatch.setattr(numba_doors, "by_common_types", kept)  # and put back afterwards
    monkeypatch.setattr(build, "_WAY", [])
    monkeypatch.setattr(build, "object_code", compile_nothing)
    monkeypatch.setattr("gc.disable", lambda: None)
    assert doors.seconds_here(way) >= 0.0
    expected = {
        "both doors": (numba_doors.Doors, True),
        "without by_common_types": (numba_doors.Doors, False),
        "without both": (plain_numba.Plain, True),
    }
    assert used == [expected[way]]


def test_skips_are_tabled_and_a_defect_is_the_exit_status(bench, monkeypatch, tmp_path):
    honest = skips.run
    monkeypatch.setattr(
        skips, "run", lambda scene, record="rest", no_skip=(): honest(scene, record=record)
    )
    arguments = ["skips", "half-ball-cut", "--repeats", "1", "--out", tmp_path]
    result = bench(*arguments)
    assert result.exit_code == 0, result.output
    assert "same bits" in result.stdout
    kept = SkipsMeasurement.load(tmp_path / "skips.json")
    assert {row.scene for row in kept.rows} == {"half-ball-cut"}
    monkeypatch.setattr(skips, "compare_answers", lambda on, off: ("differs", "planted"))
    result = bench(*arguments)
    assert result.exit_code == 1
    assert "differs: planted" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["targets", "brake"], "'brake'"),
        (["targets", "--repeats", "0"], "--repeats"),
        (["targets", "--store", "gas-*"], "`--store`"),
        (["racks", "--peer", "pooltol"], "pooltool"),
        (["skips", "nosuch"], "nosuch"),
        (["skips", "--store", "break-16"], "`--store`"),
        (["racks", "--store", "--peer", "none"], "`--peer`"),
        (["targets", "--out", "/dev/null/x"], "can't create the folder"),
        (["nonsense"], "nonsense"),
    ],
)
def test_bad_input_is_refused(bench, arguments, part):
    assert refused(bench(*arguments), part)

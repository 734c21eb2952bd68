"""Fails where a workload doesn't run, a target is of nothing, or met and missed are mixed up."""

import pytest

from benchmarks import measurements
from benchmarks.running import BenchError
from benchmarks.speed import (
    QUANTITIES,
    TARGETS,
    WORKLOADS,
    Target,
    TargetsMeasurement,
    Workload,
    chosen_workloads,
    measure_targets,
    shipped_scene,
    target_of,
)

IN_PROCESS = [load for load in WORKLOADS if not load.name.endswith("start")]


def ticking():
    now = 0.0

    def clock():
        nonlocal now
        now += 1.0
        return now

    return clock


@pytest.mark.parametrize("load", IN_PROCESS, ids=lambda load: load.name)
def test_a_sample_has_a_value_for_each_target(load, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    sample = load.prepare(True)(ticking())
    assert sample.keys() <= QUANTITIES.keys()
    assert {t.quantity for t in TARGETS if t.workload == load.name} <= sample.keys()


def test_with_one_processor_two_threads_are_not_measured(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    (sweep,) = (load for load in WORKLOADS if load.name == "sweep")
    assert "two_threads" not in sweep.prepare(True)(ticking())


def test_a_shot_at_another_speed_changes_nothing_else():
    plain, fast = shipped_scene("break-16"), shipped_scene("break-16@8")
    assert fast.balls[0].speed == pytest.approx(8.0)
    assert fast.balls[1:] == plain.balls[1:]
    assert fast.balls[0].position == plain.balls[0].position


def test_every_target_is_of_something_that_is_measured():
    names = [load.name for load in WORKLOADS]
    assert len(set(names)) == len(names)
    keys = [(t.workload, t.quantity) for t in TARGETS]
    assert len(set(keys)) == len(keys)
    assert all(workload in names and quantity in QUANTITIES for workload, quantity in keys)


@pytest.mark.parametrize(
    ("kind", "value", "met", "margin"),
    [
        ("at_most", 8.0, True, 0.2),
        ("at_most", 10.0, True, 0.0),
        ("at_most", 15.0, False, -0.5),
        ("at_least", 15.0, True, 0.5),
        ("at_least", 8.0, False, -0.2),
    ],
)
def test_met_and_by_how_much(kind, value, met, margin):
    target = Target("w", "q", kind, 10.0)
    assert target.met(value) is met
    assert target.margin(value) == pytest.approx(margin)


def test_a_target_is_found():
    assert target_of("sweep", "shots_per_second").kind == "at_least"
    assert target_of("sweep", "kernel") is None


def test_workloads_are_chosen_by_pattern():
    assert chosen_workloads(()) == WORKLOADS
    assert [load.name for load in chosen_workloads(("gas-1*0",))] == [
        "gas-1000",
        "gas-10000",
        "gas-100000",
    ]
    with pytest.raises(BenchError, match=r"must match a workload, got 'brake'.*break-pool"):
        chosen_workloads(("brake",))


def sampled(*values):
    """Return a workload that has a target, with these values; None interrupts."""
    left = iter(values)

    def sample(_):
        value = next(left)
        if value is None:
            raise KeyboardInterrupt
        return {"kernel": value}

    return Workload("break-pool", "t", lambda _: sample)


def test_a_row_has_the_spread_and_the_verdict_and_a_trial_judges_nothing(tmp_path):
    (row,) = measure_targets([sampled(10e-6, 20e-6, 90e-6)], rounds=3).rows
    assert (row.median, row.least, row.greatest, row.samples) == (20e-6, 10e-6, 90e-6, 3)
    assert (row.unit, row.target, row.met) == ("s", 30e-6, True)
    assert measure_targets([sampled(90e-6)], rounds=1).rows[0].met is False
    trial = measure_targets([sampled(90e-6)], rounds=1, quick=True)
    assert trial.rows[0].met is None
    measurements.save(trial, tmp_path / "targets.json", "--out")
    assert measurements.load(tmp_path / "targets.json", TargetsMeasurement) == trial


def test_an_interrupt_keeps_what_is_there():
    measured = measure_targets([sampled(1.0, 1.0, None)], rounds=9)
    assert measured.interrupted
    assert measured.rows[0].samples == 2

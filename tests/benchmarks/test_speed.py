"""Fails where a workload doesn't run, a target is of nothing, or met and missed are mixed up."""

import pytest

from benchmarks.speed import (
    QUANTITIES,
    TARGETS,
    WORKLOADS,
    Row,
    TargetsMeasurement,
    Workload,
    chosen_workloads,
    measure_targets,
    shipped_scene,
)
from ghostball.validation.results.measurement import MeasurementError


@pytest.mark.parametrize(
    "load",
    [load for load in WORKLOADS if not load.name.endswith("start")],
    ids=lambda load: load.name,
)
def test_a_sample_has_a_value_for_each_target(load, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    sample = load.prepare(True)()
    assert sample.keys() <= QUANTITIES.keys()
    assert {quantity for name, quantity in TARGETS if name == load.name} <= sample.keys()


def test_with_one_processor_two_threads_are_not_measured(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    (sweep,) = (load for load in WORKLOADS if load.name == "sweep")
    assert sweep.prepare(True)().keys() == {"shots_per_second"}


def test_a_shot_at_another_speed_changes_nothing_else():
    plain, fast = shipped_scene("break-16"), shipped_scene("break-16@8")
    assert fast.balls[0].speed == pytest.approx(8.0)
    assert fast.balls[1:] == plain.balls[1:]
    assert fast.balls[0].position == plain.balls[0].position


def test_every_target_is_of_something_that_is_measured():
    names = [load.name for load in WORKLOADS]
    assert len(set(names)) == len(names)
    assert all(name in names and quantity in QUANTITIES for name, quantity in TARGETS)


@pytest.mark.parametrize(
    ("name", "quantity", "value", "verdict"),
    [
        ("break-pool", "kernel", 24e-6, "[green]met[/], 20 % better"),
        ("break-pool", "kernel", 45e-6, "[bold red]missed[/] by 50 %"),
        ("sweep", "shots_per_second", 600e3, "[green]met[/], 50 % better"),
        ("sweep", "shots_per_second", 320e3, "[bold red]missed[/] by 20 %"),
        ("air", "over_no_air", 9.0, "[bold red]missed[/] by 50 %"),
        ("air", "over_no_air", 3.0, "[green]met[/], 50 % better"),
        ("sweep", "kernel", 1.0, ""),
    ],
)
def test_met_and_by_how_much(name, quantity, value, verdict):
    assert Row.of(Workload(name, "t", lambda _: None), quantity, [value]).verdict == verdict


def test_workloads_are_chosen_by_pattern():
    assert chosen_workloads(()) == WORKLOADS
    gases = [load.name for load in chosen_workloads(("gas-1*0",))]
    assert gases == ["gas-1000", "gas-10000", "gas-100000"]
    with pytest.raises(MeasurementError, match=r"must match a workload, got 'brake'.*break-pool"):
        chosen_workloads(("brake",))


def test_a_row_has_the_spread_and_reads_back(tmp_path):
    values = iter([10e-6, 20e-6, 90e-6])
    load = Workload("break-pool", "t", lambda _: lambda: {"kernel": next(values)})
    measured = measure_targets([load], rounds=3)
    row = measured.row("break-pool", "kernel")
    assert (row.median, row.least, row.greatest, row.samples) == (20e-6, 10e-6, 90e-6, 3)
    assert (row.unit, row.target, row.met) == ("s", 30e-6, True)
    assert TargetsMeasurement.load(measured.save(tmp_path)) == measured

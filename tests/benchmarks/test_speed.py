"""Each workload runs, each target has a measured quantity, and missed targets are recognized."""

import pytest

from benchmarks.speed import (
    MEANINGS,
    TargetRow,
    TargetsMeasurement,
    chosen_workloads,
    measure_targets,
)
from benchmarks.workloads import WORKLOADS, Workload, shipped_scene
from ghostball.validation.results.measurement import MeasurementError


@pytest.mark.parametrize(
    "load",
    [load for load in WORKLOADS.values() if not load.name.endswith("start")],
    ids=lambda load: load.name,
)
def test_a_sample_has_a_value_for_each_target(load):
    sample = load.prepare(True)()
    assert load.targets.keys() <= sample.keys() <= MEANINGS.keys()


def test_a_shot_at_another_speed_changes_nothing_else():
    plain, fast = shipped_scene("break-16"), shipped_scene("break-16@8")
    assert fast.balls[0].speed == pytest.approx(8.0)
    assert fast.balls[1:] == plain.balls[1:]
    assert fast.balls[0].position == plain.balls[0].position


@pytest.mark.parametrize(
    ("name", "quantity", "value", "verdict"),
    [
        ("loose-racks", "kernel", 24e-6, "[green]met[/], 20 % better"),
        ("loose-racks", "kernel", 45e-6, "[bold red]missed[/] by 50 %"),
        ("gas-10000", "collisions_per_second", 1.5e6, "[green]met[/], 50 % better"),
        ("gas-10000", "collisions_per_second", 0.8e6, "[bold red]missed[/] by 20 %"),
        ("air", "over_no_air", 9.0, "[bold red]missed[/] by 50 %"),
        ("air", "over_no_air", 3.0, "[green]met[/], 50 % better"),
        ("start", "kernel", 1.0, ""),
    ],
)
def test_met_and_by_how_much(name, quantity, value, verdict):
    assert TargetRow.of(WORKLOADS[name], quantity, [value]).cells[-1] == verdict


def test_workloads_are_chosen_by_pattern():
    assert chosen_workloads(()) == [*WORKLOADS.values()]
    gases = [load.name for load in chosen_workloads(("gas-1*0",))]
    assert gases == ["gas-1000", "gas-10000", "gas-100000"]
    with pytest.raises(MeasurementError, match=r"must match a workload, got 'brake'.*loose-racks"):
        chosen_workloads(("brake",))


def test_a_row_has_the_spread_and_reads_back(tmp_path):
    values = iter([10e-6, 20e-6, 90e-6])
    load = Workload("t", lambda _: lambda: {"kernel": next(values)}, {"kernel": 30e-6})
    measured = measure_targets([load], rounds=3)
    row = measured.row("t", "kernel")
    assert (row.median, row.least, row.greatest, row.samples) == (20e-6, 10e-6, 90e-6, 3)
    assert (row.target, row.met) == (30e-6, True)
    assert TargetsMeasurement.load(measured.save(tmp_path)) == measured

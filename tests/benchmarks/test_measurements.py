"""A measurement is stored in the folder of its machine, and found there."""

import pytest
from rich.console import Console

from benchmarks import measurements
from benchmarks.accuracy import AccuracyMeasurement
from benchmarks.measurements import Distribution, committed, machine_folder, measured
from benchmarks.racks import RacksMeasurement, RackTimes
from benchmarks.skips import SkipsMeasurement
from benchmarks.speed import TargetsMeasurement
from ghostball.validation.results.measurement import MeasurementError

MEASURED = RacksMeasurement(engines=(RackTimes(engine="ghostball", seconds=(1e-5, 2e-5)),))


def test_it_reads_back_from_the_folder_of_the_machine(tmp_path, monkeypatch):
    monkeypatch.setattr(measurements, "STORE", tmp_path)
    assert committed(RacksMeasurement) is None
    with pytest.raises(MeasurementError, match=r"no folder has a racks\.json"):
        measured(RacksMeasurement)
    path = MEASURED.save(machine_folder())
    assert path.parent.parent == tmp_path
    assert RacksMeasurement.load(path) == measured(RacksMeasurement) == MEASURED
    assert [p.name for p in path.parent.iterdir()] == ["racks.json"]
    assert "command" not in MEASURED.environment


@pytest.mark.checkout
@pytest.mark.parametrize(
    "kind",
    [
        AccuracyMeasurement,
        RacksMeasurement,
        SkipsMeasurement,
        TargetsMeasurement,
    ],
)
def test_committed_measurements_are_read_and_have_a_table(kind):
    console = Console(width=200, record=True)
    console.print(committed(kind).table)
    assert "ghostball" in console.export_text() or kind is not RacksMeasurement


@pytest.mark.parametrize(("count", "p99"), [(1, 1.0), (99, 99.0), (100, 99.0), (1000, 990.0)])
def test_the_99th_percentile_is_exceeded_by_1_percent_at_most(count, p99):
    middle = (count + 1) / 2.0
    spread = Distribution.of([float(value) for value in range(count, 0, -1)])
    assert spread == Distribution(
        count=count, median=middle, mean=middle, p99=p99, greatest=float(count)
    )
    assert Distribution.of([]) == Distribution(count=0)

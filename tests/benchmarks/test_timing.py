"""Fails where a figure of many times is another one, or a run that broke off counts."""

import dataclasses

import pytest

from benchmarks import timing
from benchmarks.scenes import table_gas
from benchmarks.timing import Figures, run
from ghostball.model import Status
from ghostball.validation.results.measurement import MeasurementError


@pytest.mark.parametrize(("count", "p99"), [(1, 1.0), (99, 99.0), (100, 99.0), (1000, 990.0)])
def test_the_99th_percentile_is_exceeded_by_1_percent_at_most(count, p99):
    figures = Figures.of([float(value) for value in range(count, 0, -1)])
    middle = (count + 1) / 2.0
    assert figures == Figures(median=middle, mean=middle, p99=p99, slowest=float(count))


def test_a_run_that_broke_off_is_no_measurement(monkeypatch):
    simulate = timing.simulate
    monkeypatch.setattr(
        timing,
        "simulate",
        lambda *a, **k: dataclasses.replace(simulate(*a, **k), status=Status.FAILED),
    )
    with pytest.raises(MeasurementError):
        run(table_gas(2, 0.1))

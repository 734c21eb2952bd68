"""Fails where a run that broke off counts as a measurement, or a gas's rate is wrong."""

import dataclasses

import pytest

from benchmarks import running
from benchmarks.running import BenchError
from benchmarks.scenes import table_gas
from ghostball.engine import Status


def ended(monkeypatch, status):
    simulate = running.simulate
    monkeypatch.setattr(
        running, "simulate", lambda *a, **k: dataclasses.replace(simulate(*a, **k), status=status)
    )


def test_an_interrupted_run_interrupts(monkeypatch):
    ended(monkeypatch, Status.INTERRUPTED)
    with pytest.raises(KeyboardInterrupt):
        running.run(table_gas(2, 0.1))


def test_a_run_that_broke_off_is_no_measurement(monkeypatch):
    ended(monkeypatch, Status.FAILED)
    with pytest.raises(BenchError, match='scene "table-gas" did not end by itself'):
        running.run(table_gas(2, 0.1))

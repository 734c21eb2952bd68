"""Fails where a run that broke off counts as a measurement, or a gas's rate is wrong."""

import dataclasses

import numpy as np
import pytest

from benchmarks import running
from benchmarks.running import BenchError, after, collision_rate
from benchmarks.scenes import table_gas
from ghostball.engine import Status
from ghostball.validation.scenes.gases import FRICTIONLESS, packed_gas


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


def test_a_lattice_is_elsewhere_after_a_while_and_keeps_its_energy():
    scene = packed_gas(4, 0.3, FRICTIONLESS, t_max=0.1)
    later = after(scene)
    assert not np.allclose(later.positions, scene.positions)
    assert np.sum(later.velocities**2) == pytest.approx(np.sum(scene.velocities**2))


@pytest.mark.compiled
def test_the_rate_of_collisions_is_that_of_a_gas():
    """Enskog's rate is good to a few percent; few balls, and cushions, cost some."""
    packing, collisions = 0.3, 20.0
    scene = packed_gas(144, packing, FRICTIONLESS, collisions / collision_rate(packing))
    counted = running.run(scene).collision_counts["ball-ball"]
    assert 2.0 * counted / len(scene.balls) == pytest.approx(collisions, rel=0.15)

"""Fails where a run that broke off counts as a measurement, or memory is counted wrongly."""

import dataclasses

import numpy as np
import pytest

from benchmarks import running
from benchmarks.accuracy import measure_accuracy
from benchmarks.attribution import measure_attribution
from benchmarks.running import BenchError, after, bytes_per_ball, collision_rate
from benchmarks.scenes import table_gas
from ghostball.engine import Status
from ghostball.engine.running.from_scene import layout_of
from ghostball.validation.parallel.pool import Done
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


@pytest.mark.parametrize(
    ("measure", "name"),
    [(measure_accuracy, "shot 17"), (measure_attribution, "shot 17 on pymunk")],
)
def test_a_process_that_dies_names_the_measurement(measure, name, monkeypatch):
    def dying(tasks, jobs, work):
        yield Done(tasks[0], None, "its process ended with signal 9", "")

    monkeypatch.setattr("benchmarks.running.run_tasks", dying)
    with pytest.raises(BenchError, match=f"^the measurement of {name}: its process ended"):
        measure(1, first=17, jobs=1)


def test_a_lattice_is_elsewhere_after_a_while_and_keeps_its_energy():
    scene = packed_gas(4, 0.3, FRICTIONLESS, t_max=0.1)
    later = after(scene)
    assert not np.allclose(later.positions, scene.positions)
    assert np.sum(later.velocities**2) == pytest.approx(np.sum(scene.velocities**2))


def test_memory_is_all_arrays_of_a_run():
    """At least what no run can do without: state, bounds of pairs, state at the end."""
    scene = table_gas(4, 0.1)
    layout = layout_of(scene)
    least = layout.state.nbytes + 4 * 4 * 8 + 3 * 4 * 3 * 8
    assert least < 4 * bytes_per_ball(scene) < 20 * least
    crowd = packed_gas(121, 0.3, FRICTIONLESS, 0.1)
    assert bytes_per_ball(crowd) * 121 > layout_of(crowd).block.numbers.nbytes


@pytest.mark.compiled
def test_the_rate_of_collisions_is_that_of_a_gas():
    """Enskog's rate is good to a few percent; few balls, and cushions, cost some."""
    packing, collisions = 0.3, 20.0
    scene = packed_gas(144, packing, FRICTIONLESS, collisions / collision_rate(packing))
    counted = running.run(scene).collision_counts["ball-ball"]
    assert 2.0 * counted / len(scene.balls) == pytest.approx(collisions, rel=0.15)

"""Fails where a workload doesn't run, or measures a quantity that has no unit."""

import pytest

from benchmarks.quantities import QUANTITIES
from benchmarks.sizes import QUICK
from benchmarks.targets import TARGETS
from benchmarks.workloads import WORKLOADS, shipped_scene

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
    sample = load.prepare(QUICK)(ticking())
    assert sample.keys() <= QUANTITIES.keys()
    wanted = {t.quantity for t in TARGETS if t.workload == load.name and not t.peer}
    assert wanted <= sample.keys()


def test_with_one_processor_two_threads_are_not_measured(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    (sweep,) = (load for load in WORKLOADS if load.name == "sweep")
    assert "two_threads" not in sweep.prepare(QUICK)(ticking())


def test_a_shot_at_another_speed_changes_nothing_else():
    plain, fast = shipped_scene("break-16"), shipped_scene("break-16@8")
    assert fast.balls[0].speed == pytest.approx(8.0)
    assert fast.balls[1:] == plain.balls[1:]
    assert fast.balls[0].position == plain.balls[0].position

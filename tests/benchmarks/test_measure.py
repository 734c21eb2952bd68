"""Fails where a measurement loses a value, judges a trial, or hides what became of a peer."""

import pytest
from peers import FakePeer

from benchmarks import measure
from benchmarks.measure import measure_targets
from benchmarks.peer_engines import (
    PeerAbsentError,
    PeerCannotError,
    PeerFailedError,
)
from benchmarks.scenes import table_gas
from benchmarks.sizes import FULL, QUICK
from benchmarks.workloads import Workload


def load_of(name, **values):
    return Workload(name, f"about {name}", lambda _: lambda _: values)


def ticking():
    seconds = iter(range(100_000))
    return lambda: float(next(seconds))


@pytest.fixture
def gas(monkeypatch):
    """Compare peers on one small scene, called like a workload with a target."""
    scenes = {"break-pool": lambda _: [table_gas(2, 0.5), table_gas(3, 0.5)]}
    monkeypatch.setattr("benchmarks.comparison.COMPARED", scenes)
    return load_of("break-pool", kernel=20e-6, per_event=300e-9)


def test_rows_are_judged_by_their_median(gas):
    measured = measure_targets([gas], rounds=3, size=FULL)
    kernel, per_event = measured.rows
    assert (kernel.median, kernel.samples, kernel.target, kernel.met) == (20e-6, 3, 30e-6, True)
    assert per_event.met is False
    assert not measured.quick
    assert measured.environment["cores"]


def test_a_quantity_without_a_target_is_shown_only():
    (row,) = measure_targets([load_of("scene:push", kernel=1.0)], rounds=1).rows
    assert (row.target, row.met, row.unit) == (None, None, "s")


def test_a_trial_is_not_judged(gas):
    peer = FakePeer("pooltool")
    measured = measure_targets([gas], [peer], rounds=1, size=QUICK)
    assert measured.quick
    assert [row.met for row in measured.rows] == [None, None]
    assert measured.peers[0].met is None


def test_a_peer_runs_beside_ours_on_every_scene(gas):
    peer = FakePeer("pooltool", seconds=100.0, events=50)
    measured = measure_targets([gas], [peer], rounds=4, size=FULL)
    (row,) = measured.peers
    assert (row.outcome, row.samples, row.seconds, row.events) == ("ran", 4, 100.0, 50.0)
    assert row.per_event == 2.0
    assert row.times_quicker == pytest.approx(100.0 / row.ours_seconds, rel=0.9)
    assert row.target == 4000.0
    assert row.met is (row.times_quicker >= 4000.0)
    assert [len(scene.balls) for scene in peer.asked] == [2, 2, 3, 2, 3]  # the first warms it up


@pytest.mark.parametrize(
    ("error", "outcome"),
    [
        (PeerAbsentError("get it"), "absent"),
        (PeerCannotError("no cloth"), "not-representable"),
        (PeerFailedError("no chalk"), "failed"),
    ],
)
def test_a_peer_that_does_not_run_is_listed_with_the_reason(gas, error, outcome):
    peer = FakePeer("FastFiz", error=error)
    (row,) = measure_targets([gas], [peer], rounds=3, size=FULL).peers
    assert (row.outcome, row.detail, row.met, row.samples) == (outcome, str(error), None, 0)
    assert len(peer.asked) == 1


def test_a_peer_that_fails_later_is_not_asked_again(gas):
    peer = FakePeer("pooltool", error=PeerFailedError("no chalk"), from_balls=2)
    (row,) = measure_targets([gas], [peer], rounds=4, size=FULL).peers
    assert (row.outcome, row.detail, row.samples) == ("failed", "no chalk", 1)
    assert len(peer.asked) == 3


def test_peers_run_only_where_they_are_compared(gas):
    assert measure_targets([load_of("sweep")], [FakePeer()], rounds=1).peers == ()


def test_an_interrupt_keeps_what_is_there():
    turns = iter(range(3))

    def sample(_):
        if next(turns) == 2:
            raise KeyboardInterrupt
        return {"kernel": 1.0}

    load = Workload("scene:push", "", lambda _: sample)
    measured = measure.measure_targets([load], rounds=9)
    assert measured.interrupted
    assert measured.rows[0].samples == 2

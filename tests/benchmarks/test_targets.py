"""Fails where a target is of nothing that is measured, or met and missed are mixed up."""

import pytest

from benchmarks.comparison import COMPARED
from benchmarks.peer_engines import DEFAULT_PEERS
from benchmarks.quantities import QUANTITIES
from benchmarks.running import BenchError
from benchmarks.targets import (
    TARGETS,
    TIMES_QUICKER,
    Target,
    chosen_workloads,
    target_of,
)
from benchmarks.workloads import WORKLOADS


def test_every_target_is_of_something_that_is_measured():
    names = {load.name for load in WORKLOADS}
    for target in TARGETS:
        assert target.workload in names
        if target.quantity == TIMES_QUICKER:
            assert target.workload in COMPARED
            assert target.peer in DEFAULT_PEERS
        else:
            assert target.quantity in QUANTITIES
    keys = [(t.workload, t.quantity, t.peer) for t in TARGETS]
    assert len(set(keys)) == len(keys)


def test_names_and_meanings_are_whole():
    assert len({load.name for load in WORKLOADS}) == len(WORKLOADS)
    assert COMPARED.keys() <= {load.name for load in WORKLOADS}


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


def test_a_target_is_found_by_its_peer_too():
    assert target_of("break-pool", TIMES_QUICKER, "pooltool").limit == 4000.0
    assert target_of("break-pool", TIMES_QUICKER) is None
    assert target_of("sweep", "shots_per_second").kind == "at_least"


def test_workloads_are_chosen_by_pattern():
    assert chosen_workloads(()) == WORKLOADS
    assert [load.name for load in chosen_workloads(("gas-1*0",))] == [
        "gas-1000",
        "gas-10000",
        "gas-100000",
    ]
    with pytest.raises(BenchError, match=r"must match a workload, got 'brake'.*break-pool"):
        chosen_workloads(("brake",))

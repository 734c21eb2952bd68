"""Measure our engine's workloads, and peers beside them, into what is stored."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

from benchmarks.comparison import comparisons
from benchmarks.measurements import measured_where
from benchmarks.peer_engines import Peer
from benchmarks.quantities import QUANTITIES
from benchmarks.records import Row, TargetsMeasurement, spread_fields
from benchmarks.sizes import FULL, Size
from benchmarks.targets import target_of
from benchmarks.timing import Clock, Samples, take_turns
from benchmarks.workloads import Workload
from ghostball.validation.parallel.pool import Progress


def measure_targets(
    workloads: Sequence[Workload],
    peers: Sequence[Peer] = (),
    *,
    rounds: int,
    size: Size = FULL,
    clock: Clock = time.perf_counter,
    progress: Progress[str] | None = None,
) -> TargetsMeasurement:
    """Measure workloads by turns; Ctrl-C keeps what was measured.

    Parameters
    ----------
    workloads : sequence of Workload
    peers : sequence of Peer
        Run beside ours on those workloads that they are compared on.
    rounds : int
        At most as many samples of each.
    size : Size
        Any but `FULL` is a trial: no target is judged.
    clock, progress
        As for `take_turns`.
    """
    environment = measured_where()
    compared = comparisons([load.name for load in workloads], peers, size)
    tasks = [load.task(size) for load in workloads] + [one.task() for one in compared]
    samples = take_turns(tasks, rounds, clock=clock, progress=progress)
    return TargetsMeasurement(
        environment=environment,
        rounds=rounds,
        quick=size != FULL,
        interrupted=samples.interrupted,
        rows=tuple(row for load in workloads for row in _rows(load, samples, size)),
        peers=tuple(one.row(samples, judged=size == FULL) for one in compared),
    )


def _rows(load: Workload, samples: Samples, size: Size) -> Iterator[Row]:
    for quantity, spread in samples.spreads(load.name).items():
        target = target_of(load.name, quantity)
        judged = target is not None and size == FULL
        yield Row(
            workload=load.name,
            title=load.title,
            quantity=quantity,
            unit=QUANTITIES[quantity].unit,
            **spread_fields(spread),
            target=target.limit if target else None,
            met=target.met(spread.median) if target and judged else None,
        )

"""What our engine is meant to reach, and how far a measurement is from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Literal

from benchmarks.running import BenchError
from benchmarks.workloads import WORKLOADS, Workload

LimitKind = Literal["at_most", "at_least"]


@dataclass(frozen=True)
class Target:
    """A limit on the median of one quantity of one workload, in SI units.

    `peer` names the engine where the quantity is how many times quicker ours is.
    """

    workload: str
    quantity: str
    kind: LimitKind
    limit: float
    peer: str = ""

    def met(self, value: float) -> bool:
        """Whether a measured value keeps it."""
        return value <= self.limit if self.kind == "at_most" else value >= self.limit

    def margin(self, value: float) -> float:
        """How much better than the limit a value is, as a part of the limit; negative if worse."""
        better = self.limit - value if self.kind == "at_most" else value - self.limit
        return better / self.limit


TIMES_QUICKER = "times_quicker"
"""The quantity of a comparison: a peer's time over ours, on the same scenes."""

TARGETS: tuple[Target, ...] = (
    Target("break-pool", "kernel", "at_most", 30e-6),
    Target("break-pool", "per_event", "at_most", 280e-9),
    Target("break-pool", "call_extra", "at_most", 25e-6),
    Target("break-pool", TIMES_QUICKER, "at_least", 4000.0, peer="pooltool"),
    Target("break-pool", TIMES_QUICKER, "at_least", 40.0, peer="FastFiz"),
    Target("racks", "kernel_mean", "at_most", 60e-6),
    Target("racks", "kernel_p99", "at_most", 0.5e-3),
    Target("racks", "kernel_slowest", "at_most", 3e-3),
    Target("racks", "free_call_extra", "at_most", 10e-6),
    Target("racks", "contact_call_extra", "at_most", 15e-6),
    Target("contact-step", "per_contact_step", "at_most", 1e-6),
    Target("joint-impact", "per_joint_impact", "at_most", 5e-6),
    Target("break-pool-events", "events_extra", "at_most", 0.05),
    Target("break-paper", "per_event", "at_most", 400e-9),
    Target("gas-16", "per_event", "at_most", 180e-9),
    Target("gas-1000", "collisions_per_second", "at_least", 1.3e6),
    Target("gas-10000", "collisions_per_second", "at_least", 1.0e6),
    Target("gas-100000", "collisions_per_second", "at_least", 0.5e6),
    Target("gas-1000", "bytes_per_ball", "at_most", 400.0),
    Target("gas-10000", "bytes_per_ball", "at_most", 400.0),
    Target("gas-100000", "bytes_per_ball", "at_most", 400.0),
    Target("cloth-10000", "per_event", "at_most", 1.2e-6),
    Target("sweep", "shots_per_second", "at_least", 400e3),
    Target("sweep", "two_threads", "at_least", 1.9),
    Target("start", "first_shot", "at_most", 1.0),
    Target("start", "import", "at_most", 0.3),
    Target("cold-start", "first_shot", "at_most", 10.0),
    Target("cold-start", "every_variant", "at_most", 40.0),
)


def target_of(workload: str, quantity: str, peer: str = "") -> Target | None:
    """Return the target of a quantity, or None where there is none."""
    wanted = (workload, quantity, peer)
    found = (t for t in TARGETS if (t.workload, t.quantity, t.peer) == wanted)
    return next(found, None)


def chosen_workloads(patterns: Sequence[str]) -> tuple[Workload, ...]:
    """Return the workloads whose name matches any of some patterns, such as "gas-*"; none is all.

    Raises
    ------
    BenchError
        Where none matches.
    """
    if not patterns:
        return WORKLOADS
    chosen = tuple(
        load for load in WORKLOADS if any(fnmatchcase(load.name, one) for one in patterns)
    )
    if not chosen:
        names = ", ".join(load.name for load in WORKLOADS)
        raise BenchError(
            f"what is measured must match a workload, got {' '.join(patterns)!r}. There are: "
            f"{names}"
        )
    return chosen

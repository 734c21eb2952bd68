"""Peers beside our engine: the same scenes, ours first, then the peer, in every round."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import cycle
from statistics import median

from benchmarks.peer_engines import (
    Peer,
    PeerAbsentError,
    PeerCannotError,
    PeerFailedError,
)
from benchmarks.records import Outcome, PeerRow
from benchmarks.running import run, until
from benchmarks.scenes import ROLLING, table_gas
from benchmarks.sizes import Size, break_scenes, gas_scene, rack_scenes
from benchmarks.targets import TIMES_QUICKER, target_of
from benchmarks.timing import Clock, Sampler, Samples, Task
from ghostball.engine import Scene
from ghostball.validation.scenes.gases import FULL_CLOTH

OUR_RUNS = 5
"""Runs of ours beside each of a peer, whose median counts: they are so much shorter."""

COMPARED: Mapping[str, Callable[[Size], Sequence[Scene]]] = {
    "break-pool": lambda size: break_scenes(FULL_CLOTH, size)[:10],
    "racks": lambda size: rack_scenes(size)[:10],
    "break-paper": lambda size: break_scenes(ROLLING, size)[:10],
    "gas-16": lambda size: [table_gas(16, min(10.0, size.gas_time))],
    "gas-1000": lambda size: [_shorter(gas_scene(1_000, size))],
}
"""Workloads on which peers run, with a few of their scenes, or shorter ones."""

MOST = 7
"""Samples of a peer on a workload: some take seconds."""

PEER_ERRORS = (PeerAbsentError, PeerCannotError, PeerFailedError)


def outcome_of(error: Exception) -> Outcome:
    """Return what an error of a peer means for its measurement."""
    if isinstance(error, PeerAbsentError):
        return "absent"
    return "not-representable" if isinstance(error, PeerCannotError) else "failed"


def _shorter(scene: Scene) -> Scene:
    assert scene.t_max is not None
    return until(scene, scene.t_max / 40.0)


@dataclass
class Comparison:
    """One peer on one workload: measured by its `task`, told by its `row`."""

    workload: str
    peer: Peer
    scenes: Callable[[], Sequence[Scene]]
    outcome: Outcome = "ran"
    detail: str = ""
    _turns: Iterator[Scene] = field(default_factory=lambda: iter(()))

    @property
    def name(self) -> str:
        """What progress calls it."""
        return f"{self.workload} on {self.peer.name}"

    def task(self) -> Task:
        """Return it as something to be measured by turns; a peer that can't is asked only once."""
        return Task(self.name, self._prepare, most=MOST)

    def row(self, samples: Samples, *, judged: bool) -> PeerRow:
        """Return what became of it; `judged` where its target counts."""
        spreads = samples.spreads(self.name)
        target = target_of(self.workload, TIMES_QUICKER, self.peer.name)
        base = PeerRow(
            workload=self.workload,
            peer=self.peer.name,
            version=self.peer.version,
            outcome=self.outcome,
            detail=self.detail,
            target=target.limit if target else None,
        )
        if not spreads:
            return base
        found = {name: spread.median for name, spread in spreads.items()}
        met = target.met(found[TIMES_QUICKER]) if target and judged else None
        seconds = spreads["seconds"]
        counts = {"samples": seconds.samples, "least": seconds.least, "met": met}
        return base.model_copy(update=found | counts)

    def _prepare(self) -> Sampler:
        try:
            scenes = self.scenes()
            for scene in scenes[:1]:
                run(scene)
                self.peer.simulate(scene)  # it may compile
        except PEER_ERRORS as error:
            self._note(error)
            return lambda _: {}
        self._turns = cycle(scenes)
        return self._sample

    def _sample(self, _: Clock) -> dict[str, float]:
        if self.outcome != "ran":
            return {}
        scene = next(self._turns)
        ours = [run(scene) for _ in range(OUR_RUNS)]
        ours_seconds = median(result.wall_time for result in ours)
        ours_events = ours[0].work["events"]
        try:
            theirs = self.peer.simulate(scene)
        except PEER_ERRORS as error:
            self._note(error)
            return {}
        per_event = theirs.seconds / max(theirs.events, 1)
        ours_per_event = ours_seconds / max(ours_events, 1)
        return {
            "seconds": theirs.seconds,
            "events": float(theirs.events),
            "per_event": per_event,
            "ours_seconds": ours_seconds,
            "ours_events": float(ours_events),
            "ours_per_event": ours_per_event,
            "times_quicker": theirs.seconds / ours_seconds,
        }

    def _note(self, error: Exception) -> None:
        self.outcome, self.detail = outcome_of(error), str(error)


def comparisons(workloads: Sequence[str], peers: Sequence[Peer], size: Size) -> list[Comparison]:
    """Return every peer on every one of these workloads that peers run on."""
    return [
        Comparison(workload, peer, partial(COMPARED[workload], size))
        for workload in workloads
        if workload in COMPARED
        for peer in peers
    ]

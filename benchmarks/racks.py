"""How long each of many random racks takes: the mean hangs on a few slow ones."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel, ConfigDict

from benchmarks.comparison import PEER_ERRORS, outcome_of
from benchmarks.measurements import Measurement, measured_where
from benchmarks.peer_engines import Peer
from benchmarks.records import Outcome
from benchmarks.scaling import OurEngine
from benchmarks.scenes import random_rack
from benchmarks.timing import Clock, Figures, Sampler, Samples, Task, take_turns
from ghostball.engine import Scene
from ghostball.validation.parallel.pool import Progress

RACKS = 1_000
"""Racks of a whole measurement."""

PEER_RACKS = 100
"""The first of them, which peers play, once: they need so much longer."""

WARMING = 10
"""The first of them, which each engine plays beforehand: it may compile."""


class RackTimes(BaseModel):
    """Wall time of the simulation alone [s] of each rack, from number 0 on: medians of the rounds.

    `detail` says why there are none.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    engine: str
    version: str = ""
    outcome: Outcome
    detail: str = ""
    seconds: tuple[float, ...] = ()

    @property
    def figures(self) -> Figures | None:
        """What is told of them; None where there are none."""
        return Figures.of(self.seconds) if self.seconds else None


class RacksMeasurement(Measurement):
    """What `python -m benchmarks racks` measured; see `random_rack`."""

    kind: Literal["racks"] = "racks"
    engines: tuple[RackTimes, ...]

    @property
    def anything(self) -> bool:
        """Whether any rack was timed before an interrupt."""
        return any(one.seconds for one in self.engines)


@dataclass(eq=False)
class _Player:
    """One engine that plays racks, and what becomes of it."""

    engine: Peer
    scenes: Sequence[Scene]
    most: int | None = None
    outcome: Outcome = "ran"
    detail: str = ""

    def task(self) -> Task:
        return Task(self.engine.name, self._prepare, self.most)

    def times(self, samples: Samples) -> RackTimes:
        spreads = samples.spreads(self.engine.name).values()
        return RackTimes(
            engine=self.engine.name,
            version=self.engine.version,
            outcome=self.outcome,
            detail=self.detail,
            seconds=tuple(float(f"{spread.median:.4g}") for spread in spreads),
        )

    def _prepare(self) -> Sampler:
        self._play(self.scenes[:WARMING])
        return lambda _: self._play(self.scenes)

    def _play(self, scenes: Sequence[Scene]) -> dict[str, float]:
        """Return the time of each of the scenes; nothing where the engine fails in one of them."""
        if self.outcome != "ran":
            return {}
        try:
            return {scene.name: self.engine.simulate(scene).seconds for scene in scenes}
        except PEER_ERRORS as error:
            self.outcome, self.detail = outcome_of(error), str(error)
            return {}


def measure_racks(
    peers: Sequence[Peer] = (),
    *,
    rounds: int,
    racks: int = RACKS,
    clock: Clock = time.perf_counter,
    progress: Progress[str] | None = None,
) -> RacksMeasurement:
    """Measure our engine on racks, and peers on the first of them; Ctrl-C keeps what was measured.

    Parameters
    ----------
    peers : sequence of Peer
    rounds : int
        How often our engine plays each rack.
    racks : int
        How many; fewer than `RACKS` are a trial.
    clock, progress
        As for `take_turns`.
    """
    environment = measured_where()
    scenes = [random_rack(number) for number in range(racks)]
    players = [_Player(OurEngine(), scenes)]
    players += [_Player(peer, scenes[:PEER_RACKS], most=1) for peer in peers]
    tasks = [player.task() for player in players]
    samples = take_turns(tasks, rounds, clock=clock, progress=progress)
    return RacksMeasurement(
        environment=environment,
        rounds=rounds,
        quick=racks < RACKS,
        interrupted=samples.interrupted,
        engines=tuple(player.times(samples) for player in players),
    )

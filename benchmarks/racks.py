"""How long each of many random racks takes: the mean hangs on a few slow ones."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

from pydantic import BaseModel, ConfigDict

from benchmarks.measurements import Measurement, measured_where
from benchmarks.running import run
from benchmarks.scenes import random_rack
from benchmarks.timing import Clock, Figures, Sampler, Samples, Task, take_turns
from ghostball.engine import EngineFailedError, Scene, UnsupportedSceneError
from ghostball.reference_adapters import EngineUnavailableError, ReferenceEngine, make_engine
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.parallel.pool import Progress
from ghostball.validation.results.environment import versions
from ghostball.validation.runs.playing import ONE_BY_ONE, run_as_it_can

RACKS = 1_000
"""Racks of a whole measurement."""

PEER_RACKS = 100
"""The first of them, which other engines play, once: they need so much longer."""

WARMING = 10
"""The first of them, which each engine plays beforehand: it may compile."""

PEERS = ("pooltool", "billiards", "pymunk:dt=1e-3", "pybullet:dt=1e-3")
"""Engines that are measured beside ours unless others are asked for."""

Outcome = Literal["ran", "absent", "not-representable", "failed"]

_PACKAGES = {"pooltool": "pooltool-billiards"}
"""What an engine is installed as, where that is another name."""


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
class Player:
    """One engine that plays racks, and what becomes of it.

    `play` runs a scene to its end and returns the time of the simulation alone [s].
    """

    name: str
    version: str
    play: Callable[[Scene], float]
    outcome: Outcome = "ran"
    detail: str = ""

    def task(self, scenes: Sequence[Scene], most: int | None = None) -> Task:
        """Return it as something to be measured by turns; what fails isn't asked again."""

        def prepare() -> Sampler:
            self._times(scenes[:WARMING])
            return lambda _: self._times(scenes)

        return Task(self.name, prepare, most)

    def found(self, samples: Samples) -> RackTimes:
        """Return what was measured of it."""
        spreads = samples.spreads(self.name).values()
        return RackTimes(
            engine=self.name,
            version=self.version,
            outcome=self.outcome,
            detail=self.detail,
            seconds=tuple(float(f"{spread.median:.4g}") for spread in spreads),
        )

    def _times(self, scenes: Sequence[Scene]) -> dict[str, float]:
        """Return the time of each of the scenes; nothing where the engine fails in one of them."""
        if self.outcome != "ran":
            return {}
        try:
            return {scene.name: self.play(scene) for scene in scenes}
        except EngineUnavailableError as error:
            self.outcome, self.detail = "absent", str(error)
        except UnsupportedSceneError as error:
            self.outcome, self.detail = "not-representable", str(error)
        except EngineFailedError as error:
            self.outcome, self.detail = "failed", str(error)
        return {}


def our_player() -> Player:
    """Return our own engine."""
    return Player(OURS, "", lambda scene: run(scene).wall_time)


def peer(spec: str) -> Player:
    """Return another engine, as `--engine` names it; one that isn't installed says so when asked.

    Raises
    ------
    GhostballError
        Where there is none of that name, or it doesn't know a setting.
    """
    try:
        engine = make_engine(spec)
    except EngineUnavailableError as error:
        return Player(spec, "", lambda _: math.nan, "absent", str(error))  # never asked
    package = _PACKAGES.get(engine.name, engine.name)
    return Player(spec, versions().get(package) or "", partial(_played, engine))


def _played(engine: ReferenceEngine, scene: Scene) -> float:
    """Run a scene; impacts that share a ball come one by one where the engine knows no other."""
    with captured():
        result = run_as_it_can(engine, scene, ({}, ONE_BY_ONE), "rest")
    if not result.status.complete:
        raise EngineFailedError(engine.name, f"{result.status.value}: {result.reason}")
    return result.wall_time


def measure_racks(
    ours: Player,
    peers: Sequence[Player] = (),
    *,
    rounds: int,
    racks: int = RACKS,
    clock: Clock = time.perf_counter,
    progress: Progress[str] | None = None,
) -> RacksMeasurement:
    """Measure our engine on racks, and peers on the first of them; Ctrl-C keeps what was measured.

    Parameters
    ----------
    ours : Player
    peers : sequence of Player
    rounds : int
        How often our engine plays each rack.
    racks : int
        How many; fewer than `RACKS` are a trial.
    clock, progress
        As for `take_turns`.
    """
    environment = measured_where()
    scenes = [random_rack(number) for number in range(racks)]
    tasks = [ours.task(scenes), *(one.task(scenes[:PEER_RACKS], most=1) for one in peers)]
    samples = take_turns(tasks, rounds, clock=clock, progress=progress)
    return RacksMeasurement(
        environment=environment,
        rounds=rounds,
        quick=racks < RACKS,
        interrupted=samples.interrupted,
        engines=tuple(player.found(samples) for player in (ours, *peers)),
    )

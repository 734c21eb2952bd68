"""How long each of many random racks takes: the mean hangs on a few slow ones."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Annotated, Literal

import typer
from rich.console import RenderableType
from rich.markup import escape

from benchmarks.frame import Repeats, benchmark, report
from benchmarks.measurements import Distribution, Shown, table_of
from benchmarks.scenes import random_rack, run
from ghostball.model import EngineFailedError, Scene, UnsupportedSceneError
from ghostball.reference_adapters import EngineUnavailableError, ReferenceEngine, make_engine
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.registry import OURS
from ghostball.reports.style import format_time
from ghostball.validation.parallel.sources import PACKAGE_OF, versions
from ghostball.validation.results.measurement import Record
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.runs.interleave import Sampler, Task, interleave

RACKS = 1_000
"""Racks of a whole measurement."""

PEER_RACKS = 100
"""The first of them, which other engines play, once: they need so much longer."""

WARMING = 10
"""The first of them, which each engine plays beforehand: it may compile."""

PEERS = ("pooltool", "billiards", "pymunk:dt=1e-3", "pybullet:dt=1e-3")
"""Engines that are measured beside ours unless others are asked for."""


class RackTimes(Record):
    """Wall time of the simulation alone [s] of each rack, from number 0 on: medians of the rounds.

    `detail` says why there are none.
    """

    engine: str
    version: str = ""
    detail: str = ""
    seconds: tuple[float, ...] = ()

    @property
    def figures(self) -> Distribution:
        """How the times are spread."""
        return Distribution.of(self.seconds)


class RacksMeasurement(Shown):
    """What `python -m benchmarks racks` measured; see `random_rack`."""

    kind: Literal["racks"] = "racks"
    engines: tuple[RackTimes, ...]

    @property
    def table(self) -> RenderableType:
        """Each engine's figures over the racks, or why it has none."""
        rows = []
        for one in self.engines:
            found = one.figures
            name = f"{one.engine} {one.version}".strip()
            times = map(format_time, (found.median, found.mean, found.p99, found.greatest))
            rows.append((name, str(found.count), *times, escape(one.detail)))
        heads = ("engine", "racks", "median", "mean", "99 %", "slowest", "why not")
        return table_of(heads, rows, left=("why not",))


@dataclass(eq=False)
class Player:
    """One engine that plays racks; `why_not` says why it can't, and then it isn't asked again.

    `play` runs a scene to its end and returns the time of the simulation alone [s].
    """

    name: str
    version: str
    play: Callable[[Scene], float]
    why_not: str = ""

    def task(self, scenes: Sequence[Scene], most: int | None = None) -> Task:
        """Return it as something to be measured, the first racks played beforehand."""

        def prepare() -> Sampler:
            self.times(scenes[:WARMING])
            return lambda: self.times(scenes)

        return Task(self.name, prepare, most)

    def times(self, scenes: Sequence[Scene]) -> dict[str, float]:
        """Return the time of each of the scenes; nothing where the engine fails in one of them."""
        if self.why_not:
            return {}
        try:
            return {scene.name: self.play(scene) for scene in scenes}
        except (EngineUnavailableError, UnsupportedSceneError, EngineFailedError) as error:
            self.why_not = str(error)
            return {}


def our_player() -> Player:
    """Return our own engine."""
    return Player(OURS, "", lambda scene: run(scene).wall_time)


def peer_of(spec: str) -> Player:
    """Return another engine, named as by `--engine`; one that isn't there says so when asked."""
    try:
        engine = make_engine(spec)
    except EngineUnavailableError as error:
        return Player(spec, "", lambda _: math.nan, str(error))  # never asked
    package = PACKAGE_OF.get(engine.name, engine.name)
    return Player(spec, versions().get(package) or "", partial(_played, engine))


def _played(engine: ReferenceEngine, scene: Scene) -> float:
    """Run a scene; impacts that share a ball come one by one where the engine knows no other."""
    with captured():
        try:
            result = run_engine(engine, scene, "rest")
        except UnsupportedSceneError as refused:
            physics = scene.physics.model_copy(update={"impacts": "sequential"})
            try:
                result = run_engine(engine, scene.model_copy(update={"physics": physics}), "rest")
            except UnsupportedSceneError:
                raise refused from None
    if not result.status.complete:
        raise EngineFailedError(engine.name, f"{result.status.value}: {result.reason}")
    return result.wall_time


Peers = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ENGINE",
        help="Another engine beside ours, as for `run --engine`; once for each, or none for none "
        f"(default: {', '.join(PEERS)}).",
    ),
]


@benchmark
def racks(repeats: Repeats = 5, peer: Peers = None) -> RacksMeasurement:
    """Measure the time of each of 1000 random racks, half frozen.

    The other half is loose by up to 1 mm; all of pool's physics, the cue ball at 4 to 12 m/s. Other
    engines play the first 100 of them, once.
    """
    asked = PEERS if peer is None else [] if peer == ["none"] else peer
    return measure_racks(our_player(), [*map(peer_of, asked)], rounds=repeats)


def measure_racks(
    ours: Player, peers: Sequence[Player] = (), *, rounds: int, racks: int = RACKS
) -> RacksMeasurement:
    """Measure our engine on racks, `rounds` times each, and peers once on the first of them."""
    scenes = [random_rack(number) for number in range(racks)]
    tasks = [ours.task(scenes), *(one.task(scenes[:PEER_RACKS], most=1) for one in peers)]
    found = interleave(tasks, rounds, report)
    engines = (
        RackTimes(
            engine=player.name,
            version=player.version,
            detail=player.why_not,
            seconds=tuple(float(f"{median(one):.4g}") for one in found[player.name].values()),
        )
        for player in (ours, *peers)
    )
    return RacksMeasurement(rounds=rounds, engines=tuple(engines))

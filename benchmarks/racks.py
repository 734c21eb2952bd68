"""Run time of each of many random racks; a few slow racks dominate the mean."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import Annotated, Literal

from rich.console import RenderableType
from rich.markup import escape

from benchmarks.commands import Repeats, benchmark, peer_option, report_progress
from benchmarks.measurements import BenchmarkMeasurement, Distribution, table_of
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
"""Number of racks of a whole measurement."""

PEER_RACKS = 100
"""Number of racks that other engines simulate, once: they are much slower."""

WARM_UP_RACKS = 10
"""Number of racks that each engine simulates beforehand, because it may have to compile."""

PEERS = ("pooltool", "billiards", "pymunk:dt=1e-3", "pybullet:dt=1e-3")
"""Other engines that are measured by default."""


class RackTimes(Record):
    """Run times of one engine.

    `seconds` [s]: time of the simulation alone for each rack, the median of the rounds.
    `detail`: why there are no times, or "".
    """

    engine: str
    version: str = ""
    detail: str = ""
    seconds: tuple[float, ...] = ()

    @property
    def figures(self) -> Distribution:
        """Distribution of the times."""
        return Distribution.of(self.seconds)


class RacksMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks racks`; see `random_rack`."""

    kind: Literal["racks"] = "racks"
    engines: tuple[RackTimes, ...]

    @property
    def table(self) -> RenderableType:
        """Table with a row for each engine: its distribution, or why there is none."""
        rows = []
        for one in self.engines:
            found = one.figures
            name = f"{one.engine} {one.version}".strip()
            times = map(format_time, (found.median, found.mean, found.p99, found.greatest))
            rows.append((name, str(found.count), *times, escape(one.detail)))
        heads = ("engine", "racks", "median", "mean", "99 %", "slowest", "reason")
        return table_of(heads, rows, left=("reason",))


@dataclass(eq=False)
class TimedEngine:
    """An engine that simulates racks.

    `play`: simulates a scene and returns the time of the simulation alone [s].
    `why_not`: why the engine can't run; then `times` doesn't run it again.
    """

    name: str
    version: str
    play: Callable[[Scene], float]
    why_not: str = ""

    def task(self, scenes: Sequence[Scene], most: int | None = None) -> Task:
        """Return the measurement of the scenes as a task; its preparation runs the first scenes."""

        def prepare() -> Sampler:
            self.times(scenes[:WARM_UP_RACKS])
            return lambda: self.times(scenes)

        return Task(self.name, prepare, most)

    def times(self, scenes: Sequence[Scene]) -> dict[str, float]:
        """Return the time of each scene [s], by name; {} if the engine fails in one of them."""
        if self.why_not:
            return {}
        try:
            return {scene.name: self.play(scene) for scene in scenes}
        except (EngineUnavailableError, UnsupportedSceneError, EngineFailedError) as error:
            self.why_not = str(error)
            return {}


def timed_ghostball() -> TimedEngine:
    """Return Ghostball's engine."""
    return TimedEngine(OURS, "", lambda scene: run(scene).wall_time)


def timed_peer(spec: str) -> TimedEngine:
    """Return another engine, named as for `--engine`; it may be unavailable."""
    try:
        engine = make_engine(spec)
    except EngineUnavailableError as error:
        return TimedEngine(spec, "", lambda _: math.nan, str(error))  # never called
    package = PACKAGE_OF.get(engine.name, engine.name)
    return TimedEngine(spec, versions().get(package) or "", partial(_run_time, engine))


def _run_time(engine: ReferenceEngine, scene: Scene) -> float:
    """Return the time of a scene [s].

    If the engine doesn't support simultaneous impacts, they are resolved one after another.
    """
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


Peers = Annotated[list[str] | None, peer_option(PEERS)]


@benchmark
def racks(repeats: Repeats = 5, peer: Peers = None) -> RacksMeasurement:
    """Measure the run time of each of 1000 random racks.

    Half of the racks are frozen, and half have gaps of up to 1 mm. They have the full physics of
    pool, and cue balls of 4 to 12 m/s. Other engines simulate the first 100 racks, once.
    """
    asked = PEERS if peer is None else [] if peer == ["none"] else peer
    return measure_racks(timed_ghostball(), [*map(timed_peer, asked)], rounds=repeats)


def measure_racks(
    ours: TimedEngine, peers: Sequence[TimedEngine] = (), *, rounds: int, racks: int = RACKS
) -> RacksMeasurement:
    """Measure Ghostball's engine on `racks` racks in `rounds` rounds; peers on few, once."""
    scenes = [random_rack(number) for number in range(racks)]
    tasks = [ours.task(scenes), *(one.task(scenes[:PEER_RACKS], most=1) for one in peers)]
    found = interleave(tasks, rounds, report_progress)
    engines = (
        RackTimes(
            engine=engine.name,
            version=engine.version,
            detail=engine.why_not,
            seconds=tuple(float(f"{median(one):.4g}") for one in found[engine.name].values()),
        )
        for engine in (ours, *peers)
    )
    return RacksMeasurement(rounds=rounds, engines=tuple(engines))

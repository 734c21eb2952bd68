"""Shares of breaks that make a ball, scratch or make the 8, beside published counts.

`validation/measured/breaks.toml` has the setups of the breaks and the values of the model, with
their sources.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Final, Literal, NamedTuple

import numpy as np
from pydantic import Field
from rich.console import RenderableType

from benchmarks.commands import Count, benchmark, peer_option, with_progress
from benchmarks.measurements import BenchmarkMeasurement, table_of
from ghostball.engine import simulate, simulate_starts
from ghostball.model import POOL_BALL_RADIUS, EngineFailedError, Physics, UnsupportedSceneError
from ghostball.model.features import check_supported
from ghostball.reference_adapters import EngineUnavailableError, make_engine
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.measured.breaks import (
    BreakCounts,
    Setup,
    break_physics,
    count_breaks,
    counts_of_results,
    fallen,
    inputs,
    setups,
    starts_of,
    values_of,
)
from ghostball.validation.measured.facts import FactRow, binomial_error, facts_of
from ghostball.validation.parallel.sources import PACKAGE_OF, versions
from ghostball.validation.results.measurement import Record
from ghostball.validation.runs.engine_runs import run_engine

BREAKS = 1_000
"""Number of breaks of a cell; the standard error of a share of 80 % is 1.3 %. Half as many if an
input is changed."""

PEER_BREAKS = 40
"""Number of breaks of another engine, which takes seconds for a break."""

PEERS = ("pymunk", "pybullet", "mujoco", "box2d")

GAPS = (2e-6, 5e-6, 15e-6, 50e-6, 150e-6, 500e-6)
"""Mean gaps of racks [m]: the range of which the largest is clearly visible."""

RACK_OPENS = 4e-3
"""Time after the start of a break at which the balls of the rack have parted [s], plus that until
the cue ball arrives. From then on, breaks with balls that may fly are simulated."""

FLIGHTS: Final = (
    {"airborne": 0.0},
    {"airborne": 1.0, "table_restitution": 0.5},
    {"airborne": 1.0, "table_restitution": 0.0},
)
"""Whether balls may leave the cloth, and the restitution of a ball that lands; see `_flights`."""

FAMILIES: Final = {"made": "breaks-made", "scratch": "breaks-scratch", "eight": "breaks-eight"}
"""The facts about each outcome."""


class CountedBreaks(Record):
    """Counts of breaks of one setup, see `BreakCounts`.

    `impacts`: how impacts of several balls are resolved; "" for other engines.
    `changed`: inputs that differ from their usual values; or one of `FLIGHTS`.
    `left`: number of breaks in which a ball leaves the table other than into a pocket.
    `detail`: why there are no counts, or "".
    """

    engine: str
    version: str = ""
    setup: str
    impacts: str = ""
    changed: dict[str, float] = Field(default_factory=dict)
    detail: str = ""
    breaks: int = 0
    made: int = 0
    clean: int = 0
    scratch: int = 0
    eight: int = 0
    balls: int = 0
    left: int = 0

    def share(self, outcome: str) -> tuple[float, float]:
        """Return the share of an outcome, and its standard error of counting.

        The balls that count are those of the published counts, see `FactRow.without_scratch`.
        """
        clean = any(one.what == self.setup and one.without_scratch for one in _rows(outcome))
        count = self.clean if clean else getattr(self, outcome)
        return count / self.breaks, binomial_error(count, self.breaks)


class ComparedShare(NamedTuple):
    """A published share with its error, and that of Ghostball's engine.

    `share`, `error`: with impacts that last, and its error of counting.
    `unknown`: its standard uncertainty from inputs.
    `rigid`: share and error with impacts one after another.
    """

    setup: str
    outcome: str
    published: tuple[float, float]
    share: float
    error: float
    unknown: float
    rigid: tuple[float, float]

    @property
    def errors_off(self) -> float:
        """Difference of the shares in standard errors of counting and inputs together."""
        error = math.hypot(self.published[1], self.error, self.unknown)
        return (self.share - self.published[0]) / error


class MadeBallsMeasurement(BenchmarkMeasurement):
    """Measurement of `python -m benchmarks made-balls`."""

    kind: Literal["made-balls"] = "made-balls"
    cells: tuple[CountedBreaks, ...]

    @property
    def table(self) -> RenderableType:
        """Table of the published shares, and of those of Ghostball's engine."""
        heads = ("setup", "outcome", "published", "impacts that last", "rigid", "inputs")
        rows = [
            (
                one.setup,
                one.outcome,
                percent(*one.published),
                percent(one.share, one.error),
                percent(*one.rigid),
                f"± {100.0 * one.unknown:.1f} %",
            )
            for one in self.compared()
        ]
        return table_of(heads, rows, left=("outcome",))

    def compared(self) -> list[ComparedShare]:
        """Return each published share, and those of Ghostball's engine."""
        found = []
        for outcome in FAMILIES:
            for row in _rows(outcome):
                share, error = self.cell(row.what, "compliant").share(outcome)
                found.append(
                    ComparedShare(
                        setup=row.what,
                        outcome=words_of(row, outcome),
                        published=(row.value, row.error or 0.0),
                        share=share,
                        error=error,
                        unknown=self.uncertainty(row.what, outcome),
                        rigid=self.cell(row.what, "sequential").share(outcome),
                    )
                )
        return found

    def cell(
        self, setup: str, impacts: str, changed: Mapping[str, float] | None = None
    ) -> CountedBreaks:
        """Return the counts of Ghostball's engine in a setup, with some inputs changed."""
        return next(
            one
            for one in self.cells
            if (one.engine, one.setup, one.impacts) == (OURS, setup, impacts)
            and one.changed == (changed or {})
        )

    def effects(self, setup: str, outcome: str) -> dict[str, tuple[float, float]]:
        """Return how far a share moves with each input, and the standard error of counting.

        The effect of an input is half of the difference between the shares one standard
        uncertainty above and below its value.
        """
        found = {}
        for one in inputs():
            (low, low_error), (high, high_error) = (
                self.cell(setup, "compliant", {one.name: value}).share(outcome)
                for value in (one.value - one.error, one.value + one.error)
            )
            found[one.name] = 0.5 * (high - low), 0.5 * math.hypot(low_error, high_error)
        return found

    def uncertainty(self, setup: str, outcome: str) -> float:
        """Return the standard uncertainty of a share from that of all inputs.

        This is the root of the sum of squared effects, less the squares that counting adds.
        """
        found = self.effects(setup, outcome).values()
        return math.sqrt(max(0.0, sum(effect**2 - error**2 for effect, error in found)))


_WAYS: Final = ("compliant", "sequential", "simultaneous")


def _rows(outcome: str) -> Sequence[FactRow]:
    return facts_of(FAMILIES[outcome]).rows


def words_of(row: FactRow, outcome: str) -> str:
    """Return what a published share counts."""
    if outcome == "made":
        return "makes a ball, no scratch" if row.without_scratch else "makes a ball"
    return {"scratch": "scratches", "eight": "makes the 8"}[outcome]


def percent(share: float, error: float) -> str:
    """Return a share with its standard error, in per cent."""
    return f"{100.0 * share:.1f} ± {100.0 * error:.1f} %"


Peers = Annotated[list[str] | None, peer_option(PEERS)]


@benchmark
def made_balls(count: Count = BREAKS, peer: Peers = None) -> MadeBallsMeasurement:
    """Count the breaks that make a ball, scratch or make the 8; compare with published counts."""
    asked = PEERS if peer is None else () if peer == ["none"] else peer
    cells = [
        _ours(setup, -(-count // 2) if changed else count, impacts, changed)
        for setup, impacts, changed in with_progress(list(_variants()), lambda one: one[0].name)
    ]
    first = setups()[0]
    cells += _flights(first, -(-count // 2))
    cells += [_peer(first, min(count, PEER_BREAKS), one) for one in asked]
    return MadeBallsMeasurement(cells=tuple(cells))


def _variants() -> Iterator[tuple[Setup, str, dict[str, float]]]:
    """Yield the setup, way of impacts and changed inputs of each cell of Ghostball's engine."""
    for setup in setups():
        for impacts in _WAYS:
            yield setup, impacts, {}
        for one in inputs():
            for value in (one.value - one.error, one.value + one.error):
                yield setup, "compliant", {one.name: value}
    first = setups()[0]
    yield first, "simultaneous", {"gap": 0.0}
    for gap in GAPS:
        for impacts in ("compliant", "sequential"):
            for unevenness in (1.0, 0.0):
                yield first, impacts, {"gap": gap, "unevenness": unevenness}


def _ours(setup: Setup, count: int, impacts: str, changed: dict[str, float]) -> CountedBreaks:
    values = values_of(**changed)
    fields = break_physics(OURS, make_engine(OURS).capabilities, values, impacts)
    assert fields is not None
    counts = count_breaks(setup, starts_of(setup, Physics(**fields), values, count))
    return _counted(setup, counts, engine=OURS, impacts=impacts, changed=changed)


def _flights(setup: Setup, count: int) -> list[CountedBreaks]:
    """Count breaks whose balls may fly once the rack has opened, and the same without flight.

    Impacts that last need balls on the cloth, so the rack is opened without flight. The cushions
    are those of the preset `pool`, because the law of the other breaks keeps balls on the cloth.
    Breaks with balls that still push each other are left out.
    """
    values = values_of()
    fields = break_physics(OURS, make_engine(OURS).capabilities, values)
    assert fields is not None
    starts = starts_of(setup, Physics(**fields), values, count)
    states = []
    for scene in starts.scenes():
        to_rack = float(scene.positions[1, 0] - scene.positions[0, 0]) / scene.balls[0].speed
        opened = scene.model_copy(update={"t_max": to_rack + RACK_OPENS})
        states.append(simulate(opened).final_state)
    positions, velocities, spins = (
        np.array([getattr(one, name)[0] for one in states])
        for name in ("positions", "velocities", "angular_velocities")
    )
    between = positions[:, :, None] - positions[:, None]
    apart = np.linalg.norm(between, axis=3) + np.eye(positions.shape[1])
    free = apart.min(axis=(1, 2)) >= 2.0 * POOL_BALL_RADIUS
    usual = {
        name: fields[name]
        for name in ("ball_restitution", "ball_friction", "sliding_friction", "rolling_friction")
    }
    cells = []
    for changed in FLIGHTS:
        flight = changed | {"airborne": changed["airborne"] == 1.0}
        physics = Physics(preset="pool", impacts="sequential", **usual, **flight)
        scene = starts.scene.model_copy(update={"physics": physics})
        batch = simulate_starts(scene, positions[free], velocities[free], spins[free])
        counts = BreakCounts.of(batch.pocketed >= 0, setup.ids.index("8"))
        left = int(np.count_nonzero(batch.off_table.any(axis=1)))
        cells.append(
            _counted(setup, counts, engine=OURS, impacts="compliant", changed=changed, left=left)
        )
    return cells


def _peer(setup: Setup, count: int, spec: str) -> CountedBreaks:
    """Count the breaks of another engine; it may be unavailable or fail."""
    try:
        engine = make_engine(spec)
        version = versions().get(PACKAGE_OF.get(engine.name, engine.name)) or ""
        fields = break_physics(engine.name, engine.capabilities, values_of())
        if fields is None:
            raise UnsupportedSceneError(spec, ("no cushion law that changes spin",))
        starts = starts_of(setup, Physics(**fields), values_of(), count)
        check_supported(engine.name, engine.capabilities, starts.scene)
        fell = []
        for scene in with_progress(list(starts.scenes()), lambda _: spec):
            with captured():
                fell.append(fallen(run_engine(engine, scene, "events")))
    except (EngineUnavailableError, UnsupportedSceneError, EngineFailedError) as error:
        return CountedBreaks(engine=spec, setup=setup.name, detail=str(error))
    return _counted(setup, counts_of_results(setup, fell), engine=spec, version=version)


def _counted(setup: Setup, counts: BreakCounts, **fields: object) -> CountedBreaks:
    return CountedBreaks.model_validate({"setup": setup.name, **counts._asdict(), **fields})


def counted_peers(stored: MadeBallsMeasurement) -> Sequence[CountedBreaks]:
    """Return the counts of other engines that have any."""
    return [one for one in stored.cells if one.engine != OURS and one.breaks]

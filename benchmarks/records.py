"""What is stored of our engine's speed, beside peers and against targets."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from benchmarks.measurements import Measurement
from benchmarks.timing import Spread

Physics = Literal["gas", "cloth"]
"""An elastic gas, or balls with all of pool's physics."""

Outcome = Literal["ran", "absent", "not-representable", "failed"]


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Row(_Model):
    """One quantity of one workload, in SI units; `met` is None where nothing was aimed at."""

    workload: str
    title: str
    quantity: str
    unit: str
    median: float
    least: float
    greatest: float
    samples: int
    target: float | None = None
    met: bool | None = None


class PeerRow(_Model):
    """One peer on one workload, beside ours on the same scenes in the same minutes.

    `seconds` and `per_event` are the peer's medians [s], `events` is how many it had; `ours_` the
    same of our engine. `times_quicker` is the median of the peer's time over ours. `detail` says
    why there is none.
    """

    workload: str
    peer: str
    version: str = ""
    outcome: Outcome
    detail: str = ""
    samples: int = 0
    seconds: float | None = None
    least: float | None = None
    events: float | None = None
    per_event: float | None = None
    ours_seconds: float | None = None
    ours_events: float | None = None
    ours_per_event: float | None = None
    times_quicker: float | None = None
    target: float | None = None
    met: bool | None = None


class TargetsMeasurement(Measurement):
    """What `python -m benchmarks targets` measured."""

    kind: Literal["targets"] = "targets"
    rows: tuple[Row, ...]
    peers: tuple[PeerRow, ...] = ()

    @property
    def anything(self) -> bool:
        """Whether any row was measured."""
        return bool(self.rows)

    def row(self, workload: str, quantity: str) -> Row | None:
        """Return a row, or None where it wasn't measured."""
        found = (r for r in self.rows if (r.workload, r.quantity) == (workload, quantity))
        return next(found, None)


class Point(_Model):
    """Time per event of one engine on one scene [s], and what it had to do."""

    engine: str
    physics: Physics
    balls: int
    packing: Annotated[float, Field(gt=0.0)]
    events: float
    per_event: float
    least: float
    greatest: float
    samples: int


class Curve(_Model):
    """What became of one engine: as far as it went, and why no further."""

    engine: str
    physics: Physics
    version: str = ""
    outcome: Outcome
    detail: str = ""


class ScalingMeasurement(Measurement):
    """What `python -m benchmarks scaling` measured."""

    kind: Literal["scaling"] = "scaling"
    fixed_packing: float
    fixed_balls: int
    by_balls: tuple[Point, ...]
    by_packing: tuple[Point, ...]
    curves: tuple[Curve, ...] = ()

    @property
    def anything(self) -> bool:
        """Whether any point was measured."""
        return bool(self.by_balls or self.by_packing)


def spread_fields(spread: Spread) -> dict[str, Any]:
    """Return a spread as fields of a row."""
    return {
        "median": spread.median,
        "least": spread.least,
        "greatest": spread.greatest,
        "samples": spread.samples,
    }

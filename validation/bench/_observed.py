"""What a stored measurement of any kind observed: named numbers, and what they spread over."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from pydantic import BaseModel, Field

from ghostball.validation.bench._points import best_of
from ghostball.validation.bench.accuracy import AccuracyMeasurement
from ghostball.validation.bench.attribution import AttributionMeasurement
from ghostball.validation.bench.measurements import ScalingMeasurement, TargetsMeasurement
from ghostball.validation.bench.precision import PrecisionMeasurement
from ghostball.validation.bench.racks import RacksMeasurement
from ghostball.validation.bench.skips import COUNTERS, SkipsMeasurement


@dataclass(frozen=True)
class Observed:
    """One number.

    Attributes
    ----------
    value : float
        In SI units: a median, or a count.
    unit : str
    low, high : float or None
        What it was spread over; None for what is counted, which no repetition changes.
    target : float or None
    target_kind : "at_most", "at_least" or None
    """

    value: float
    unit: str
    low: float | None = None
    high: float | None = None
    target: float | None = None
    target_kind: Literal["at_most", "at_least"] | None = None


@dataclass(frozen=True)
class Measured:
    """What one file holds: where it was measured, and its numbers by quantity."""

    environment: Mapping[str, Any]
    values: dict[str, Observed]


Pairs = Iterator[tuple[str, Observed]]


def _targets(measured: TargetsMeasurement) -> Pairs:
    for row in measured.rows:
        spread = (row.median, row.unit, row.least, row.greatest)
        yield f"{row.workload}/{row.quantity}", Observed(*spread, row.target, row.target_kind)
    for peer in measured.peers:
        if peer.times_quicker is not None:
            kind: Literal["at_least"] | None = None if peer.target is None else "at_least"
            name = f"{peer.workload}/times_quicker/{peer.peer}"
            yield name, Observed(peer.times_quicker, "1", target=peer.target, target_kind=kind)


def _scaling(measured: ScalingMeasurement) -> Pairs:
    for along, points in (("balls", measured.by_balls), ("packing", measured.by_packing)):
        for point in points:
            name = f"{point.engine}/{point.physics}/{along}={getattr(point, along):g}"
            yield name, Observed(point.per_event, "s", point.least, point.greatest)


def _racks(measured: RacksMeasurement) -> Pairs:
    for one in measured.engines:
        figures = asdict(one.figures) if one.figures else {}
        for name, seconds in figures.items():
            yield f"{one.engine}/{name}", Observed(seconds, "s")


def _skips(measured: SkipsMeasurement) -> Pairs:
    """Yield, for each skip, what it is over all scenes."""
    for skip in dict.fromkeys(row.skip for row in measured.rows):
        rows = [row for row in measured.rows if row.skip == skip]
        yield f"{skip}/scenes", Observed(len(rows), "1")
        yield f"{skip}/differing", Observed(sum(r.equality == "differs" for r in rows), "1")
        for counter in COUNTERS:
            yield f"{skip}/{counter}_on", Observed(sum(r.work_on[counter] for r in rows), "1")
            yield f"{skip}/{counter}_off", Observed(sum(r.work_off[counter] for r in rows), "1")


def _accuracy(measured: AccuracyMeasurement) -> Pairs:
    for name in ("shots", "events", "missing", "invented", "swapped", "negligible"):
        yield name, Observed(getattr(measured, name), "1")
    yield "faulty", Observed(len(measured.faulty), "1")
    for name, spread in (
        ("quality_factor", measured.quality_factor),
        ("time_error_ulps", measured.time_error_ulps),
    ):
        for part in ("median", "p99", "greatest"):
            if (value := getattr(spread, part)) is not None:
                yield f"{name}/{part}", Observed(value, "1")


def _attribution(measured: AttributionMeasurement) -> Pairs:
    for one in measured.engines:
        for name in ("shots", "attributed", "covered", "not_told", "not_compared", "blamed"):
            yield f"{one.engine}/{name}", Observed(getattr(one, name), "1")


def _precision(measured: PrecisionMeasurement) -> Pairs:
    for curve in measured.curves:
        name = f"{curve.scene}/{curve.engine}"
        mine = [p for p in measured.points if (p.scene, p.engine) == (curve.scene, curve.engine)]
        yield f"{name}/least_error", Observed(best_of(mine).error_high, "m")
        if curve.order is not None:
            yield f"{name}/order", Observed(curve.order, "1")
        for reach in curve.reach:
            if reach.how == "measured" and reach.seconds is not None:
                yield f"{name}/to_{reach.target:g}_m", Observed(reach.seconds, "s")


class _Survival(BaseModel):
    """One line of what engines survived: a family, an engine, counts."""

    family: str
    engine: str
    trials: int
    survived: int
    broken: int


class _Tracked(BaseModel):
    """The numbers by which the stress suite tracks an engine."""

    engine: str
    largest_step_without_a_miss: float | None = None
    needs: dict[str, dict[str, float]] = Field(default_factory=dict)


class _Stress(BaseModel):
    """What `ghostball stress --json` prints, as far as it is tracked."""

    environment: dict[str, Any]
    survival: tuple[_Survival, ...]
    tracked: tuple[_Tracked, ...]


def _stress(measured: _Stress) -> Pairs:
    for line in measured.survival:
        for name in ("trials", "survived", "broken"):
            yield f"{line.engine}/{line.family}/{name}", Observed(getattr(line, name), "1")
    for one in measured.tracked:
        if one.largest_step_without_a_miss is not None:
            name = f"{one.engine}/largest_step_without_a_miss"
            yield name, Observed(one.largest_step_without_a_miss, "s")
        for counted, quantiles in one.needs.items():
            for quantile, value in quantiles.items():
                name = f"{one.engine}/breaks/{counted}/{quantile}"
                yield name, Observed(value, "s" if counted == "seconds" else "1")


_READERS: Mapping[str, tuple[type[BaseModel], Callable[[Any], Pairs]]] = {
    "targets": (TargetsMeasurement, _targets),
    "scaling": (ScalingMeasurement, _scaling),
    "racks": (RacksMeasurement, _racks),
    "skips": (SkipsMeasurement, _skips),
    "accuracy": (AccuracyMeasurement, _accuracy),
    "attribution": (AttributionMeasurement, _attribution),
    "precision": (PrecisionMeasurement, _precision),
    "stress": (_Stress, _stress),
}

KINDS = tuple(_READERS)
"""Kinds of measurements that are stored, by the names of their files."""


def observed_in(kind: str, text: str) -> Measured:
    """Return what a stored measurement observed.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    text : str
        The JSON.

    Raises
    ------
    ValidationError
        Where it is another file, or of another version of the schema.
    """
    model, pairs = _READERS[kind]
    measured: Any = model.model_validate_json(text)
    return Measured(measured.environment, dict(pairs(measured)))

"""The band in which a metric or counter is accepted, made from what it was when it was accepted.

The engine is deterministic: what it counts may not move at all. An error may move within what
rounding does to it, and no further in either direction: an error that grew is a regression, one
that shrank is to be kept.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from ghostball.model import GhostballError
from ghostball.validation.baselines.regression import Level, Quantity
from ghostball.validation.checks.metric_table import METRICS, Metric

FACTOR = 2.0
"""How many times larger or smaller an error may become: the last bits decide that much."""

ROUNDINGS = 4.0
"""How many roundings more or fewer: the largest error of many balls moves by as much by chance."""

_COUNTED_IN_ROUNDINGS = ("rest_error_ulps", "quality_factor")
"""Errors in units of what rounding makes of this very shot: they tell how far others may move."""

_EXTENTS = ("graded_until", "graded_events")

_PLACES = frozenset({"first_divergence_time", "energy_difference_time"})
"""Metrics that are a time at which something happens: neither direction of change is better."""

_MORE_IS_BETTER = frozenset({"matching_events", *_EXTENTS})

IN_ROUNDINGS_OF_SHOT = frozenset(
    {
        *_COUNTED_IN_ROUNDINGS,
        "rest_time_error_ulps",
        "event_time_factor",
        "rest_time_factor",
        "path_factor",
        "energy_difference_factor",
    }
)

_GRAIN = 1e-15
"""What a few roundings are in a scene of metres and seconds, or of an energy over the first one."""

COUNTED = "a count: the same on every machine"
EXTENT = "how far the run is graded: less of it would hide what comes later"
OF_WORK = "what the engine does is deterministic: the same on every machine"
IN_ROUNDINGS = f"an error in roundings: within a factor of {FACTOR:g}, or {ROUNDINGS:g} of them"
SCALED = "an error: as far as the error in roundings may move"
SMALL = f"an error: within a factor of {FACTOR:g}, or a few roundings"
SHOWN = "says where, not how much"


class Band(NamedTuple):
    """What is accepted of a number, what leaving it means, and why."""

    low: int | float | None
    high: int | float | None
    level: Level
    why: str

    def holds(self, value: int | float | None) -> bool:
        """Whether a value lies in the band; none never does."""
        if value is None:
            return False
        return (self.low is None or value >= self.low) and (self.high is None or value <= self.high)


@dataclass(frozen=True)
class Bands:
    """What is accepted of a scene: bands of its metrics and counters, and how its hash counts."""

    metrics: Mapping[str, Band]
    counters: Mapping[str, Band]
    hash_level: Level = "error"


def band_of_metric(name: str, metrics: Mapping[str, int | float]) -> Band:
    """Return the band of a metric, given all that were accepted together.

    In a chaotic shot the last bits decide the leading digits of an error in metres, and only its
    size in roundings means something: an error in metres may move by the same factor as that one.
    """
    value = metrics[name]
    if name in _PLACES:
        return Band(None, None, "off", SHOWN)
    if name in _EXTENTS:
        return Band(value, value, "error", EXTENT)
    if isinstance(value, int):
        return Band(value, value, "error", COUNTED)
    if name in IN_ROUNDINGS_OF_SHOT:
        return Band(*_around(float(value), ROUNDINGS), "error", IN_ROUNDINGS)
    counted = next((metrics[one] for one in _COUNTED_IN_ROUNDINGS if metrics.get(one)), None)
    if counted is None:
        return Band(*_around(float(value), _GRAIN), "error", SMALL)
    low, high = _around(float(counted), ROUNDINGS)
    # Nothing of an error that isn't there, also where a factor is beyond all numbers.
    least, most = (value * (bound / counted) if value else 0.0 for bound in (low, high))
    return Band(max(0.0, min(least, value - _GRAIN)), max(most, value + _GRAIN), "error", SCALED)


def _around(value: float, grain: float) -> tuple[float, float]:
    low = max(0.0, min(value / FACTOR, value - grain))
    return low, max(value * FACTOR, value + grain)


def band_of_counter(value: int) -> Band:
    """Return the band of a work counter."""
    return Band(value, value, "error", OF_WORK)


def is_error(metric: Metric) -> bool:
    """Whether less of a metric is nearer to the truth."""
    return metric.compares is not None and metric.name not in {*_PLACES, *_MORE_IS_BETTER}


def direction(quantity: Quantity) -> int:
    """Return -1 where a metric left its band away from the truth, 1 where towards it, else 0.

    Raises `GhostballError` where there is no such metric.
    """
    metric = METRICS.get(quantity.name)
    if metric is None:
        raise GhostballError(f"`{quantity.name}` is no metric. Known: {', '.join(METRICS)}")
    if quantity.within or quantity.level == "off":
        return 0
    if quantity.base is None or quantity.head is None:
        return 0
    if metric.name in _MORE_IS_BETTER:
        return 1 if quantity.head > quantity.base else -1
    if not is_error(metric):
        return 0
    return 1 if quantity.head < quantity.base else -1

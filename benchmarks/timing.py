"""What is said of the times of many scenes, and how one of them is run."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from statistics import mean, median

import numpy as np

from ghostball.engine import simulate
from ghostball.model import Record, Result, Scene
from ghostball.validation.results.measurement import MeasurementError


@dataclass(frozen=True)
class Figures:
    """What is said of the times of many scenes: whoever runs them all pays the mean.

    `median`, `mean`, `p99`, `slowest`: `p99` is the least of the values that 99 % of them don't
    exceed.
    """

    median: float
    mean: float
    p99: float
    slowest: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Figures:
        """Return the figures of at least one value."""
        p99 = float(np.quantile(values, 0.99, method="inverted_cdf"))
        return cls(median(values), mean(values), p99, max(values))


def run(scene: Scene, *, record: Record = "rest", no_skip: Collection[str] = ()) -> Result:
    """Simulate `scene` to its natural end; arguments as for `simulate`."""
    result = simulate(scene, record=record, no_skip=no_skip)
    if not result.status.complete:
        raise MeasurementError(
            f'scene "{scene.name}" did not end by itself: {result.status.value}: {result.reason}. '
            "Its time would mean nothing"
        )
    return result

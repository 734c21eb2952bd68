"""What is stored of errors against time: points, what curves of them reach, and what is missing."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from pydantic import BaseModel, ConfigDict

from ghostball.validation.bench._reach import Reach
from ghostball.validation.bench.measurements import Measurement


class PrecisionPoint(BaseModel):
    """One engine with all of its settings on one scene.

    Attributes
    ----------
    scene, title, truth : str
        The scene, and which kind of truth it has.
    engine : str
        The engine as asked for: one curve.
    label : str
        The same with the step of this point.
    step : float or None [s]
    seconds, seconds_median : float [s]
        The simulation alone: the least of all samples, and their median.
    samples : int
    error, error_low, error_high : float [m]
        The largest distance of a ball from where it truly ends: median, least and greatest over
        the samples, each of which begins the shot at another part of a step.
    work_name : str
        What `work` counts, such as "steps"; "" where the engine counts nothing.
    work : int
    exact : bool
        Whether the engine has no step: a point, no ladder.
    true_course : bool
        Whether those balls and cushions met that meet in truth, from every phase.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    scene: str
    title: str
    truth: str
    engine: str
    label: str
    step: float | None
    seconds: float
    seconds_median: float
    samples: int
    error: float
    error_low: float
    error_high: float
    work_name: str
    work: int
    exact: bool
    true_course: bool = True


def best_of(points: Iterable[PrecisionPoint]) -> PrecisionPoint:
    """Return the point whose worst phase is nearest to truth: its `error_high` is the least error.

    A median would let an engine win by a step that is good from half of all phases.
    """
    return min(points, key=lambda point: point.error_high)


class PrecisionCurve(BaseModel):
    """One engine on one scene: in which order its error falls with its step, and what it reaches.

    `order` is None where there is none, and `order_note` says why; else which would fit as well.
    `limit_beside` is how far at least it ends beside the truth at zero step [m]; 0 where that can't
    be told from none.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    scene: str
    engine: str
    order: float | None
    order_note: str
    limit_beside: float = 0.0
    reach: tuple[Reach, ...]


class LeftOut(BaseModel):
    """A point, or a whole curve, that is not there, and why."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scene: str
    engine: str
    why: str


class PrecisionMeasurement(Measurement):
    """What `ghostball bench precision` measured."""

    kind: Literal["precision"] = "precision"
    points: tuple[PrecisionPoint, ...]
    curves: tuple[PrecisionCurve, ...] = ()
    left_out: tuple[LeftOut, ...] = ()

    @property
    def anything(self) -> bool:
        """Whether any point was measured."""
        return bool(self.points)

"""What is stored of errors against time: points, the time to an accuracy, and what is missing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from pydantic import BaseModel, ConfigDict

from benchmarks.measurements import Measurement


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
    seconds : float [s]
        The simulation alone: the least of all samples.
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


class Reach(BaseModel):
    """How long an engine takes for an accuracy [m]; `seconds` is None where no run was so near."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    target: float
    seconds: float | None


class PrecisionCurve(BaseModel):
    """One engine on one scene, over its steps: the time that it takes for each accuracy."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scene: str
    engine: str
    reach: tuple[Reach, ...]


def reach_of(target: float, points: Sequence[PrecisionPoint], lost: Sequence[float] = ()) -> Reach:
    """Return how long an engine takes for an accuracy.

    Parameters
    ----------
    target : float [m]
    points : sequence of PrecisionPoint
        Of one engine on one scene, the longest step first.
    lost : sequence of float [s]
        Steps at which a run failed or stopped early: nothing coarser than these counts.

    Notes
    -----
    A step that is good by luck doesn't count: all finer ones must be as good, from every phase.
    """
    seconds = []
    for point in reversed(points):
        fails_finer = point.step is not None and any(step < point.step for step in lost)
        if fails_finer or not point.error_high <= target:
            break
        seconds.append(point.seconds)
    return Reach(target=target, seconds=min(seconds, default=None))


class LeftOut(BaseModel):
    """A point, or a whole curve, that is not there, and why."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scene: str
    engine: str
    why: str


class PrecisionMeasurement(Measurement):
    """What `python -m benchmarks precision` measured."""

    kind: Literal["precision"] = "precision"
    points: tuple[PrecisionPoint, ...]
    curves: tuple[PrecisionCurve, ...] = ()
    left_out: tuple[LeftOut, ...] = ()

    @property
    def anything(self) -> bool:
        """Whether any point was measured."""
        return bool(self.points)

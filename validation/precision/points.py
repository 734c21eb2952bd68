"""What is stored of errors against time: each point, and what is missing and why."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

from ghostball.validation.results.measurement import Measurement, Record
from ghostball.validation.runs.ladder import knee_step

TARGETS = (1e-3, 1e-6, 1e-9)
"""Accuracies whose time is given [m]."""


class PrecisionPoint(Record):
    """One engine with all of its settings on one scene.

    `scene`, `title`, `truth`: the scene, and which kind of truth it has.
    `engine`: the engine as asked for: one curve.
    `label`: the same with the step of this point.
    `step` [s]: none where the engine has no step: a point, no ladder.
    `call_seconds` [s]: the whole call of `simulate`, as a user waits for it: the least of all
        samples. Costs are compared by this time.
    `seconds` [s]: the part of the call that the engine itself reports as its run time.
    `error`, `error_low`, `error_high` [m]: the largest distance of a ball from where it truly ends:
        median, least and greatest over the samples, each of which begins the shot at another part
        of a step.
    `same_events`: whether those balls and cushions met that meet in truth, from every phase.
    """

    scene: str
    title: str
    truth: str
    engine: str
    label: str
    step: float | None
    call_seconds: float
    seconds: float
    samples: int
    error: float
    error_low: float
    error_high: float
    same_events: bool = True


class LeftOut(Record):
    """A point, or a whole curve, that is not there, and why; `step` [s] is that of a failed run."""

    scene: str
    engine: str
    why: str
    step: float | None = None


class PrecisionMeasurement(Measurement):
    """What `ghostball engines --steps` measured."""

    kind: Literal["precision"] = "precision"
    points: tuple[PrecisionPoint, ...]
    left_out: tuple[LeftOut, ...] = ()


def seconds_to(
    target: float, points: Sequence[PrecisionPoint], lost: Sequence[float] = ()
) -> float | None:
    """Return how long an engine takes for an accuracy; None where no run was so near.

    `target` [m].
    `points`: of one engine on one scene, the longest step first.
    `lost` [s]: steps at which a run failed or stopped early: nothing coarser than these counts.

    A step that is good by luck doesn't count: all finer ones must be as good, from every phase.
    """
    seconds = []
    for point in reversed(points):
        fails_finer = point.step is not None and any(step < point.step for step in lost)
        if fails_finer or not point.error_high <= target:
            break
        seconds.append(point.call_seconds)
    return min(seconds, default=None)


def knee_of(points: Iterable[PrecisionPoint]) -> PrecisionPoint | None:
    """Return the point whose step is worth it: see `knee_step`.

    `points`: of one engine on one scene. None where no step brought about the true events.
    """
    steps = {one.step: one for one in points if one.step is not None and one.same_events}
    knee = knee_step({step: one.error_high for step, one in steps.items()})
    return None if knee is None else steps[knee]

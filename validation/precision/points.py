"""The stored measurement of errors against run times: points, and missing points with reasons."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import takewhile
from statistics import linear_regression
from typing import Literal

from ghostball.validation.results.measurement import Measurement, Record
from ghostball.validation.runs.time_steps import knee_step

TARGETS = (1e-3, 1e-6, 1e-9)
"""Accuracies for which times are given [m]."""

USELESS_ERROR = 1e-2
"""No step is recommended if errors are above this [m] and shorter steps don't reduce them."""


class PrecisionPoint(Record):
    """One engine with all of its settings on one scene.

    `scene`, `title`, `truth`: the scene, and the kind of its reference.
    `engine`: the engine as the user named it: one curve.
    `label`: the same with the time step of this point.
    `step` [s]: None for an engine without a time step, which has one point only.
    `call_seconds` [s]: duration of a whole call of `simulate`, as a user experiences it: the least
        of all samples. Costs are compared by this time.
    `seconds` [s]: the part of the call that the engine itself reports as its run time.
    `engine_seconds` [s]: the part in the engine's own steps, without the adapter; None if it was
        not measured.
    `error`, `error_low`, `error_high` [m]: the largest distance of a ball from its reference
        position: median, least and greatest over the samples, each with another phase of the step.
    `same_events`: whether the same bodies collided as in the reference, for every phase.
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
    engine_seconds: float | None = None


class LeftOut(Record):
    """A missing point or curve, and the reason; `step` [s] is that of a failed run."""

    scene: str
    engine: str
    why: str
    step: float | None = None


class PrecisionMeasurement(Measurement):
    """The measurement of `ghostball engines --steps`."""

    kind: Literal["precision"] = "precision"
    points: tuple[PrecisionPoint, ...]
    left_out: tuple[LeftOut, ...] = ()


def seconds_to(
    target: float, points: Sequence[PrecisionPoint], lost: Sequence[float] = ()
) -> float | None:
    """Return the run time of an engine for an accuracy; None if no run reached it.

    `target` [m].
    `points`: of one engine on one scene, the longest step first.
    `lost` [s]: steps with a failed or stopped run; longer steps than these don't count.

    A step that is accurate by chance doesn't count: all shorter steps must be as accurate, for
    every phase.
    """
    seconds = []
    for point in reversed(points):
        fails_finer = point.step is not None and any(step < point.step for step in lost)
        if fails_finer or not point.error_high <= target:
            break
        seconds.append(point.call_seconds)
    return min(seconds, default=None)


def knee_of(points: Iterable[PrecisionPoint]) -> PrecisionPoint | None:
    """Return the point with the step that is worth its cost: see `knee_step`.

    `points`: of one engine on one scene. A step counts if it and all shorter steps gave the right
    events. None if no step counts, or if the error is above `USELESS_ERROR` and shorter steps don't
    reduce it.
    """
    found = sorted((one.step, one) for one in points if one.step is not None)
    steps = dict(takewhile(lambda pair: pair[1].same_events, found))
    knee = knee_step({step: one.error_high for step, one in steps.items()})
    if knee is None or (knee > min(steps) and steps[knee].error_high > USELESS_ERROR):
        return None
    return steps[knee]


def order_of(points: Iterable[PrecisionPoint]) -> float | None:
    """Return the order of convergence: the exponent p of error ~ step^p, by least squares.

    `points`: of one engine on one scene. None with fewer than two steps that gave the right events
    and an error above 0.
    """
    found = [
        (one.step, one.error_high)
        for one in points
        if one.step is not None and one.same_events and one.error_high > 0.0
    ]
    if len(found) < 2:
        return None
    steps, errors = ([math.log(one) for one in numbers] for numbers in zip(*found, strict=True))
    return linear_regression(steps, errors).slope

"""The accuracy of a run: one of seven classes, with the same scale for every engine.

    >>> accuracy_of(result, truth).kind
    'millimetres'

A class doesn't depend on the time step of the engine; limits do (`step_limits`). It compares the
final positions of the balls with the reference. If rounding alone may change the shot before its
end, it compares the positions at the horizon.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from ghostball.model import Result, first_energy
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import Resolution
from ghostball.validation.checks.energy_gain import largest_gain
from ghostball.validation.checks.metric import RunAndTruth
from ghostball.validation.checks.velocity_jumps import largest_jump
from ghostball.validation.grading.event_logs import compare_collisions
from ghostball.validation.grading.gradable import Gradable
from ghostball.validation.grading.grading import position_errors
from ghostball.validation.grading.horizon import extent_of
from ghostball.validation.grading.tolerances import EPS, ROUNDINGS, TIE, UNIT_ROUNDOFF
from ghostball.validation.results.records import (
    CERTIFIED,
    INTEGRATION,
    Accuracy,
    AccuracyKind,
    BrokenBy,
)
from ghostball.validation.runs.sampling import (
    energy_series,
    events_of,
    first_not_finite,
    largest_overlap,
)
from ghostball.validation.truth.scene_truth import Truth

LARGEST_ERROR: Final[Mapping[AccuracyKind, float]] = {
    "nanometres": 1e-6,
    "micrometres": 1e-3,
    "millimetres": 1e-2,
    "centimetres": math.inf,
}
"""The largest error of a class [m]: "nanometres" means less than 1 um."""

BROKEN_SHARE: Final = 1e-2
"""Relative energy gain above which a shot is unphysical.

A smaller gain counts only by its effect: a ball with 1 % more energy rolls 1 % farther, which shows
in its rest position. The same share is allowed for changes of velocity without a cause.
"""

PASSED_THROUGH: Final = 1.0
"""Overlap, in radii of the smallest ball, above which balls count as having passed through each
other.

The distance of the centres is then at most one radius.
"""


def accuracy_of(result: Result, truth: Truth, *, resolution: Resolution = 0.0) -> Accuracy | None:
    """Return the accuracy of a run, or None without a reference.

    `result`: recorded with `record="trajectory"`.
    `resolution` [m]: of the engine: `reference_adapters.base.resolution_of`.
    """
    if broken := _broken(result, resolution):
        return Accuracy("broken", cause=broken[0], amount=broken[1])
    if truth.rest_positions is None or truth.collisions is None:
        return None
    within = truth.graded if truth.kind == CERTIFIED else None
    predictable = within.until if within is not None and within.extent == "horizon" else math.inf
    times = truth.collision_times
    found = compare_collisions(truth.collisions, times, events_of(result))
    if found.parting is not None:
        agree, parts_at = found.leading, found.parts_at(timed=bool(len(times)))
        if parts_at is None or (parts_at <= predictable and parts_at < _counted_until(truth)):
            if parts_at is not None and parts_at > truth.horizon_of(0.0):
                return None  # rounding alone may change the shot earlier
            return Accuracy("another shot", at=parts_at, agree=agree, of=len(truth.collisions))
    if within is not None and math.isfinite(predictable):
        return _at_the_horizon(result, truth, within)
    if truth.kind == INTEGRATION and math.isfinite(truth.shot_horizon):
        return None  # the effect of rounding on the end isn't known
    errors = RunAndTruth(result, truth).ball_errors
    return Accuracy(_kind(errors, _rounding(result, truth, within)), error=float(np.max(errors)))


def kind_of(error: float) -> AccuracyKind:
    """Return the class of an error [m] that is larger than rounding."""
    return next(kind for kind, most in LARGEST_ERROR.items() if error < most or math.isinf(most))


def _at_the_horizon(result: Result, truth: Truth, within: Gradable) -> Accuracy:
    """Compare the positions of the balls just before the horizon for rounding errors."""
    assert truth.certificate is not None
    t, errors = position_errors(result, truth.certificate, within)
    sizes = within.sizes
    assert sizes is not None
    rounding = UNIT_ROUNDOFF * np.where(np.isfinite(sizes), sizes, 0.0)
    kind = _kind(errors, np.maximum(rounding, EPS * extent_of(result.scene)))
    return Accuracy(kind, error=float(np.max(errors)), at=t)


def _kind(errors: FloatArray, rounding: FloatArray) -> AccuracyKind:
    if np.all(errors <= ROUNDINGS * rounding):
        return "exact"
    return kind_of(float(np.max(errors)))


def _rounding(result: Result, truth: Truth, within: Gradable | None) -> FloatArray:
    """Return the shift of the rest positions by one rounding of the scene or events, (n,) [m]."""
    scene = result.scene
    rounding = np.full(len(scene.balls), EPS * extent_of(scene))
    if truth.conditioning is not None:
        rounding = EPS * truth.conditioning
    elif within is not None and within.extent == "whole" and within.sizes is not None:
        known = np.isfinite(within.sizes)
        rounding[known] = np.maximum(rounding[known], UNIT_ROUNDOFF * within.sizes[known])
    return rounding


def _counted_until(truth: Truth) -> float:
    """Return the time until which collisions can be counted [s]: until a resting contact starts.

    In a resting contact, one engine lets balls push, another lets them bounce a hundred times. Only
    the final positions show which engine is accurate.
    """
    certificate = truth.certificate
    if certificate is None or certificate.ending != "sustained contact":
        return math.inf
    return float(certificate.t_end) * (1.0 - TIE)


def _broken(result: Result, resolution: Resolution) -> tuple[BrokenBy, float | None] | None:
    """Return why a run is unphysical, and by how much; None if it isn't."""
    if not result.status.complete:
        return "stopped", None
    energy = energy_series(result)
    finite = np.all(np.isfinite(energy)) and np.all(np.isfinite(result.rest_positions))
    if not finite or first_not_finite(result):
        return "not finite", None
    gain = largest_gain(result, resolution)
    first = first_energy(result.scene)
    if gain > BROKEN_SHARE * first:
        return "energy", gain / first if first > 0.0 else math.inf
    if len(result.scene.balls) > 1:
        overlap = largest_overlap(result)
        if overlap > PASSED_THROUGH * float(np.min(result.scene.radii)):
            return "overlap", overlap
    jump = largest_jump(result, resolution, share=BROKEN_SHARE * first)
    if jump > 0.0:
        return "jump", jump / first if first > 0.0 else math.inf
    return None

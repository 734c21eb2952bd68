"""Metrics that compare a run with the certified shot, and the reasons why one has no value."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import Final, TypeVar

import numpy as np

from ghostball.model import EventKind, ExactTrajectory, Result, SampledTrajectory, Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import Resolution, stated_error
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.checks.energy_curve import compared_instants, energy_differences
from ghostball.validation.grading.event_logs import ALL_KINDS, Event, events_in, proved_events
from ghostball.validation.grading.gradable import Gradable, proved_motion
from ghostball.validation.grading.grading import Grade, grade
from ghostball.validation.grading.horizon import extent_of
from ghostball.validation.grading.near_misses import gaps_of, things_of
from ghostball.validation.grading.phase_ends import PHASE_ENDS, first_contact, phase_ends
from ghostball.validation.grading.tolerances import LEAST_DOUBLE, UNIT_ROUNDOFF
from ghostball.validation.runs.sampling import UNIFORM_TIMES, events_of, times_gone
from ghostball.validation.truth.scene_truth import Truth, TruthPart

Compute = Callable[[Result, Truth], int | float]
"""Computes a metric; raises `NotMeasuredError` where it has no value."""

T = TypeVar("T")

_NO_PAIR = "no event of the run matches a certified event"


class NotMeasuredError(Exception):
    """Why a metric has no value in a case; the sentence is kept beside it."""


class RunIncompleteError(NotMeasuredError):
    """The run itself is the reason for the missing value: a criterion on this metric fails."""


def known(value: T | None, truth: Truth, part: TruthPart) -> T:
    """Return a part of the reference.

    Raises `NotMeasuredError` if there is no such part.
    """
    if value is None:
        raise NotMeasuredError(truth.why_not(part))
    return value


def require_end(result: Result) -> None:
    """Raise `RunIncompleteError` where the run did not reach its end."""
    if not result.status.complete:
        why = f": {result.reason}" if result.reason else ""
        raise RunIncompleteError(f"the run stopped early ({result.status.value}){why}")


def differences_of(
    result: Result, truth: Truth, until: float = math.inf
) -> tuple[FloatArray, FloatArray]:
    """Return instants up to `until` (k,) [s], and energy differences at them (k,) [J]."""
    require_end(result)
    right = known(truth.motion, truth, "energy")
    if truth.is_own_measure(result.engine, "energy"):
        raise NotMeasuredError("the reference energy of this shot is of Ghostball's own engine")
    return _differences(result, right, until)


def _differences(result: Result, right: Result, until: float) -> tuple[FloatArray, FloatArray]:
    times, differences = energy_differences(result, right, until)
    if not len(times):
        raise NotMeasuredError("a collision is due at the start: no energy can be compared")
    return times, differences


def _certified_motion(truth: Truth, compared: str) -> Result:
    if truth.proved is None:
        raise NotMeasuredError(f"the shot isn't certified to its end, so no {compared} is compared")
    return truth.proved


def _graded(result: Result, truth: Truth) -> Grade:
    known(truth.certificate, truth, "proof")
    require_end(result)
    assert truth.certificate is not None
    exact = isinstance(result.trajectory, ExactTrajectory)
    found = graded(result, truth.certificate, truth.graded if exact else truth.graded_steps)
    if found.until == 0.0:
        raise NotMeasuredError(f"no part of this shot is certified: {found.why}")
    return found


@lru_cache(maxsize=1)  # several metrics are made of it
def graded(result: Result, certificate: Certificate, within: Gradable | None) -> Grade:
    """Return `grade` of these, and keep the last one."""
    return grade(result, certificate, within)


def _graded_until(result: Result, truth: Truth) -> float:
    until = _graded(result, truth).until
    assert truth.certificate is not None  # `_graded` needed it
    return min(until, float(truth.certificate.t_end))


def _event_time_error_ulps(result: Result, truth: Truth) -> float:
    error = _graded(result, truth).time_error_max
    if error is None:
        raise NotMeasuredError(_NO_PAIR)
    return error


def event_time_error(result: Result, truth: Truth, horizon: float) -> float:
    """Return the largest error of an event's time [s] up to a `horizon` [s]."""
    found = _graded(result, truth)
    assert truth.certificate is not None  # `_graded` needed it
    proved = np.array([float(truth.certificate.events[k].t) for k in found.paired])
    errors = found.late_by[proved < horizon]
    if not len(errors):
        raise NotMeasuredError(_NO_PAIR)
    return float(np.max(errors))


def phase_time_error(result: Result, truth: Truth, horizon: float, resolution: Resolution) -> float:
    """Return the largest error of the end of a slide or a roll [s], of an engine that steps.

    `horizon` [s]: until when the engine can be expected to play this shot.
    `resolution` [m]: of the engine: `reference_adapters.base.resolution_of`.
    """
    certificate = known(truth.certificate, truth, "proof")
    if stated_error(resolution) == 0.0:
        raise NotMeasuredError("`event_time_error` compares all events of this engine")
    until = min(horizon, _graded(result, truth).until)
    found = events_in(events_of(result), ALL_KINDS)
    ends = phase_ends(proved_events(certificate), found, result.rest_time)
    errors = [one.late_by for one in ends if one.true.t < until]
    if not errors:
        raise NotMeasuredError("the run reports no certified end of a slide or a roll")
    return max(errors)


def early_path_error(result: Result, truth: Truth, resolution: Resolution) -> float:
    """Return the largest position error before the first contact [m], of an engine that steps.

    Of the proved contacts and those of the run, the first. A contact of the run counts only where
    the proved motion has the ball near what it is said to touch. In space where balls may fly, else
    in the plane.

    `resolution` [m]: of the engine: `reference_adapters.base.resolution_of`.
    """
    certificate = known(truth.certificate, truth, "proof")
    require_end(result)
    error = stated_error(resolution)
    if error == 0.0:
        raise NotMeasuredError("`path_factor` compares the whole path of this engine")
    motion = proved_motion(result.scene, certificate)
    proved = first_contact(proved_events(certificate), float(certificate.t_end))
    until = min(proved, result.rest_time)
    for event in events_in(events_of(result), ALL_KINDS):
        if event.t < until and _may_touch(result.scene, motion, event, error):
            until = event.t
    frames = result.trajectory
    times = np.linspace(0.0, until, UNIFORM_TIMES)
    if isinstance(frames, SampledTrajectory):
        times = frames.times
    times = times[times < until]
    if not len(times) or times[-1] == 0.0:
        raise NotMeasuredError("the run shows no motion before its first contact")
    true = motion.sample(times).positions
    axes = slice(3 if result.scene.physics.airborne else 2)
    errors = np.linalg.norm((result.sample(times).positions - true)[..., axes], axis=2)
    return float(np.max(np.where(np.isfinite(errors), errors, np.inf)))


def _may_touch(scene: Scene, motion: ExactTrajectory, event: Event, error: float) -> bool:
    """Return True if an event is a contact that an engine's balls may have in a proved motion.

    Both balls may be a radius off, and `error` [m]: past that, nothing is asked of an engine.
    """
    if event.kind in PHASE_ENDS:
        return False
    reach = 2.0 * (float(np.min(scene.radii)) + error)
    centres = motion.sample(np.array([event.t])).positions
    if event.kind is EventKind.BALL_CLOTH:
        height = float(centres[0, event.a, 2] - scene.radii[event.a])
        return scene.physics.airborne and 0.0 < height <= reach
    things = [event.b] if event.kind is EventKind.BALL_BALL else things_of(scene)
    return any(float(gaps_of(scene, event.a, one, centres)[0]) <= reach for one in things)


def _event_time_factor(result: Result, truth: Truth) -> float:
    found, rounding = _graded(result, truth), known(truth.rounding, truth, "proof")
    if not found.paired:
        raise NotMeasuredError(_NO_PAIR)
    return _in_roundings(found.late_by, rounding.events[list(found.paired)])


def _rest_time_factor(result: Result, truth: Truth) -> float:
    found, rounding = _graded(result, truth), known(truth.rounding, truth, "proof")
    assert truth.certificate is not None  # `_graded` needed it
    if found.extent != "whole" or not truth.certificate.proved:
        raise NotMeasuredError(f"the end can't be compared with a certified one: {found.why}")
    t_end = truth.certificate.t_end.mid
    error = abs(float(Fraction(result.rest_time) - t_end))
    return _in_roundings(np.array([error]), np.array([rounding.rest]))


def _energy_difference_factor(result: Result, truth: Truth) -> float:
    found, rounding = _graded(result, truth), known(truth.rounding, truth, "proof")
    times, differences = _differences(result, _certified_motion(truth, "energy"), found.until)
    sizes = rounding.energy_at(times)
    scene = result.scene
    if scene.physics.airborne:  # a height is rounded, too: more than the energy of a slow ball is
        sizes = sizes + scene.physics.gravity * float(scene.masses @ scene.positions[:, 2])
    return _in_roundings(differences, sizes)


@lru_cache(maxsize=1)  # both metrics of the path compare these
def _states(result: Result, right: Result, until: float) -> tuple[FloatArray, Samples, Samples]:
    """Return instants up to `until`, (k,) [s], with the states of the run and the true ones."""
    times = compared_instants(result, right, until)
    if not len(times):
        raise NotMeasuredError("a collision is due at the start: no position can be compared")
    return times, result.sample(times), right.sample(times)


def _path_error(result: Result, truth: Truth) -> float:
    found, right = _graded(result, truth), _certified_motion(truth, "path")
    times, shown, true = _states(result, right, found.until)
    errors = np.linalg.norm((shown.positions - true.positions)[..., :2], axis=2)
    # Where a ball is shown after it left the table is free.
    errors[times[:, np.newaxis] >= times_gone(right)] = 0.0
    return float(np.max(np.where(np.isfinite(errors), errors, np.inf)))


def _path_factor(result: Result, truth: Truth) -> float:
    found, rounding = _graded(result, truth), known(truth.rounding, truth, "proof")
    right = _certified_motion(truth, "path")
    times, shown, true = _states(result, right, found.until)
    scene = result.scene
    beside = np.linalg.norm(shown.positions - true.positions, axis=2)
    # The coordinates are rounded as well, and the instant, by which a ball moves on.
    speeds = np.linalg.norm(true.velocities, axis=2)
    coordinates = np.maximum(np.linalg.norm(true.positions, axis=2), extent_of(scene))
    places = rounding.places_at(times) + coordinates + times[:, np.newaxis] * speeds
    # So are the velocities, of a ball and of its surface: by what slows them meanwhile, and by the
    # line along which balls part, which the rounding of their places turns.
    faster = np.linalg.norm(shown.velocities - true.velocities, axis=2)
    faster += scene.radii * np.linalg.norm(
        shown.angular_velocities - true.angular_velocities, axis=2
    )
    turns = scene.radii * np.linalg.norm(true.angular_velocities, axis=2)
    slowed = scene.physics.gravity * (3.5 * scene.sliding_frictions + 2.0 * scene.rolling_frictions)
    slowed = slowed + scene.radii * scene.spinning_friction_rates
    drag = scene.physics.air_drag + scene.physics.rolling_friction_quadratic
    lever = max(1.0, float(np.max(coordinates)) / (2.0 * float(np.min(scene.radii))))
    changes = rounding.speeds_at(times) + lever * float(np.max(speeds + turns))
    changes += times[:, np.newaxis] * (slowed + 2.0 * drag * speeds**2)
    errors, sizes = np.concatenate([beside, faster]), np.concatenate([places, changes])
    return _in_roundings(np.where(np.isfinite(errors), errors, np.inf), sizes)


def _in_roundings(errors: FloatArray, sizes: FloatArray) -> float:
    """Return the largest error over what rounding makes of it, given over 2^-53."""
    finite = np.isfinite(sizes)
    if not finite.any():
        raise NotMeasuredError("the effect of rounding on the shot isn't known up to there")
    rounding = UNIT_ROUNDOFF * sizes
    # In a shot of 1e-310 s, one rounding is the smallest positive double.
    rounding[sizes > 0.0] = np.maximum(rounding[sizes > 0.0], LEAST_DOUBLE)
    with np.errstate(divide="ignore", invalid="ignore"):
        factors = errors[finite] / rounding[finite]
    # An error of 0 is 0 roundings, even of a value that rounding can't change. NaN stays NaN.
    return float(np.max(np.where(errors[finite] == 0.0, 0.0, factors)))


def _quality_factor(result: Result, truth: Truth) -> float:
    found = _graded(result, truth)
    if found.quality_factor is None:
        raise NotMeasuredError(found.no_quality)
    return found.quality_factor


PROOF_METRICS: Final[Mapping[str, Compute]] = {
    "graded_until": _graded_until,
    "graded_events": lambda result, truth: _graded(result, truth).events,
    "events_missing": lambda result, truth: len(_graded(result, truth).missing),
    "events_invented": lambda result, truth: len(_graded(result, truth).invented),
    "event_time_error_ulps": _event_time_error_ulps,
    "event_time_factor": _event_time_factor,
    "rest_time_factor": _rest_time_factor,
    "quality_factor": _quality_factor,
    "path_error": _path_error,
    "path_factor": _path_factor,
    "energy_difference_factor": _energy_difference_factor,
}
"""What computes each metric that is measured against a proof, whatever the engine's horizon."""

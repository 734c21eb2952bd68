"""Metrics that compare a run with the certified shot."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache
from typing import Final

import numpy as np

from ghostball.model import EventKind, ExactTrajectory, Result, SampledTrajectory, Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import stated_error
from ghostball.reference_adapters.certified import Certificate
from ghostball.validation.checks.energy_curve import compared_instants
from ghostball.validation.checks.metric import MetricGroup, NotMeasuredError, RunAndTruth
from ghostball.validation.grading.event_logs import (
    ALL_KINDS,
    Event,
    events_in,
    events_of_certificate,
)
from ghostball.validation.grading.gradable import motion_of_certificate
from ghostball.validation.grading.horizon import extent_of
from ghostball.validation.grading.near_misses import gaps_of, things_of
from ghostball.validation.grading.phase_ends import PHASE_ENDS, first_contact, phase_ends
from ghostball.validation.grading.tolerances import LEAST_DOUBLE, UNIT_ROUNDOFF
from ghostball.validation.runs.sampling import UNIFORM_TIMES, events_of, times_gone

CERTIFICATE: Final = MetricGroup()

_NO_PAIR = "no event of the run matches a certified event"


def certified_motion(run: RunAndTruth, compared: str) -> Result:
    """Return the whole certified shot."""
    if run.truth.certified_shot is None:
        raise NotMeasuredError(f"the shot isn't certified to its end, so no {compared} is compared")
    return run.truth.certified_shot


@CERTIFICATE.metric(
    "graded_until",
    "s",
    "time up to which the run is compared with the certified result: its end, or the horizon for "
    "rounding errors",
    "certificate",
)
def _graded_until(run: RunAndTruth) -> float:
    return min(run.grade.until, float(run.certificate.t_end))


@CERTIFICATE.metric(
    "graded_events", "1", "number of certified events up to `graded_until`", "certificate"
)
def _graded_events(run: RunAndTruth) -> int:
    return run.grade.events


@CERTIFICATE.metric(
    "events_missing",
    "1",
    "certified events of any kind that are missing from the run, up to the horizon; once the order "
    "of a ball's events differs, all its later events count",
    "certificate",
)
def _events_missing(run: RunAndTruth) -> int:
    return len(run.grade.missing)


@CERTIFICATE.metric(
    "events_invented",
    "1",
    "events in the run that match no certified event, up to the horizon",
    "certificate",
)
def _events_invented(run: RunAndTruth) -> int:
    return len(run.grade.invented)


@CERTIFICATE.metric(
    "event_time_error",
    "s",
    "largest time error of the run's events that match a certified event, up to the engine's "
    "horizon",
    "certificate",
)
def _event_time_error(run: RunAndTruth) -> float:
    found = run.grade
    certified = np.array([float(run.certificate.events[k].t) for k in found.paired])
    errors = found.late_by[certified < run.horizon]
    if not len(errors):
        raise NotMeasuredError(_NO_PAIR)
    return float(np.max(errors))


@CERTIFICATE.metric(
    "phase_time_error",
    "s",
    "largest time error of the ends of slides and rolls up to the horizon, for a time-stepping "
    "engine that reports them; for a missing end, its ball's nearest collision counts",
    "certificate",
)
def _phase_time_error(run: RunAndTruth) -> float:
    certificate = run.certificate
    if stated_error(run.resolution) == 0.0:
        raise NotMeasuredError("`event_time_error` compares all events of this engine")
    until = min(run.horizon, run.grade.until)
    found = events_in(events_of(run.result), ALL_KINDS)
    ends = phase_ends(events_of_certificate(certificate), found, run.result.rest_time)
    errors = [one.late_by for one in ends if one.true.t < until]
    if not errors:
        raise NotMeasuredError("no certified end of a slide or a roll is among the run's events")
    return max(errors)


@CERTIFICATE.metric(
    "event_time_error_ulps",
    "1",
    "largest error of an event time up to the horizon, in ulps (spacings of doubles) of that time",
    "certificate",
)
def _event_time_error_ulps(run: RunAndTruth) -> float:
    error = run.grade.time_error_max
    if error is None:
        raise NotMeasuredError(_NO_PAIR)
    return error


@CERTIFICATE.metric(
    "event_time_factor",
    "1",
    "largest error of an event time up to the horizon, in units of the error that one rounding per "
    "event would cause",
    "certificate",
)
def _event_time_factor(run: RunAndTruth) -> float:
    found, rounding = run.grade, run.rounding
    if not found.paired:
        raise NotMeasuredError(_NO_PAIR)
    return in_roundings(found.late_by, rounding.events[list(found.paired)])


@CERTIFICATE.metric(
    "rest_time_factor",
    "1",
    "error of the time at which the last ball stops, in units of the error that one rounding per "
    "event would cause",
    "certificate",
    "end",
)
def _rest_time_factor(run: RunAndTruth) -> float:
    found, rounding, certificate = run.grade, run.rounding, run.certificate
    if found.extent != "whole" or not certificate.proved:
        raise NotMeasuredError(f"the end can't be compared with a certified one: {found.why}")
    error = abs(float(Fraction(run.result.rest_time) - certificate.t_end.mid))
    return in_roundings(np.array([error]), np.array([rounding.rest]))


@CERTIFICATE.metric(
    "quality_factor",
    "1",
    "largest position error at the horizon, in units of the error that one rounding per event "
    "would cause",
    "certificate",
    "shot",
)
def _quality_factor(run: RunAndTruth) -> float:
    found = run.grade
    if found.quality_factor is None:
        raise NotMeasuredError(found.no_quality)
    return found.quality_factor


@lru_cache(maxsize=1)  # `path_error` and `path_factor` use the same states
def _states(run: RunAndTruth) -> tuple[FloatArray, Samples, Samples]:
    """Return times up to the horizon, (k,) [s], the states of the run, and the reference states."""
    until, right = run.grade.until, certified_motion(run, "path")
    times = compared_instants(run.result, right, until)
    if not len(times):
        raise NotMeasuredError("a collision is due at the start: no position can be compared")
    return times, run.result.sample(times), right.sample(times)


@CERTIFICATE.metric(
    "path_error",
    "m",
    "largest position error of a ball in the plane, up to the horizon; positions between the two "
    "times of a matching event aren't compared",
    "certificate",
)
def _path_error(run: RunAndTruth) -> float:
    times, shown, true = _states(run)
    errors = np.linalg.norm((shown.positions - true.positions)[..., :2], axis=2)
    # The displayed position of a ball after it left the table is arbitrary.
    errors[times[:, np.newaxis] >= times_gone(certified_motion(run, "path"))] = 0.0
    return float(np.max(np.where(np.isfinite(errors), errors, np.inf)))


@CERTIFICATE.metric(
    "early_path_error",
    "m",
    "largest position error before the first contact of the shot, for a time-stepping engine",
    "certificate",
)
def _early_path_error(run: RunAndTruth) -> float:
    """Return the largest position error before the first contact [m].

    The first contact of the certified shot or of the run counts, whichever is earlier. A contact of
    the run counts only if the ball is near the other body in the certified motion. Errors are in
    space if balls may fly, otherwise in the plane.
    """
    certificate, result = run.certificate, run.result
    run.require_end()
    error = stated_error(run.resolution)
    if error == 0.0:
        raise NotMeasuredError("`path_factor` compares the whole path of this engine")
    motion = motion_of_certificate(result.scene, certificate)
    certified = first_contact(events_of_certificate(certificate), float(certificate.t_end))
    until = min(certified, result.rest_time)
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


@CERTIFICATE.metric(
    "first_landing_error",
    "s",
    "time error of the first landing in the shot if no other contact comes before it, for a "
    "time-stepping engine that reports landings",
    "certificate",
)
def _first_landing_error(run: RunAndTruth) -> float:
    landing = first_landing(run.certificate)
    if stated_error(run.resolution) == 0.0:
        raise NotMeasuredError("`event_time_error` compares all events of this engine")
    if landing is None:
        raise NotMeasuredError("the certified result has no landing, or another contact before it")
    found = events_in(events_of(run.result), (EventKind.BALL_CLOTH,))
    times = [one.t for one in found if one.a == landing.a]
    if not found:
        raise NotMeasuredError("the run reports no landing")
    return abs(times[0] - landing.t) if times else math.inf


def first_landing(certificate: Certificate) -> Event | None:
    """Return the landing that is the first contact of a certified shot, if there is one."""
    contacts = (one for one in events_of_certificate(certificate) if one.kind not in PHASE_ENDS)
    first = next(contacts, None)
    return first if first is not None and first.kind is EventKind.BALL_CLOTH else None


def _may_touch(scene: Scene, motion: ExactTrajectory, event: Event, error: float) -> bool:
    """Return True if the bodies of an event are near each other in a certified motion.

    The run may displace each body by the smallest radius plus `error` [m].
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


@CERTIFICATE.metric(
    "path_factor",
    "1",
    "largest error of a ball's position, velocity or spin up to the horizon, in units of the error "
    "that one rounding per event would cause; nothing is compared between the two times of a "
    "matching event",
    "certificate",
)
def _path_factor(run: RunAndTruth) -> float:
    run.require_end()
    scene, rounding = run.result.scene, run.rounding
    times, shown, true = _states(run)
    beside = np.linalg.norm(shown.positions - true.positions, axis=2)
    # Coordinates are rounded, too, and so is the time, during which a ball moves on.
    speeds = np.linalg.norm(true.velocities, axis=2)
    coordinates = np.maximum(np.linalg.norm(true.positions, axis=2), extent_of(scene))
    places = rounding.places_at(times) + coordinates + times[:, np.newaxis] * speeds
    # Rounding also changes velocities and surface velocities: a rounded time by the deceleration,
    # rounded positions by turning the line of centres.
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
    return in_roundings(np.where(np.isfinite(errors), errors, np.inf), sizes)


def in_roundings(errors: FloatArray, sizes: FloatArray) -> float:
    """Return the largest error, in effects of one rounding; `sizes`: these effects over 2^-53."""
    finite = np.isfinite(sizes)
    if not finite.any():
        raise NotMeasuredError("the effect of rounding on these values isn't known")
    rounding = UNIT_ROUNDOFF * sizes
    # In a shot of 1e-310 s, one rounding is the smallest positive double.
    rounding[sizes > 0.0] = np.maximum(rounding[sizes > 0.0], LEAST_DOUBLE)
    with np.errstate(divide="ignore", invalid="ignore"):
        factors = errors[finite] / rounding[finite]
    # An error of 0 is 0 roundings, even of a value that rounding can't change. NaN stays NaN.
    return float(np.max(np.where(errors[finite] == 0.0, 0.0, factors)))

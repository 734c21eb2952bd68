"""Compare a run with the certified result of its shot: events, their times, and positions.

    >>> grade = grade(simulate(scene, record="trajectory"), certify(scene, motion=True))
    >>> grade.missing, grade.invented, grade.quality_factor

Only a part may be comparable (`gradable`); `Grade.why` states why it isn't longer.

Only the reported events and positions are taken from the run. The horizon and the scale of errors
come from the certified motion (`certified_growth`), the limits from `tolerances`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ghostball.model import (
    COLLISION_KINDS,
    EventKind,
    ExactTrajectory,
    GhostballError,
    Result,
    SampledTrajectory,
    Scene,
)
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.certified import Certificate, Enclosure
from ghostball.validation.grading.event_logs import (
    ALL_KINDS,
    Event,
    Parting,
    compare_logs,
    events_in,
    events_of_certificate,
)
from ghostball.validation.grading.gradable import Extent, Gradable, gradable, motion_of_certificate
from ghostball.validation.grading.horizon import extent_of
from ghostball.validation.grading.tolerances import EPS, LEAST_SLIP, TIE, UNIT_ROUNDOFF


@dataclass(frozen=True, eq=False)
class Grade:
    """Comparison of a run with the certified result of its shot.

    `extent`, `why`, `until`: the compared part; see `Gradable`.
    `compared_at` [s]: time at which positions were compared.
    `events`: number of compared certified events.
    `missing`, `invented`: indices of certified events that the run lacks, and of events of the run
        that aren't certified. After a difference in the order of a ball's events, these include all
        its further events.
    `first`: the earliest of these.
    `swapped`: number of events that have changed places with an event of other balls. Their time
        errors are compared.
    `negligible`: number of slides, rolls and flights, certified or in the run, that last no longer
        than rounding; left out.
    `paired`: indices of the certified events that the run has.
    `late_by` (m,) float64 [s]: absolute time error of each of these.
    `time_errors` (m,) float64 [1]: the same in ulps of the certified time.
    `position_errors` (n,) float64 [m]: distance of each ball from its enclosure at `compared_at`.
    `quality_factor`: the largest of these errors divided by the effect of rounding the state once
        at each event.
    `no_quality`: why there is no quality factor; else "".
    """

    extent: Extent
    why: str
    until: float
    compared_at: float
    events: int
    missing: tuple[int, ...]
    invented: tuple[int, ...]
    first: Parting | None
    swapped: int
    negligible: int
    paired: tuple[int, ...]
    late_by: FloatArray
    time_errors: FloatArray
    position_errors: FloatArray
    quality_factor: float | None
    no_quality: str = ""

    @property
    def time_error_max(self) -> float | None:
        """The largest error of an event time, in ulps; None if none was compared."""
        return float(np.max(self.time_errors)) if len(self.time_errors) else None


def grade(result: Result, certificate: Certificate, within: Gradable | None = None) -> Grade:
    """Compare a run with the certified result of its shot.

    `result`: recorded with `record="trajectory"`.
    `certificate`: of the same scene, with its motion: `certify(scene, motion=True)`.
    `within`: the compared part. Default: by `gradable`, for the kind of engine that ran.

    Raises `GhostballError` if the run recorded too little.

    Differences from an enclosure are computed with rational numbers: a double is a rational number.
    An error is the distance from the enclosure, 0 inside it. At a horizon, where errors are far
    above rounding, it is the difference of two doubles.

    Simultaneous events without a common ball may have either order. Near the horizon, times are
    uncertain by far more than rounding, so events without a common ball are paired in any order,
    and their time errors show a wrong order.

    The quality factor is max |x_i - X_i| / (2^-53 A_i), with A_i from the certified motion
    (`CertifiedGrowth.sizes`): 2^-53 A_i is the standard deviation of the position of ball i if the
    state is rounded once at each event. It is near 1 for an exact method in double precision, and
    large for a method that loses digits or has wrong collisions.

    Two balls, or a ball and a cushion, may bounce lower and lower, infinitely often in a finite
    time. Nothing is compared after the first bounce that certainly stays below `LOWEST_BOUNCE`.

    No derivative exists after simultaneous collisions of a ball. The error growth is then unknown,
    so events are compared up to the end of the certified part, but positions at the last time with
    a derivative.

    A slide or a roll is negligible if its whole deceleration is below `LEAST_SLIP` times the
    fastest initial speed, or if it is shorter than two roundings of the clock: a certified slip of
    1e-17 m/s of a stunned ball doesn't exist in double precision. After a collision with another
    ball, the limit is multiplied by the coordinates over the diameter of a ball: rounding of
    positions turns the line of centres by this much, and in a head-on collision, which stops a
    ball, this share of the speed remains. A flight is negligible if it is shorter than the
    tolerance for simultaneous events (`TIE`): a ball that is pushed back to the table within a
    rounding of its bounce. The lowest compared bounce is much longer.
    """
    scene = result.scene
    if result.events is None or result.trajectory is None:
        raise GhostballError(
            f"`result` must hold events and motion, but engine `{result.engine}` recorded too "
            f'little in scene "{scene.name}". Run it with record="trajectory"'
        )
    exact = isinstance(result.trajectory, ExactTrajectory)
    within = within or gradable(scene, certificate, exact=exact)
    until = within.until
    kinds: Sequence[EventKind] = ALL_KINDS
    if not exact:
        # Engines that record frames must report collisions and pocketed balls. Any other kind of
        # event is compared only if the engine reports it.
        told = set(result.events["kind"].tolist()) if within.sizes is not None else set()
        told |= {*COLLISION_KINDS, EventKind.POCKETED}
        kinds = [kind for kind in ALL_KINDS if kind in told]
    logs = (
        [one for one in events_of_certificate(certificate) if one.kind in kinds],
        events_in(result.events, kinds),
    )
    negligible = [negligible_ends(scene, log) for log in logs]
    certified, found = (
        [one for one, but in zip(log, buts, strict=True) if not but]
        for log, buts in zip(logs, negligible, strict=True)
    )
    compared = compare_logs(certified, found, strict=True)
    pairs = [(true, ours) for true, ours in compared.pairs if true.t <= until]
    missing = [certified[i] for i in compared.missing if certified[i].t <= until]
    before = until
    if within.extent in ("low bounce", "certified part"):
        before = _end_of_found(scene, pairs, until)
    invented = [found[j] for j in compared.invented if found[j].t <= before]
    compared_at, errors = position_errors(result, certificate, within)
    quality, no_quality = _quality(result, errors, within)
    late_by = np.array([_distance(f.t, certificate.events[true.index].t) for true, f in pairs])
    return Grade(
        within.extent,
        within.why,
        until,
        compared_at,
        sum(one.t <= until for one in certified),
        tuple(one.index for one in missing),
        tuple(one.index for one in invented),
        compared.parting if missing or invented else None,
        _swapped(pairs),
        sum(
            one.t <= until
            for log, buts in zip(logs, negligible, strict=True)
            for one, but in zip(log, buts, strict=True)
            if but
        ),
        tuple(true.index for true, _ in pairs),
        late_by,
        late_by / np.array([math.ulp(true.t) for true, _ in pairs]),
        errors,
        quality,
        no_quality,
    )


def negligible_ends(scene: Scene, log: Sequence[Event]) -> list[bool]:
    """Return whether each event ends a negligible slide, roll or flight; see `grade`."""
    gravity, radii = scene.physics.gravity, scene.radii
    surface = np.linalg.norm(scene.velocities, axis=1)
    surface += radii * np.linalg.norm(scene.angular_velocities, axis=1)
    noise = LEAST_SLIP * float(np.max(surface))
    # du/dt = -(7/2) mu_s g of a solid ball while it slides, dv/dt = -mu_r g while it rolls.
    slowing = {
        EventKind.SLIDE_TO_ROLL: 3.5 * gravity * scene.sliding_frictions,
        EventKind.ROLL_TO_REST: gravity * scene.rolling_frictions,
    }
    since, levers = [0.0] * len(scene.balls), [1.0] * len(scene.balls)
    lever = _lever(scene)
    negligible = []
    for one in log:
        lasted = one.t - since[one.a]
        if one.kind in slowing:
            slowed = (lasted - 2.0 * EPS * one.t) * slowing[one.kind][one.a]
            negligible.append(bool(slowed <= noise * levers[one.a]))
        else:
            negligible.append(one.kind is EventKind.BALL_CLOTH and lasted <= TIE * one.t)
        for ball in one.balls:
            since[ball] = one.t
            if one.kind is EventKind.BALL_BALL:
                levers[ball] = lever
    return negligible


def _lever(scene: Scene) -> float:
    """Return the effect of rounding of two positions on the line of centres of touching balls.

    It is the change of direction, in units of one rounding: the coordinates over the smallest
    distance.
    """
    size = float(np.max(np.abs(scene.positions[:, :2])))
    if scene.table is not None:
        size = max(size, scene.table.length, scene.table.width)
    return max(size / (2.0 * float(np.min(scene.radii))), 1.0)


def _end_of_found(scene: Scene, pairs: Sequence[tuple[Event, Event]], until: float) -> float:
    """Return the time up to which events of the run count, for certified events up to `until` [s].

    It is just before the last matching event of the run, which may be early or late by its error:
    events at this time, or after it, may depend on what isn't certified. If a certified part ends
    at the start of the shot, with touching balls, rounding of their positions shifts this event by
    a time of this size: `TIE` times the time in which the fastest ball moves a radius.
    """
    last = min(until, pairs[-1][1].t) if pairs else until
    speed = float(np.max(np.linalg.norm(scene.velocities, axis=1)))
    early = float(np.min(scene.radii)) / speed if speed > 0.0 else 0.0
    return last - TIE * max(last, early)


def _swapped(pairs: Sequence[tuple[Event, Event]]) -> int:
    """Return the number of pairs that come after a pair that the reference has later."""
    swapped, latest = 0, 0
    for k, (true, found) in enumerate(pairs):
        if found.index >= pairs[latest][1].index:
            latest = k
            continue
        before, after = pairs[latest]
        tied = true.t - before.t <= TIE * true.t or after.t - found.t <= TIE * after.t
        swapped += not tied
    return swapped


def position_errors(
    result: Result, certificate: Certificate, within: Gradable
) -> tuple[float, FloatArray]:
    """Compare positions at `within.compared_at`, or at the last frame before that time.

    `result`: recorded with `record="trajectory"`.
    `certificate`: of the same scene, with its motion.
    `within`: the compared part.

    Returns that time [s], which is finite, and each ball's distance from the reference [m].
    """
    t = within.compared_at
    if t < float(certificate.t_end) or within.extent == "horizon":
        frames = result.trajectory
        if within.sizes is not None and isinstance(frames, SampledTrajectory):
            # Motion between two frames isn't known to rounding; the earlier frame has smaller
            # errors.
            t = float(frames.times[np.searchsorted(frames.times, t, side="right") - 1])
        truth = motion_of_certificate(result.scene, certificate)
        at = np.array([t])
        difference = result.sample(at).positions[0] - truth.sample(at).positions[0]
        return t, np.linalg.norm(difference, axis=1)
    if within.extent == "whole":
        t, positions = result.rest_time, result.rest_positions
    else:
        positions = result.sample([t]).positions[0]
    errors = [
        math.hypot(*(_distance(x, e) for x, e in zip(place, enclosures, strict=False)))
        for place, enclosures in zip(positions.tolist(), certificate.positions, strict=True)
    ]
    return t, np.array(errors)


def _distance(value: float, enclosure: Enclosure) -> float:
    """Return the distance of a double from an enclosure, 0 inside; inf if it isn't finite."""
    if not math.isfinite(value):
        return math.inf
    # In units of a power of two, all three are integers, and Python rounds their quotient
    # correctly.
    mantissa, denominator = value.as_integer_ratio()
    exponent = 1 - denominator.bit_length()
    lowest = min(exponent, enclosure.mid_exponent, enclosure.rad_exponent, 0)
    middle = enclosure.mid_mantissa << (enclosure.mid_exponent - lowest)
    radius = enclosure.rad_mantissa << (enclosure.rad_exponent - lowest)
    beyond = abs((mantissa << (exponent - lowest)) - middle) - radius
    return max(beyond, 0) / (1 << -lowest)


def _quality(result: Result, errors: FloatArray, within: Gradable) -> tuple[float | None, str]:
    """Return the largest error (n,) [m] in units of rounding, and ""; or None, and the reason."""
    if within.sizes is None:
        return None, f"engine `{result.engine}` records frames, whose errors exceed rounding"
    scale = UNIT_ROUNDOFF * within.sizes
    known = np.isfinite(scale)
    if not known.any():
        return None, "the effect of rounding on the compared positions isn't known"
    errors, scale = errors[known], scale[known]
    if not scale.any() and not errors.any():
        return None, "no ball has moved in the compared part of the shot"
    # If no ball moves, only its coordinates are rounded.
    scale[scale == 0.0] = UNIT_ROUNDOFF * extent_of(result.scene)
    return float(np.max(errors / scale)), ""

"""Grade one run against the proof of its shot: its events, their times, where the balls are.

    >>> grade = grade(simulate(scene, record="trajectory"), certify(scene, motion=True))
    >>> grade.missing, grade.invented, grade.quality_factor

Compared is what can be (`gradable`); `Grade.why` says what cut it short.

No number is taken from the run that is graded but what it claims to have happened: the horizon and
the scale of errors come from the proved motion (`certified_growth`), limits from `tolerances`.
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
    proved_events,
)
from ghostball.validation.grading.gradable import Extent, Gradable, gradable, proved_motion
from ghostball.validation.grading.horizon import extent_of
from ghostball.validation.grading.tolerances import EPS, LEAST_SLIP, TIE, UNIT_ROUNDOFF


@dataclass(frozen=True, eq=False)
class Grade:
    """How a run compares with the proof of its shot.

    `extent`, `why`, `until`: of what was graded; see `Gradable`.
    `compared_at` [s]: when positions were compared.
    `events`: proved events that are compared.
    `missing`, `invented`: indices of proved events that were not found, and of found events that
        are not so. From where a ball's own order of events differs on, all that it goes through is
        among these.
    `first`: the earliest of these.
    `swapped`: events that come before another one instead of after it, without a ball in common
        with it. Their times are wrong by as much, and are graded as such.
    `negligible`: ends of slides and rolls, proved or found, that last no longer than rounding; left
        out.
    `paired`: indices of the proved events that were found.
    `late_by` (m,) float64 [s]: how far each of these was found from its proved instant.
    `time_errors` (m,) float64 [1]: the same in ulps of the proved time.
    `position_errors` (n,) float64 [m]: how far each ball is from its enclosure at `compared_at`.
    `quality_factor`: the largest of these errors over what rounding the state once at each event
        makes of it.
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
        """The largest error of an event's time, in ulps; None where none was compared."""
        return float(np.max(self.time_errors)) if len(self.time_errors) else None


def grade(result: Result, certificate: Certificate, within: Gradable | None = None) -> Grade:
    """Grade a run against the proof of its shot.

    `result`: recorded with `record="trajectory"`.
    `certificate`: of the same scene, with its motion: `certify(scene, motion=True)`.
    `within`: what of the proof is graded. Left out: as `gradable` says of an engine such as the
        run's.

    Raises `GhostballError` where the run recorded too little.

    Differences from an enclosure are taken in rationals: a double is the rational that it is. An
    error is the distance from the enclosure, 0 inside it; at a horizon, where errors are far above
    rounding, it is that of two doubles.

    Of events that share no ball either order is right where they are at one instant. Towards the
    horizon instants are uncertain by far more than rounding, so that such events are paired in any
    order: their times are graded, which says the same.

    The quality factor is max |x_i - X_i| / (2^-53 A_i), A_i from the proved motion
    (`CertifiedGrowth.sizes`): 2^-53 A_i is the standard deviation of ball i's position where the
    state is rounded once at each event. An exact method in double precision keeps it near 1; one
    that loses digits, or plays another shot, doesn't.

    Two balls, or a ball and a cushion, may bounce ever lower, without end in a finite time. From
    the first bounce that is proved to stay below `LOWEST_BOUNCE` on, nothing is graded.

    No derivative exists once a ball has had two collisions at one instant. That says nothing of how
    errors have grown, so that events are compared beyond it, up to the end of the proof; positions
    at the last instant before it.

    A slide or a roll is negligible where all that it slows is below `LEAST_SLIP` of the fastest
    speed at the start, or where it lasts no longer than two roundings of the clock: the slip of
    1e-17 m/s of a stunned ball is a slip to the proof, and nothing in double precision. Of a ball
    that has met another one that is multiplied by the places of balls over their diameter: so far
    off rounding of the places turns the line along which they part, and one that meets another
    head-on, which takes all of its speed, keeps that much of it. So is a flight that lasts no
    longer than what counts as one instant (`TIE`): a ball that is pushed back to the table within a
    rounding of its own bounce. The lowest bounce takes far longer.
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
        [one for one in proved_events(certificate) if one.kind in kinds],
        events_in(result.events, kinds),
    )
    negligible = [_negligible(scene, log) for log in logs]
    proved, found = (
        [one for one, but in zip(log, buts, strict=True) if not but]
        for log, buts in zip(logs, negligible, strict=True)
    )
    compared = compare_logs(proved, found, strict=True)
    pairs = [(true, ours) for true, ours in compared.pairs if true.t <= until]
    missing = [proved[i] for i in compared.missing if proved[i].t <= until]
    before = until
    if within.extent in ("low bounce", "proved part"):
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
        sum(one.t <= until for one in proved),
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


def _negligible(scene: Scene, log: Sequence[Event]) -> list[bool]:
    """Whether each event ends a slide, a roll or a flight that is but rounding; see `grade`."""
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
    """Return what rounding of two places makes of the line between two balls that touch.

    Of its direction, in units of what it makes of a number: the places over the least distance.
    """
    size = float(np.max(np.abs(scene.positions[:, :2])))
    if scene.table is not None:
        size = max(size, scene.table.length, scene.table.width)
    return max(size / (2.0 * float(np.min(scene.radii))), 1.0)


def _end_of_found(scene: Scene, pairs: Sequence[tuple[Event, Event]], until: float) -> float:
    """Return up to when the run's events are graded, where the proved ones are up to `until` [s].

    Just before the run's last one of those, which may come later or sooner by its error: what
    comes at that instant, or after it, may be what can't be known any more. Where a proof ends as
    the shot begins, with balls that touch, that instant is one of some rounding of their places:
    `TIE` of the time in which the fastest ball goes a radius.
    """
    last = min(until, pairs[-1][1].t) if pairs else until
    speed = float(np.max(np.linalg.norm(scene.velocities, axis=1)))
    early = float(np.min(scene.radii)) / speed if speed > 0.0 else 0.0
    return last - TIE * max(last, early)


def _swapped(pairs: Sequence[tuple[Event, Event]]) -> int:
    """Count the pairs that come after one that they come before in truth."""
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
    """Compare positions at the instant that they are graded at.

    `result`: recorded with `record="trajectory"`.
    `certificate`: of the same scene, with its motion.
    `within`: what of the proof is graded.

    Returns that instant, finite [s], and each ball's distance from the truth [m].
    """
    t = within.compared_at
    if t < float(certificate.t_end) or within.extent == "horizon":
        frames = result.trajectory
        if within.sizes is not None and isinstance(frames, SampledTrajectory):
            # The motion between two frames isn't known to rounding; the first has smaller errors.
            t = float(frames.times[np.searchsorted(frames.times, t, side="right") - 1])
        truth = proved_motion(result.scene, certificate)
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
    """Return how far a double is from an enclosure, 0 inside; inf where it isn't finite."""
    if not math.isfinite(value):
        return math.inf
    # In units of a power of two all three are integers, and Python rounds their quotient correctly.
    mantissa, denominator = value.as_integer_ratio()
    exponent = 1 - denominator.bit_length()
    lowest = min(exponent, enclosure.mid_exponent, enclosure.rad_exponent, 0)
    middle = enclosure.mid_mantissa << (enclosure.mid_exponent - lowest)
    radius = enclosure.rad_mantissa << (enclosure.rad_exponent - lowest)
    beyond = abs((mantissa << (exponent - lowest)) - middle) - radius
    return max(beyond, 0) / (1 << -lowest)


def _quality(result: Result, errors: FloatArray, within: Gradable) -> tuple[float | None, str]:
    """Return the largest error, (n,) [m], over what rounding does until then; or None, and why."""
    if within.sizes is None:
        return None, f"engine `{result.engine}` records frames, whose errors exceed rounding"
    scale = UNIT_ROUNDOFF * within.sizes
    known = np.isfinite(scale)
    if not known.any():
        return None, "the effect of rounding can't be computed up to that time"
    errors, scale = errors[known], scale[known]
    if not scale.any() and not errors.any():
        return None, "nothing has moved in what is graded"
    # Where nothing moves a ball, only its coordinates are rounded, wherever they are counted from.
    scale[scale == 0.0] = UNIT_ROUNDOFF * extent_of(result.scene)
    return float(np.max(errors / scale)), ""

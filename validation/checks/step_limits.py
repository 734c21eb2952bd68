"""Limits that follow from the time step of an engine, computed for each shot.

A time-stepping engine detects an event up to one time step late. By then balls overlap, a ball has
passed the cushion, or a slide has continued. To first order, the delays move the end of the shot by

    sum over its events k of |dX / d delay_k| delay_k,     0 <= delay_k <= dt,

where X is the rest position of a ball. The derivatives are those of the certified motion
(`grading.lateness`), so the limit depends on the judged engine only by its time step. An engine
that ends its steps when balls touch has a delay of its resolution r over the approach speed. It may
end a step r before the contact and detect the contact with an overlap of r: delay_k <= 2 r /
approach_k, and never more than the step.

If balls are displaced or overlap when they collide, the line of centres turns by more than its
derivative: by d / depth, where d is the displacement and depth the displacement that would make
them miss. Each such collision multiplies the errors that it passes on (`Margins.amplified`). A
collision shortly before the balls would stop multiplies them, too: a displacement by a part x of
the remaining path multiplies them by up to 1 / sqrt(1 - x). The motion between contacts adds r
once; r is v dt for a time-stepping engine, and for an engine that detects contacts without delay
but drifts. So

    rest error <= r + prod_m (1 + d_m / depth_m) / sqrt(1 - x_m) sum_k |dX / d delay_k| delay_k.

The same sums limit the errors of times and of the energy (`Lateness`). The delay of one event
shifts later events by their derivative; each event adds its own delay:

    |event time error| <= P sum_k max_j |dt_j / d delay_k| delay_k + max_k delay_k,
    |phase end error|  <= P max_i sum_k |dT_i / d delay_k| delay_k + dt,
    |rest time error|  <= P sum_k |dT / d delay_k| delay_k + dt,
    |energy error|     <= P sum_k |dE / d delay_k| delay_k + r F,
    |landing error|    <= g dt T / v_z + dt, for the first landing, after a flight of the time T,
    |path error|       <= P sum_k max_t |dx(t) / d delay_k| delay_k + r,

where P is the product above, t_j are the times of the collisions, T_i the ends of slides and rolls,
and T the time at which the last ball rests. T_i and T are detected at the end of a step. The bound
on T_i isn't only to first order: if a delay changes a slip by more than the slip itself, the slide
ends earlier or later by the whole change. The energy that a collision dissipates is no error until
the engine detects the collision (`energy_curve`). dE is the error that remains afterwards: friction
has acted on the old motion for longer, and the balls separate along another line. In a step, a
solver may compute a collision with velocities from before the step (without the friction in this
step), with surface speeds from before the step, or with both. So each sum includes the effect of
the delay, and the effects of velocities and of surface speeds that are as old as the delay. An
engine that drifts detects a collision late or early, by v dt over the approach speed. F is the
largest energy that friction dissipates in all balls while the fastest ball moves one metre: a
rolling ball loses 7/5 mu_r m g; a sliding ball loses mu_s m g times its slip. The slip is the
velocity of a ball minus the velocity of its surface. It is at most the speed of the fastest ball
plus that of the fastest surface. A surface is as fast as the fastest ball at most or, with draw or
spin alone, as the fastest surface at first.

An engine with larger errors violates a physical law, or its time step is longer than it states.

There is no limit if the sum isn't a bound: if a ball may collide twice within a step, so that the
second collision differs; if delays may close the gap by which a ball passes another ball, an
obstacle or the edge of a pocket, or make it miss what it hits (`other_paths`); if balls may pass
through each other between two steps, or move more than a radius in one step; after simultaneous
collisions, which have no derivative; after the horizon of the engine, where its errors may have
changed the collisions; and if the shot isn't certified to its end. There is no limit either if a
ball may end more than a radius from its place, because such a limit is too wide. In these cases the
first collisions are judged, up to the first of these instants: the engine must find them, in their
order. The path of each ball before the first contact, or the first landing, is judged, too, and so
is the time of the first landing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, Scene, first_energy
from ghostball.model.rounding import CONTACT_TOLERANCE, FLIGHT_CONTACT_TOLERANCE
from ghostball.model.scene.sides import CUSHIONS
from ghostball.reference_adapters.base import (
    ReferenceEngine,
    resolution_of,
    resolution_of_step,
    stated_error,
)
from ghostball.validation.checks.certificate_metrics import first_landing
from ghostball.validation.checks.criterion import Criterion, Selector, StepRule
from ghostball.validation.checks.step_delays import SteppedShot
from ghostball.validation.grading.event_logs import events_of_certificate
from ghostball.validation.grading.gradable import motion_of_certificate
from ghostball.validation.grading.horizon import extent_of
from ghostball.validation.grading.phase_ends import PHASE_ENDS, first_contact
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.results.quantities import scaled
from ghostball.validation.results.records import INTEGRATION
from ghostball.validation.runs.time_steps import step_of
from ghostball.validation.truth.scene_truth import Truth

STEP_METRICS = frozenset(
    {
        "rest_error_max",
        "ball_ball_count_error",
        "ball_cushion_count_error",
        "matching_events",
        "events_missing",
        "events_invented",
        "event_time_error",
        "rest_time_error",
        "phase_time_error",
        "path_error",
        "early_path_error",
        "first_landing_error",
        "energy_difference_max",
        "energy_rise",
        "overlap_max",
    }
)
"""Metrics on which a limit may be computed."""

_OPTIONAL_METRICS = ("phase_time_error", "early_path_error", "first_landing_error")
"""Metrics of events or motions that an engine may leave out of its results."""

_LANDING_LEAD = 1e-9
"""Time before a landing at which the velocity is sampled, relative to the time of the landing."""

LEAST_LIMIT = 1e-12
"""Error allowed whatever the time step [m], [s]: the roundings of some thousand steps."""

SLIDING_NOISE = 1e-6
"""Allowed relative gain of energy if balls slide: contact with the table is noisy in 3D engines."""

OVERLAP_MARGIN = 10.0
"""Allowed overlap at a contact that ends a step, in units of the resolution.

The last step must be long enough for the engine to detect the contact, so balls overlap more.
"""

_TOUCHING_ROUNDINGS = 1024.0
"""Allowed error of a gap, in roundings of a coordinate: an engine makes several at each event."""

_CLOCK_ROUNDINGS = 4.0
"""Roundings of a time during which balls may continue into each other."""


def step_criteria(
    rule: StepRule, engine: ReferenceEngine, scene: Scene, truth: Truth
) -> tuple[Criterion, ...]:
    """Return the limits for a scene that follow from the time step of an engine.

    `rule`: the events that the engine detects late, and the noise of its energy.
    `truth`: the reference of this scene, with its part "certificate".
    """
    resolution = stated_error(resolution_of(engine, scene))
    if resolution == 0.0:
        return ()
    step = step_of(engine)
    shot = SteppedShot(rule, scene, truth, resolution, math.inf if step is None else step)
    selector = Selector(engine=engine.name)
    return tuple(
        Criterion(
            engines=(selector,),
            metric=metric,
            reason=reason,
            # Not every engine reports the ends of slides and rolls, or the beginning of a shot.
            if_measured=metric in _OPTIONAL_METRICS,
            **limit,
        )
        for metric, limit, reason in (
            *(tuple(_outcome(shot)) or _beginning(shot)),
            *_integrated(shot),
            *_of_motion(shot),
            *_of_landing(shot),
        )
    )


_Limit = tuple[str, dict[str, float], str]
"""A metric, its limit by kind, and the reason."""


def _outcome(shot: SteppedShot) -> Iterator[_Limit]:
    """Yield the limits on the end of the shot."""
    scene, truth, lateness = shot.scene, shot.truth, shot.truth.lateness
    if lateness is None or truth.rest_time is None or truth.collisions is None:
        return
    if truth.certificate is None or not truth.certificate.proved:
        return
    if truth.horizon_of(shot.resolution) < truth.rest_time:
        return
    separate, margins = shot.separate_collisions(), lateness.margins
    if separate is None or margins is None:
        return
    own, all_separate = separate
    more = margins.amplified(shot.delays, len(scene.balls), shot.drift)
    if more is None:
        return
    late, between = shot.words, shot.between
    # NaN or infinite if a collision has no derivative: then the sums limit nothing after it.
    with np.errstate(invalid="ignore"):
        moved = float(np.max(more * (shot.delays @ lateness.places)))
    if not between + moved <= shot.smallest:
        return
    by = f", which moves the rest positions of this shot by at most {scaled(moved, 'm')}"
    yield (
        "rest_error_max",
        {"at_most": LEAST_LIMIT + between + moved},
        f"{late}{by if moved > 0.0 else ''}; the motion between contacts adds "
        f"{scaled(between, 'm')}.",
    )
    yield from _on_the_way(shot, float(np.max(more)))
    if own:
        reason = f"{late}: this can't make a collision of this shot vanish or come twice."
        yield "ball_ball_count_error", {"equals": 0}, reason
        yield "ball_cushion_count_error", {"equals": 0}, reason
    if own and scene.table is not None and scene.table.holes and shot.falls_alone():
        reason = f"{late}: this can't send a ball of this shot into another pocket, or into none."
        yield "events_missing", {"equals": 0}, reason
        yield "events_invented", {"equals": 0}, reason
    if all_separate:
        reason = f"{late}: the collisions of this shot are farther apart in time than this delay."
        yield "matching_events", {"equals": len(truth.collisions)}, reason


def _integrated(shot: SteppedShot) -> Iterator[_Limit]:
    """Yield the limit on the end of a shot without collisions, with an integrated reference.

    For an engine without a time step: the error of a ball without collisions is at most the stated
    resolution.
    """
    truth = shot.truth
    if truth.kind != INTEGRATION or math.isfinite(shot.longest) or truth.collisions:
        return
    reason = f"The engine states that balls are off by at most {scaled(shot.resolution, 'm')}."
    yield "rest_error_max", {"at_most": LEAST_LIMIT + shot.resolution}, reason


def _beginning(shot: SteppedShot) -> Iterator[_Limit]:
    """Yield the limits on the beginning of a shot whose end can't be judged."""
    yield from _before_contacts(shot)
    if shot.truth.lateness is None or shot.truth.collisions is None:
        return
    first = shot.first_sure()
    if first > 0:
        reason = (
            f"{shot.words}: this can't change the first {first} collisions of this shot, "
            "or their order."
        )
        yield "matching_events", {"at_least": min(first, len(shot.truth.collisions))}, reason


def _before_contacts(shot: SteppedShot) -> Iterator[_Limit]:
    """Yield the limits on the motion before the first contact, flights included.

    Until then only errors of the engine's own motion displace a ball: by its resolution, or by
    v dt. A slide that ends one step late adds the change of velocity in this step times the
    remaining time. If balls may fly, the effect of gravity in one step is added.
    """
    scene, certificate = shot.scene, shot.truth.certificate
    if certificate is None or shot.fastest == 0.0:
        return
    dt, off, physics = shot.last, shot.between, scene.physics
    until = first_contact(events_of_certificate(certificate), float(certificate.t_end))
    if physics.motion == "sliding" and EventKind.SLIDE_TO_ROLL in shot.rule.kinds:
        friction = scene.sliding_frictions + scene.rolling_frictions
        off += physics.gravity * float(np.max(friction)) * dt * until
    if physics.airborne:
        off += physics.gravity * dt * until
    if off < shot.smallest:
        reason = (
            f"No ball has a contact before t = {until:.3g} s; until then the time steps of this "
            f"engine displace a ball by at most {scaled(off, 'm')}."
        )
        yield "early_path_error", {"at_most": LEAST_LIMIT + off}, reason


def _of_landing(shot: SteppedShot) -> Iterator[_Limit]:
    """Yield the limit on the time of the first landing.

    In a flight of the time T, an error of one step in the vertical velocity changes the height by
    at most g dt T. A ball that is this much too high or too low lands later or earlier by this
    height divided by its downward speed, and the engine detects the landing up to one step late.
    """
    certificate, dt = shot.truth.certificate, shot.last
    landing = None if certificate is None or shot.fastest == 0.0 else first_landing(certificate)
    if certificate is None or landing is None:
        return
    before = motion_of_certificate(shot.scene, certificate).sample(
        np.array([landing.t * (1.0 - _LANDING_LEAD)])
    )
    speed = -float(before.velocities[0, landing.a, 2])
    off = shot.scene.physics.gravity * dt * landing.t
    if speed > 0.0 and off < shot.smallest:
        reason = (
            f"Until the first landing, time steps of {1e3 * dt:.3g} ms change the height of a ball "
            f"by at most {scaled(off, 'm')}, which shifts the landing by "
            f"{scaled(off / speed, 's')}; the engine detects the landing up to one step later."
        )
        yield "first_landing_error", {"at_most": LEAST_LIMIT + off / speed + dt}, reason


def _on_the_way(shot: SteppedShot, more: float) -> Iterator[_Limit]:
    """Yield the limits on the times of events, on paths and on the energy; see the module.

    `more`: largest factor by which meetings amplify errors.
    """
    scene, lateness = shot.scene, shot.lateness
    late, between, delays = shot.words, shot.between, shot.delays.copy()
    collides = np.isin(lateness.kinds, COLLISION_KINDS)
    if shot.rule.drifts:
        with np.errstate(divide="ignore"):
            delays[collides] = np.maximum(delays[collides], between / lateness.approach[collides])
    falls = np.array([kind is EventKind.POCKETED for kind in lateness.kinds], dtype=bool)
    own = np.append(delays[collides], shot.delays_of_falls(between)[falls])
    comes = np.max(lateness.comes[collides | falls], axis=0, initial=0.0)
    shifted = more * float(delays @ comes) + float(np.max(own, initial=0.0))
    if len(own) and math.isfinite(shifted):
        what = "an event" if falls.any() else "a collision"
        reason = f"{late}, which shifts the time of {what} of this shot by at most {shifted:.3g} s."
        yield "event_time_error", {"at_most": LEAST_LIMIT + shifted}, reason
    beside = between + more * float(delays @ lateness.strays)
    if math.isfinite(beside) and beside < shot.smallest:
        reason = f"{late}, which displaces a ball by at most {scaled(beside, 'm')} from its path."
        yield "path_error", {"at_most": LEAST_LIMIT + beside}, reason
    if shot.fastest == 0.0:
        return
    last = shot.last
    ends = np.isin(lateness.kinds, PHASE_ENDS)
    shifted = more * float(np.max(lateness.comes[ends] @ delays, initial=0.0))
    if ends.any() and math.isfinite(shifted):
        reason = (
            f"{late}, which shifts the end of a slide or of a roll of this shot by at most "
            f"{shifted:.3g} s; the engine detects the end up to {last:.3g} s later."
        )
        yield "phase_time_error", {"at_most": LEAST_LIMIT + shifted + last}, reason
    shifted = more * float(delays @ lateness.rests)
    if math.isfinite(shifted):
        reason = (
            f"{late}, which makes the last ball rest at most {shifted:.3g} s late or early; "
            f"the engine detects it up to {last:.3g} s later."
        )
        yield "rest_time_error", {"at_most": LEAST_LIMIT + shifted + last}, reason
    first = first_energy(scene)
    slows = 1.4 * scene.rolling_frictions
    if scene.physics.motion == "sliding":
        turns = scene.radii * np.linalg.norm(scene.angular_velocities[:, :2], axis=1)
        slips = 1.0 + max(1.0, float(np.max(turns)) / shot.fastest)
        slows = slows + slips * scene.sliding_frictions
    work = between * scene.physics.gravity * float(scene.masses @ slows)
    taken = work + more * float(delays @ lateness.energies)
    share = taken / first if first > 0.0 else math.inf  # squares of tiny speeds underflow
    if math.isfinite(share):
        reason = f"{late}, which changes the energy by at most {share:.3g} of its initial value."
        yield "energy_difference_max", {"at_most": shot.rule.energy_noise + share}, reason


def _of_motion(shot: SteppedShot) -> Iterator[_Limit]:
    """Yield the limits that hold for every path of the balls."""
    scene, resolution, noise = shot.scene, shot.resolution, shot.rule.energy_noise
    if scene.physics.motion == "sliding" and math.isfinite(shot.longest):
        noise = max(noise, SLIDING_NOISE)
    yield (
        "energy_rise",
        {"at_most": noise},
        "Impacts conserve or dissipate energy, and the cloth dissipates it: a gain is noise.",
    )
    if len(scene.balls) == 1 or EventKind.BALL_BALL not in shot.rule.kinds:
        return
    closing = _closing(scene)
    overlap = shot.longest * closing
    reason = f"Two balls approach at no more than {closing:.3g} m/s, for one time step."
    if 2.0 * resolution < shot.longest * shot.fastest:
        overlap = OVERLAP_MARGIN * resolution
        reason = (
            f"Time steps end within {scaled(resolution, 'm')} of touching; "
            "balls overlap in the next step."
        )
    if overlap < shot.smallest:
        yield "overlap_max", {"at_most": touching(scene, shot.truth) + overlap}, reason


def touching(scene: Scene, truth: Truth) -> float:
    """Return the gap below which an exact engine may treat balls as touching [m].

    The gap is 1e-12 m for pool balls on their table. It grows with the size of the balls, with the
    largest coordinate that a ball can reach, and with the distance that a ball with all of the
    energy moves in a rounding of time.

    `truth`: the reference of this scene, which gives the end of the shot.
    """
    until = (scene.t_max if truth.rest_time is None else truth.rest_time) or 0.0
    diameter = 2.0 * float(np.max(scene.radii))
    part = FLIGHT_CONTACT_TOLERANCE if scene.physics.airborne else CONTACT_TOLERANCE
    energy = first_energy(scene)
    fastest = math.sqrt(2.0 * energy / float(np.min(scene.masses)))
    clock = _CLOCK_ROUNDINGS * EPS * until * fastest
    extent = extent_of(scene) + _beyond_the_table(scene, energy, fastest)
    return part * diameter + _TOUCHING_ROUNDINGS * EPS * extent + clock


def _beyond_the_table(scene: Scene, energy: float, fastest: float) -> float:
    """Return how far a ball with all of the energy [J] can roll where no cushion stops it [m].

    `fastest` [m/s]: the speed of such a ball, for a cloth without rolling friction.
    """
    table = scene.table
    if table is not None and (not table.is_rectangle or len(table.cushions) == len(CUSHIONS)):
        return 0.0
    braking = float(np.min(scene.masses * scene.rolling_frictions)) * scene.physics.gravity
    until_rest = energy / braking if braking > 0.0 else math.inf
    return min(until_rest, fastest * scene.t_max) if scene.t_max is not None else until_rest


def travel(engine: ReferenceEngine, scene: Scene) -> float:
    """Return how far the fastest ball moves in a time step [m], at most the smallest radius.

    For an engine without a time step, return the smallest radius.
    """
    step, radius = step_of(engine), float(np.min(scene.radii))
    return radius if step is None else min(resolution_of_step(step, scene), radius)


def _closing(scene: Scene) -> float:
    """Return the largest possible approach speed of two balls [m/s].

    For two balls of equal mass, the sum of their speeds; otherwise the approach speed if the two
    lightest balls have all the energy.
    """
    speeds = [
        resolution_of_step(1.0, scene.model_copy(update={"balls": (ball,)})) for ball in scene.balls
    ]
    if len(speeds) == 2 and scene.masses[0] == scene.masses[1]:
        return sum(speeds)
    lightest = np.sort(scene.masses)[:2]
    return math.sqrt(float(np.sum(scene.masses * np.square(speeds))) * float(np.sum(1 / lightest)))

"""What an engine's step allows: limits that are computed, shot by shot.

An engine that steps sees an event late, by up to its step: balls have overlapped by then, a ball is
past the cushion, a slide has continued. To first order that moves the end of the shot by

    sum over its events k of |dX / d delay_k| delay_k,     0 <= delay_k <= dt,

X where a ball ends. The derivatives are those of the proved motion (`CertifiedGrowth.lateness`), so
that nothing of the engine that is judged is in its limit but its step. An engine that stops its
steps where balls touch is late by its resolution r, over the speed of approach; it may end a step r
short of the contact and see it with an overlap of r: delay_k <= 2 r / approach_k, and never more
than the step.

Balls that are displaced, or overlap, as they meet turn the line of centres by more than its
derivative says: by d / depth, d the displacement and depth that by which they would miss. That
multiplies what each such meeting passes on (`Margins.amplified`). So does a meeting just before the
balls would stop short of it: what takes a part x of the way that they would still go multiplies it
by up to 1 / sqrt(1 - x). The motion between contacts adds r once, which is v dt for an engine that
steps; and so much for one that finds contacts in time, but drifts. So

    rest error <= r + prod_m (1 + d_m / depth_m) / sqrt(1 - x_m) sum_k |dX / d delay_k| delay_k.

The same sums say when things happen, and how much energy there is (`Lateness`). A delay of one
event moves later ones by their derivative; an event adds its own delay:

    |event time error| <= P sum_k max_j |dt_j / d delay_k| delay_k + max_k delay_k,
    |phase end error|  <= P max_i sum_k |dT_i / d delay_k| delay_k + dt,
    |rest time error|  <= P sum_k |dT / d delay_k| delay_k + dt,
    |energy error|     <= P sum_k |dE / d delay_k| delay_k + r F,
    |path error|       <= P sum_k max_t |dx(t) / d delay_k| delay_k + r,

P the product above, t_j the times of the collisions, T_i when a slide or a roll ends, T when the
last ball rests; the latter two are seen at the end of a step. Of the T_i the bound isn't to first
order alone: a slip that a delay changes by more than it is ends sooner or later by all of that.
What a collision takes is no error of the energy until it is seen (`energy_curve`); dE is what is
left of a delay after that: friction has worked for longer on the balls as they were, and they part
along another line. Solvers let balls collide with the velocities that they had before the step, as
if friction hadn't slowed them in it, with the surface speeds of then, or with both; so each sum is
that of the delay, of velocities and of surface speeds that are as old. An engine that drifts meets
a collision late, or early, by v dt over the speed of approach. F is the most that friction takes
from all balls while the fastest one goes a metre: a rolling ball loses 7/5 mu_r m g; a sliding one
mu_s m g over what it slips. The slip is the velocity of a ball less that of its surface: no more
than the fastest ball goes, and as much again, or what the fastest surface turns by at first if that
is more, as with draw or spin alone.

An engine that is worse than this breaks a law, or steps more coarsely than it says.

Nothing is said where the sum isn't the whole story: where a ball may collide twice within a step,
so that the second collision is another one; where delays may close the gap by which a ball passes
another one, an obstacle or the edge of a pocket, or make it miss what it meets (`other_paths`);
where balls may pass through each other between two steps, or go more than a radius in one; past
ties, which have no derivative; past the horizon of the engine, where its errors may have led the
shot onto another path; and where the shot isn't proved to its end. Nor where a ball may end more
than a radius from its place: a limit so wide is none. There the first collisions are judged, those
that come before any of this: they must be found, in their order. And so is the path of each ball
before the first contact, be it a landing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, Scene, first_energy
from ghostball.model.rounding import CONTACT_TOLERANCE, FLIGHT_CONTACT_TOLERANCE
from ghostball.reference_adapters.base import (
    ReferenceEngine,
    resolution_of,
    resolution_of_step,
    stated_error,
)
from ghostball.validation.checks.criterion import Criterion, Selector, StepRule
from ghostball.validation.checks.step_delays import (
    LateEvents,
    between_contacts,
    delays_of_falls,
    falls_alone,
    first_sure,
    late_events,
    separate_collisions,
)
from ghostball.validation.grading.event_logs import proved_events
from ghostball.validation.grading.horizon import extent_of
from ghostball.validation.grading.lateness import Lateness
from ghostball.validation.grading.phase_ends import PHASE_ENDS, first_contact
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.runs.steps import step_of
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
        "energy_difference_max",
        "energy_rise",
        "overlap_max",
    }
)
"""Metrics on which a limit may be computed."""

LEAST = 1e-12
"""Error that is allowed whatever the step [m], [s]: roundings of some thousand steps."""

SLIDING_NOISE = 1e-6
"""Energy that may be made where balls slide, over the first: a table contact in space is noisy."""

OVERLAP_MARGIN = 10.0
"""Overlap, in resolutions, that a contact where a step ends may come to: the engine steps on from
it.

The last step must be long enough for the engine to see the contact, which takes some resolutions.
"""

_TOUCHING_ROUNDINGS = 1024.0
"""Roundings of a coordinate that a gap may be off by: an engine takes some at each event."""

_CLOCK_ROUNDINGS = 4.0
"""Roundings of an instant in which balls may go on into each other."""


def step_criteria(
    rule: StepRule, engine: ReferenceEngine, scene: Scene, truth: Truth
) -> tuple[Criterion, ...]:
    """Return the limits that an engine's step sets in a scene.

    `rule`: which events the engine sees late, and what noise its energy has.
    `truth`: of that scene, with its part "proof".
    """
    resolution = stated_error(resolution_of(engine, scene))
    if resolution == 0.0:
        return ()
    step = step_of(engine)
    longest = math.inf if step is None else step
    selector = Selector(engine=engine.name)
    return tuple(
        Criterion(
            engines=(selector,),
            metric=metric,
            reason=reason,
            # Not every engine says when a slide or a roll ends, or shows how a shot begins.
            if_measured=metric in ("phase_time_error", "early_path_error"),
            **limit,
        )
        for metric, limit, reason in (
            *(
                tuple(_outcome(rule, scene, truth, resolution, longest))
                or _beginning(rule, scene, truth, resolution, longest)
            ),
            *_of_motion(rule, scene, truth, resolution, longest),
        )
    )


_Limit = tuple[str, dict[str, float], str]
"""A metric, its limit by kind, and why."""


def _outcome(
    rule: StepRule, scene: Scene, truth: Truth, resolution: float, longest: float
) -> Iterator[_Limit]:
    """Yield what judges how the shot ends."""
    lateness = truth.lateness
    if lateness is None or truth.rest_time is None or truth.collisions is None:
        return
    if truth.certificate is None or not truth.certificate.proved:
        return
    if truth.horizon_of(resolution) < truth.rest_time:
        return
    step = late_events(rule, scene, lateness, resolution, longest)
    smallest = float(np.min(scene.radii))
    separate = separate_collisions(lateness, step, smallest)
    if separate is None:
        return
    own, all_separate = separate
    between, drift = between_contacts(rule, scene, step)
    if lateness.margins is None:
        return
    more = lateness.margins.amplified(step.delays, len(scene.balls), drift)
    if more is None:
        return
    late = step.words
    moved = float(np.max(more * (step.delays @ lateness.places)))
    if math.isfinite(moved):
        if between + moved > smallest:
            return
        yield (
            "rest_error_max",
            {"at_most": LEAST + between + moved},
            f"{late}, which moves the rest positions of this shot by at most {moved:.3g} m; "
            f"the motion between contacts adds {between:.3g} m.",
        )
        most = float(np.max(more))
        yield from _on_the_way(rule, scene, lateness, step, between, most)
    if own:
        reason = f"{late}: this can't make a collision of this shot vanish or come twice."
        yield "ball_ball_count_error", {"equals": 0}, reason
        yield "ball_cushion_count_error", {"equals": 0}, reason
    if own and scene.table is not None and scene.table.holes and falls_alone(lateness, step):
        reason = f"{late}: this can't send a ball of this shot into another pocket, or into none."
        yield "events_missing", {"equals": 0}, reason
        yield "events_invented", {"equals": 0}, reason
    if all_separate:
        reason = f"{late}: the collisions of this shot are farther apart in time."
        yield "matching_events", {"equals": len(truth.collisions)}, reason


def _beginning(
    rule: StepRule, scene: Scene, truth: Truth, resolution: float, longest: float
) -> Iterator[_Limit]:
    """Yield what judges how the shot begins, where its end can't be judged."""
    yield from _before_contacts(rule, scene, truth, resolution, longest)
    lateness = truth.lateness
    if lateness is None or truth.collisions is None:
        return
    step = late_events(rule, scene, lateness, resolution, longest)
    first = first_sure(rule, scene, truth, lateness, step)
    if first > 0:
        reason = (
            f"{step.words}: the first {first} collisions of this shot are found all the same, "
            "in their order."
        )
        yield "matching_events", {"at_least": min(first, len(truth.collisions))}, reason


def _before_contacts(
    rule: StepRule, scene: Scene, truth: Truth, resolution: float, longest: float
) -> Iterator[_Limit]:
    """Yield what judges the motion before the first contact, in flights too.

    Until then nothing but the engine's own motion displaces a ball: by the resolution, or by v dt;
    by what the cloth changes of its velocity in a step, where a slide ends that much late, for the
    time that is left; and by what gravity does, where balls may fly.
    """
    fastest = resolution_of_step(1.0, scene)
    if truth.certificate is None or fastest == 0.0:
        return
    step = LateEvents(resolution, longest, np.empty(0))
    dt, (off, _) = step.last(scene), between_contacts(rule, scene, step)
    until = first_contact(proved_events(truth.certificate), float(truth.certificate.t_end))
    physics = scene.physics
    if physics.motion == "sliding" and EventKind.SLIDE_TO_ROLL in rule.kinds:
        friction = scene.sliding_frictions + scene.rolling_frictions
        off += physics.gravity * float(np.max(friction)) * dt * until
    if physics.airborne:
        off += physics.gravity * dt * until
    if off < float(np.min(scene.radii)):
        reason = (
            f"Nothing touches a ball before t = {until:.3g} s; until then the steps of this engine "
            f"take a ball at most {off:.3g} m off its path."
        )
        yield "early_path_error", {"at_most": LEAST + off}, reason


def _on_the_way(
    rule: StepRule, scene: Scene, lateness: Lateness, step: LateEvents, between: float, more: float
) -> Iterator[_Limit]:
    """Yield what judges when things happen, and the energy meanwhile; see the module."""
    late = step.words
    collides, delays = np.isin(lateness.kinds, COLLISION_KINDS), step.delays.copy()
    if rule.drifts:
        with np.errstate(divide="ignore"):
            delays[collides] = np.maximum(delays[collides], between / lateness.approach[collides])
    falls = np.array([kind is EventKind.POCKETED for kind in lateness.kinds], dtype=bool)
    own = np.append(delays[collides], delays_of_falls(lateness, step, between)[falls])
    comes = np.max(lateness.comes[collides | falls], axis=0, initial=0.0)
    shifted = more * float(delays @ comes) + float(np.max(own, initial=0.0))
    if len(own) and math.isfinite(shifted):
        what = "an event" if falls.any() else "a collision"
        reason = f"{late}, which shifts the time of {what} of this shot by at most {shifted:.3g} s."
        yield "event_time_error", {"at_most": LEAST + shifted}, reason
    beside = between + more * float(delays @ lateness.strays)
    if math.isfinite(beside) and beside < float(np.min(scene.radii)):
        reason = f"{late}, which takes a ball at most {beside:.3g} m off its path."
        yield "path_error", {"at_most": LEAST + beside}, reason
    fastest = resolution_of_step(1.0, scene)
    if fastest == 0.0:
        return
    last = step.last(scene)
    ends = np.isin(lateness.kinds, PHASE_ENDS)
    shifted = more * float(np.max(lateness.comes[ends] @ delays, initial=0.0))
    if ends.any() and math.isfinite(shifted):
        reason = (
            f"{late}, which shifts the end of a slide or of a roll of this shot by at most "
            f"{shifted:.3g} s; {last:.3g} s to see it."
        )
        yield "phase_time_error", {"at_most": LEAST + shifted + last}, reason
    shifted = more * float(delays @ lateness.rests)
    if math.isfinite(shifted):
        reason = (
            f"{late}, which makes the last ball rest at most {shifted:.3g} s late or early; "
            f"{last:.3g} s to see it rest."
        )
        yield "rest_time_error", {"at_most": LEAST + shifted + last}, reason
    first = first_energy(scene)
    slows = 1.4 * scene.rolling_frictions
    if scene.physics.motion == "sliding":
        turns = scene.radii * np.linalg.norm(scene.angular_velocities[:, :2], axis=1)
        slips = 1.0 + max(1.0, float(np.max(turns)) / fastest)
        slows = slows + slips * scene.sliding_frictions
    work = between * scene.physics.gravity * float(scene.masses @ slows)
    taken = work + more * float(delays @ lateness.energies)
    share = taken / first if first > 0.0 else math.inf  # squares of tiny speeds vanish
    if math.isfinite(share):
        reason = f"{late}, which changes the energy by at most {share:.3g} of its initial value."
        yield "energy_difference_max", {"at_most": rule.energy_noise + share}, reason


def _of_motion(
    rule: StepRule, scene: Scene, truth: Truth, resolution: float, longest: float
) -> Iterator[_Limit]:
    """Yield what must hold wherever the balls go."""
    noise = rule.energy_noise
    if scene.physics.motion == "sliding":
        noise = max(noise, SLIDING_NOISE)
    yield (
        "energy_rise",
        {"at_most": noise},
        "Impacts keep energy or lose it, and the cloth only takes: what is more is noise.",
    )
    if len(scene.balls) == 1 or EventKind.BALL_BALL not in rule.kinds:
        return
    closing = _closing(scene)
    overlap = longest * closing
    reason = f"Balls close in at no more than {closing:.3g} m/s, for one step."
    if 2.0 * resolution < longest * resolution_of_step(1.0, scene):
        overlap = OVERLAP_MARGIN * resolution
        reason = f"Steps end within {resolution:.3g} m of touching, and the next one continues."
    if overlap < float(np.min(scene.radii)):
        yield "overlap_max", {"at_most": touching(scene, truth) + overlap}, reason


def touching(scene: Scene, truth: Truth) -> float:
    """Return the distance within which balls touch, for all an exact engine can tell [m].

    1e-12 m of pool balls on their table. It grows with the balls, with the largest coordinate, and
    with what the fastest ball goes, if it has all of the energy, while the clock is rounded.

    `truth`: of that scene; it says when the shot ends.
    """
    until = (scene.t_max if truth.rest_time is None else truth.rest_time) or 0.0
    diameter = 2.0 * float(np.max(scene.radii))
    part = FLIGHT_CONTACT_TOLERANCE if scene.physics.airborne else CONTACT_TOLERANCE
    energy = first_energy(scene)
    fastest = math.sqrt(2.0 * energy / float(np.min(scene.masses)))
    clock = _CLOCK_ROUNDINGS * EPS * until * fastest
    return part * diameter + _TOUCHING_ROUNDINGS * EPS * extent_of(scene) + clock


def travel(engine: ReferenceEngine, scene: Scene) -> float:
    """Return how far the fastest ball moves in a time step [m], at most the smallest radius.

    The radius if the engine has no time step.
    """
    step, radius = step_of(engine), float(np.min(scene.radii))
    return radius if step is None else min(resolution_of_step(step, scene), radius)


def _closing(scene: Scene) -> float:
    """Return the speed at which two balls approach at most [m/s].

    Of two like balls, the sum of their speeds; else, where all the energy is in the lightest two.
    """
    speeds = [
        resolution_of_step(1.0, scene.model_copy(update={"balls": (ball,)})) for ball in scene.balls
    ]
    if len(speeds) == 2 and scene.masses[0] == scene.masses[1]:
        return sum(speeds)
    lightest = np.sort(scene.masses)[:2]
    return math.sqrt(float(np.sum(scene.masses * np.square(speeds))) * float(np.sum(1 / lightest)))

"""Delays with which a time-stepping engine detects events, and the collisions that stay the same.

    >>> step = late_events(rule, scene, lateness, resolution, longest)
    >>> step.delays                     # (events,) [s]

`step_limits` derives the errors that these delays may cause.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import resolution_of_step
from ghostball.validation.checks.criterion import StepRule
from ghostball.validation.grading.lateness import Lateness
from ghostball.validation.grading.phase_ends import PHASE_ENDS
from ghostball.validation.grading.tolerances import TIE
from ghostball.validation.truth.scene_truth import Truth

_BRANCH = 16.0
"""Safety factor on first-order displacements by delays, for the first collisions of a shot.

A delay may change an impact from slip to stick: another branch of its law, with another derivative.
In a random shot, this displaced balls by 14 times the first-order value.
"""


@dataclass(frozen=True)
class LateEvents:
    """How late an engine sees the events of a shot.

    `resolution` [m].
    `longest` [s]: the step; inf for an engine that states none.
    `delays` (events,) float64 [s].
    """

    resolution: float
    longest: float
    delays: FloatArray

    @property
    def words(self) -> str:
        """How the engine finds contacts: the first words of a reason."""
        late = float(np.max(self.delays, initial=0.0))
        if late == 0.0:
            return "Contacts are found in time"
        if late < self.longest:
            return f"Time steps end within {self.resolution:.3g} m of touching"
        return f"Contacts are detected up to one time step, {1e3 * self.longest:.3g} ms, late"

    def last(self, scene: Scene) -> float:
        """Return the delay with which an engine detects the end of a slide or of a roll [s]."""
        if math.isfinite(self.longest):
            return self.longest
        return self.resolution / resolution_of_step(1.0, scene)


def first_sure(
    rule: StepRule, scene: Scene, truth: Truth, lateness: Lateness, step: LateEvents
) -> int:
    """Return the number of collisions that come before any event that a time step may change.

    An event is certain if every other path within reach branches off later, by more than the
    uncertainty of both times, or if the other path is a consequence of this event.
    """
    margins, smallest = lateness.margins, float(np.min(scene.radii))
    if margins is None or step.resolution >= smallest:
        return 0
    many = margins.moved.shape[1]
    own = margins.times[:, np.newaxis] == lateness.times[:many]
    moved = np.where(own, margins.moved, _BRANCH * margins.moved)
    margins = replace(margins, moved=moved)
    delays = step.delays[:many]
    _, drift = between_contacts(rule, scene, step)
    _, within_reach, factors = margins.followed(delays, len(scene.balls), drift)
    begins = [(float(margins.since[k]), margins.pasts[k]) for k in within_reach]
    assert truth.certificate is not None  # lateness is of its motion
    end, horizon = float(truth.certificate.t_end), truth.horizon_of(step.resolution)
    if not truth.certificate.proved:
        # What can't be proved follows from what comes at that very instant.
        last = [k for k in range(many) if end - float(lateness.times[k]) <= TIE * end]
        begins.append((end, sum(1 << k for k in last)))
    pasts = [0] * len(scene.balls)
    before: dict[int, int] = {}
    for k in range(min(many + 1, len(lateness.times))):
        balls, t = lateness.balls[k], float(lateness.times[k])
        past = 0
        for ball in balls:
            past |= pasts[ball]
        if t >= horizon or k == many:
            # Errors decide what comes of this one, or it is the second of a ball at one instant.
            begins.append((t, past))
            break
        if lateness.kinds[k] in COLLISION_KINDS:
            for one in {before[ball] for ball in balls if ball in before}:
                if t - float(lateness.times[one]) <= max(float(delays[k]), float(delays[one])):
                    begins.append((float(lateness.times[one]), past))
            before |= dict.fromkeys(balls, k)
        pasts = [past | 1 << k if i in balls else old for i, old in enumerate(pasts)]
    sure, latest = 0, 0.0
    for k in range(many):
        t = float(lateness.times[k])
        row = int(np.searchsorted(margins.times, t, side="right"))
        factor = float(factors[row - 1]) if row else 1.0
        shifted = 0.0
        if lateness.kinds[k] not in PHASE_ENDS:
            with np.errstate(invalid="ignore", over="ignore"):
                shifted = _BRANCH * factor * float(lateness.comes[k, :many] @ delays)
        latest = max(latest, float(delays[k]))
        by_then = t + 2.0 * (latest + shifted)
        if not all(past >> k & 1 or by_then < begin for begin, past in begins):
            break
        sure += lateness.kinds[k] in COLLISION_KINDS
    return sure


def late_events(
    rule: StepRule, scene: Scene, lateness: Lateness, resolution: float, longest: float
) -> LateEvents:
    """Return the delays with which an engine detects events.

    `rule`: the kinds of events that it detects late.
    `resolution` [m], `longest` [s]: as of `LateEvents`.
    """
    fastest = resolution_of_step(1.0, scene)
    least = 2.0 * resolution / fastest if fastest > 0.0 else 0.0
    with np.errstate(divide="ignore"):
        delays = np.maximum(2.0 * resolution / lateness.approach, least)
    collides = np.isin(lateness.kinds, COLLISION_KINDS)
    delays = np.minimum(np.where(collides, delays, least), longest)
    seen_late = np.isin(lateness.kinds, rule.kinds)
    return LateEvents(resolution, longest, np.where(seen_late, delays, 0.0))


def between_contacts(rule: StepRule, scene: Scene, step: LateEvents) -> tuple[float, float]:
    """Return the position error of the motion between contacts, and the part from drift [m]."""
    if not rule.drifts or not math.isfinite(step.longest):
        return step.resolution, 0.0
    drift = resolution_of_step(step.longest, scene)
    return drift, drift


def separate_collisions(
    lateness: Lateness, step: LateEvents, smallest: float
) -> tuple[bool, bool] | None:
    """Return whether the collisions of each ball, and whether all collisions, come one at a time.

    None if one time step may contain enough to change the collisions: a second collision of a ball
    that follows from its first, a whole overlap, or more than the `smallest` radius [m].
    """
    meet = np.array([kind is EventKind.BALL_BALL for kind in lateness.kinds], dtype=bool)
    if np.any(step.delays[meet] > 0.0) and step.resolution >= smallest:
        return None
    own, all_separate = True, True
    before: dict[int, int] = {}
    last: int | None = None
    for k in np.flatnonzero(np.isin(lateness.kinds, COLLISION_KINDS)).tolist():
        t, delay = float(lateness.times[k]), float(step.delays[k])
        previous = {before[ball] for ball in lateness.balls[k] if ball in before}
        for one in previous:
            between = t - float(lateness.times[one])
            if between <= TIE * t:
                own = False
            elif between <= max(delay, float(step.delays[one])) and not (
                lateness.kinds[k] is lateness.kinds[one] is EventKind.BALL_CUSHION
            ):
                return None
        if last is not None and t - float(lateness.times[last]) <= delay and last not in previous:
            all_separate = False
        before |= dict.fromkeys(lateness.balls[k], k)
        last = k
    return own, own and all_separate


def delays_of_falls(lateness: Lateness, step: LateEvents, between: float) -> FloatArray:
    """Return the delay of each event if it is a fall into a pocket, (events,) [s].

    Even an engine that finds contacts in time may look for balls over pockets only after each step.
    """
    with np.errstate(divide="ignore"):
        seen = np.minimum(2.0 * step.resolution / lateness.approach, step.longest)
        delays: FloatArray = np.maximum(seen, between / lateness.approach)
    return delays


def falls_alone(lateness: Lateness, step: LateEvents) -> bool:
    """Return True if no ball falls into a pocket within a time step after its last collision."""
    late = delays_of_falls(lateness, step, step.resolution)
    before: dict[int, float] = {}
    for k, kind in enumerate(lateness.kinds):
        t = float(lateness.times[k])
        if kind is EventKind.POCKETED:
            (ball,) = lateness.balls[k]
            if t - before.get(ball, -math.inf) <= late[k]:
                return False
        elif kind in COLLISION_KINDS:
            before |= dict.fromkeys(lateness.balls[k], t + float(step.delays[k]))
    return True

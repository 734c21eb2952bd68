"""Delays with which a time-stepping engine detects events, and the collisions that stay the same.

    >>> shot = SteppedShot(rule, scene, truth, resolution, longest)
    >>> shot.delays                     # (events,) [s]

`step_limits` derives the errors that these delays may cause.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import resolution_of_step
from ghostball.validation.checks.criterion import StepRule
from ghostball.validation.grading.lateness import Lateness
from ghostball.validation.grading.phase_ends import PHASE_ENDS
from ghostball.validation.grading.tolerances import TIE
from ghostball.validation.results.quantities import scaled
from ghostball.validation.truth.scene_truth import Truth

_BRANCH = 16.0
"""Safety factor on first-order displacements by delays, for the first collisions of a shot.

A delay may change an impact from slip to stick: another branch of its law, with another derivative.
In a random shot, this displaced balls by 14 times the first-order value.
"""


@dataclass(frozen=True, eq=False)
class SteppedShot:
    """A shot as simulated by an engine that detects events up to a time step late.

    `rule`: the kinds of events that it detects late.
    `truth`: the reference of the shot. Delays, `words` and all methods need its lateness.
    `resolution` [m]: of the engine.
    `longest` [s]: the time step; inf for an engine that states none.
    """

    rule: StepRule
    scene: Scene
    truth: Truth
    resolution: float
    longest: float

    @property
    def lateness(self) -> Lateness:
        """The change of the shot by each delay, to first order."""
        assert self.truth.lateness is not None
        return self.truth.lateness

    @cached_property
    def smallest(self) -> float:
        """The smallest radius [m]."""
        return float(np.min(self.scene.radii))

    @cached_property
    def fastest(self) -> float:
        """The largest speed of a ball until balls meet [m/s]."""
        return resolution_of_step(1.0, self.scene)

    @cached_property
    def delays(self) -> FloatArray:
        """The delays with which the engine detects the events, (events,) float64 [s]."""
        lateness, fastest = self.lateness, self.fastest
        least = 2.0 * self.resolution / fastest if fastest > 0.0 else 0.0
        with np.errstate(divide="ignore"):
            delays = np.maximum(2.0 * self.resolution / lateness.approach, least)
        collides = np.isin(lateness.kinds, COLLISION_KINDS)
        delays = np.minimum(np.where(collides, delays, least), self.longest)
        seen_late = np.isin(lateness.kinds, self.rule.kinds)
        return np.where(seen_late, delays, 0.0)

    @property
    def words(self) -> str:
        """How the engine finds contacts: the first words of a reason."""
        late = float(np.max(self.delays, initial=0.0))
        if late == 0.0:
            return "Contacts are detected without delay"
        if late < self.longest:
            return f"Time steps end within {scaled(self.resolution, 'm')} of touching"
        return f"Contacts are detected up to one time step, {1e3 * self.longest:.3g} ms, late"

    @property
    def last(self) -> float:
        """The delay with which the engine detects the end of a slide or of a roll [s]."""
        return self.longest if math.isfinite(self.longest) else self.resolution / self.fastest

    @cached_property
    def _drifts(self) -> bool:
        return self.rule.drifts and math.isfinite(self.longest)

    @property
    def drift(self) -> float:
        """The part of `between` that comes from drift [m]."""
        return self.between if self._drifts else 0.0

    @cached_property
    def between(self) -> float:
        """The position error of the motion between contacts [m]."""
        return resolution_of_step(self.longest, self.scene) if self._drifts else self.resolution

    def first_sure(self) -> int:
        """Return the number of collisions that come before any event that a time step may change.

        An event is certain if every other path within reach branches off later, by more than the
        uncertainty of both times, or if the other path is a consequence of this event.
        """
        lateness, scene, truth = self.lateness, self.scene, self.truth
        margins = lateness.margins
        if margins is None or self.resolution >= self.smallest:
            return 0
        many = margins.moved.shape[1]
        own = margins.times[:, np.newaxis] == lateness.times[:many]
        moved = np.where(own, margins.moved, _BRANCH * margins.moved)
        margins = replace(margins, moved=moved)
        delays = self.delays[:many]
        _, within_reach, factors = margins.followed(delays, len(scene.balls), self.drift)
        begins = [(float(margins.since[k]), margins.pasts[k]) for k in within_reach]
        assert truth.certificate is not None  # lateness is computed from its motion
        end, horizon = float(truth.certificate.t_end), truth.horizon_of(self.resolution)
        if not truth.certificate.proved:
            # The certified motion ends there because of the events at that time.
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
                # Past the horizon, or two events of one ball at one instant: the outcome is
                # uncertain.
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

    def separate_collisions(self) -> tuple[bool, bool] | None:
        """Return whether collisions come one at a time: those of each ball, and all of them.

        None if one time step may change the collisions: a collision may cause a second one of the
        same ball within the step, or a ball may move by the smallest radius or more.
        """
        lateness = self.lateness
        meet = np.array([kind is EventKind.BALL_BALL for kind in lateness.kinds], dtype=bool)
        if np.any(self.delays[meet] > 0.0) and self.resolution >= self.smallest:
            return None
        own, all_separate = True, True
        before: dict[int, int] = {}
        last: int | None = None
        for k in np.flatnonzero(np.isin(lateness.kinds, COLLISION_KINDS)).tolist():
            t, delay = float(lateness.times[k]), float(self.delays[k])
            previous = {before[ball] for ball in lateness.balls[k] if ball in before}
            for one in previous:
                between = t - float(lateness.times[one])
                if between <= TIE * t:
                    own = False
                elif between <= max(delay, float(self.delays[one])) and not (
                    lateness.kinds[k] is lateness.kinds[one] is EventKind.BALL_CUSHION
                ):
                    return None
            if last is not None and last not in previous:
                all_separate &= not t - float(lateness.times[last]) <= delay
            before |= dict.fromkeys(lateness.balls[k], k)
            last = k
        return own, own and all_separate

    def delays_of_falls(self, between: float) -> FloatArray:
        """Return the delay of each event if it is a fall into a pocket, (events,) [s].

        Even an engine that detects contacts without delay may look for balls over pockets only
        after each step.
        """
        approach = self.lateness.approach
        with np.errstate(divide="ignore"):
            seen = np.minimum(2.0 * self.resolution / approach, self.longest)
            delays: FloatArray = np.maximum(seen, between / approach)
        return delays

    def falls_alone(self) -> bool:
        """Return True if no ball falls into a pocket within a step after its last collision."""
        lateness, late = self.lateness, self.delays_of_falls(self.resolution)
        before: dict[int, float] = {}
        for k, kind in enumerate(lateness.kinds):
            t = float(lateness.times[k])
            if kind is EventKind.POCKETED:
                (ball,) = lateness.balls[k]
                if t - before.get(ball, -math.inf) <= late[k]:
                    return False
            elif kind in COLLISION_KINDS:
                before |= dict.fromkeys(lateness.balls[k], t + float(self.delays[k]))
        return True

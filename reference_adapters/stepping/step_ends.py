"""Step ends for balls in the plane: equal steps, or steps that end at contacts."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ghostball.model import Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping import contact_time
from ghostball.reference_adapters.stepping.contact_time import time_to_contact


class ExactSteps(NamedTuple):
    """How close to contacts the steps of an engine can end.

    `gap`: gap at which a step ends, larger than the rounding of the engine's coordinates [m].
    `shortest`: shortest step; an engine that works with accelerations may limit them [s].
    """

    gap: float = contact_time.CONTACT_GAP
    shortest: float = 0.0


SINGLE_PRECISION_STEPS = ExactSteps(gap=1e-6)
"""For an engine in single precision, in which coordinates on a table are rounded to 2e-7 m."""


class BallMotion(NamedTuple):
    """The motion of the balls on the table while nothing touches.

    `positions`, `velocities`, `accelerations`: (n, 2) float64 [m], [m/s], [m/s^2].
    `radii`: (n,) float64 [m].
    `lasts`: duration for which the accelerations are constant, possibly inf [s].
    """

    positions: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    radii: FloatArray
    lasts: float


class Clock:
    """Equal steps of at most `dt` [s], independent of contacts, that end exactly at `t_end` [s].

    All steps are shortened equally instead of only the last one, because engines scale stored
    impulses of lasting contacts by the ratio of two steps. Times are multiples of the step, not a
    running sum.

    `dt`: the step [s].
    """

    def __init__(self, dt: float, t_end: float) -> None:
        self._t_end = t_end
        # With the margin, 0.3 s in steps of 0.1 s takes three steps.
        self._count = max(1, math.ceil(t_end / dt * (1.0 - 1e-12)))
        self._step = 0
        self.dt = t_end / self._count

    @property
    def left(self) -> int:
        """Number of steps that are left."""
        return self._count - self._step

    def tick(self, steps: int = 1) -> float:
        """Advance by some steps and return the time of their end [s]."""
        self._step += steps
        return self._t_end if self._step == self._count else self._step * self.dt

    def next(self, _t: float, _motion: Callable[[], BallMotion]) -> tuple[float, float, bool]:
        """Advance by one step; the return value is that of `StepsToContacts.next`."""
        return self.dt, self.tick(), False


class StepsToContacts:
    """Steps that end at contacts, or when a ball stops sliding, rolling or spinning.

    A contact takes two steps: one to a gap of 1e-10 m, and one to the same overlap, which the
    engine resolves. It takes three steps if the engine detects only overlaps at the start of a
    step.
    """

    def __init__(self, scene: Scene, exact: ExactSteps, dt: float, t_end: float) -> None:
        contact_time.warm_up()
        self._longest = dt
        self._t_end = t_end
        self._table = scene.table
        self._gap, self._shortest = exact

    def next(self, t: float, motion: Callable[[], BallMotion]) -> tuple[float, float, bool]:
        """Return the step from `t` [s], the time of its end [s], and whether a contact starts then.

        `motion` returns the motion of the balls on the table.
        """
        left = self._t_end - t
        x, v, a, radii, lasts = motion()
        horizon = min(self._longest, left, lasts)
        to_contact = time_to_contact(x, v, a, radii, self._table, gap=self._gap, horizon=horizon)
        dt = max(min(horizon, to_contact), self._shortest)
        if left - dt < self._shortest:
            dt = left
        return dt, self._t_end if dt == left else t + dt, to_contact <= horizon


StepEnds = Clock | StepsToContacts

"""When steps of balls in the plane end: after equal times, or where something touches."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from ghostball.model import Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping import contact_time
from ghostball.reference_adapters.stepping.contact_time import time_to_contact


class ExactSteps(NamedTuple):
    """How near to contacts an engine's steps can end.

    `gap` [m]: gap at which a step ends; larger than what rounding leaves of the engine's
        coordinates.
    `shortest` [s]: shortest step: an engine may work with accelerations, and bound them.
    """

    gap: float = contact_time.CONTACT_GAP
    shortest: float = 0.0


IN_SINGLE_PRECISION = ExactSteps(gap=1e-6)
"""Of an engine in single precision, which has 2e-7 m on a table."""


class Motion(NamedTuple):
    """How the balls on the table move while nothing touches.

    `positions`, `velocities`, `accelerations` (n, 2) float64 [m], [m/s], [m/s^2].
    `radii` (n,) float64 [m].
    `lasts` [s]: how long the accelerations are these; may be inf.
    """

    positions: FloatArray
    velocities: FloatArray
    accelerations: FloatArray
    radii: FloatArray
    lasts: float


class Clock:
    """Equal steps of at most `dt` [s], whatever touches, that end on `t_end` [s] exactly.

    Rather than a short last step: engines scale what they know of lasting contacts by the ratio of
    two steps. Instants are multiples of the step, not a running sum.

    `dt` [s]: the step.
    """

    def __init__(self, dt: float, t_end: float) -> None:
        self._t_end = t_end
        # The margin keeps 0.3 s in steps of 0.1 s at three.
        self._count = max(1, math.ceil(t_end / dt * (1.0 - 1e-12)))
        self._step = 0
        self.dt = t_end / self._count

    def tick(self) -> float:
        """Continue by a step; return the instant of its end [s]."""
        self._step += 1
        return self._t_end if self._step == self._count else self._step * self.dt

    def next(self, _t: float, _motion: Callable[[], Motion]) -> tuple[float, float, bool]:
        """Continue by a step; return what `StepsToContacts.next` does."""
        return self.dt, self.tick(), False


class StepsToContacts:
    """Steps that end where something touches, or a ball stops sliding, rolling or spinning.

    A contact takes two: to a gap of 1e-10 m, and to as much overlap, which the engine resolves; or
    one more, where it sees in a step only what overlaps as that begins.
    """

    def __init__(self, scene: Scene, exact: ExactSteps, dt: float, t_end: float) -> None:
        contact_time.warm_up()
        self._longest = dt
        self._t_end = t_end
        self._table = scene.table
        self._gap, self._shortest = exact

    def next(self, t: float, motion: Callable[[], Motion]) -> tuple[float, float, bool]:
        """Return the step from `t` [s], the instant of its end [s], and whether something touches.

        `motion` is asked for how the balls on the table move.
        """
        left = self._t_end - t
        x, v, a, radii, lasts = motion()
        horizon = min(self._longest, left, lasts)
        to_contact = time_to_contact(x, v, a, radii, self._table, gap=self._gap, horizon=horizon)
        dt = max(min(horizon, to_contact), self._shortest)
        if left - dt < self._shortest:
            dt = left
        return dt, self._t_end if dt == left else t + dt, to_contact <= horizon


Ends = Clock | StepsToContacts

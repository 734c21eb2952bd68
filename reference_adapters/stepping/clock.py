"""Equal steps in time."""

from __future__ import annotations

import math


class Clock:
    """Equal steps of at most `dt` [s] that end on `t_end` [s] exactly.

    Rather than a short last step: engines scale what they know of lasting contacts by the ratio of
    two steps. Instants are multiples of the step, not a running sum.

    `dt` [s]: the step.
    `t` [s]: now.
    """

    def __init__(self, dt: float, t_end: float) -> None:
        self._t_end = t_end
        # The margin keeps 0.3 s in steps of 0.1 s at three.
        self._count = max(1, math.ceil(t_end / dt * (1.0 - 1e-12)))
        self._step = 0
        self.dt = t_end / self._count
        self.t = 0.0

    def tick(self) -> float:
        """Continue by a step; return the instant of its end [s]."""
        self._step += 1
        self.t = self._t_end if self._step == self._count else self._step * self.dt
        return self.t

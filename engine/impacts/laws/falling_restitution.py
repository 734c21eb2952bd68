"""A restitution that decreases with the approach speed, for any law that has a restitution."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel


@kernel(inline=True)
def restitution_at(speed: float, slow: float, loss: float) -> float:
    """Return e = e0 / (1 + c sqrt(v)) for an impact with approach speed v >= 0 [m/s].

    `slow` is e0, the restitution of the slowest impacts; `loss` is c >= 0 [sqrt(s/m)].

    Contract: in [0, e0], and exactly e0 if c is 0. Unlike e0 - c sqrt(v), it is never negative and
    needs no limit.
    """
    return slow / (1.0 + loss * math.sqrt(speed))

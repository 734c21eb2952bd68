"""A restitution that falls with the speed of the approach, for any law that has a restitution."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel


@kernel(inline=True)
def restitution_at(speed: float, slow: float, loss: float) -> float:
    """Return e = e0 / (1 + c sqrt(v)) of an impact that approaches at v >= 0 [m/s].

    `slow` is e0, the restitution of the slowest impacts; `loss` is c >= 0 [sqrt(s/m)].

    Contract: in [0, e0], and e0 to the bit where c is 0. It needs no limit, as e0 - c sqrt(v) does
    where that turns negative.
    """
    return slow / (1.0 + loss * math.sqrt(speed))

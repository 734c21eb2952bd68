"""Deceleration of a ball by the air, and by a rolling friction that grows with the speed.

The motion with this deceleration is in `motion.drag`.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Laws


@kernel(inline=True)
def in_air(balls: Balls, laws: Laws) -> bool:
    """Return whether a deceleration that grows with the speed acts on balls.

    The result doesn't depend on whether any ball flies.
    """
    if balls.powers is None:
        return False
    return bool(laws.air_drag > 0.0 or laws.roll_quadratic > 0.0)


@kernel(inline=True)
def felt_drag(laws: Laws) -> float:
    """Return the part of the air's drag that slows a rolling ball."""
    return 5.0 / 7.0 if laws.slides else 1.0


@kernel(inline=True)
def slowed_by_air(
    balls: Balls, laws: Laws, vx: float, vy: float, ax: float, ay: float
) -> tuple[float, float]:
    """Return an acceleration with the deceleration by air added, at the velocity (vx, vy) [m/s].

    The reaction of the cloth on a rolling ball is left to the caller.
    """
    if not in_air(balls, laws):
        return ax, ay
    drag = laws.air_drag * math.sqrt(vx * vx + vy * vy)
    return ax - drag * vx, ay - drag * vy


@kernel(inline=True)
def rolling_deceleration(balls: Balls, laws: Laws, slowing: float, vx: float, vy: float) -> float:
    """Return the deceleration by rolling friction [m/s^2]; `slowing` is its constant part, mu g."""
    if in_air(balls, laws):
        slowing += laws.roll_quadratic * (vx * vx + vy * vy)
    return slowing


@kernel(inline=True)
def slowed_while_rolling(
    balls: Balls, laws: Laws, vx: float, vy: float, ax: float, ay: float
) -> tuple[float, float]:
    """Return the acceleration of a rolling ball, with the full effect of air and friction."""
    if not in_air(balls, laws):
        return ax, ay
    drag = felt_drag(laws) * laws.air_drag + laws.roll_quadratic
    drag *= math.sqrt(vx * vx + vy * vy)
    return ax - drag * vx, ay - drag * vy

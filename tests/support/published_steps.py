"""The published algorithm of Mathavan et al. (2014), in equal steps of the impulse.

Two equal balls, a rolling one onto a resting one. Sports Engineering 17, doi
10.1007/s12283-014-0158-y.
"""

from __future__ import annotations

import math
from typing import NamedTuple

TABLE_STEPS = 5000
"""Steps to the impulse of an impact without friction, with which all printed numbers come out."""


class RollingVelocities(NamedTuple):
    """Velocities once both balls roll, over the line of centres and across it [m/s]."""

    cue: tuple[float, float]
    struck: tuple[float, float]


def stepped(
    v: float,
    cut: float,
    *,
    steps: int,
    lands: bool,
    restitution: float,
    ball_friction: float,
    cloth_friction: float,
) -> RollingVelocities:
    """Return what first-order steps make of a rolling ball of speed v [m/s], `cut` [rad] off.

    As published, compression and restitution end with the first whole step that passes their end.
    With `lands`, they end where they should, and the rest of the error goes with the step.

    The velocities are (n, t, z), n along the line of centres; the surface speeds R w too. The
    resting ball b is pressed on the cloth all the time: a's front goes down.
    """
    n, t = v * math.cos(cut), v * math.sin(cut)
    a, spin_a = [n, t, 0.0], [-t, n, 0.0]
    b, spin_b = [0.0, 0.0], [0.0, 0.0, 0.0]
    h = 0.5 * (1.0 + restitution) * n / steps
    work, wanted = 0.0, -math.inf  # what is left of the work at the end, once compression is over
    while True:
        along = a[1] - b[1] + spin_a[2] + spin_b[2]
        up = a[2] - spin_a[1] - spin_b[1]
        rub = ball_friction / math.hypot(along, up)
        along, up = rub * along, rub * up
        skid = (b[0] - spin_b[1], b[1] + spin_b[0])
        grip = cloth_friction * up / math.hypot(*skid) if skid != (0.0, 0.0) else 0.0
        cloth = [grip * x for x in skid]
        falls = 2.0 + cloth[0]  # the speed of approach, per impulse over the mass
        approach = a[0] - b[0]

        length, last = h, False
        if work + h * (approach - 0.5 * h * falls) <= wanted:
            length, last = _until(wanted - work, approach, falls) if lands else h, True
        elif lands and wanted < 0.0 and approach <= h * falls:
            length = approach / falls

        work += length * (approach - 0.5 * length * falls)
        a = [x - length * f for x, f in zip(a, (1.0, along, up), strict=True)]
        b = [x + length * f for x, f in zip(b, (1.0 + cloth[0], along + cloth[1]), strict=True)]
        spin_a[1] += 2.5 * length * up
        spin_a[2] -= 2.5 * length * along
        spin_b[0] += 2.5 * length * cloth[1]
        spin_b[1] += 2.5 * length * (up - cloth[0])
        spin_b[2] -= 2.5 * length * along
        if wanted < 0.0 and (a[0] <= b[0] or length < h):
            wanted = (1.0 - restitution**2) * work
        elif last:
            return RollingVelocities(_rolling(a, spin_a), _rolling(b, spin_b))


def _until(work: float, approach: float, falls: float) -> float:
    """Return the impulse after which this work is done, the balls receding."""
    return (approach + math.sqrt(approach**2 - 2.0 * falls * work)) / falls


def _rolling(velocity: list[float], spin: list[float]) -> tuple[float, float]:
    """Return the velocity when the slide has ended: 2/7 of the slip are lost."""
    slip = (velocity[0] - spin[1], velocity[1] + spin[0])
    return velocity[0] - 2.0 / 7.0 * slip[0], velocity[1] - 2.0 / 7.0 * slip[1]

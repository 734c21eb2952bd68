"""When a gap closes: the first root of a quadratic in the time, found without losing digits."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel


@kernel(inline=True)
def first_crossing(gap: float, rate: float, acceleration: float) -> float:
    """Return the first s >= 0 at which gap + rate s + acceleration s^2 / 2 falls to 0, or inf.

    Contract: no allocation. A gap below 0 counts as 0, touching: then closing is 0, an event now,
    and opening is the later return. So a contact is found although rounding put it past its
    instant, and one that was just resolved is not found again.

    Each case adds numbers of one sign, so no digit cancels (Bannerman, Strobl, Formella and
    Poeschel 2014 give the rule for touching balls). Chosen without branches, so that a row of pairs
    becomes vector instructions.
    """
    gap = gap if gap > 0.0 else 0.0
    discriminant = rate * rate - 2.0 * acceleration * gap
    root = math.sqrt(discriminant if discriminant > 0.0 else 0.0)
    closing = rate < 0.0
    meets = (discriminant >= 0.0) & (closing | (acceleration < 0.0))
    over = 2.0 * gap if closing else rate + root
    under = root - rate if closing else -acceleration
    s = over / (under if meets else 1.0)
    return s if meets else math.inf


@kernel
def first_bent_crossing(
    gap: float, rate: float, acceleration: float, jerk: float, left: float
) -> float:
    """`first_crossing`, at the soonest, where the acceleration falls by up to `jerk` a second.

    For `left` seconds, a finite number; later than that, where it can't be before.

    Within h seconds jerk s^3 / 6 is no more than (jerk h / 3) s^2 / 2: a root of that is a bound if
    it comes before h, and h is one if not. The best h lies where both are the same; the mean of the
    logarithms of h and of its root is four times nearer to it. Where the rate is what closes the
    gap, there is nothing to be won.
    """
    bend = jerk / 3.0
    soonest: float = first_crossing(gap, rate, acceleration - bend * left)
    horizon = left
    while soonest < 0.25 * horizon and bend * horizon * soonest > -rate:
        horizon = math.sqrt(soonest * horizon)
        root = first_crossing(gap, rate, acceleration - bend * horizon)
        soonest = max(min(root, horizon), soonest)
    if rate >= 0.0 and acceleration > 0.0 and bend > 0.0:
        # It opens, and can't do else before the jerk has taken that acceleration: where the gap is
        # 0, no shorter time is a bound. A sixteenth of it is left, for rounding.
        root = first_crossing(gap, rate, 0.0625 * acceleration)
        soonest = max(min(root, 0.9375 * acceleration / bend), soonest)
    return soonest


@kernel(inline=True)
def first_meeting(rx: float, ry: float, vx: float, vy: float, reach: float) -> float:
    """Return the first s >= 0 at which |r + v s| falls to `reach` [s], or inf.

    Contract: as `first_crossing`. The constant term is (d - D)(d + D), which keeps the digits of a
    small gap.

    The discriminant (r.v)^2 - v^2 (d^2 - D^2) is v^2 D^2 - (r x v)^2, which for balls that are far
    apart has smaller terms to round: the instant of an oblique collision from 20 diameters away was
    off by 20 roundings with the first form. Touching balls have the first as their whole
    discriminant, whatever rounding makes of the second.
    """
    distance = math.sqrt(rx * rx + ry * ry)
    gap = (distance - reach) * (distance + reach)
    gap = gap if gap > 0.0 else 0.0
    rate = rx * vx + ry * vy
    offset = rx * vy - ry * vx
    speed2 = vx * vx + vy * vy
    discriminant = speed2 * (reach * reach) - offset * offset
    meets = ((discriminant >= 0.0) | (gap == 0.0)) & (rate < 0.0)
    root = math.sqrt(discriminant if meets & (discriminant > 0.0) else 0.0)
    s = gap / (root - rate if meets else 1.0)
    return s if meets else math.inf

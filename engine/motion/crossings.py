"""The time at which a gap closes: the first root of a quadratic, without loss of digits."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel


@kernel(inline=True)
def first_crossing(gap: float, rate: float, acceleration: float) -> float:
    """Return the first s >= 0 at which gap + rate s + acceleration s^2 / 2 falls to 0, or inf.

    Contract: no allocation. A gap below 0 counts as 0, touching: if it closes, the result is 0, an
    event now; if it opens, the result is the later return. So a contact is found even if rounding
    moved it past its time, and a contact that was just resolved is not found again.

    Each case adds numbers of the same sign, so no digits cancel (Bannerman, Strobl, Formella and
    Poeschel 2014 give the rule for touching balls). The code has no branches, so that the compiler
    turns a row of pairs into vector instructions.
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
    """Return a lower bound on the crossing time if the acceleration falls by up to `jerk` a second.

    As `first_crossing`. Valid for `left` seconds, a finite number; a result beyond `left` means
    that the gap doesn't close before then.

    Within h seconds jerk s^3 / 6 is at most (jerk h / 3) s^2 / 2. The root with this term is a
    bound if it comes before h; if not, h is a bound. The best h is equal to its own root; the
    geometric mean of h and its root is four times nearer to the best h. If the gap closes because
    of its rate, a better h gains nothing.
    """
    bend = jerk / 3.0
    soonest: float = first_crossing(gap, rate, acceleration - bend * left)
    if jerk == 0.0:
        return soonest
    horizon = left
    while soonest < 0.25 * horizon and bend * horizon * soonest > -rate:
        horizon = math.sqrt(soonest * horizon)
        root = first_crossing(gap, rate, acceleration - bend * horizon)
        soonest = max(min(root, horizon), soonest)
    if rate >= 0.0 and acceleration > 0.0:
        # The gap opens, and can only close after the jerk has used up this acceleration. If the gap
        # is 0, no shorter time is a bound. One sixteenth of it is left for rounding.
        root = first_crossing(gap, rate, 0.0625 * acceleration)
        soonest = max(min(root, 0.9375 * acceleration / bend), soonest)
    return soonest


@kernel(inline=True)
def first_meeting(rx: float, ry: float, vx: float, vy: float, reach: float) -> float:
    """Return the first s >= 0 at which |r + v s| falls to `reach` [s], or inf.

    Contract: as for `first_crossing`. The constant term is (d - D)(d + D), which keeps the digits
    of a small gap.

    The discriminant (r.v)^2 - v^2 (d^2 - D^2) equals v^2 D^2 - (r x v)^2. The second form has
    smaller terms, so smaller rounding errors, for balls far apart: with the first form, the time of
    an oblique collision from 20 diameters away was off by 20 roundings. For touching balls the
    discriminant is just (r.v)^2, so rounding in the second form is ignored there.
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

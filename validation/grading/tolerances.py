"""Tolerances of the comparison, each with its reason; none depends on the judged engine."""

from __future__ import annotations

UNIT_ROUNDOFF = 2.0**-53
"""Largest relative error of one rounding to double precision."""

EPS = 2.0 * UNIT_ROUNDOFF
"""Spacing of doubles at 1: times closer than EPS t can't be distinguished at a time t."""

LEAST_DOUBLE = 2.0**-1074
"""The least positive double; no rounding error is smaller."""

ROUNDINGS = 32.0
"""Error that an exact engine may have, in units of one rounding of the state at each event.

The common limit on `quality_factor`: up to the horizon, such errors stay small.
"""

TOLERANCE = 1e-3
"""Displacement [m] by `ROUNDINGS` at which a shot is no longer predictable.

A thirtieth of a pool ball's radius: it may turn the next collision by two degrees, so the one after
that may be a miss.
"""

CONTACT_STEP = 2.0**-26
"""Error of a step of a resting contact, in units of the fastest speed (1.5e-8).

Some fifty steps with equal errors stay within a millionth, which is less than the uncertainty of
friction coefficients. Ghostball's engine uses the same tolerance (`engine.core.tolerances`); change
both together.
"""

MOST_CONTACT_STEPS = 64
"""Largest number of contact steps whose errors may have the same sign; most contacts take fewer."""

INTEGRATED_IMPACT = 4e-9
"""Error of an impact law that is integrated over the impact, in units of the approach speed.

Slower slips count as held by friction. Ghostball's engine uses the same tolerance (`STILL` in
`engine.impacts.laws.impulse_integrator`); change both together.
"""

BALANCED_SLOPE = 2.0**-20
"""Slope of the line to the ball below, against the vertical, at which a ball balances on it (1e-6).

Real balls are less round than that. Ghostball's engine lets a ball that is nearer to the top fall
as from this slope, and along x from the top itself (`_ASIDE` in `engine.impacts.slow_impacts`);
change both together.
"""

TIE = 2.0**-40
"""Relative difference of times that count as simultaneous (1e-12).

It is rounding, amplified by a few collisions; at 10 m/s it is 1e-11 m of path per second of motion.
"""

LARGEST_GROWTH_RATIO = 4.0
"""Largest ratio of the error growth by Ghostball's engine to the certified one, and vice versa.

Ghostball's engine computes the rms over 32 random signs, which has an error of a tenth, rarely of a
half.
"""

LOWEST_BOUNCE = 2.0**-18
"""Height of a bounce, in diameters, below which a shot isn't compared any more.

2e-7 m for pool balls. Vanishing bounces are infinitely many in a finite time, and no engine follows
them all. A bounce of this height lasts less than a millisecond on the cloth, as long as a contact
of real balls. An engine that treats higher bounces as a contact misses compared events.
"""

LEAST_SLIP = 4.0 * EPS
"""Slip that counts as rounding, in units of the fastest initial surface speed of a ball.

A slip is the difference of two speeds, each with a rounding error or two.
"""


def contact_error(steps: int) -> float:
    """Return the error of all contact steps of a shot, in units of the fastest speed."""
    return CONTACT_STEP * (1 + min(steps, MOST_CONTACT_STEPS)) if steps else 0.0

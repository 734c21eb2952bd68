"""What the grader tolerates, each with its reason; nothing of it is the engine's that is graded."""

from __future__ import annotations

UNIT_ROUNDOFF = 2.0**-53
"""Largest relative error of one rounding to double precision."""

EPS = 2.0 * UNIT_ROUNDOFF
"""Spacing of doubles at 1: a clock that shows t can't tell instants that are EPS t apart."""

LEAST_DOUBLE = 2.0**-1074
"""The least positive double: no rounding is smaller."""

ROUNDINGS = 32.0
"""Errors that an exact engine may make, over those of one rounding of the state at each event.

The limit of the common criterion on `quality_factor`: up to the horizon, such errors stay small.
"""

TOLERANCE = 1e-3
"""Displacement [m] by such errors at which a shot can't be predicted any further.

A thirtieth of a pool ball's radius: the next collision may be turned by two degrees, and the one
after it may be missed.
"""

CONTACT_STEP = 2.0**-26
"""What a step of a resting contact may be off by, in units of the fastest speed (1.5e-8).

Some fifty of them, each as wrong, stay within a millionth: below what friction is known to. Our
engine allows itself as much (`engine.core.tolerances`); who changes that, asks why here.
"""

TIE = 2.0**-40
"""Two times within this fraction of themselves are one instant (1e-12).

It is rounding, amplified by a few collisions; at 10 m/s it is 1e-11 m of path per second of motion.
"""

OFF_BY = 4.0
"""How many times the proof's growth of errors our engine's account of it may be; or the reverse.

Our engine takes the root mean square over 32 random signs, which is off by a tenth, seldom a half.
"""

LOWEST_BOUNCE = 2.0**-18
"""Height of a bounce, in diameters, from which on a shot isn't graded.

2e-7 m for pool balls. Bounces that die out come without end in a finite time, and no engine follows
them all; a bounce of that height lasts less than a millisecond on the cloth, as long as a contact
of real balls. An engine that takes higher bounces for a contact misses events that are graded.
"""

LEAST_SLIP = 4.0 * EPS
"""Slip that is but rounding, in units of the fastest speed of a ball's surface at the start.

A slip is the difference of two speeds, each of which carries a rounding or two.
"""

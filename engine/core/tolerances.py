"""The tolerances of the engine, each with why.

All but the contact step's are derived from the rounding of double precision and only say when a
computed sign is noise: free balls have no speed below which they rest, no distance below which they
touch, no time below which events are simultaneous. A contact step has a tolerance of its own, and
what counts as touching, slow or negligible within one follows from it; and a ball that meets one
at rest more slowly than `CAPTURE_HEIGHT` allows doesn't bounce. How a step is chosen is no
tolerance: those constants are in `resting_contact.step` and `resting_contact.forces`.
"""

from __future__ import annotations

EPS = 2.0**-52
"""Spacing of doubles at 1 (twice the unit roundoff)."""

POSITION_ULPS = 16.0
"""Rounding errors, in units of EPS times the coordinates, that a *given* position may carry.

A rack computed from sqrt(3) and a few sums overlaps itself by up to about 4 of them; 16 leaves room
for longer sums. It decides only whether a scene is refused as overlapping; balls are never moved.
"""


def position_rounding(*lengths: float) -> float:
    """Largest distance [m] that rounding can put between given positions made of `lengths` [m]."""
    return POSITION_ULPS * EPS * float(sum(abs(length) for length in lengths))


GAP_ULPS = 4.0
"""Rounding of a gap, in units of EPS times the coordinates that it is computed from."""

GAP_ROUNDING = EPS
"""Gap, in units of the centre distance, that counts as touching: d - D resolves no less."""

TIME_ROUNDING = EPS
"""Step, in units of the instant, that a clock in double precision can't take.

Conservative advancement that no longer moves the clock has arrived. Without this rule about 1 in
2 000 random breaks repeats the same step for ever.
"""

APPROACH_ROUNDING = 8.0 * EPS
"""Speed of approach, in units of both balls' speeds, whose sign is noise.

An impact with restitution 0 leaves up to about 4 EPS of the speeds, of either sign. Taken as an
approach it would be resolved again and again at the same instant, changing nothing. The price: two
balls that truly approach so slowly are let pass, and overlap by up to this part of the way that
they go together, as much as the rounding of their velocities moves them anyway.
"""

SLIP_ROUNDING = 4.0 * EPS
"""Slip, in units of the speeds that it is the difference of, that is but their rounding."""

CONTACT_TOLERANCE = 2.0**-37
"""Opening or overlap, in diameters, of a gap that a contact force holds closed.

4e-13 m for pool balls: a thousand roundings of a coordinate on a table, so that the force is not
made of noise. With those below it is all that is approximate in the engine; a run that used it
says so in `work["contact_steps"]`.
"""

CAPTURE_HEIGHT = 2.0**-18
"""Height of a hop, in diameters, below which two balls that friction presses together don't part.

2e-7 m for pool balls: less than a millisecond on the cloth, some times as long as a real contact of
two balls lasts. Bounces die out towards a contact; following them down to the tolerance of a gap
took thousands of events in one of a hundred breaks, down to 2^-20 still 700 in one of a thousand.
What is left out is a gap of at most this height while they would last: an impulse that ends the
approach is all that the bounces would have exchanged, but for what friction changes meanwhile.

Also the way in which the cloth can stop a pressed ball that rolls: one as slow as that is brought
to rest by the end of its step, unless it is driven. Waiting for less took steps of microseconds, in
which forces are not told from rounding, and balls of a frozen line crept to and fro for ever.
"""

STOP_WAY = 2.0**-28
"""Way, in diameters, in which the cloth can end the slip of a pressed ball, that is as ended.

2e-10 m for pool balls, were it slowed by mu g; slip is slowed 7/2 times that. Slower slip asks for
steps so short that the tolerance of a gap leaves the force of a contact undecided.
"""

CONTACT_REACH = 4.0
"""Gap, in tolerances, up to which balls join a contact step: steps before it may have left one."""

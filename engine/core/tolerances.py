"""The tolerances of the engine, each with why.

Three are in `model.rounding`, since they decide which scenes are refused: that of given positions,
that of contacts in flight, and `CONTACT_TOLERANCE`, within which the engine keeps the gaps of
resting contacts (4e-13 m for pool balls), so that a force is not made of noise. With those below,
and the accuracy of the laws that integrate over an impact, it is all that is approximate in the
engine; a run that used it says so in `work["contact_steps"]`.

Those down to `SLIP_ROUNDING` are derived from the rounding of double precision and only say when a
computed sign is noise: free balls have no speed below which they rest, no distance below which they
touch, no time below which events are simultaneous. `SLIDE_ERROR` is of slides in air, which have no
closed form. Three others leave bounces out: those of a ball
that has too many to end at one instant (`ONE_INSTANT`), between balls that friction pushes
together, or one of which was at rest (`CAPTURE_HEIGHT`), and on the table (`LOWEST_BOUNCE`). The
rest is of balls that stay in contact. How their steps are chosen is no tolerance: those constants
are where they are used, in `resting_contact`.
"""

from __future__ import annotations

import math

EPS = 2.0**-52
"""Spacing of doubles at 1 (twice the unit roundoff)."""

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
approach it would be resolved again and again at the same instant, changing nothing. The speeds are
the largest that the balls had at that instant: a row of balls that is pushed into a cushion halves
its own speed there, again and again, and would never be at its rounding. The price: two
balls that truly approach so slowly are let pass, and overlap by up to this part of the way that
they go together, as much as the rounding of their velocities moves them in any case.
"""

LEAST_SPEED = 2.0**-500
"""Speed [m/s] below which a ball that rebounds, or is in contact, rests: its square is a double.

So two balls that approach no faster don't collide.

0.85 times the least double is that number again, so that bounces would never end. And on a cloth
without friction each inelastic impulse leaves a ball in a corner 1e-16 of its speed.
"""

SLIP_ROUNDING = 4.0 * EPS
"""Slip, in units of the speeds that it is the difference of, that is but their rounding."""

SLIDE_ERROR = 2.0**-42
"""What a piece of a slide that turns in air may leave out of the velocity, in units of the speeds.

2e-13. So rest positions in air err by less than 1e-11 m, measured against 40 digits: by at most
1.8e-12 m in the 42 random shots of up to 8 m/s by which it was chosen, a third of them with a
second ball, and by 3.3e-12 m in 24 others of up to 10 m/s. At 2^-36, 2^-40, 2^-42, 2^-44 and 2^-48
the largest errors of the 42 are 1.4e-10, 6.8e-12, 1.8e-12, 2.1e-12 and 1.0e-13 m. Where pieces
erred by rounding alone, found at nodes, 19 shots took longer: at 2^-42 they take 0.84 times as long
together, and no slide that turns takes more; at 2^-44 0.96 times, and some take more. Motion in air
that goes straight on errs by rounding, and so does flight.

The engine's resolution in air follows from it (`slide_resolution`).
"""

ONE_INSTANT = 2.0**-28
"""Time, in units of the clock, within which impacts of a ball count as one series.

4e-9 s after 1 s; and within which events count as a standstill of the clock (`event_loop.loop`).
Impacts of a series that are too many to end by themselves don't throw a ball back
(`impacts.impact.has_collapsed`). Balls that fill a row between two posts bounce there every 1e-15
s, and take a second to leave it.
"""

AT_THE_FRAME = 2.0**-26
"""Below which two times, over themselves, or two places, over a ball's radius, count as one.

The root of a rounding: far more than rounding lies between a ball that meets the middle of a
cushion and whatever else there is. Where less does, all obstacles are asked; see `motion.frame`.
"""

CAPTURE_HEIGHT = 2.0**-18
"""Height of a bounce, in diameters, below which balls that friction pushes together don't part.

2e-7 m for pool balls: less than a millisecond on the cloth, some times as long as a real contact of
two balls lasts. Bounces die out towards a contact; following them down to the tolerance of a gap
took thousands of events in one of a hundred breaks, down to 2^-20 still 700 in one of a thousand.
What is left out is a gap of at most this height while they would last: an impulse that ends the
approach is all that the bounces would have exchanged, but for what friction changes meanwhile.

Also the distance within which the cloth can stop a rolling ball in contact: a ball as slow as that
is brought to rest by the end of its step, unless something pushes it. To wait until it is slower
took steps of microseconds, in which forces can't be distinguished from rounding: the balls of a
frozen line then moved to and fro for ever.

And where balls may leave the cloth, how high an impact must let one rebound to be one in space: see
`impacts.in_space`.
"""

LOWEST_BOUNCE = 2.0**-24
"""Height of a bounce on the table, in diameters, from which on bounces aren't followed one by one.

3e-9 m for pool balls. All that follow are one motion, whose end is exact; between, the ball is on
the cloth, too low by no more than that. A table that returns half of the speed takes 12 bounces to
come to it from 1 m/s, one that returns 9/10 takes 78.

Also the overlap that two balls get in flight, where one lies on the other. No force holds a contact
there: each bounce is an impact that returns the speed of approach. Balls that gravity has pulled
together over this distance bounce as high. So a tenth of a second on top of another ball takes some
thousand impacts, and not one for each rounding of a speed.
"""

STOP_DISTANCE = 2.0**-28
"""Distance, in diameters, within which the cloth can end a slip in contact that counts as ended.

2e-10 m for pool balls, were it slowed by mu g; slip is slowed 7/2 times that. Slower slip asks for
steps so short that the tolerance of a gap leaves the force of a contact undecided.
"""

CONTACT_REACH = 4.0
"""Gap, in tolerances, up to which balls join a contact step: steps before it may have left one."""

MOTION_ERROR = 2.0**-26
"""Error of the velocities, in units of the fastest, that a step of a resting contact may make.

1.5e-8, so that some fifty steps, of which each errs as much, would be off by less than 1e-6. Of
2^-33, 2^-28, 2^-26 and 2^-24 it is where the work stops to fall: 195, 120, 94 and 85 steps of a
break, while a ball along a cushion ends within 1e-6 of its speed at all of them.
"""


def slide_resolution(fastest: float, slowing: float, drag: float, t_max: float | None) -> float:
    """Return how far off balls may be that have slid in air and roll on [m].

    An error of the velocity goes on as long as the ball rolls: so it is `SLIDE_ERROR` times the way
    that the fastest ball can roll, ln(1 + b v^2 / a) / 2b. Errors of a slide never grow (friction
    and drag are gradients of convex functions of the velocity), and of a piece they are less than
    what is allowed.

    `fastest` [m/s]: speed of the fastest ball, until balls meet.
    `slowing` [m/s^2]: a, the least deceleration of a rolling ball; 0: it rolls until `t_max` [s].
    `drag` [1/m]: of the air.
    """
    if slowing == 0.0:
        return SLIDE_ERROR * fastest * (t_max or 0.0)
    b = 5.0 / 7.0 * drag
    return SLIDE_ERROR * math.log1p(b * fastest * fastest / slowing) / (2.0 * b)

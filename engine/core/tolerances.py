"""The tolerances of the engine, each with its reason.

Three more are in `model.rounding`, because they decide which scenes are rejected: the tolerance of
given positions, that of contacts in flight, and `CONTACT_TOLERANCE`. The engine keeps the gaps of
resting contacts within the last one (4e-13 m for pool balls), so that forces are not computed from
noise. The engine makes no approximations other than these tolerances and the limited accuracy of
impacts that are integrated. `work["contact_steps"]` tells whether a run used resting contacts.

The tolerances down to `SLIP_ROUNDING` are derived from the rounding of double precision and only
decide when a computed sign is noise. Free balls have no speed below which they rest, no distance
below which they touch, and no time below which events are simultaneous. `SLIDE_ERROR` is for slides
in air, which have no closed form. Three tolerances leave out bounces: those of a ball with too many
bounces at one time (`ONE_INSTANT`), those between balls that friction pushes together or of which
one was at rest (`CAPTURE_HEIGHT`), and those on the table (`LOWEST_BOUNCE`). The remaining
tolerances are for balls in resting contact. The constants that choose their steps are not
tolerances; they are in `resting_contact`, where they are used.
"""

from __future__ import annotations

import math

EPS = 2.0**-52
"""Spacing of doubles at 1 (twice the unit roundoff)."""

GAP_ULPS = 4.0
"""Rounding error of a gap, in units of EPS times the coordinates that it is computed from."""

GAP_ROUNDING = EPS
"""Gap, relative to the centre distance d, that counts as touching: the rounding of d - D."""

TIME_ROUNDING = EPS
"""Time step, relative to the time, that a clock in double precision can't resolve.

Conservative advancement ends when it no longer moves the clock. Without this rule about 1 in 2 000
random breaks repeats the same step indefinitely.
"""

APPROACH_ROUNDING = 8.0 * EPS
"""Approach speed, relative to the speeds of both balls, below which its sign is noise.

An impact with restitution 0 leaves an approach speed of up to about 4 EPS of the speeds, of either
sign. If that counted as an approach, the impact would be resolved again and again at the same time,
without effect. The speeds are the largest that the balls had at that time: a row of balls that is
pushed into a cushion halves its own speed there repeatedly, and would never reach the rounding of
its current speed.

The cost: two balls that really approach so slowly are not stopped. They overlap by up to this part
of their common path, which is as far as the rounding of their velocities moves them in any case.
"""

LEAST_SPEED = 2.0**-500
"""Speed [m/s] below which a ball that rebounds, or is in contact, counts as at rest.

Two balls that approach more slowly don't collide. The square of this speed doesn't underflow.

Without this limit, bounces would never end: 0.85 times the smallest double is rounded to the
smallest double again. In a corner on a cloth without friction, each inelastic impulse leaves a ball
1e-16 of its speed, so its speed would decrease to the smallest doubles.
"""

SLIP_ROUNDING = 4.0 * EPS
"""Slip that counts as rounding, divided by the speeds whose difference is the slip."""

SLIDE_ERROR = 2.0**-42
"""Error of the velocity that a piece of a turning slide in air may have, relative to the speeds.

2e-13. Rest positions in air then have errors below 1e-11 m, measured against computations with 40
digits: at most 1.8e-12 m in the 42 random shots of up to 8 m/s with which the value was chosen (a
third of them with a second ball), and 3.3e-12 m in 24 other shots of up to 10 m/s. With 2^-36,
2^-40, 2^-42, 2^-44 and 2^-48 the largest errors of the 42 shots are 1.4e-10, 6.8e-12, 1.8e-12,
2.1e-12 and 1.0e-13 m.

An earlier method computed pieces from their values at nodes, with rounding errors only. With that
method, 19 of the shots took longer. They take 0.84 times as long in total with 2^-42, and no
turning slide takes longer; with 2^-44 they take 0.96 times as long, and some take longer. Straight
motion in air and flight have rounding errors only.

The engine's resolution in air follows from this value (`slide_resolution`).
"""

ONE_INSTANT = 2.0**-28
"""Time, relative to the clock, within which the impacts of a ball count as one series.

4e-9 s after 1 s. Also the time within which events count as a standstill of the clock
(`event_loop.loop`). If a series has too many impacts to end by itself, its impacts no longer throw
the ball back (`impacts.impact.has_collapsed`). Balls that fill a row between two posts bounce there
every 1e-15 s, and take a second to leave the row.
"""

AT_THE_FRAME = 2.0**-26
"""Relative difference below which two times count as equal, or two positions (relative to radius).

The square root of a rounding error. If a ball meets the middle of a cushion, all other obstacles
are farther away than this by much more than rounding. If an obstacle is nearer, all obstacles are
checked; see `motion.frame`.
"""

CAPTURE_HEIGHT = 2.0**-18
"""Height of a bounce, in diameters, below which balls that friction pushes together stay together.

2e-7 m for pool balls: such a bounce takes less than a millisecond on the cloth, a few times as long
as a real contact of two balls. Bounces decay to a contact. To follow them down to the tolerance of
a gap took thousands of events in one of a hundred breaks, and down to 2^-20 still 700 events in one
of a thousand. The error is a gap of at most this height for as long as the bounces would last: the
impulse that ends the approach is the total impulse of the bounces, except for what friction changes
meanwhile.

Also the distance within which the cloth can stop a rolling ball in contact: such a slow ball is
brought to rest by the end of its step, unless something pushes it. To wait for lower speeds took
steps of microseconds, in which forces can't be distinguished from rounding: the balls of a frozen
line then moved back and forth indefinitely.

Also, if balls may leave the cloth, the lowest rebound after which an impact counts as an impact in
space: see `impacts.in_space`.
"""

LOWEST_BOUNCE = 2.0**-24
"""Height of a bounce on the table, in diameters, below which bounces are not followed one by one.

3e-9 m for pool balls. All further bounces are one motion, whose end is exact; during the motion the
ball is on the cloth, too low by at most this height. From 1 m/s, a ball reaches this height after
12 bounces on a table that returns half of the speed, and after 78 on a table that returns 9/10.

Also the allowed overlap of two balls in flight, if one lies on the other. No force holds a contact
there: each bounce is an impact that returns the approach speed. Balls that gravity has pulled
together over this distance bounce to the same height. A tenth of a second on top of another ball
therefore takes about a thousand impacts; without this rule, each rounding of a speed would cause
an impact.
"""

STOP_DISTANCE = 2.0**-28
"""A slip in contact counts as ended if the cloth can end it within this distance, in diameters.

2e-10 m for pool balls, for a deceleration of mu g; the deceleration of a slip is 7/2 times that.
Slower slip requires steps so short that the force of a contact is undetermined within the tolerance
of its gap.
"""

CONTACT_REACH = 4.0
"""Gap, in tolerances, up to which balls join a contact step: earlier steps may leave such gaps."""

MOTION_ERROR = 2.0**-26
"""Error of the velocities, relative to the fastest, that a step of a resting contact may make.

1.5e-8: fifty steps with this error each are then off by less than 1e-6. With 2^-33, 2^-28, 2^-26
and 2^-24 a break takes 195, 120, 94 and 85 steps: larger errors than this value hardly save work.
With all four values, the speed of a ball along a cushion is exact to 1e-6 at the end.
"""


def slide_resolution(
    fastest: float, slowing: float, sliding: float, drag: float, place: float, t_max: float | None
) -> float:
    """Return a bound on the position errors of balls that have slid in air and then roll [m].

    An error of the velocity persists while the ball rolls. The pieces of a slide give at most
    `SLIDE_ERROR` times the distance that the fastest ball can roll, ln(1 + b v^2 / a) / 2b. Errors
    of a slide never grow (friction and drag are gradients of convex functions of the velocity), and
    the error of a piece is smaller than the allowed error.

    The last piece gives a position error of at most e = `SLIDE_ERROR` times `place`, by its turn
    (`motion.drag`). Air takes 5/7 of the integral of k |v| v from its velocity, over the remaining
    time t = 2 u / 7 c, with the slip u and c = `sliding`. The midpoint rule computes this integral
    with an error of at most k t (2 u / 7)^2 / 8, because no second derivative of |v| v exceeds 3.
    The last piece begins when 2 k w^2 t^2 <= 7 e, where w is at least the speed and at least 2 u /
    7. So the error of the velocity is at most 5/16 e c / s, where s^4 = 7/2 e c^2 / k. It decreases
    as 1 / w^3 for a speed w above s, so a ball rolls no farther off than one that starts with s.

    `fastest` [m/s]: speed of the fastest ball, until balls collide.
    `slowing` [m/s^2]: a, the smallest deceleration of a rolling ball; 0: it rolls until `t_max`
        [s].
    `sliding` [m/s^2]: the largest deceleration of a sliding ball.
    `drag` [1/m]: k, the drag coefficient of the air.
    `place` [m]: largest sum of the coordinates of a ball, or a radius, while it slides.
    """
    turned = SLIDE_ERROR * place
    slow: float = (3.5 * turned * sliding * sliding / drag) ** 0.25
    if slowing == 0.0:
        rolls, lasts = fastest * (t_max or 0.0), t_max or 0.0
    else:
        b = 5.0 / 7.0 * drag
        rolls = math.log1p(b * fastest * fastest / slowing) / (2.0 * b)
        lasts = slow / slowing
    return SLIDE_ERROR * rolls + turned * (1.0 + 0.3125 * sliding / slow * lasts)

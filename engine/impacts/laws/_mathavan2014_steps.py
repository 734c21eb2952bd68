"""The equations of `ball_mathavan2014`, and a step of their integration.

b is the pressed ball, a the lifted one. The cloth keeps b from moving down: friction between the
balls turns both, and accelerates a alone upwards. Every speed is in units of the speed of approach
before the impact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from engine.core.kernel import kernel

ACCURACY = 1e-10
"""Error of one step, in units of the largest impulse that friction can reach in this impact."""

STEP_ROUNDING = 2.0**-48
"""Error of one step, in units of the slip and the pressed ball's own speeds: their rounding, which
no shorter step escapes."""


class Contact(NamedTuple):
    """What doesn't change during the impact; b is the pressed ball; speeds over the approach."""

    slip_along: float  # of a's surface over b's, before
    slip_down: float  # positive
    cloth_slip_n: float  # of b on the cloth, before
    cloth_slip_t: float
    share: float  # of b in the change of the relative velocity: reduced mass over b's mass
    yielding: float  # fall of the slip down per impulse down on b over the reduced mass
    friction: float  # coefficient between the balls
    cloth: float  # coefficient between b and the cloth, times `share`
    restitution: float
    reach: float  # the largest impulse that friction can reach
    error: float  # that one step may make
    rolls: float  # slip on the cloth that counts as none


class Course(NamedTuple):
    """How far the impact has come; or the derivatives of these.

    `fade` falls from 1 towards 0 as the slip between the balls ends. That slip is fade^6 times
    (`along`, `down`), because so it falls if the cloth takes no part: as fade^6 down, and along,
    between equal masses, as fade^7. With fade as the variable the course is then smooth up to the
    slip's end, where it is singular in the impulse itself. Between other masses the power along is
    one from 6 to 8.4, and the steps get shorter with fade.
    """

    fade: float
    normal: float  # impulse over the reduced mass
    along: float
    down: float
    cloth_n: float  # impulse of the cloth over b's own mass
    cloth_t: float
    cloth_work: float  # integral of `cloth_n` over the normal impulse


@kernel
def speed_of(course: Course) -> float:
    """Return the speed of approach, in units of that before the impact."""
    return (1.0 - course.normal) - course.cloth_n


@kernel
def slip_of(course: Course) -> float:
    """Return the speed of the slip between the balls, in the same units."""
    fade = course.fade * course.fade
    size = math.sqrt(course.along * course.along + course.down * course.down)
    return fade * fade * fade * size


@kernel
def rubbed(course: Course, contact: Contact) -> tuple[float, float]:
    """Return the impulse on b over the reduced mass, along t and down, from the slip's change."""
    fade = course.fade * course.fade
    fade *= fade * fade
    along = (contact.slip_along - fade * course.along) - course.cloth_t
    down = (contact.slip_down - fade * course.down) - 2.5 * course.cloth_n
    return along / 3.5, down / contact.yielding


@kernel
def _cloth_slip(course: Course, contact: Contact) -> tuple[float, float]:
    """Return the slip of b on the cloth, along n and t."""
    along, down = rubbed(course, contact)
    pushed = contact.share * (course.normal + 2.5 * down)
    n = (contact.cloth_slip_n + pushed) + 3.5 * course.cloth_n
    t = (contact.cloth_slip_t + contact.share * along) + 3.5 * course.cloth_t
    return n, t


@kernel
def cloth_rates(course: Course, contact: Contact) -> tuple[float, float]:
    """Return the cloth's impulse on b per unit of the normal impulse, along n and t."""
    size = math.sqrt(course.along * course.along + course.down * course.down)
    if size == 0.0:
        return 0.0, 0.0
    down = contact.friction * (abs(course.down) / size)
    n, t = _cloth_slip(course, contact)
    slip = math.sqrt(n * n + t * t)
    if slip <= contact.rolls:
        # b starts to slip at once, the way that a pushes it.
        n, t = 1.0 + 2.5 * down, contact.friction * (course.along / size)
        slip = math.sqrt(n * n + t * t)
    grip = contact.cloth * down
    return -grip * (n / slip), -grip * (t / slip)


@kernel
def normal_rate(course: Course, contact: Contact) -> float:
    """Return the derivative of the normal impulse by `fade`."""
    size = math.sqrt(course.along * course.along + course.down * course.down)
    fade = course.fade * course.fade
    return -6.0 / contact.yielding * (fade * fade * course.fade) * (size / contact.friction)


@kernel
def _derivatives(course: Course, contact: Contact, landing: bool) -> Course:
    """Return the derivatives by the speed of approach (`landing`), or else by `fade`."""
    size = math.sqrt(course.along * course.along + course.down * course.down)
    rate_n, rate_t = cloth_rates(course, contact)
    normal = normal_rate(course, contact)
    factor = -1.0 / ((1.0 + rate_n) * normal) if landing else 1.0
    normal *= factor
    turning = factor / course.fade
    pull = size / contact.friction
    pace = 6.0 / contact.yielding
    return Course(
        factor,
        normal,
        turning * ((3.5 * pace - 6.0) * course.along + pace * (pull * rate_t)),
        turning * (2.5 * pace * (pull * rate_n)),
        rate_n * normal,
        rate_t * normal,
        course.cloth_n * normal,
    )


@kernel
def _plus(course: Course, h: float, slope: Course) -> Course:
    return Course(
        course.fade + h * slope.fade,
        course.normal + h * slope.normal,
        course.along + h * slope.along,
        course.down + h * slope.down,
        course.cloth_n + h * slope.cloth_n,
        course.cloth_t + h * slope.cloth_t,
        course.cloth_work + h * slope.cloth_work,
    )


@kernel
def take_step(course: Course, contact: Contact, h: float, landing: bool) -> tuple[Course, float]:
    """Take one step of h and return where it ends and its error, in units of what is allowed.

    Notes
    -----
    Dormand and Prince (1980, J. Comp. Appl. Math. 6, 19), with the result of order 5.
    """
    k1 = _derivatives(course, contact, landing)
    at = _plus(course, h * (1.0 / 5.0), k1)
    k2 = _derivatives(at, contact, landing)
    at = _plus(_plus(course, h * (3.0 / 40.0), k1), h * (9.0 / 40.0), k2)
    k3 = _derivatives(at, contact, landing)
    at = _plus(_plus(course, h * (44.0 / 45.0), k1), h * (-56.0 / 15.0), k2)
    at = _plus(at, h * (32.0 / 9.0), k3)
    k4 = _derivatives(at, contact, landing)
    at = _plus(_plus(course, h * (19372.0 / 6561.0), k1), h * (-25360.0 / 2187.0), k2)
    at = _plus(_plus(at, h * (64448.0 / 6561.0), k3), h * (-212.0 / 729.0), k4)
    k5 = _derivatives(at, contact, landing)
    at = _plus(_plus(course, h * (9017.0 / 3168.0), k1), h * (-355.0 / 33.0), k2)
    at = _plus(_plus(at, h * (46732.0 / 5247.0), k3), h * (49.0 / 176.0), k4)
    at = _plus(at, h * (-5103.0 / 18656.0), k5)
    k6 = _derivatives(at, contact, landing)
    end = _plus(_plus(course, h * (35.0 / 384.0), k1), h * (500.0 / 1113.0), k3)
    end = _plus(_plus(end, h * (125.0 / 192.0), k4), h * (-2187.0 / 6784.0), k5)
    end = _plus(end, h * (11.0 / 84.0), k6)
    k7 = _derivatives(end, contact, landing)

    error = _plus(Course(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), h * (71.0 / 57600.0), k1)
    error = _plus(_plus(error, h * (-71.0 / 16695.0), k3), h * (71.0 / 1920.0), k4)
    error = _plus(_plus(error, h * (-17253.0 / 339200.0), k5), h * (22.0 / 525.0), k6)
    error = _plus(error, h * (-1.0 / 40.0), k7)
    return end, _relative(error, end, contact) + _reversal(course, end, contact)


@kernel
def _reversal(course: Course, end: Course, contact: Contact) -> float:
    """Return the error where the slip on the cloth turns back during a step, else 0; same units.

    The cloth's force jumps there if the slip passes through zero, which the difference of two
    formulas can miss. The error is at most what the cloth does in the other direction.
    """
    n, t = cloth_rates(course, contact)
    end_n, end_t = cloth_rates(end, contact)
    if n * end_n + t * end_t >= 0.0:
        return 0.0
    jump = max(abs(end_n - n), abs(end_t - t))
    return jump * abs(end.normal - course.normal) / contact.error


@kernel
def _relative(error: Course, end: Course, contact: Contact) -> float:
    """Return the largest error in units of what is allowed.

    An error of the normal impulse only shifts friction along the course: it counts by what friction
    does meanwhile. Where the slip is large, the impulse has rounding of the size of its own steps.
    """
    part = end.fade * end.fade
    part *= part * end.fade
    slip = abs(end.along) + abs(end.down)
    slipping = part * (
        end.fade * (abs(error.along) + abs(error.down)) + 6.0 * slip * abs(error.fade)
    )
    holding = max(abs(error.cloth_n), abs(error.cloth_t), abs(error.cloth_work))
    shifting = contact.friction * abs(error.normal)
    return max(slipping, holding, shifting) / contact.error

"""Ball-ball impacts integrated over the impulse, with the friction of the cloth during the impact.

Mathavan, Jackson and Parkin (2014), "Numerical simulations of the frictional collisions of solid
balls on a rough surface", Sports Engineering 17, doi 10.1007/s12283-014-0158-y.

Friction between the balls presses one of them on the cloth, the one whose surface goes up against
the other's; the cloth's friction then acts on that ball while the impact lasts. Which ball it is
can't change during an impact: the vertical slip shrinks in proportion to itself. So the equations
are written once, in a frame in which b is the pressed ball, with every speed in units of the speed
of approach.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from engine._jit import kernel
from engine._state import Laws
from engine.impact_laws.ball_frictional import contact_slip, frictional, length
from engine.impact_laws.friction_curve import friction_coefficient
from engine.impact_laws.interface import BallImpact, BallImpulse

ACCURACY = 3e-10
"""Error of one step, in units of the largest impulse that friction can reach in this impact."""

STUCK = 1e-10
"""Slip between the balls, in the same units, that counts as ended."""

ROLLS = 16.0 * ACCURACY
"""Slip on the cloth, in the same units, that counts as none: the error of a few steps."""

ROLLING_ROUNDING = 2.0**-48
"""Slip on the cloth, in units of the ball's own speeds, that is the rounding of a rolling ball."""

NEGLIGIBLE = 2.0**-56
"""Approach in units of all the speeds, or friction, so small that rounding hides the cloth."""

LONGEST_STEP = 0.5
"""Of the variable `fade`, in units of itself: it never gets to zero."""

LONGEST_LANDING = 0.1
"""The same for the last step, which is taken in the speed and could overshoot the slip's end."""

MOST_STEPS = 1000
"""A bound on the work of a phase that no impact reaches: one of pool balls takes about 10 steps, or
100 where the slip ends, and the worst of 60 000 random ones with any coefficients took 320. Beyond
it friction would end and the normal impulse complete the phase."""

MOST_LANDINGS = 4
"""Last steps of a phase, each of which corrects the one before; three reach rounding."""

ROUNDING = 2.0**-51
"""Speed, in units of the approach, that is the rounding of a speed."""

HIGHEST_FRICTION = 1.0
HIGHEST_CLOTH = 0.7
"""Coefficients of friction, between balls and of the cloth, above which they count as these.

Balls have 0.05 and cloth 0.2. Far above, the pressed ball could jam between the other and the
cloth, which a model of balls that stay on the cloth doesn't describe. Below 5/7 the cloth can't
even keep the ball from slipping, however strongly it is pressed: so the slip passes through zero,
and the ball never rolls during an impact.
"""


class _Contact(NamedTuple):
    """What doesn't change during the impact; b is the pressed ball; speeds over the approach."""

    slip_along: float  # of a's surface over b's, before
    slip_down: float  # positive
    cloth_slip_n: float  # of b on the cloth, before
    cloth_slip_t: float
    share: float  # of b in the change of the relative velocity: reduced mass over b's mass
    friction: float  # coefficient between the balls
    cloth: float  # coefficient between b and the cloth, times `share`
    restitution: float
    reach: float  # the largest impulse that friction can reach; unit of the errors
    rolls: float  # slip on the cloth that counts as none


class _Course(NamedTuple):
    """How far the impact has come; or the derivatives of these.

    `fade` falls from 1 towards 0 as the slip between the balls ends. That slip is fade^5 times
    (`along`, `down`), because so it falls if the cloth takes no part: as fade^5 down and fade^7
    along. With fade as the variable the course is smooth up to the slip's end, where it is singular
    in the impulse itself.
    """

    fade: float
    normal: float  # impulse over the reduced mass
    along: float
    down: float
    cloth_n: float  # impulse of the cloth over b's own mass
    cloth_t: float
    cloth_work: float  # integral of `cloth_n` over the normal impulse


@kernel
def mathavan2014(impact: BallImpact, laws: Laws) -> BallImpulse:
    """Return the impulses of an impact during which the pressed ball rubs on the cloth.

    Parameters
    ----------
    impact : BallImpact
        The balls just before, approaching each other.
    laws : Laws
        `ball_restitution`, and `ball_friction` or `speed_dependent`, are used; the cloth's
        coefficients are the balls' own.

    Returns
    -------
    BallImpulse
        Within 1e-9 of the speed of approach, and of the rounding of the other speeds.

    Notes
    -----
    Mathavan, Jackson and Parkin (2014), generalised to balls of different radii and masses. Over
    each element of the normal impulse friction acts against the slip between the balls, and the
    cloth against the slip of the pressed ball. Compression ends when the balls no longer approach;
    restitution ends when the normal force has returned e^2 of the work that it stored (Stronge).

    Four details are ours:

    - The slip on the cloth is that of the lowest point, v + w x (-R z). The algorithm is usually
      written with the slip of the highest, (v_x + R w_y, v_y - R w_x), on which friction could feed
      the ball.
    - Slip between the balls that reaches zero stays zero.
    - A coefficient between the balls that depends on the speed is that of the slip before the
      impact, for which the curve was fitted.
    - Coefficients above any real ball's or cloth's are cut, see `HIGHEST_FRICTION`.

    The cloth holds the balls down, so vertical slip ends after an impulse of 2/5 of it, not 2/7.
    Without vertical slip, or without friction, the cloth takes no part: this is then `frictional`.

    Contract: no allocation; a bounded number of steps. Turning the frame by half a turn and
    exchanging the balls gives the same bits, and so does the mirror image.
    """
    approach = impact.a_vn - impact.b_vn
    slip_along, slip_up = contact_slip(impact)
    slip = length(slip_along, slip_up)
    friction = min(friction_coefficient(laws, slip), HIGHEST_FRICTION)
    speeds = slip + abs(impact.a_vn) + abs(impact.b_vn)
    if not friction > NEGLIGIBLE or slip_up == 0.0 or not approach > NEGLIGIBLE * speeds:
        return frictional(impact, laws)
    b_pressed = slip_up < 0.0
    done = _press_b(impact if b_pressed else _turned(impact), friction, laws.ball_restitution)
    if b_pressed:
        return done
    return BallImpulse(
        done.normal, done.along, -done.up, -done.b_cloth_n, -done.b_cloth_t, 0.0, 0.0
    )


@kernel
def _turned(impact: BallImpact) -> BallImpact:
    """Exchange the balls and turn the frame by half a turn about the vertical."""
    return BallImpact(
        -impact.b_vn,
        -impact.b_vt,
        -impact.b_wn,
        -impact.b_wt,
        impact.b_wz,
        impact.b_radius,
        impact.b_mass,
        impact.b_cloth,
        -impact.a_vn,
        -impact.a_vt,
        -impact.a_wn,
        -impact.a_wt,
        impact.a_wz,
        impact.a_radius,
        impact.a_mass,
        impact.a_cloth,
    )


@kernel
def _press_b(impact: BallImpact, friction: float, restitution: float) -> BallImpulse:
    """Return the impulses of an impact in which b is the pressed ball."""
    approach = impact.a_vn - impact.b_vn
    slip_along, slip_up = contact_slip(impact)
    share = impact.a_mass / (impact.a_mass + impact.b_mass)
    turning_n, turning_t = impact.b_radius * impact.b_wn, impact.b_radius * impact.b_wt
    own = abs(impact.b_vn) + abs(impact.b_vt) + abs(turning_n) + abs(turning_t)
    reach = min(friction * (1.0 + restitution), length(slip_along, slip_up) / approach)
    contact = _Contact(
        slip_along / approach,
        -slip_up / approach,
        (impact.b_vn - turning_t) / approach,
        (impact.b_vt + turning_n) / approach,
        share,
        friction,
        min(impact.b_cloth, HIGHEST_CLOTH) * share,
        restitution,
        reach,
        ROLLS * reach + ROLLING_ROUNDING * (own / approach),
    )
    course = _collide(contact)
    along, down = _rubbed(course, contact)
    return BallImpulse(
        approach * course.normal,
        approach * along,
        -approach * down,
        0.0,
        0.0,
        approach * course.cloth_n,
        approach * course.cloth_t,
    )


@kernel
def _collide(contact: _Contact) -> _Course:
    """Return where the course ends: after compression, then restitution."""
    start = _Course(1.0, 0.0, contact.slip_along, contact.slip_down, 0.0, 0.0, 0.0)
    course = start
    wanted = -1.0  # compression
    for _ in range(2):
        start, course = course, _run_phase(course, wanted, contact)
        wanted = contact.restitution * contact.restitution * _work(start, course)
    return course


@kernel
def _run_phase(start: _Course, wanted: float, contact: _Contact) -> _Course:
    """Return where a phase ends, see `_left`.

    Notes
    -----
    Steps in `fade`, except the last, which are taken in the speed so that they end where they
    should. Once the slip between the balls has ended, only the normal impulse is left, in closed
    form.
    """
    course = start
    longest = LONGEST_STEP
    landings = 0
    for _ in range(MOST_STEPS):
        if _slip(course) <= STUCK * contact.reach:
            course = _stuck(course)
            break
        gain = 1.0 + _cloth_rates(course, contact)[0]
        left = _left(start, course, wanted, gain)
        if abs(left) <= ROUNDING or landings == MOST_LANDINGS:
            break
        whole = -left / (gain * _normal_rate(course, contact) * course.fade)
        landing = abs(whole) <= min(longest, LONGEST_LANDING)
        part = whole if landing else max(-longest, min(longest, 0.9 * whole))
        step = -left if landing else -part * course.fade
        trial, error = _step(course, contact, step, landing)
        longest = min(abs(part) * _growth(error), LONGEST_STEP)
        if error <= 1.0:
            course = trial
            landings += landing
    return _pushed(course, _left(start, course, wanted, 1.0))


@kernel
def _left(start: _Course, course: _Course, wanted: float, gain: float) -> float:
    """Return by how much the speed of approach has to fall until the phase ends.

    Compression (`wanted` negative) ends when the balls don't approach; restitution, when the normal
    force has returned the wanted work. That goes with the square of the speed, but for what the
    cloth does to it meanwhile, which `gain`, the fall of the speed per normal impulse, foresees.
    """
    speed = _speed(course)
    if wanted < 0.0:
        return speed
    missing = wanted + _work(start, course)
    return speed + math.sqrt(max(speed * speed + 2.0 * gain * missing, 0.0))


@kernel
def _work(before: _Course, after: _Course) -> float:
    """Return the work that the normal force stored from one point of the course to another.

    It is the integral of the speed of approach, 1 - normal - cloth_n, over the normal impulse.
    """
    normal = after.normal - before.normal
    mean = 1.0 - 0.5 * (before.normal + after.normal)
    return mean * normal - (after.cloth_work - before.cloth_work)


@kernel
def _growth(error: float) -> float:
    """Return about 0.9 error^(-1/5), by square roots, between 1/5 and 5: the next step's factor."""
    if not error < 1e4:
        return 0.2
    eighth = math.sqrt(math.sqrt(math.sqrt(max(error, 1e-4))))
    return min(max(0.9 / (eighth * math.sqrt(eighth)), 0.2), 5.0)


@kernel
def _pushed(course: _Course, normal: float) -> _Course:
    """Return the course with more normal impulse, and nothing else."""
    return _Course(
        course.fade,
        course.normal + normal,
        course.along,
        course.down,
        course.cloth_n,
        course.cloth_t,
        course.cloth_work + course.cloth_n * normal,
    )


@kernel
def _stuck(course: _Course) -> _Course:
    """Return the course without slip between the balls."""
    return _Course(
        course.fade, course.normal, 0.0, 0.0, course.cloth_n, course.cloth_t, course.cloth_work
    )


@kernel
def _speed(course: _Course) -> float:
    """Return the speed of approach, in units of that before the impact."""
    return (1.0 - course.normal) - course.cloth_n


@kernel
def _slip(course: _Course) -> float:
    """Return the speed of the slip between the balls, in the same units."""
    fade = course.fade * course.fade
    size = math.sqrt(course.along * course.along + course.down * course.down)
    return fade * fade * course.fade * size


@kernel
def _rubbed(course: _Course, contact: _Contact) -> tuple[float, float]:
    """Return the impulse on b over the reduced mass, along t and down, from the slip's change."""
    fade = course.fade * course.fade
    fade *= fade * course.fade
    along = (contact.slip_along - fade * course.along) - course.cloth_t
    down = contact.slip_down - fade * course.down
    return along / 3.5, down / 2.5 - course.cloth_n


@kernel
def _cloth_slip(course: _Course, contact: _Contact) -> tuple[float, float]:
    """Return the slip of b on the cloth, along n and t."""
    along, down = _rubbed(course, contact)
    pushed = contact.share * (course.normal + 2.5 * down)
    n = (contact.cloth_slip_n + pushed) + 3.5 * course.cloth_n
    t = (contact.cloth_slip_t + contact.share * along) + 3.5 * course.cloth_t
    return n, t


@kernel
def _cloth_rates(course: _Course, contact: _Contact) -> tuple[float, float]:
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
def _normal_rate(course: _Course, contact: _Contact) -> float:
    """Return the derivative of the normal impulse by `fade`."""
    size = math.sqrt(course.along * course.along + course.down * course.down)
    fade = course.fade * course.fade
    return -2.0 * (fade * fade) * (size / contact.friction)


@kernel
def _derivatives(course: _Course, contact: _Contact, landing: bool) -> _Course:
    """Return the derivatives by the speed of approach (`landing`), or else by `fade`."""
    size = math.sqrt(course.along * course.along + course.down * course.down)
    rate_n, rate_t = _cloth_rates(course, contact)
    normal = _normal_rate(course, contact)
    factor = -1.0 / ((1.0 + rate_n) * normal) if landing else 1.0
    normal *= factor
    turning = factor / course.fade
    pull = size / contact.friction
    return _Course(
        factor,
        normal,
        2.0 * turning * (course.along + pull * rate_t),
        5.0 * turning * (pull * rate_n),
        rate_n * normal,
        rate_t * normal,
        course.cloth_n * normal,
    )


@kernel
def _plus(course: _Course, h: float, slope: _Course) -> _Course:
    return _Course(
        course.fade + h * slope.fade,
        course.normal + h * slope.normal,
        course.along + h * slope.along,
        course.down + h * slope.down,
        course.cloth_n + h * slope.cloth_n,
        course.cloth_t + h * slope.cloth_t,
        course.cloth_work + h * slope.cloth_work,
    )


@kernel
def _step(course: _Course, contact: _Contact, h: float, landing: bool) -> tuple[_Course, float]:
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

    error = _plus(_Course(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), h * (71.0 / 57600.0), k1)
    error = _plus(_plus(error, h * (-71.0 / 16695.0), k3), h * (71.0 / 1920.0), k4)
    error = _plus(_plus(error, h * (-17253.0 / 339200.0), k5), h * (22.0 / 525.0), k6)
    error = _plus(error, h * (-1.0 / 40.0), k7)
    return end, _relative(error, end, contact)


@kernel
def _relative(error: _Course, end: _Course, contact: _Contact) -> float:
    """Return the largest error in units of what is allowed.

    An error of the normal impulse only shifts friction along the course: it counts by what friction
    does meanwhile. Where the slip is large, the impulse has rounding of the size of its own steps.
    """
    part = end.fade * end.fade
    part *= part
    slip = abs(end.along) + abs(end.down)
    slipping = part * (
        end.fade * (abs(error.along) + abs(error.down)) + 5.0 * slip * abs(error.fade)
    )
    holding = max(abs(error.cloth_n), abs(error.cloth_t), abs(error.cloth_work))
    shifting = contact.friction * abs(error.normal)
    return max(slipping, holding, shifting) / (ACCURACY * contact.reach)

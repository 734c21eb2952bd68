"""Ball-ball impacts integrated over the impulse, with the friction of the cloth during the impact.

Mathavan, Jackson and Parkin (2014), "Numerical simulations of the frictional collisions of solid
balls on a rough surface", Sports Engineering 17, doi 10.1007/s12283-014-0158-y.

Friction between the balls presses one of them on the cloth, the one whose surface goes up against
the other's; the cloth's friction then acts on that ball while the impact lasts. The other ball is
lifted, and its vertical velocity counts in the slip between the balls. Which ball is pressed can't
change during an impact: the vertical slip shrinks in proportion to itself. So the equations
(`_mathavan2014_steps`) are written once, for b as the pressed ball.
"""

from __future__ import annotations

import math

from engine.core.kernel import kernel
from engine.core.state import Laws
from engine.impacts.laws._mathavan2014_steps import (
    ACCURACY,
    STEP_ROUNDING,
    Contact,
    Course,
    cloth_rates,
    normal_rate,
    rubbed,
    slip_of,
    speed_of,
    take_step,
)
from engine.impacts.laws.ball_frictional import contact_slip, frictional, length
from engine.impacts.laws.friction_curve import friction_coefficient
from engine.impacts.laws.interface import BallImpact, BallImpulse

STUCK = 1e-10
"""Slip between the balls, in the units of `ACCURACY`, that counts as ended."""

ROLLS = 16.0 * ACCURACY
"""Slip on the cloth, in these units too, that counts as none: the error of a few steps."""

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
100 where the slip ends, and the worst of 55 000 random ones with any coefficients took 480. Beyond
it the result is NaN, which fails the run."""

MOST_LANDINGS = 4
"""Last steps of a phase, each of which corrects the one before; three reach rounding."""

ROUNDING = 2.0**-51
"""Speed, in units of the approach, that is the rounding of a speed."""


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

    As in the paper, the slip between the balls has the vertical velocity of the lifted one in it.
    Codes of this law often leave it out, which turns the object ball of the paper's shots 0.02
    degrees away from the printed angles.

    Three details are ours:

    - The slip on the cloth is that of the lowest point, v + w x (-R z). The algorithm is usually
      written with the slip of the highest, (v_x + R w_y, v_y - R w_x), on which friction could feed
      the ball. The printed numbers can't tell the two apart.
    - Slip between the balls that reaches zero stays zero.
    - A coefficient between the balls that depends on the speed is that of the slip before the
      impact, for which the curve was fitted.

    The cloth keeps the pressed ball from moving down, so that between equal masses vertical slip
    ends after an impulse of 1/3 of it, not 2/7. What the lifted ball has of vertical velocity is
    dropped after the impact, as in `frictional`, which takes energy and never gives any. Without
    vertical slip, or without friction, the cloth takes no part: this is then `frictional`.

    Contract: coefficients within the limits that the registry names; no allocation; a bounded
    number of steps. Turning the frame by half a turn and
    exchanging the balls gives the same bits, and so does the mirror image.
    """
    approach = impact.a_vn - impact.b_vn
    slip_along, slip_up = contact_slip(impact)
    slip = length(slip_along, slip_up)
    friction = friction_coefficient(laws, slip)
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
    slip = length(slip_along, slip_up)
    reach = min(friction * (1.0 + restitution), slip / approach)
    contact = Contact(
        slip_along / approach,
        -slip_up / approach,
        (impact.b_vn - turning_t) / approach,
        (impact.b_vt + turning_n) / approach,
        share,
        2.5 + impact.b_mass / (impact.a_mass + impact.b_mass),  # both turn, and a rises
        friction,
        impact.b_cloth * share,
        restitution,
        reach,
        ACCURACY * reach + STEP_ROUNDING * ((slip + own) / approach),
        ROLLS * reach + ROLLING_ROUNDING * (own / approach),
    )
    course = _collide(contact)
    along, down = rubbed(course, contact)
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
def _collide(contact: Contact) -> Course:
    """Return where the course ends: after compression, then restitution."""
    start = Course(1.0, 0.0, contact.slip_along, contact.slip_down, 0.0, 0.0, 0.0)
    course = start
    wanted = -1.0  # compression
    for _ in range(2):
        start, course = course, _run_phase(course, wanted, contact)
        wanted = contact.restitution * contact.restitution * _work(start, course)
    return course


@kernel
def _run_phase(start: Course, wanted: float, contact: Contact) -> Course:
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
        if slip_of(course) <= STUCK * contact.reach:
            course = _stuck(course)
            break
        gain = 1.0 + cloth_rates(course, contact)[0]
        left = _left(start, course, wanted, gain)
        if abs(left) <= ROUNDING or landings == MOST_LANDINGS:
            break
        whole = -left / (gain * normal_rate(course, contact) * course.fade)
        landing = abs(whole) <= min(longest, LONGEST_LANDING)
        part = whole if landing else max(-longest, min(longest, 0.9 * whole))
        step = -left if landing else -part * course.fade
        trial, error = take_step(course, contact, step, landing)
        longest = min(abs(part) * _growth(error), LONGEST_STEP)
        if error <= 1.0:
            course = trial
            landings += landing
    else:
        return _pushed(course, math.nan)
    return _pushed(course, _left(start, course, wanted, 1.0))


@kernel
def _left(start: Course, course: Course, wanted: float, gain: float) -> float:
    """Return by how much the speed of approach has to fall until the phase ends.

    Compression (`wanted` negative) ends when the balls don't approach; restitution, when the normal
    force has returned the wanted work. That goes with the square of the speed, but for what the
    cloth does to it meanwhile, which `gain`, the fall of the speed per normal impulse, foresees.
    """
    speed = speed_of(course)
    if wanted < 0.0:
        return speed
    missing = wanted + _work(start, course)
    return speed + math.sqrt(max(speed * speed + 2.0 * gain * missing, 0.0))


@kernel
def _work(before: Course, after: Course) -> float:
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
def _pushed(course: Course, normal: float) -> Course:
    """Return the course with more normal impulse, and nothing else."""
    return Course(
        course.fade,
        course.normal + normal,
        course.along,
        course.down,
        course.cloth_n,
        course.cloth_t,
        course.cloth_work + course.cloth_n * normal,
    )


@kernel
def _stuck(course: Course) -> Course:
    """Return the course without slip between the balls."""
    return Course(
        course.fade, course.normal, 0.0, 0.0, course.cloth_n, course.cloth_t, course.cloth_work
    )

"""Ball-ball impacts integrated over the impulse, with the friction of the cloth during the impact.

Mathavan, Jackson and Parkin (2014), "Numerical simulations of the frictional collisions of solid
balls on a rough surface", Sports Engineering 17, doi 10.1007/s12283-014-0158-y.

Friction between the balls pushes one of them onto the cloth, the one whose surface goes up against
the other's; the cloth's friction then acts on that ball while the impact lasts. The other ball is
lifted, and its vertical velocity counts in the slip between the balls. Which ball that is can't
change during an impact: the vertical slip shrinks in proportion to itself. So the equations are
written once, for b as the ball on the cloth.
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Laws
from ghostball.engine.impacts.laws.ball_frictional import contact_slip, frictional, length
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.impacts.laws.impulse_integrator import integrate
from ghostball.engine.impacts.laws.interface import BallImpact, BallImpulse
from ghostball.engine.impacts.laws.two_contacts import Model, Slips

NEGLIGIBLE = 2.0**-56
"""Approach in units of all the speeds, or friction, so small that rounding hides the cloth."""


@kernel
def mathavan2014(impact: BallImpact, laws: Laws) -> BallImpulse:
    """Return the impulses of an impact during which the ball on the cloth rubs on it.

    `impact`: the balls just before, approaching each other.
    `laws`: `ball_restitution`, and `ball_friction` or `speed_dependent`, are used; the cloth's
        coefficients are the balls' own.

    Returns within 1e-7 of the speed of approach, and of the rounding of the other speeds.

    Mathavan, Jackson and Parkin (2014), generalised to balls of different radii and masses. Over
    each element of the normal impulse friction acts against the slip between the balls, and the
    cloth against the slip of the ball on it. Compression ends when the balls no longer approach;
    restitution ends when the normal force has returned e^2 of the work that it stored (Stronge).

    As in the paper, the slip between the balls has the vertical velocity of the lifted one in it.
    Codes of this law often leave it out, which turns the object ball of the paper's shots 0.02
    degrees away from the printed angles.

    Three details are ours:

    - The slip on the cloth is that of the lowest point, v + w x (-R z). The algorithm is usually
      written with the slip of the highest, (v_x + R w_y, v_y - R w_x), on which friction could feed
      the ball. The printed numbers can't distinguish the two.
    - Slip between the balls that reaches zero stays zero.
    - A coefficient between the balls that depends on the speed is that of the slip before the
      impact, for which the curve was fitted.

    The cloth keeps the ball on it from moving down, so that between equal masses vertical slip
    ends after an impulse of 1/3 of it, not 2/7. What the lifted ball has of vertical velocity is
    dropped after the impact, as in `frictional`, which takes energy and never gives any. Without
    vertical slip, or without friction, the cloth takes no part: this is then `frictional`.

    Contract: coefficients within the limits in `model.impact_laws`; no allocation; a bounded
    number of steps. Turning the frame by half a turn and exchanging the balls gives the same bits,
    and so does the mirror image.
    """
    approach = impact.a_vn - impact.b_vn
    slip_along, slip_up = contact_slip(impact)
    slip = length(slip_along, slip_up)
    friction = friction_coefficient(laws, slip)
    speeds = slip + abs(impact.a_vn) + abs(impact.b_vn)
    if not friction > NEGLIGIBLE or slip_up == 0.0 or not approach > NEGLIGIBLE * speeds:
        return frictional(impact, laws)
    b_on_table = slip_up < 0.0
    done = _press_b(impact if b_on_table else _turned(impact), friction, laws.ball_restitution)
    if b_on_table:
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
    """Return the impulses of an impact in which b is the ball on the cloth.

    Across the cloth's plane, the slip of a's surface over b's is down. b alone is moved along by
    the cloth, and a alone is moved up.
    """
    approach = impact.a_vn - impact.b_vn
    slip_along, slip_up = contact_slip(impact)
    # Of b in the change of the relative velocity: the reduced mass over b's mass.
    share = impact.a_mass / (impact.a_mass + impact.b_mass)
    turning_n, turning_t = impact.b_radius * impact.b_wn, impact.b_radius * impact.b_wt
    own = abs(impact.b_vn) + abs(impact.b_vt) + abs(turning_n) + abs(turning_t)
    start = Slips(
        -slip_up / approach,
        slip_along / approach,
        (impact.b_vn - turning_t) / approach,
        (impact.b_vt + turning_n) / approach,
        0.0,
    )
    model = Model(
        friction=friction,
        cloth_friction=impact.b_cloth * share,
        load=0.0,
        load_across=-1.0,
        restitution=restitution,
        speed=-1.0,
        speed_across=0.0,
        speed_cloth=-1.0,
        push_across=0.0,
        push_n=share,
        across=3.5 - share,
        across_cloth=-2.5,
        along_cloth=-1.0,
        n_across=-2.5 * share,
        t_along=-share,
        start=start,
    )
    speeds = (abs(slip_along) + abs(slip_up) + own) / approach
    done = integrate(model, speeds)
    return BallImpulse(
        approach * (done.normal + max(done.speed, 0.0)),  # to the rounding of its end
        -approach * done.friction.along,
        approach * done.friction.across,
        0.0,
        0.0,
        approach * done.friction.n,
        approach * done.friction.t,
    )

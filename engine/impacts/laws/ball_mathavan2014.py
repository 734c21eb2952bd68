"""Ball-ball impacts integrated over the impulse, with the friction of the cloth during the impact.

Mathavan, Jackson and Parkin (2014), "Numerical simulations of the frictional collisions of solid
balls on a rough surface", Sports Engineering 17, doi 10.1007/s12283-014-0158-y.

Friction between the balls presses one of them onto the cloth: the ball whose surface moves up
against the other's. The cloth's friction acts on this ball during the impact. The other ball is
lifted, and its vertical velocity contributes to the slip between the balls. The two balls can't
exchange these roles during an impact, because the vertical slip decreases in proportion to itself.
So the equations are written once, with b as the ball on the cloth.
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Laws
from ghostball.engine.impacts.laws.ball_frictional import contact_slip, frictional
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.impacts.laws.impulse_integrator import integrate
from ghostball.engine.impacts.laws.interface import BallImpact, BallImpulse, BallInFrame
from ghostball.engine.impacts.laws.two_contacts import Model, Slips
from ghostball.engine.motion.geometry import speed_of

NEGLIGIBLE = 2.0**-56
"""Approach speed relative to all speeds, or friction, below which rounding hides the cloth."""


@kernel
def mathavan2014(impact: BallImpact, laws: Laws) -> BallImpulse:
    """Return the impulses of an impact with friction between the cloth and the ball on it.

    `impact`: the balls just before, approaching each other.
    `laws`: `ball_restitution`, and `ball_friction` or `speed_dependent`, are used; the cloth's
        coefficients are the balls' own.

    The error is below 1e-7 of the approach speed, plus the rounding of the other speeds.

    Mathavan, Jackson and Parkin (2014), generalised to balls of different radii and masses. During
    each element of the normal impulse, friction acts against the slip between the balls, and the
    cloth's friction against the slip of the ball on it. Compression ends when the balls no longer
    approach; restitution ends when the normal force has returned e^2 of the work that it stored
    (Stronge).

    As in the paper, the slip between the balls includes the vertical velocity of the lifted ball.
    Implementations of this law often omit it, which turns the object ball of the paper's shots 0.02
    degrees away from the printed angles.

    Three details differ from other implementations:

    - The slip on the cloth is that of the lowest point, v + w x (-R z). The algorithm is usually
      written with the slip of the highest point, (v_x + R w_y, v_y - R w_x), with which friction
      could add energy to the ball. The printed numbers can't distinguish the two.
    - Slip between the balls that reaches zero stays zero.
    - A speed-dependent coefficient between the balls is that of the slip before the impact, for
      which the curve was fitted.

    The cloth keeps the ball on it from moving down, so between equal masses vertical slip ends
    after an impulse of 1/3 of the slip, not 2/7. The vertical velocity of the lifted ball is
    dropped after the impact, as in `frictional`, which removes energy and never adds any. Without
    vertical slip, or without friction, the cloth has no effect, and the law equals `frictional`.

    Contract: coefficients within the limits in `model.impact_laws`; no allocation; a bounded
    number of steps. The results are bit-identical if the balls are exchanged and the frame is
    turned by half a turn, and in the mirror image.
    """
    approach = impact.a.vn - impact.b.vn
    slip_along, slip_up = contact_slip(impact)
    slip = speed_of(slip_along, slip_up)
    friction = friction_coefficient(laws, slip)
    speeds = slip + abs(impact.a.vn) + abs(impact.b.vn)
    if not friction > NEGLIGIBLE or slip_up == 0.0 or not approach > NEGLIGIBLE * speeds:
        return frictional(impact, laws)
    b_on_table = slip_up < 0.0
    done = _press_b(
        impact if b_on_table else BallImpact(_turned(impact.b), _turned(impact.a)),
        friction,
        laws.ball_restitution,
    )
    if b_on_table:
        return done
    return BallImpulse(
        done.normal, done.along, -done.up, -done.b_cloth_n, -done.b_cloth_t, 0.0, 0.0
    )


@kernel
def _turned(ball: BallInFrame) -> BallInFrame:
    """Return the ball in a frame that is turned by half a turn about the vertical."""
    return BallInFrame(
        -ball.vn, -ball.vt, -ball.wn, -ball.wt, ball.wz, ball.radius, ball.mass, ball.cloth
    )


@kernel
def _press_b(impact: BallImpact, friction: float, restitution: float) -> BallImpulse:
    """Return the impulses of an impact in which b is the ball on the cloth.

    "Across" is vertical: the slip of a's surface over b's, positive down. The cloth moves only b
    along its plane, and only a moves up.
    """
    approach = impact.a.vn - impact.b.vn
    slip_along, slip_up = contact_slip(impact)
    # The part of b in a change of the relative velocity: the reduced mass over b's mass.
    share = impact.a.mass / (impact.a.mass + impact.b.mass)
    turning_n, turning_t = impact.b.radius * impact.b.wn, impact.b.radius * impact.b.wt
    own = abs(impact.b.vn) + abs(impact.b.vt) + abs(turning_n) + abs(turning_t)
    start = Slips(
        -slip_up / approach,
        slip_along / approach,
        (impact.b.vn - turning_t) / approach,
        (impact.b.vt + turning_n) / approach,
        0.0,
        0.0,
    )
    model = Model(
        friction=friction,
        cloth_friction=impact.b.cloth * share,
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
        approach * (done.normal + max(done.speed, 0.0)),  # corrects the rounding of the end
        -approach * done.friction.along,
        approach * done.friction.across,
        0.0,
        0.0,
        approach * done.friction.n,
        approach * done.friction.t,
    )

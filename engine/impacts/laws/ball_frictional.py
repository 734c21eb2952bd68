"""The ball law "frictional": restitution along the line of centres, Coulomb friction across it."""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Laws
from ghostball.engine.impacts.laws.friction_curve import friction_coefficient
from ghostball.engine.impacts.laws.interface import BallImpact, BallImpulse
from ghostball.engine.motion.geometry import speed_of

STICKING = 2.0 / 7.0
"""Impulse, over the reduced mass, that ends a slip of 1.

An impulse at the surface of a solid sphere changes the velocity of the surface 7/2 times as much as
that of the centre.
"""


@kernel(inline=True)
def frictional(impact: BallImpact, laws: Laws) -> BallImpulse:
    """Return the impulse of an impact with restitution and Coulomb friction between the balls.

    `impact`: the balls just before, approaching each other.
    `laws`: `ball_restitution`, and `ball_friction` or `speed_dependent` are used.

    Returns impulses over the reduced mass [m/s]; the cloth takes no part.

    Wallace and Schroeder (1988, Am. J. Phys. 56, 815); Alciatore, technical proof A.14: the normal
    impulse is (1 + e) times the approach speed, and friction acts against the slip of the surfaces.
    Friction is mu times the normal impulse, but at most 2/7 of the slip, because 2/7 end the slip.
    The coefficient mu depends on the slip before the impact.

    Friction ends a vertical slip as if the balls were free to rise. The vertical velocities of the
    balls are dropped after the impact, which never adds energy; 2/7 of the vertical slip is left.

    Contract: no allocation. Without friction the tangential components are 0.
    """
    normal = (1.0 + laws.ball_restitution) * (impact.a.vn - impact.b.vn)
    slip_along, slip_up = contact_slip(impact)
    slip = speed_of(slip_along, slip_up)
    if slip == 0.0:
        return BallImpulse(normal, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    part = min(friction_coefficient(laws, slip) * normal / slip, STICKING)
    return BallImpulse(normal, part * slip_along, part * slip_up, 0.0, 0.0, 0.0, 0.0)


@kernel
def contact_slip(impact: BallImpact) -> tuple[float, float]:
    """Return the slip of a's surface over b's at the contact, along t and up [m/s]."""
    along = (impact.a.vt - impact.b.vt) + (
        impact.a.radius * impact.a.wz + impact.b.radius * impact.b.wz
    )
    up = -(impact.a.radius * impact.a.wt + impact.b.radius * impact.b.wt)
    return along, up

"""A cushion law that integrates over the impulse, with friction at the nose and at the cloth.

Mathavan, S., Jackson, M. R. and Parkin, R. M. (2010): A theoretical analysis of billiard ball
dynamics under cushion impacts. Proc. IMechE C, J. Mechanical Engineering Science 224(9), 1863-1873.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.impulse_integrator import integrate
from ghostball.engine.impacts.laws.interface import BallInFrame, Cushion, CushionBounce
from ghostball.engine.impacts.laws.two_contacts import Model, Slips

# Below either approach speed the ball only bounces, because the effect of friction is rounded away.
_LEAST = 1e-140  # [m/s]; the squares of smaller speeds underflow
_GRAZING = 1e-13  # relative to the sum of all speeds


@kernel
def mathavan2010(impact: BallInFrame, cushion: Cushion) -> CushionBounce:
    """Return the bounce off a nose at its height, by Mathavan's law.

    `impact`: the ball when it touches the cushion [m/s, rad/s, m, kg]; the mass cancels. `cloth` is
        the coefficient of friction between ball and cloth.
    `cushion`: `restitution` in [0, 1], `friction` >= 0, and `height`, above the cloth and below the
        top of the ball [m].

    Returns the ball after the impact [m/s, rad/s]. If the limit of steps is ever reached, the
    numbers are NaN, which the engine reports.

    Contract: no allocation; a bounded number of steps; energy does not increase; vn <= 0
    afterwards; bit-identical if mirrored along the cushion, or with speeds times a power of two.

    The paper's equations of motion with x = -t and y = n, in the impulse of the nose. The nose
    pushes along its normal and rubs against the slip of the ball. The ball stays on the cloth; this
    determines the load on the cloth, which rubs, too. Compression ends when vn = 0; the rebound
    ends when the nose has returned e^2 of the work that it took. The paper leaves three points
    open:

    - A slip that has ended stays 0 while friction can hold it, and starts again if it can't. The
      paper's ratio of components is undefined there, and a fixed step chatters.
    - The cloth can't pull. If the nose lifts the ball (topspin, a nose below mid-ball), the load
      would be negative and the cloth would drive the slip. Load and friction are 0 then.
    - A ball may jam: either both contacts can hold it (coefficients of at least
      cosine / (1 + sine) of the angle of the nose), or the cloth's friction outweighs the push of
      the nose as the ball leaves. Then the impact ends with vn = 0, and the stored work is lost.

    Energy: both frictions remove energy, vertical forces do no work, and the nose returns at most
    the work that it took.

    Accuracy: 1e-7 of the sum of all speeds, and mostly 1e-8 of the approach speed. This doesn't
    hold for a cloth's coefficient above 1: the friction that would hold the nose then loads the
    cloth so much that the slip grows instead, and the result depends on the compliance of the
    contacts.
    """
    radius, vn = impact.radius, impact.vn
    speeds = vn + abs(impact.vt) + radius * (abs(impact.wn) + abs(impact.wt) + abs(impact.wz))
    if vn < _LEAST or vn < _GRAZING * speeds:
        vn = -cushion.restitution * vn
        return CushionBounce(vn, impact.vt, impact.wn, impact.wt, impact.wz, 0.0)
    # theta is the angle of the nose above n, seen from the centre. Across t, the slip at the nose
    # is positive towards the cushion and down.
    sine = (cushion.height - impact.radius) / impact.radius
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    cross = 1.0 - 2.5 * sine
    start = Slips(
        sine + radius * impact.wt / vn,
        (impact.vt + radius * (impact.wz * cosine - impact.wn * sine)) / vn,
        1.0 - radius * impact.wt / vn,
        (impact.vt + radius * impact.wn) / vn,
        0.0,
        0.0,
    )
    model = Model(
        friction=cushion.friction,
        cloth_friction=impact.cloth,
        load=sine,
        load_across=cosine,
        restitution=cushion.restitution,
        speed=-cosine,
        speed_across=sine,
        speed_cloth=1.0,
        push_across=-sine * cosine,
        push_n=-cosine,
        across=2.5 + sine * sine,
        across_cloth=sine - 2.5,
        along_cloth=cross,
        n_across=sine - 2.5,
        t_along=cross,
        start=start,
    )
    done = integrate(model, speeds / vn)
    friction, turn = done.friction, 2.5 * vn / radius  # m R / I
    return CushionBounce(
        min(vn * done.speed, 0.0),
        impact.vt + vn * (friction.along + friction.t),
        impact.wn + turn * (friction.t - sine * friction.along),
        impact.wt + turn * (friction.across - friction.n),
        impact.wz + turn * (cosine * friction.along),
        0.0,  # the cloth has taken the vertical impulse during the impact
    )

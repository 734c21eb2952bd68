"""The cushion laws "han2005", "stronge2000" and "frictional": restitution and friction at the nose.

In the first two laws the contact is at the height of the nose; in "frictional" it is at mid-ball.
In "stronge2000" the contact yields along the slip.

Han, I. (2005): Dynamics in carom and three cushion billiards. Journal of Mechanical Science and
Technology 19(4), 976-984.
Stronge, W. J. (2000): Impact Mechanics. Cambridge University Press, chapter 5.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.impacts.laws.compliant_contact import compliant_share
from ghostball.engine.impacts.laws.interface import BallInFrame, Cushion, CushionBounce


@kernel
def han2005(impact: BallInFrame, cushion: Cushion) -> CushionBounce:
    """Return the bounce off a nose at its height, by Han's law, or by Stronge's model.

    `impact`: the ball when it touches the cushion [m/s, rad/s, m, kg]; the mass cancels.
    `cushion`: `restitution` in [0, 1], `friction` >= 0, and `height`, above the cloth and below the
        top of the ball [m]; `ratio` is 0 for Han's law. For Stronge's model of a contact that
        yields, `ratio` in (1, 2) is the frequency of the spring along the slip over that of the
        normal spring.

    Returns the ball after the impact [m/s, rad/s].

    Contract: no allocation; energy does not increase; vn <= 0 afterwards; mirrored along the
    cushion, the result is mirrored to the bit.

    Stronge's model differs by the tangential impulse only: the rubber stores energy along the slip
    as well, and returns it (`compliant_contact`). A stiff contact along the slip isn't the limit of
    a large ratio: for a ratio of 2 or more, the contact may slip and stick several times, and the
    formulas don't hold.

    Han's equations, with these corrections of printing errors: the normal impulse whose friction mu
    just ends the slip s is |s| / (mu A), with A = 7 / (2 m); the sign of c in equation 14; the
    second factor of the impulse along n in equation 21, which is a cosine. As in the paper, the
    vertical impulse turns the ball, and a ball on the cloth loses its vertical velocity.

    Energy: in free space the impact loses energy, because the closing speed at the nose is
    multiplied by -e, and the friction, at most that which stops the slip, works against the slip.
    Dropping the vertical velocity removes more. So energy can't increase, whatever the height,
    friction and spin.

    Upper bound on vn: Han's vn afterwards is vn (sin^2 - e cos^2) - P sin, where P is the friction
    at the nose over the mass, upwards positive. It is positive, so that the ball still approaches,
    if the nose is far from mid-ball (without friction: if sin^2 > e / (1 + e), a sine of 0.68 for
    e = 0.85), or if backspin under a high nose (or topspin against a low one) pulls the ball in.
    Dropping the vertical velocity has then closed the contact again: ball and nose are wedged
    against the cloth, and the impact continues. Repeating it without friction stops the ball, in a
    geometric series. The bound, vn at most 0, is that limit. The further impulse acts through the
    centre and turns nothing, the cloth bears its vertical part, and it removes energy.
    """
    sine = (cushion.height - impact.radius) / impact.radius
    return bounce_off_nose(impact, cushion, sine)


@kernel
def frictional(impact: BallInFrame, cushion: Cushion) -> CushionBounce:
    """Return the bounce off a nose at the height of the ball's centre: `han2005` with angle 0.

    `impact`: the ball when it touches the cushion [m/s, rad/s, m, kg]; the mass cancels.
    `cushion`: `restitution` in [0, 1] and `friction` >= 0.

    Returns the ball after the impact [m/s, rad/s]; vn is exactly -e times its value before.

    Contract: as for `han2005`.
    """
    return bounce_off_nose(impact, cushion, 0.0)


@kernel
def bounce_off_nose(impact: BallInFrame, cushion: Cushion, sine: float) -> CushionBounce:
    """Return the bounce off a nose at an angle with this sine above n, seen from the centre.

    With `cushion.ratio` > 0 the contact yields along the slip, see `compliant_contact`.

    Speeds and impulses over the mass are in [m/s]; "down" is the tangent of the ball at the nose in
    the plane of n and z, (sine, -cosine).
    """
    cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
    radius, e = impact.radius, cushion.restitution
    slip_down = impact.vn * sine + radius * impact.wt
    slip_along = impact.vt + radius * (impact.wz * cosine - impact.wn * sine)
    slip = math.sqrt(slip_down * slip_down + slip_along * slip_along)
    closing = cosine * impact.vn
    if cushion.ratio > 0.0 and closing > 0.0:
        share = compliant_share(slip / closing, cushion.friction, e, cushion.ratio)
    else:
        most = cushion.friction * ((1.0 + e) * closing)
        # 2/7 of the slip stops it: the effective mass at a sphere's surface is 2/7 of its mass.
        share = 2.0 / 7.0 if slip * (2.0 / 7.0) <= most else most / slip
    down, along = -share * slip_down, -share * slip_along
    # Grouped so that mid-ball gives exactly -e: vn - (1 + e) vn cosine^2 = vn (sine^2 - e cosine^2)
    vn = impact.vn * (sine * sine - e * (cosine * cosine)) + down * sine
    turn = 2.5 / radius  # m R / I
    return CushionBounce(
        min(vn, 0.0),
        impact.vt + along,
        impact.wn - turn * (along * sine),
        impact.wt + turn * down,
        impact.wz + turn * (along * cosine),
        -(1.0 + e) * (sine * cosine * impact.vn) - down * cosine,
    )

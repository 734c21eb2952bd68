"""The signature of all laws of ball-ball impacts, and that of all laws of ball-cushion impacts.

Both use a right-handed frame in space: n, the unit normal of the contact; t = z x n, along the
contact; and up, n x t, which is z for contacts between balls on the cloth, or with a cushion. A law
gets numbers in this frame, without table, time or other balls. It returns the effect of the impact
along all three axes. `impacts.impact` ensures that an upward impulse doesn't lift a ball on the
cloth.

    ball law     (BallImpact, Laws) -> BallImpulse
    cushion law  (BallInFrame, Cushion) -> CushionBounce

Contract of every law: no allocation, no raising; only + - * / and square roots; energy does not
increase; the contact doesn't approach afterwards.
"""

from __future__ import annotations

from typing import NamedTuple


class BallInFrame(NamedTuple):
    """A ball just before an impact, in the frame of the contact.

    In an impact with a cushion, n points into the cushion, and the ball approaches: vn > 0.
    """

    vn: float  # velocity [m/s]
    vt: float
    wn: float  # angular velocity [rad/s]
    wt: float
    wz: float
    radius: float  # [m]
    mass: float  # [kg]
    cloth: float  # coefficient of sliding friction between ball and cloth


class BallImpact(NamedTuple):
    """Balls a and b that touch and approach; n points from a to b.

    The slip of a's surface over b's is va - vb + (ra wa + rb wb) x n:
    along t: a.vt - b.vt + a.radius a.wz + b.radius b.wz; up: -(a.radius a.wt + b.radius b.wt).
    """

    a: BallInFrame
    b: BallInFrame


class BallImpulse(NamedTuple):
    """The impulses of an impact.

    First the impulse on b through the contact (its opposite acts on a), over the reduced mass
    [m/s]; it changes velocities and spins. Then the impulse of the cloth on each ball during the
    impact, over the mass of the ball [m/s], which acts at the ball's lowest point; 0 if the law
    ignores the cloth.
    """

    normal: float  # along n, never negative
    along: float  # along t
    up: float  # along z
    a_cloth_n: float
    a_cloth_t: float
    b_cloth_n: float
    b_cloth_t: float


class Cushion(NamedTuple):
    """The coefficients of an obstacle, and the height of its nose."""

    restitution: float  # in [0, 1]
    tangential: float  # factor on the tangential velocity
    friction: float
    height: float  # above the cloth [m]
    ratio: float  # frequency of the spring along the slip over the normal spring's; 0: it is rigid


class CushionBounce(NamedTuple):
    """The ball's velocity [m/s] and angular velocity [rad/s] after the impact; vn <= 0.

    `up` is the impulse of the cushion along z, over the mass [m/s], minus the part that the law
    itself transfers to the cloth. The engine drops it, because the ball stays on the cloth.
    """

    vn: float
    vt: float
    wn: float
    wt: float
    wz: float
    up: float

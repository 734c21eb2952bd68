"""The one signature of the laws of ball-ball impacts, and the one of ball-cushion impacts.

Both work in a right-handed frame in space: n, the unit normal of the contact; t = z x n, along the
contact; and up, n x t, which is z as long as the contact is between balls on the cloth, or with a
cushion. A law sees numbers in that frame and knows of no table, no time and no other ball. It
returns what the impact does along all three. That an impulse up doesn't lift a ball isn't the law's
business: see `impacts.impact`.

    ball law     (BallImpact, Laws) -> BallImpulse
    cushion law  (CushionImpact, Cushion) -> CushionBounce

Contract of every law: no allocation, no raising; only + - * / and square roots; energy does not
rise; the contact doesn't approach afterwards.
"""

from __future__ import annotations

from typing import NamedTuple


class BallImpact(NamedTuple):
    """Balls a and b that touch and approach; n from a to b. Each ball about its own centre.

    The slip of a's surface over b's is va - vb + (ra wa + rb wb) x n:
    along t: a_vt - b_vt + a_radius a_wz + b_radius b_wz; up: -(a_radius a_wt + b_radius b_wt).
    """

    a_vn: float  # velocity [m/s]
    a_vt: float
    a_wn: float  # angular velocity [rad/s]
    a_wt: float
    a_wz: float
    a_radius: float  # [m]
    a_mass: float  # [kg]
    a_cloth: float  # coefficient of sliding friction between ball and cloth
    b_vn: float
    b_vt: float
    b_wn: float
    b_wt: float
    b_wz: float
    b_radius: float
    b_mass: float
    b_cloth: float


class BallImpulse(NamedTuple):
    """What the impact does.

    The impulse on b through the contact, and its opposite on a, over the reduced mass [m/s]; it
    turns the balls as well as moves them. And the impulse of the cloth on each ball during the
    impact, over the ball's own mass [m/s], which acts at the ball's lowest point; 0 where the law
    leaves the cloth out.
    """

    normal: float  # along n, never negative
    along: float  # along t
    up: float  # along z
    a_cloth_n: float
    a_cloth_t: float
    b_cloth_n: float
    b_cloth_t: float


class CushionImpact(NamedTuple):
    """A ball that touches a cushion and approaches it (vn > 0); n points into the cushion."""

    vn: float  # velocity [m/s]
    vt: float
    wn: float  # angular velocity [rad/s]
    wt: float
    wz: float
    radius: float  # [m]
    mass: float  # [kg]
    cloth: float  # coefficient of sliding friction between ball and cloth


class Cushion(NamedTuple):
    """The coefficients of what a ball bounces off, and how high its nose is."""

    restitution: float  # in [0, 1]
    tangential: float  # factor on the velocity along it
    friction: float
    height: float  # above the cloth [m]


class CushionBounce(NamedTuple):
    """The ball's velocity [m/s] and angular velocity [rad/s] after; vn <= 0.

    `up` is the impulse of the cushion along z, over the mass [m/s], less what the law itself lets
    the cloth take of it; the engine drops it, since the ball stays on the cloth.
    """

    vn: float
    vt: float
    wn: float
    wt: float
    wz: float
    up: float

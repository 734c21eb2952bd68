"""Ball-ball impacts for tests of impact laws, and the motions after an impulse."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from hypothesis import strategies as st
from shots import R, ball, scene_of

from ghostball.engine.core.state import Laws
from ghostball.engine.impacts.laws.interface import BallImpact, BallImpulse, BallInFrame
from ghostball.engine.running.from_scene import laws_of

EPS = 2.0**-52
POOL_BALL = (R, 0.17, 0.2)
SNOOKER_BALL = (0.02625, 0.1406, 0.21)
REST = (0.0, 0.0, 0.0, 0.0, 0.0)


def laws(restitution: float, friction: float | str) -> Laws:
    scene = scene_of(
        ball((0.0, 0.0)),
        motion="sliding",
        ball_restitution=restitution,
        ball_friction=friction,
    )
    return laws_of(scene)


def impact_of(
    a: Sequence[float],
    b: Sequence[float] = REST,
    ball_a: Sequence[float] = POOL_BALL,
    ball_b: Sequence[float] = POOL_BALL,
) -> BallImpact:
    """Return the impact of motions (vn, vt, wn, wt, wz) and balls (radius, mass, cloth)."""
    return BallImpact(
        BallInFrame(*map(float, (*a, *ball_a))), BallInFrame(*map(float, (*b, *ball_b)))
    )


def shot(cut: float, speed: float, roll: float = 0.0, side: float = 0.0, radius: float = R):
    """Return the motion of ball a at an angle `cut` to the line of centres.

    `roll`: 0 for a ball without horizontal spin, 1 for a rolling ball.
    `side`: side spin R wz divided by the speed.
    """
    n, t = speed * math.cos(cut), speed * math.sin(cut)
    return (n, t, -roll * t / radius, roll * n / radius, side * speed / radius)


class BallVelocities(NamedTuple):
    vn: float
    vt: float
    wn: float
    wt: float
    wz: float

    def rolling(self, radius: float) -> tuple[float, float]:
        """Return the velocity of the ball at the end of its slide."""
        slip_n, slip_t = self.vn - radius * self.wt, self.vt + radius * self.wn
        return self.vn - 2.0 / 7.0 * slip_n, self.vt - 2.0 / 7.0 * slip_t


def after(i: BallImpact, p: BallImpulse) -> tuple[BallVelocities, BallVelocities]:
    """Return both motions after the impulses at the contact and at the lowest points."""
    to_a = i.b.mass / (i.a.mass + i.b.mass)
    to_b = i.a.mass / (i.a.mass + i.b.mass)
    turn_a, turn_b = 2.5 / i.a.radius, 2.5 / i.b.radius
    a = BallVelocities(
        i.a.vn - to_a * p.normal + p.a_cloth_n,
        i.a.vt - to_a * p.along + p.a_cloth_t,
        i.a.wn + turn_a * p.a_cloth_t,
        i.a.wt + turn_a * (to_a * p.up - p.a_cloth_n),
        i.a.wz - turn_a * to_a * p.along,
    )
    b = BallVelocities(
        i.b.vn + to_b * p.normal + p.b_cloth_n,
        i.b.vt + to_b * p.along + p.b_cloth_t,
        i.b.wn + turn_b * p.b_cloth_t,
        i.b.wt + turn_b * (to_b * p.up - p.b_cloth_n),
        i.b.wz - turn_b * to_b * p.along,
    )
    return a, b


def energy(i: BallImpact, a: Sequence[float], b: Sequence[float]) -> float:
    total = 0.0
    for radius, mass, motion in ((i.a.radius, i.a.mass, a), (i.b.radius, i.b.mass, b)):
        vn, vt, wn, wt, wz = motion
        turning = 0.4 * radius * radius * (wn * wn + wt * wt + wz * wz)
        total += 0.5 * mass * (vn * vn + vt * vt + turning)
    return total


def gained(i: BallImpact, p: BallImpulse) -> float:
    return energy(i, *after(i, p)) - energy(i, i.a[:5], i.b[:5])


def _with_speeds_exchanged(i: BallImpact) -> BallImpact:
    return BallImpact(i.a._replace(vn=i.b.vn), i.b._replace(vn=i.a.vn))


def mirrored(i: BallImpact) -> BallImpact:
    """Return the mirror image in the plane of n and z: t changes sign, and so do wn and wz."""
    signs = (1, -1, -1, 1, -1, 1, 1, 1)
    return BallImpact(*(_signed(ball, signs) for ball in i))


def exchanged(i: BallImpact) -> BallImpact:
    """Return the impact with a and b exchanged: the frame rotates by 180 degrees about z."""
    signs = (-1, -1, -1, -1, 1, 1, 1, 1)
    return BallImpact(_signed(i.b, signs), _signed(i.a, signs))


def _signed(ball: BallInFrame, signs: Sequence[int]) -> BallInFrame:
    return BallInFrame(*(sign * x for sign, x in zip(signs, ball, strict=True)))


signed = st.floats(-3.0, 3.0, allow_subnormal=False)  # 5e-324 m/s can't be shared by two balls
motions = st.one_of(
    st.just(REST),
    st.tuples(signed, signed, *[st.floats(-150.0, 150.0)] * 3),
    st.tuples(signed, signed).map(lambda v: (*v, -v[1] / R, v[0] / R, 0.0)),  # rolls
)
balls = st.one_of(
    st.just(POOL_BALL),
    st.tuples(st.floats(0.01, 0.1), st.floats(0.01, 1.0), st.floats(0.0, 0.7)),
)
impacts = (
    st.builds(impact_of, motions, motions, balls, balls)
    .map(lambda i: i if i.a.vn >= i.b.vn else exchanged(i))
    .map(lambda i: i if i.a.vn >= i.b.vn else _with_speeds_exchanged(i))
    .filter(lambda i: i.a.vn > i.b.vn)
)
restitutions = st.sampled_from([0.0, 1e-3, 0.5, 0.95, 1.0])
frictions = st.sampled_from([0.0, 1e-6, 0.03, 0.06, 0.5, 1.0, "alciatore"])
"""Coefficients of friction for which mathavan2014 is valid."""
any_frictions = st.one_of(frictions, st.just(5.0))

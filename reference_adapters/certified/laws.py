"""The impact laws in interval arithmetic, written from the cited equations.

Each ball is given in the frame of its contact: n, the unit normal; t = z x n; z up. Its spin is
given by its slip on the cloth, u = v - d, where R w = z x d + R wz z. So R w has the component d_n
along t and -d_t along n, and an impulse that doesn't turn the ball changes u and v equally.
"""

from __future__ import annotations

from typing import NamedTuple

from flint import arb, fmpq

from ghostball.reference_adapters.certified.arithmetic import (
    ONE,
    ZERO,
    UndecidedError,
    Vector,
    exactly,
    length,
)
from ghostball.reference_adapters.certified.problem import ExactProblem

STICKING = fmpq(2, 7)
"""Impulse over mass and slip that ends a slip: an impulse changes the slip by 7/2 J / m."""

# Alciatore's fit to Marlow's measurements, technical proof A.14: a + b exp(-c v), [1], [1], [s/m].
ALCIATORE = tuple(exactly(number) for number in (9.951e-3, 0.108, 1.088))


class InContactFrame(NamedTuple):
    """A ball at an impact, in the frame of the contact; velocities in m/s."""

    vn: arb
    vt: arb
    un: arb
    ut: arb
    wz: arb  # [rad/s]
    radius: arb  # [m]

    @property
    def dn(self) -> arb:
        """R w along t [m/s]."""
        return self.vn - self.un

    @property
    def dt(self) -> arb:
        """Minus R w along n [m/s]."""
        return self.vt - self.ut


class CushionRestitution:
    """The restitution of cushions of one problem, e0 / (1 + c sqrt(v)) at the approach speed v."""

    def __init__(self, problem: ExactProblem) -> None:
        self._slow = arb(problem.cushion_restitution)
        self._loss = arb(problem.cushion_loss) if problem.cushion_loss > 0.0 else None

    def at(self, speed: arb) -> arb:
        """Return the restitution at an approach speed [m/s].

        Raises `UndecidedError` if it isn't known whether the ball approaches.
        """
        if self._loss is None:
            return self._slow
        if not speed >= 0:
            raise UndecidedError("how fast a ball meets a cushion")
        return self._slow / (1 + self._loss * speed.sqrt())


class ImpactLaws:
    """The impact laws of one problem, with the present precision."""

    def __init__(self, problem: ExactProblem) -> None:
        self._restitution = arb(problem.ball_restitution)
        self._friction = None if problem.ball_friction is None else arb(problem.ball_friction)
        self._rubs = problem.ball_friction != 0.0
        self._alciatore = tuple(arb(number) for number in ALCIATORE)
        self._cushion = problem.cushion
        self._falling = CushionRestitution(problem)
        self._cushion_tangential = arb(problem.cushion_tangential)
        self._cushion_friction = arb(problem.cushion_friction)
        self._height = exactly(problem.cushion_height)
        # The exact fraction of the approach that each ball takes: 1 for equal elastic balls.
        e, masses = exactly(problem.ball_restitution), [exactly(b.mass) for b in problem.balls]
        self._exchange = {
            (m, other): arb((1 + e) * other / (m + other)) for m in masses for other in masses
        }
        self._masses = masses
        self._radii = [exactly(b.radius) for b in problem.balls]

    def collide(
        self, i: int, j: int, a: InContactFrame, b: InContactFrame
    ) -> tuple[InContactFrame, InContactFrame]:
        """Return balls i and j after their impact; n points from i to j.

        Wallace and Schroeder (1988); Alciatore, technical proof A.14: the normal impulse is (1 + e)
        times the approach; friction is at most mu times this, and at most 2/7 of the slip, which
        ends it. Vertical velocities are dropped.
        """
        mi, mj = self._masses[i], self._masses[j]
        to_a, to_b = self._exchange[mi, mj], self._exchange[mj, mi]
        after_a, after_b = _exchanged(a, b, to_a), _exchanged(b, a, to_b)
        if not self._rubs:
            return after_a, after_b
        along = a.vt - b.vt + (a.radius * a.wz + b.radius * b.wz)
        up = -(a.dn + b.dn)
        part = self._part(along, up, a.vn - b.vn)
        along, up = part * along, part * up
        share_a, share_b = arb(mj / (mi + mj)), arb(mi / (mi + mj))
        return (
            _rubbed(after_a, share_a, -along, along, up),
            _rubbed(after_b, share_b, along, along, up),
        )

    def _part(self, along: arb, up: arb, approach: arb) -> arb:
        """Return the impulse of friction over the slip and the reduced mass."""
        slip = length(along, up)
        return capped((1 + self._restitution) * self.friction(slip) * approach, slip)

    def friction(self, slip: arb) -> arb:
        """Return the coefficient of friction between balls at a slip speed [m/s]."""
        if self._friction is not None:
            return self._friction
        least, span, rate = self._alciatore
        return least + span * (-rate * slip).exp()

    def bounce(self, i: int, seen: InContactFrame) -> InContactFrame:
        """Return ball i after an impact with a cushion; n points into the cushion.

        Mirror and restitution: factors on vn and vt, spin unchanged (the paper, 4.2). Han (2005),
        equations 14 to 21 with the misprints corrected; "frictional" is the same law with a nose at
        the height of the centre.
        """
        e = self._falling.at(seen.vn)
        if self._cushion in ("mirror", "restitution"):
            vn, vt = -e * seen.vn, self._cushion_tangential * seen.vt
            return seen._replace(
                vn=vn,
                vt=vt,
                un=seen.un - (1 + e) * seen.vn,
                ut=seen.ut - (1 - self._cushion_tangential) * seen.vt,
            )
        sine, cosine = ZERO, ONE
        if self._cushion == "han2005":
            radius = self._radii[i]
            ratio = (self._height - radius) / radius
            sine = arb(ratio)
            cosine = arb(1 - ratio * ratio).sqrt()
        return self._bounce_off_nose(seen, e, sine, cosine)

    def _bounce_off_nose(
        self, seen: InContactFrame, e: arb, sine: arb, cosine: arb
    ) -> InContactFrame:
        slip_down = seen.vn * sine + seen.dn
        slip_along = seen.vt + seen.radius * seen.wz * cosine + seen.dt * sine
        push = (1 + e) * cosine * seen.vn
        share = capped(self._cushion_friction * push, length(slip_down, slip_along))
        down, along = -share * slip_down, -share * slip_along
        vn = seen.vn * (sine * sine - e * cosine * cosine) + down * sine
        if not vn <= 0:
            # The ball would still approach: wedged between nose and cloth, it stops along n.
            if not vn > 0:
                raise UndecidedError("whether the cushion stops it")
            vn = ZERO
        return InContactFrame(
            vn=vn,
            vt=seen.vt + along,
            un=seen.un + (vn - seen.vn) - 5 * down / 2,
            ut=seen.ut + along - 5 * along * sine / 2,
            wz=seen.wz + 5 * along * cosine / (2 * seen.radius),
            radius=seen.radius,
        )


def _exchanged(own: InContactFrame, other: InContactFrame, part: arb) -> InContactFrame:
    """Return a ball that takes `part` of the difference of the two normal velocities.

    Computed as a mean, so that equal elastic balls swap their speeds exactly.
    """
    vn = (1 - part) * own.vn + part * other.vn
    return own._replace(vn=vn, un=own.un + part * (other.vn - own.vn))


def capped(most: arb, slip: arb) -> arb:
    """Return the impulse of friction over mass and slip: 2/7, which ends the slip, or less.

    `most`: largest impulse of friction over mass [m/s].

    The result increases with `most` and decreases with the slip: if the slip may be 0, interval
    ends give the range.
    """
    limit = arb(STICKING)
    if most.is_zero():
        return ZERO
    if most >= limit * slip:
        return limit
    if most < limit * slip:
        return most / slip
    if slip > 0:
        return arb.min(most / slip, limit)
    least = ZERO
    if slip.upper() > 0 and most > 0:
        least = arb.min(most.lower() / slip.upper(), limit)
    return least.union(limit)


def _rubbed(ball: InContactFrame, share: arb, push: arb, along: arb, up: arb) -> InContactFrame:
    """Return a ball that friction pushes along t and turns; R / I is 5 / (2 m R).

    The turn is the same for both balls, because arm and impulse both change sign.
    """
    return ball._replace(
        vt=ball.vt + share * push,
        un=ball.un - 5 * share * up / 2,
        ut=ball.ut + share * push,
        wz=ball.wz - 5 * share * along / (2 * ball.radius),
    )


def to_contact_frame(
    n: Vector, velocity: Vector, slip: Vector, wz: arb, radius: arb
) -> InContactFrame:
    """Transform a ball to the frame of a contact with the normal n."""
    (nx, ny), (vx, vy), (ux, uy) = n, velocity, slip
    return InContactFrame(
        vn=nx * vx + ny * vy,
        vt=nx * vy - ny * vx,
        un=nx * ux + ny * uy,
        ut=nx * uy - ny * ux,
        wz=wz,
        radius=radius,
    )


def from_contact_frame(n: Vector, seen: InContactFrame) -> tuple[Vector, Vector]:
    """Transform a ball back; return its velocity and its slip."""
    nx, ny = n
    return (
        (nx * seen.vn - ny * seen.vt, ny * seen.vn + nx * seen.vt),
        (nx * seen.un - ny * seen.ut, ny * seen.un + nx * seen.ut),
    )

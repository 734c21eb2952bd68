"""Simultaneous impacts that share balls, by the model's law: they act together.

Balls: (1 + e) times the impulses that just end every approach (Moreau 1988; Smith, Kaufman, Vouga,
Tamstorf and Grinspun 2012, section 4), with friction against the mean of the slips before and
after the impacts; each ball is split among its contacts (Tonge, Benevolenski and Voroshilov 2012).
A ball in a corner bounces off both sides in turn until it leaves both; its motion is the mean over
both orders, with the mean of their energies. `docs/physics.md` describes this model.

The impacts must be proved to be simultaneous: `ties.are_at_once`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from flint import arb, arb_mat

from ghostball.model import EventKind
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    UndecidedError,
    Vector,
    dot,
    exactly,
    length,
    minus,
)
from ghostball.reference_adapters.certified.candidates import Candidate
from ghostball.reference_adapters.certified.gaps import PairGap
from ghostball.reference_adapters.certified.impacts import Impacts, Together, age_of
from ghostball.reference_adapters.certified.laws import (
    InContactFrame,
    capped,
    from_contact_frame,
    to_contact_frame,
)
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.obstacle_gaps import RoundGap, StraightGap
from ghostball.reference_adapters.certified.ties import axis_of_mirror

MAX_CORNER_BOUNCES = 64
"""Largest number of bounces in one corner; after it, the proof ends."""


class _JointContact(NamedTuple):
    """A contact of balls a and b; `normal` points from a to b; `approach` [m/s] is positive."""

    a: int
    b: int
    normal: Vector
    approach: arb


class _Ball:
    """A ball in simultaneous impacts; its motion is changed in place.

    Masses and impulses are in units of one ball's mass: [1] and [m/s].
    """

    def __init__(self, body: Body, dt: arb, mass: arb) -> None:
        moved = ZERO if body.resting else dt
        self.body, self.mass, self.contacts = body, mass, 0
        self.place = body.position_after(moved)
        self.velocity, self.slip = body.velocity_after(moved), body.slip_after(moved)
        self.wz = body.spin_after(dt)

    def push(self, impulse: Vector) -> None:
        """Apply an impulse through the centre; the rotation doesn't change."""
        x, y = (part / self.mass for part in impulse)
        self.velocity = (self.velocity[0] + x, self.velocity[1] + y)
        self.slip = (self.slip[0] + x, self.slip[1] + y)

    def rub(self, n: Vector, along: arb, up: arb) -> None:
        """Turn the ball by the friction of a contact, given along t = z x n and upwards."""
        by = 5 * up / (2 * self.mass)
        self.slip = (self.slip[0] - by * n[0], self.slip[1] - by * n[1])
        self.wz -= 5 * along / (2 * self.mass * self.body.constants.radius)

    def seen(self, n: Vector) -> InContactFrame:
        """Return the ball in the frame of a contact with this normal."""
        return to_contact_frame(n, self.velocity, self.slip, self.wz, self.body.constants.radius)


class JointImpacts(Impacts):
    """Outcomes of impacts of balls that stay on the cloth, simultaneous impacts included."""

    def together(self, group: Sequence[Candidate], order: int) -> Together:
        """Return the outcome of simultaneous impacts that share balls.

        Raises `UndecidedError` if their law or their outcome is unknown.
        """
        if all(one.choice.kind is EventKind.BALL_BALL for one in group):
            return self._collided_together(group, order)
        if len(group) == 2 and len({one.choice.a for one in group}) == 1:
            return self._bounced_in_corner(group[0], group[1], order)
        raise UndecidedError("what comes first", exact=True)

    def _collided_together(self, group: Sequence[Candidate], order: int) -> Together:
        balls: dict[int, _Ball] = {}
        contacts: list[_JointContact] = []
        first = group[0].choice.a
        for one in group:
            assert isinstance(one.gap, PairGap)
            n = self._checked_normal(one, one.gap)
            a, b = one.balls
            for k, body in zip((a, b), one.bodies, strict=True):
                if k not in balls:
                    balls[k] = _Ball(body, age_of(body, one), self._relative_mass(k, first))
                balls[k].contacts += 1
            contacts.append(_JointContact(a, b, n, -_opening(balls[a], balls[b], n)))
        restitution = arb(self._problem.ball_restitution)
        forces = _impulses(contacts, balls, [(1 + restitution) * one.approach for one in contacts])
        rubs = self._problem.slides and self._problem.ball_friction != 0.0
        if rubs:
            self._rub(contacts, balls, forces)
            wanted = [
                restitution * one.approach - _opening(balls[one.a], balls[one.b], one.normal)
                for one in contacts
            ]
            forces = _impulses(contacts, balls, wanted)
        for contact, force in zip(contacts, forces, strict=True):
            x, y = contact.normal
            balls[contact.a].push((-force * x, -force * y))
            balls[contact.b].push((force * x, force * y))
        self.still = self._problem.ball_restitution == 0.0
        t = group[0].instant
        after = {}
        for k, ball in balls.items():
            slip = ball.slip if self._problem.slides else (ZERO, ZERO)
            velocity, wz = ball.velocity, ball.wz
            if len(group) == 2 and ball.contacts == 2:
                velocity, slip, wz = _on_axis(group[0], group[1], velocity, slip, wz)
            after[k] = Body(ball.body.constants, ball.place, velocity, slip, wz, t, order)
        return Together(after, tuple(one.choice for one in group))

    def _relative_mass(self, k: int, first: int) -> arb:
        """Return the mass of ball k over the mass of ball `first`: exactly 1 for equal balls."""
        own, other = (exactly(self._problem.balls[m].mass) for m in (k, first))
        return arb(own / other)

    def _rub(
        self, contacts: Sequence[_JointContact], balls: dict[int, _Ball], forces: Sequence[arb]
    ) -> None:
        """Let friction act against the mean of the slips before and after the normal impulses."""
        gains = {k: [ZERO, ZERO] for k in balls}
        for one, force in zip(contacts, forces, strict=True):
            for k, sign in ((one.a, -1), (one.b, 1)):
                for axis in range(2):
                    gains[k][axis] += sign * force * one.normal[axis] / balls[k].mass
        pushes = []
        for one, force in zip(contacts, forces, strict=True):
            n, first, second = one.normal, balls[one.a], balls[one.b]
            a, b = first.seen(n), second.seen(n)
            gx, gy = minus(tuple(gains[one.a]), tuple(gains[one.b]))
            along = a.vt - b.vt + (a.radius * a.wz + b.radius * b.wz)
            along += (n[0] * gy - n[1] * gx) / 2
            up = -(a.dn + b.dn)
            size = length(along, up)
            part_a, part_b = first.mass / first.contacts, second.mass / second.contacts
            mass = part_a * part_b / (part_a + part_b)
            part = mass * capped(self._laws.friction(size) * force / mass, size)
            pushes.append((part * along, part * up))
        for one, (along, up) in zip(contacts, pushes, strict=True):
            x, y = one.normal
            for k, sign in ((one.a, -1), (one.b, 1)):
                balls[k].push((-sign * along * y, sign * along * x))
                balls[k].rub(one.normal, along, up)

    def _bounced_in_corner(self, first: Candidate, second: Candidate, order: int) -> Together:
        normals = [self._corner_normal(one) for one in (first, second)]
        outcomes = [self._bounce_until_off(first, way) for way in (normals, normals[::-1])]
        (v1, u1, w1, count), (v2, u2, w2, again) = outcomes
        velocity: Vector = ((v1[0] + v2[0]) / 2, (v1[1] + v2[1]) / 2)
        slip: Vector = ((u1[0] + u2[0]) / 2, (u1[1] + u2[1]) / 2)
        kept, square = (dot(v1, v1) + dot(v2, v2)) / 2, dot(velocity, velocity)
        if not square > 0:
            raise UndecidedError("whether it stops in the corner")
        longer = (kept / square).sqrt() - 1
        more = (longer * velocity[0], longer * velocity[1])
        velocity = (velocity[0] + more[0], velocity[1] + more[1])
        # The spin is the mean, so the slip changes like the velocity.
        slip = (slip[0] + more[0], slip[1] + more[1]) if self._problem.slides else (ZERO, ZERO)
        velocity, slip, wz = _on_axis(first, second, velocity, slip, (w1 + w2) / 2)
        body, s = first.bodies[0], first.age
        place = body.position_after(s)
        for one in (first, second):
            gap = one.gap
            if isinstance(gap, StraightGap) and gap.piece.is_level and not self.overlapping(one):
                place = self._at_cushion(one.choice.a, gap.piece, place)
        after = Body(body.constants, place, velocity, slip, wz, first.instant, order)
        choices = (first.choice, second.choice)
        return Together(
            {first.choice.a: after}, tuple(choices[k % 2] for k in range(max(count, again)))
        )

    def _corner_normal(self, chosen: Candidate) -> Vector:
        """Return the normal of a contact, out of the table; raise an error if it is resting."""
        gap, s = chosen.gap, chosen.age
        if isinstance(gap, RoundGap):
            x, y = gap.normal(s, touching=not self.overlapping(chosen))
            self._check_distance(chosen, gap, (x, y), 2 * chosen.bodies[0].constants.radius)
        else:
            assert isinstance(gap, StraightGap)
            x, y = gap.piece.inward
            self._check_cushion(chosen, gap.piece)
        return (-x, -y)

    def _bounce_until_off(
        self, chosen: Candidate, normals: Sequence[Vector]
    ) -> tuple[Vector, Vector, arb, int]:
        """Return velocity, slip and spin of a ball after alternating bounces, and their number."""
        body, s = chosen.bodies[0], chosen.age
        velocity, slip, wz = body.velocity_after(s), body.slip_after(s), body.spin_after(s)
        for count in range(MAX_CORNER_BOUNCES):
            n = normals[count % 2]
            into = dot(n, velocity)
            if count and not into > 0:
                if not into <= 0:
                    raise UndecidedError("whether it leaves the corner")
                return velocity, slip, wz, count
            seen = to_contact_frame(n, velocity, slip, wz, body.constants.radius)
            after = self._laws.bounce(chosen.choice.a, seen)
            velocity, slip = from_contact_frame(n, after)
            wz = after.wz
            if not self._problem.slides:
                slip = (ZERO, ZERO)
        raise UndecidedError("how a ball leaves a corner", exact=True)


def _on_axis(
    first: Candidate, second: Candidate, velocity: Vector, slip: Vector, wz: arb
) -> tuple[Vector, Vector, arb]:
    """Return velocity, slip and spin of the ball of two impacts; 0 where symmetry requires it."""
    axis = axis_of_mirror(first, second)
    if axis is None:
        return velocity, slip, wz
    velocity, slip = ((ZERO, one[1]) if axis == 0 else (one[0], ZERO) for one in (velocity, slip))
    return velocity, slip, ZERO


def _opening(a: _Ball, b: _Ball, n: Vector) -> arb:
    """Return the rate at which the gap of two balls opens [m/s]."""
    return dot(n, minus(b.velocity, a.velocity))


def _impulses(
    contacts: Sequence[_JointContact], balls: dict[int, _Ball], gains: Sequence[arb]
) -> list[arb]:
    """Return the normal impulses that cause given changes of the rates of all gaps.

    Raises `UndecidedError` if an impulse may have to pull, because then different contacts act.
    """

    def response(one: _JointContact, other: _JointContact) -> arb:
        total = ZERO
        for k, sign in ((one.a, -1), (one.b, 1)):
            for m, its in ((other.a, -1), (other.b, 1)):
                if k == m:
                    total += sign * its * dot(one.normal, other.normal) / balls[k].mass
        return total

    matrix = arb_mat([[response(one, other) for other in contacts] for one in contacts])
    try:
        found = matrix.solve(arb_mat([[gain] for gain in gains]))
    except ZeroDivisionError:
        raise UndecidedError("how contacts share an impact") from None
    forces = [found[k, 0] for k in range(len(contacts))]
    if not all(force > 0 for force in forces):
        raise UndecidedError("which contacts share an impact")
    return forces

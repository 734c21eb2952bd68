"""One impact: balls are moved to its time, transformed to the contact's frame, and resolved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from flint import arb

from ghostball.model import EventKind
from ghostball.reference_adapters.certified.arithmetic import ZERO, Vector
from ghostball.reference_adapters.certified.candidates import Candidate
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.contacts import RunContacts
from ghostball.reference_adapters.certified.gaps import PairGap
from ghostball.reference_adapters.certified.laws import (
    ImpactLaws,
    InContactFrame,
    from_contact_frame,
    to_contact_frame,
)
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.obstacle_gaps import (
    ObstacleGap,
    RoundGap,
    StraightGap,
    reach_to_nose,
)
from ghostball.reference_adapters.certified.obstacles import StraightPiece
from ghostball.reference_adapters.certified.problem import ExactProblem


class Together(NamedTuple):
    """The outcome of impacts that act together: balls after them, by index, and events."""

    bodies: dict[int, Body]
    choices: tuple[Choice, ...]


class Impacts:
    """The outcomes of impacts in one run.

    `together`, `collided` and `bounced` raise an error if the outcome can't be decided, or if the
    contact is a resting contact from now on.

    `still`: whether the last impact has exactly ended the approach of two balls.
    """

    def __init__(self, problem: ExactProblem, contacts: RunContacts) -> None:
        self._problem = problem
        self._laws = ImpactLaws(problem)
        self._contacts = contacts
        self.still = False

    def together(self, group: Sequence[Candidate], order: int) -> Together:
        """Return the outcome of simultaneous impacts that share balls, if they act together."""
        raise NotImplementedError

    def overlapping(self, chosen: Candidate) -> bool:
        """Return whether an impact starts with an overlap, from rounding of the scene."""
        a, b = chosen.choice.a, chosen.choice.b
        if not chosen.age.is_zero():
            return False
        if chosen.choice.kind is EventKind.BALL_BALL:
            return not self._contacts.touches_ball(a, b)
        assert isinstance(chosen.gap, ObstacleGap)
        return not self._contacts.touches_obstacle(a, chosen.gap.piece.row)

    def collided(self, chosen: Candidate, order: int) -> tuple[Body, ...]:
        """Return both balls after their impact."""
        gap = chosen.gap
        assert isinstance(gap, PairGap)
        n = self._checked_normal(chosen, gap)
        places, seen = [], []
        for body in chosen.bodies:
            dt = age_of(body, chosen)
            moved = ZERO if body.resting else dt
            places.append(body.position_after(moved))
            v, u = body.velocity_after(moved), body.slip_after(moved)
            seen.append(to_contact_frame(n, v, u, body.spin_after(dt), body.constants.radius))
        self.still = self._problem.ball_restitution == 0.0
        after = self._laws.collide(chosen.choice.a, chosen.choice.b, seen[0], seen[1])
        return tuple(
            self._sent_off(body, n, place, ball, chosen.instant, order)
            for body, place, ball in zip(chosen.bodies, places, after, strict=True)
        )

    def bounced(self, chosen: Candidate, order: int) -> Body:
        """Return a ball after its impact with a cushion or a disc."""
        body, s, gap = chosen.bodies[0], chosen.age, chosen.gap
        velocity, slip, place = body.velocity_after(s), body.slip_after(s), body.position_after(s)
        if isinstance(gap, RoundGap):
            x, y = gap.normal(s, touching=not self.overlapping(chosen))
            self._check_distance(chosen, gap, (x, y), 2 * body.constants.radius)
        else:
            assert isinstance(gap, StraightGap)
            x, y = gap.piece.inward
            self._check_cushion(chosen, gap.piece)
            if gap.piece.is_level and not self.overlapping(chosen):
                place = self._at_cushion(chosen.choice.a, gap.piece, place)
        n = (-x, -y)
        seen = to_contact_frame(n, velocity, slip, body.spin_after(s), body.constants.radius)
        after = self._laws.bounce(chosen.choice.a, seen)
        return self._sent_off(body, n, place, after, chosen.instant, order)

    def _checked_normal(self, chosen: Candidate, gap: PairGap) -> Vector:
        """Return the normal of two balls in the plane; raise an error for a resting contact."""
        nx, ny = gap.normal(chosen.age, touching=not self.overlapping(chosen))
        self._check_distance(chosen, gap, (nx, ny), gap.reach)
        return (nx, ny)

    def _check_cushion(self, chosen: Candidate, piece: StraightPiece) -> None:
        """Raise an error if a ball stays in contact with a cushion."""
        body, s = chosen.bodies[0], chosen.age
        rate, opening = (
            piece.across(vector) for vector in (body.velocity_after(s), body.acceleration_after(s))
        )
        self._contacts.check_bounce(chosen, rate, opening, 2 * body.constants.radius)

    def _check_distance(
        self, chosen: Candidate, gap: PairGap | RoundGap, n: Vector, diameter: arb
    ) -> None:
        """Raise an error if balls, or a ball and a disc, stay in contact; `n`: along the gap."""
        (vx, vy), (ax, ay) = gap.vector(chosen.age, 1), gap.vector(chosen.age, 2)
        rate, across = n[0] * vx + n[1] * vy, n[0] * vy - n[1] * vx
        # The second derivative of the distance, from the rotation of the line of centres and
        # friction.
        opening = across * across / gap.reach + n[0] * ax + n[1] * ay
        self._contacts.check_bounce(chosen, rate, opening, diameter)

    def _sent_off(
        self, body: Body, n: Vector, place: Vector, after: InContactFrame, t: arb, order: int
    ) -> Body:
        velocity, slip = from_contact_frame(n, after)
        if not self._problem.slides:
            slip = (ZERO, ZERO)  # the velocity of a ball that always rolls determines its spin
        return Body(body.constants, place, velocity, slip, after.wz, t, order)

    def _at_cushion(self, i: int, piece: StraightPiece, place: Vector) -> Vector:
        """Return the position of ball i at a cushion along an axis: exact across the cushion.

        Otherwise, the times of a ball between a cushion and a different ball would become less
        precise at every bounce (Galperin's 31415 collisions would need a hundred thousand bits).
        """
        (x, y), reach = piece.inward, reach_to_nose(self._problem, i, piece)
        if y.is_zero():
            return (piece.place[0] + x * reach, place[1])
        return (place[0], piece.place[1] + y * reach)


def age_of(body: Body, chosen: Candidate) -> arb:
    """Return the time from a ball's start time to the contact of a pair [s]."""
    assert chosen.gap is not None
    # The gap's own time is a narrower interval than the difference of two times.
    return chosen.age if body.t is chosen.gap.t else (chosen.gap.t - body.t) + chosen.age

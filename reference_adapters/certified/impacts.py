"""One impact: balls moved to its instant, turned into the frame of the contact, and sent off."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from flint import arb

from ghostball.model import EventKind
from ghostball.reference_adapters.certified.arithmetic import ZERO, Vector
from ghostball.reference_adapters.certified.candidates import Candidate
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.contacts import Contacts
from ghostball.reference_adapters.certified.gaps import PairGap
from ghostball.reference_adapters.certified.laws import (
    InContactFrame,
    Laws,
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
from ghostball.reference_adapters.certified.obstacles import Straight
from ghostball.reference_adapters.certified.problem import Problem


class Together(NamedTuple):
    """What impacts that act at once do: the balls after them, by index, and their events."""

    bodies: dict[int, Body]
    choices: tuple[Choice, ...]


class Impacts:
    """What impacts do in one run.

    Both methods raise where the outcome can't be decided, or the contact is sustained from here on.

    `still`: whether the last impact has exactly ended the approach of two balls.
    """

    def __init__(self, problem: Problem, contacts: Contacts) -> None:
        self._problem = problem
        self._laws = Laws(problem)
        self._contacts = contacts
        self.still = False

    @property
    def act_at_once(self) -> bool:
        """Whether impacts of one instant act at once; else one after another, in an order."""
        return False

    def together(self, group: Sequence[Candidate], order: int) -> Together:
        """Return what impacts of one instant do that share balls, where they act at once."""
        raise NotImplementedError

    def overlapping(self, chosen: Candidate) -> bool:
        """Whether an impact begins in an overlap, by the rounding of the scene's numbers."""
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
        """Return a ball after it met a cushion, or a disc."""
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
        """Return the normal of two balls in the plane, unless they stay in contact from here on."""
        nx, ny = gap.normal(chosen.age, touching=not self.overlapping(chosen))
        self._check_distance(chosen, gap, (nx, ny), gap.reach)
        return (nx, ny)

    def _check_cushion(self, chosen: Candidate, piece: Straight) -> None:
        """Raise where a ball that meets a cushion stays in contact."""
        body, s = chosen.bodies[0], chosen.age
        rate, opening = (
            piece.across(vector) for vector in (body.velocity_after(s), body.acceleration_after(s))
        )
        self._contacts.check_bounce(chosen, rate, opening, 2 * body.constants.radius)

    def _check_distance(
        self, chosen: Candidate, gap: PairGap | RoundGap, n: Vector, diameter: arb
    ) -> None:
        """Raise where balls, or a ball and a disc, stay in contact; `n` is along their gap."""
        (vx, vy), (ax, ay) = gap.vector(chosen.age, 1), gap.vector(chosen.age, 2)
        rate, across = n[0] * vx + n[1] * vy, n[0] * vy - n[1] * vx
        # The second derivative of the distance: the line of centres turns away, and friction.
        opening = across * across / gap.reach + n[0] * ax + n[1] * ay
        self._contacts.check_bounce(chosen, rate, opening, diameter)

    def _sent_off(
        self, body: Body, n: Vector, place: Vector, after: InContactFrame, t: arb, order: int
    ) -> Body:
        velocity, slip = from_contact_frame(n, after)
        if not self._problem.slides:
            slip = (ZERO, ZERO)  # a ball that always rolls has the spin of its velocity
        return Body(body.constants, place, velocity, slip, after.wz, t, order)

    def _at_cushion(self, i: int, piece: Straight, place: Vector) -> Vector:
        """Return where ball i touches a cushion along an axis: across it there is no doubt.

        Without this, the instants of a ball between a cushion and another grow wider at every
        bounce (Galperin's 31415 collisions would need a hundred thousand bits).
        """
        (x, y), reach = piece.inward, reach_to_nose(self._problem, i, piece)
        if y.is_zero():
            return (piece.place[0] + x * reach, place[1])
        return (place[0], piece.place[1] + y * reach)


def age_of(body: Body, chosen: Candidate) -> arb:
    """Return how long after a ball's instant the two of a pair meet [s]."""
    assert chosen.gap is not None
    # The gap's own time is narrower than a difference of instants.
    return chosen.age if body.t is chosen.gap.t else (chosen.gap.t - body.t) + chosen.age

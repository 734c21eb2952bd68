"""One impact in an airborne scene: along the true normal, in space, and on the table.

The model's law: restitution along the contact normal and Coulomb friction against the slip of the
surfaces, at most as much as ends the slip; then the table reacts at the same time on each ball that
lies on it (`flight.answered_by_table`). An impact on the cloth whose rebound would rise less than
`LOW_BOUNCE` lifts no ball and is an impact in the plane. In flight, slower impacts aren't computed:
a ball that rests on a different ball, or on a nose, bounces there endlessly.
"""

from __future__ import annotations

from typing import NamedTuple

from flint import arb

from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    Direction,
    SustainedContactError,
    UndecidedError,
    Vector,
    dot,
    exactly,
    minus,
)
from ghostball.reference_adapters.certified.candidates import Candidate
from ghostball.reference_adapters.certified.contacts import LOW_BOUNCE, RunContacts
from ghostball.reference_adapters.certified.flight import FlightState, FlyingBody, answered_by_table
from ghostball.reference_adapters.certified.gaps import PairGap, motion_of
from ghostball.reference_adapters.certified.impacts import Impacts, age_of
from ghostball.reference_adapters.certified.laws import CushionRestitution, capped
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.obstacle_gaps import (
    NoseGap,
    RoundGap,
    StraightGap,
    nose_reach,
)
from ghostball.reference_adapters.certified.problem import ExactProblem

TURNING = ("frictional", "han2005")
"""Cushion laws with friction, which changes spin; the other laws have a tangential factor."""


class _Moving(NamedTuple):
    """A ball at an impact, with the spin as R w; all in m/s."""

    body: Body
    place: Vector  # [m]
    rise: arb  # [m]
    velocity: Direction
    surface: Direction
    slip: Vector  # over the cloth


class ImpactsInSpace(Impacts):
    """The outcomes of impacts in one run of an airborne scene."""

    def __init__(self, problem: ExactProblem, contacts: RunContacts) -> None:
        super().__init__(problem, contacts)
        self._gravity = arb(problem.gravity)
        self._restitution = arb(problem.ball_restitution)
        self._height = problem.cushion_height
        self._falling = CushionRestitution(problem)
        self._cushion_tangential = arb(problem.cushion_tangential)
        self._cushion_friction = arb(problem.cushion_friction)

    def collided(self, chosen: Candidate, order: int) -> tuple[Body, ...]:
        """Return both balls after their impact."""
        gap, s = chosen.gap, chosen.age
        first, second = chosen.bodies
        assert isinstance(gap, PairGap)
        free, touching = gap.free, not self.overlapping(chosen)
        if free:
            n = gap.normal(s, touching=touching)
        else:
            n = self._tilted(gap, s, first, second, touching=touching)
        a, b = (self._moved(body, age_of(body, chosen)) for body in chosen.bodies)
        speed = dot(minus(a.velocity, b.velocity), n)
        slow = self._slow(first.constants.radius + second.constants.radius)
        if not free:
            self._checked_normal(chosen, gap)
        if not self._lifts(speed, slow):
            if free:
                raise _resting_on(chosen, "a ball")
            return super().collided(chosen, order)
        returned = self._restitution * speed
        if free:
            returned = arb.max(returned, slow)
        normal = speed + returned
        turning = _plus(a.surface, b.surface)
        slip = _plus(minus(minus(a.velocity, b.velocity), _times(speed, n)), _cross(turning, n))
        part = self._part(normal, slip)
        masses = [exactly(self._problem.balls[k].mass) for k in (chosen.choice.a, chosen.choice.b)]
        impulse = _plus(_times(normal, n), _times(part, slip))
        turn = _times(5 * part / 2, _cross(n, slip))
        total = masses[0] + masses[1]
        # The vertical impulse is exactly 0 if no ball is lifted or pushed onto the table.
        self.still = not free and returned.is_zero() and impulse[2].is_zero()
        return (
            self._sent_on(a, arb(-masses[1] / total), impulse, turn, chosen.instant, order),
            self._sent_on(b, arb(masses[0] / total), impulse, turn, chosen.instant, order),
        )

    def _tilted(
        self, gap: PairGap, s: arb, first: Body, second: Body, *, touching: bool
    ) -> Direction:
        """Return the normal of two balls on the cloth, whose centres may have different heights."""
        x, y = gap.normal(s, touching=touching)
        below, above = first.constants.radius, second.constants.radius
        reach = below + above
        level = gap.reach / reach
        return (level * x, level * y, (above - below) / reach)

    def bounced(self, chosen: Candidate, order: int) -> Body:
        """Return a ball after its impact with a nose."""
        body, s, gap = chosen.bodies[0], chosen.age, chosen.gap
        assert isinstance(gap, NoseGap | StraightGap | RoundGap)
        radius, touching = body.constants.radius, not self.overlapping(chosen)
        inward = gap.normal(s, touching=touching) if isinstance(gap, RoundGap) else gap.piece.inward
        ball = self._moved(body, s)
        slow = self._slow(2 * radius)
        free = isinstance(body, FlyingBody)
        if isinstance(gap, NoseGap):
            away, above = gap.normal(s, touching=touching)
        else:
            rate = inward[0] * ball.velocity[0] + inward[1] * ball.velocity[1]
            if not free and not self._lifts(-rate, slow):
                return super().bounced(chosen, order)
            away, above = arb(1), ZERO
            if not (isinstance(gap, RoundGap) and gap.piece.is_post):
                reach = nose_reach(self._problem.balls[chosen.choice.a].radius, self._height)
                away, above = reach / radius, (radius - self._height) / radius
        if isinstance(gap, RoundGap) and not free:
            self._check_distance(chosen, gap, (inward[0], inward[1]), 2 * radius)
        if isinstance(gap, StraightGap):
            self._check_cushion(chosen, gap.piece)
            if gap.piece.is_level and touching:
                ball = ball._replace(place=self._at_cushion(chosen.choice.a, gap.piece, ball.place))
        n = (-inward[0] * away, -inward[1] * away, -above)
        speed = dot(ball.velocity, n)
        returned = self._falling.at(speed) * speed
        if free:
            if not self._lifts(speed, slow):
                raise _resting_on(chosen, "a cushion")
            returned = arb.max(returned, slow)
        normal = speed + returned
        impulse = _times(-normal, n)
        turn: Direction = (ZERO, ZERO, ZERO)
        if self._problem.cushion in TURNING:
            slip = _plus(minus(ball.velocity, _times(speed, n)), _cross(ball.surface, n))
            most = self._cushion_friction * normal
            part = capped(most, _size(slip))
            impulse = minus(impulse, _times(part, slip))
            turn = _times(5 * part / 2, _cross(n, slip))
        else:
            along = inward[0] * ball.velocity[1] - inward[1] * ball.velocity[0]
            lost = (1 - self._cushion_tangential) * along
            impulse = _plus(impulse, (lost * inward[1], -lost * inward[0], ZERO))
        return self._sent_on(ball, arb(1), impulse, turn, chosen.instant, order)

    def _slow(self, diameter: arb) -> arb:
        """Return the speed of a rebound that rises by `LOW_BOUNCE` diameters [m/s]."""
        return (2 * self._gravity * LOW_BOUNCE * diameter).sqrt()

    def _lifts(self, speed: arb, slow: arb) -> bool:
        """Return whether an impact is fast enough to be an impact in space."""
        if speed > slow:
            return True
        if speed <= slow:
            return False
        raise UndecidedError("whether an impact is fast enough to lift a ball")

    def _part(self, normal: arb, slip: Direction) -> arb:
        """Return the impulse of friction over the slip and the reduced mass."""
        size = _size(slip)
        return ZERO if size.is_zero() else capped(self._laws.friction(size) * normal, size)

    def _moved(self, body: Body, s: arb) -> _Moving:
        """Return a ball at the age s [s]."""
        slip, radius = body.slip_after(s), body.constants.radius
        place, velocity = (motion_of(body, s, order, in_space=True) for order in range(2))
        rise = ZERO
        if isinstance(body, FlyingBody) and not (body.rise.is_zero() and s.is_zero()):
            rise = place[2] - radius
            if not rise > 0:
                raise UndecidedError("whether the ball has landed before")
        # From u = (vx - R wy, vy + R wx).
        surface = (slip[1] - velocity[1], velocity[0] - slip[0], radius * body.spin_after(s))
        return _Moving(body, (place[0], place[1]), rise, velocity, surface, slip)

    def _sent_on(
        self, ball: _Moving, share: arb, impulse: Direction, turn: Direction, t: arb, order: int
    ) -> Body:
        """Return a ball after its share of an impulse and of a torque, over the reduced mass."""
        radius = ball.body.constants.radius
        gain, twist = _times(share, impulse), _times(-abs(share), turn)
        state = FlightState(
            ball.place,
            ball.rise,
            (ball.velocity[0] + gain[0], ball.velocity[1] + gain[1]),
            ball.velocity[2] + gain[2],
            (ball.slip[0] + (gain[0] - twist[1]), ball.slip[1] + (gain[1] + twist[0])),
            (ball.surface[2] + twist[2]) / radius,
        )
        return answered_by_table(ball.body.constants, state, t, order)


def _resting_on(chosen: Candidate, what: str) -> SustainedContactError:
    return SustainedContactError(
        f"an airborne ball rests on {what}, or bounces there too low to be resolved",
        (chosen.choice,),
        chosen.instant,
    )


def _cross(x: Direction, y: Direction) -> Direction:
    return (
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    )


def _plus(x: Direction, y: Direction) -> Direction:
    return tuple(p + q for p, q in zip(x, y, strict=True))


def _times(part: arb, x: Direction) -> Direction:
    return tuple(part * p for p in x)


def _size(x: Direction) -> arb:
    square = dot(x, x)
    if square > 0:
        return square.sqrt()
    if all(p.is_zero() for p in x):
        return ZERO
    return ZERO.union(square.upper().sqrt())

"""Exact contacts at the present time, and the detection of resting contacts.

Intervals can't show that a gap is exactly 0: this is known from the doubles of the scene and after
a collision, as long as the bodies don't move.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from flint import arb, fmpq

from ghostball.model import COLLISION_KINDS, EventKind, Phase
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    SustainedContactError,
    UndecidedError,
    exactly,
)
from ghostball.reference_adapters.certified.candidates import Candidate
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.obstacle_gaps import ObstacleGap
from ghostball.reference_adapters.certified.obstacles import RoundPiece, StraightPiece
from ghostball.reference_adapters.certified.problem import ExactProblem

LOW_BOUNCE = 2.0**-18
"""Height of a bounce, in diameters, below which a contact is a resting contact.

2e-7 m for pool balls. A ball that friction pushes against a different ball or a cushion bounces
ever lower, infinitely often in a finite time. If a rebound at the approach speed would not rise
higher than this, the contact is a resting contact from then on, as in the certified model
(`docs/physics.md`).
"""

TOUCHING = 2.0**-37
"""Gap, in diameters, below which an engine in doubles can't decide whether bodies touch.

4e-13 m for pool balls, as in the certified model (`docs/physics.md`). In addition, a gap has the
uncertainty of the rounding of the positions.
"""

MAX_LOW_BOUNCES = 4
"""Number of consecutive bounces, none higher than `LOW_BOUNCE`, that count as an endless series.

This happens if friction pushes only between the impacts: a ball that rolls slowly up to a resting
ball touches it repeatedly, because the resting ball stops at once after each impact.
"""

MAX_SIMULTANEOUS = {"elastic": 10_000, "slowed": 128, "not slowed": 24}
"""Number of simultaneous impacts of a ball that count as an endless series.

For impacts that lose energy, the number depends on whether friction slows the ball. In the
certified model, one inelastic impulse then ends the approach of all touching balls
(`docs/physics.md`).
"""


class RunContacts:
    """Contacts of one run, at the time of its last event."""

    def __init__(self, problem: ExactProblem, pieces: Sequence[StraightPiece | RoundPiece]) -> None:
        self._balls: set[tuple[int, int]] = set()
        self._obstacles: set[tuple[int, int]] = set()
        self._still: dict[tuple[int, int], tuple[Body, ...]] = {}
        self._low_bounces: dict[Choice, tuple[float, float, int]] = {}
        self._impacts: Counter[int] = Counter()  # at the present time, by ball
        self._losing = {
            EventKind.BALL_BALL: problem.ball_restitution < 1.0,
            EventKind.BALL_CUSHION: problem.cushion_restitution < 1.0 or problem.cushion_loss > 0.0,
        }
        in_air = problem.air_drag > 0.0 or problem.rolling_quadratic > 0.0
        self._slowed = [
            in_air
            or ball.rolling_friction > 0.0
            or (problem.slides and ball.sliding_friction > 0.0)
            for ball in problem.balls
        ]
        self._pieces = {piece.row: piece for piece in pieces}
        self._in_line = {
            piece.row: [other.row for other in pieces if piece is other or _in_line(piece, other)]
            for piece in pieces
        }
        for i in range(len(problem.balls)):
            self._note_start(problem, i)

    def _note_start(self, problem: ExactProblem, i: int) -> None:
        """Record the initial contacts of ball i, from the exact numbers of the scene."""
        ball = problem.balls[i]
        x, y, radius = exactly(ball.x), exactly(ball.y), exactly(ball.radius)
        for j, other in enumerate(problem.balls[:i]):
            dx, dy, reach = ball.x - other.x, ball.y - other.y, ball.radius + other.radius
            dz = ball.z - other.z if problem.airborne else 0.0
            if abs(dx * dx + dy * dy + dz * dz - reach * reach) > 1e-9 * reach * reach:
                continue  # far apart: avoid rational arithmetic
            rx, ry, r = x - exactly(other.x), y - exactly(other.y), radius + exactly(other.radius)
            rz = exactly(ball.z) - exactly(other.z) if problem.airborne else 0
            if rx * rx + ry * ry + rz * rz == r * r:
                self._balls.add((j, i))
        above = exactly(ball.z) - exactly(problem.cushion_height) if problem.airborne else fmpq(0)
        for piece in self._pieces.values():
            if _touches(piece, x, y, above, radius):
                self._obstacles.add((i, piece.row))

    def touches_ball(self, i: int, j: int) -> bool:
        """Return whether the gap of balls i < j is exactly 0."""
        return (i, j) in self._balls

    def touches_obstacle(self, i: int, row: int) -> bool:
        """Return whether the gap of ball i to the piece of an obstacle is exactly 0."""
        return (i, row) in self._obstacles

    def is_still(self, i: int, j: int, bodies: tuple[Body, ...]) -> bool:
        """Return whether an inelastic impact has just ended the approach of balls i < j."""
        kept = self._still.get((i, j))
        return kept is not None and all(a is b for a, b in zip(kept, bodies, strict=True))

    def start_instant(self, bodies: list[Body]) -> None:
        """Remove, at a new time, the contacts of bodies that moved."""
        self._impacts.clear()
        self._balls = {(i, j) for i, j in self._balls if bodies[i].resting and bodies[j].resting}
        self._obstacles = {
            (i, row) for i, row in self._obstacles if _keeps_to(bodies[i], self._pieces[row])
        }

    def count(self, choice: Choice, t: arb) -> None:
        """Count an impact at the present time; raise an error if the series is endless."""
        if choice.kind not in COLLISION_KINDS:
            return
        for k in choice.balls:
            kind = "slowed" if self._slowed[k] else "not slowed"
            most = MAX_SIMULTANEOUS[kind if self._losing.get(choice.kind) else "elastic"]
            if self._impacts[k] >= most:
                raise SustainedContactError("endless impacts at one instant", (choice,), t)
        self._impacts.update(choice.balls)

    def note(
        self, chosen: Candidate, bodies: tuple[Body, ...], overlapping: bool, *, still: bool
    ) -> None:
        """Record that the bodies of a collision touch, unless they overlap.

        `still`: whether the impact has exactly ended the approach of two balls.
        """
        choice, gap = chosen.choice, chosen.gap
        if overlapping:
            return
        if choice.kind is EventKind.BALL_CUSHION:
            assert isinstance(gap, ObstacleGap)
            # Pieces in the same line, such as the second rail at a side pocket, have the same
            # distance.
            self._obstacles.update((choice.a, row) for row in self._in_line[gap.piece.row])
        elif choice.kind is EventKind.BALL_BALL:
            self._balls.add((choice.a, choice.b))
            if still:
                self._still[choice.a, choice.b] = bodies

    def check_bounce(self, chosen: Candidate, rate: arb, opening: arb, diameter: arb) -> None:
        """Raise an error if the contact of an event is a resting contact from now on.

        `rate`: rate of the gap before the impact [m/s].
        `opening`: acceleration of the gap; negative if the bodies are pulled together [m/s^2].
        `diameter`: sum of the radii, or twice that of the ball [m].
        """
        choice, t, square = chosen.choice, chosen.instant, rate * rate
        most = 2 * LOW_BOUNCE * diameter * arb.max(-opening, ZERO)
        if not square > most:
            if opening < 0 and square <= most:
                raise SustainedContactError("in resting contact", (choice,), t)
            raise UndecidedError("whether they bounce or stay in contact", (choice,), t)
        self._count_bounce(chosen, abs(float(rate)), LOW_BOUNCE * float(diameter))

    def _count_bounce(self, chosen: Candidate, speed: float, height: float) -> None:
        """Count consecutive low bounces; in doubles, because the limit is a choice."""
        if not any(self._slowed[k] for k in chosen.balls):
            return
        choice, now = chosen.choice, float(chosen.instant)
        before, was, bounces = self._low_bounces.get(choice, (-math.inf, 0.0, 0))
        bounces = bounces + 1 if (now - before) * max(speed, was) <= height else 0
        if bounces > MAX_LOW_BOUNCES:
            raise SustainedContactError("ever lower bounces", (choice,), chosen.instant)
        self._low_bounces[choice] = (now, speed, bounces)


def _keeps_to(body: Body, piece: StraightPiece | RoundPiece) -> bool:
    """Return whether the distance of a ball from a body that it touches stays exactly the same."""
    if body.phase is Phase.FLYING:
        return False
    if isinstance(piece, RoundPiece):
        return body.resting
    v, a = piece.across((body.vx, body.vy)), piece.across((body.ax, body.ay))
    return bool(v.is_zero() and a.is_zero())


def _in_line(piece: StraightPiece | RoundPiece, other: StraightPiece | RoundPiece) -> bool:
    """Return whether two pieces are in the same line, with the table on the same side."""
    if isinstance(piece, RoundPiece) or isinstance(other, RoundPiece):
        return False
    (ax, ay), (bx, by) = piece.along, other.along
    dx, dy = (
        exactly(q) - exactly(p) for p, q in zip(piece.doubles[:2], other.doubles[:2], strict=True)
    )
    return bool(ax * by == ay * bx and ax * bx + ay * by > 0 and ax * dy == ay * dx)


def _touches(
    piece: StraightPiece | RoundPiece, x: fmpq, y: fmpq, above: fmpq, radius: fmpq
) -> bool:
    """Return whether the gap of a ball to an obstacle is exactly 0, by exact numbers.

    For a straight piece, the gap is that to its infinite line.
    """
    wx, wy, *rest = piece.doubles
    dx, dy = x - exactly(wx), y - exactly(wy)
    if isinstance(piece, RoundPiece):
        if piece.takes_out or not (piece.is_post or above == 0):
            return False
        reach = exactly(rest[0]) + radius
        return bool(dx * dx + dy * dy == reach * reach)
    ax, ay = piece.along
    away, square = ax * dy - ay * dx, ax * ax + ay * ay
    return bool(away > 0 and away * away == (radius * radius - above * above) * square)

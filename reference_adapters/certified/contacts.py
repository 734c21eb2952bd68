"""What touches exactly at an instant, and which contacts are sustained.

That a gap is exactly 0 can't be read off numbers that aren't exact: it is known of the scene's own
doubles and of what just collided, and kept as long as nothing moves.
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
from ghostball.reference_adapters.certified.obstacles import Round, Straight
from ghostball.reference_adapters.certified.problem import Problem

LOW_BOUNCE = 2.0**-18
"""Height of a bounce, in diameters, at which a contact counts as sustained: 2e-7 m for pool balls.

A ball that friction pushes against another, or a cushion, bounces ever lower, without end in a
finite time. Where a rebound at the speed of approach would not rise higher, the contact holds from
there on; the model that is certified says so too (README, "What our engine models").
"""

TOUCHING = 2.0**-37
"""Gap, in diameters, below which no engine in doubles can tell what touches from what doesn't.

4e-13 m for pool balls, as the model that is certified says (README, "What our engine models").
Beside it, a gap is as uncertain as the rounding of the places that it is between.
"""

MOST_LOW_BOUNCES = 4
"""Bounces in a row, each no higher than `LOW_BOUNCE`, that are taken for an endless series.

So it goes where friction pushes only in between: a ball that rolls up to a resting one touches it
again and again, since the one that it met stops at once.
"""

AT_ONE_INSTANT = {"elastic": 10_000, "slowed": 128, "not slowed": 24}
"""Impacts of a ball at one instant after which they are taken for an endless series.

Where they lose energy, by whether anything slows the ball: from then on the model that is certified
lets its impacts end all approach (`docs/physics.md`).
"""


class Contacts:
    """Contacts of one run, at the instant of its last event."""

    def __init__(self, problem: Problem, pieces: Sequence[Straight | Round]) -> None:
        self._balls: set[tuple[int, int]] = set()
        self._obstacles: set[tuple[int, int]] = set()
        self._still: dict[tuple[int, int], tuple[Body, ...]] = {}
        self._low_bounces: dict[Choice, tuple[float, float, int]] = {}
        self._impacts: Counter[int] = Counter()  # at this instant, by ball
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

    def _note_start(self, problem: Problem, i: int) -> None:
        """Note what ball i touches in the scene, by its exact numbers."""
        ball = problem.balls[i]
        x, y, radius = exactly(ball.x), exactly(ball.y), exactly(ball.radius)
        for j, other in enumerate(problem.balls[:i]):
            dx, dy, reach = ball.x - other.x, ball.y - other.y, ball.radius + other.radius
            dz = ball.z - other.z if problem.airborne else 0.0
            if abs(dx * dx + dy * dy + dz * dz - reach * reach) > 1e-9 * reach * reach:
                continue  # far from it: spare the rationals
            rx, ry, r = x - exactly(other.x), y - exactly(other.y), radius + exactly(other.radius)
            rz = exactly(ball.z) - exactly(other.z) if problem.airborne else 0
            if rx * rx + ry * ry + rz * rz == r * r:
                self._balls.add((j, i))
        above = exactly(ball.z) - exactly(problem.cushion_height) if problem.airborne else fmpq(0)
        for piece in self._pieces.values():
            if _touches(piece, x, y, above, radius):
                self._obstacles.add((i, piece.row))

    def touches_ball(self, i: int, j: int) -> bool:
        """Whether the gap of balls i < j is exactly 0."""
        return (i, j) in self._balls

    def touches_obstacle(self, i: int, row: int) -> bool:
        """Whether the gap of ball i to what has this row is exactly 0."""
        return (i, row) in self._obstacles

    def is_still(self, i: int, j: int, bodies: tuple[Body, ...]) -> bool:
        """Whether balls i < j have just lost all approach, in an impact without restitution."""
        kept = self._still.get((i, j))
        return kept is not None and all(a is b for a, b in zip(kept, bodies, strict=True))

    def start_instant(self, bodies: list[Body]) -> None:
        """Forget, at a new instant, the contacts of what moved until then."""
        self._impacts.clear()
        self._balls = {(i, j) for i, j in self._balls if bodies[i].resting and bodies[j].resting}
        self._obstacles = {
            (i, row) for i, row in self._obstacles if _keeps_to(bodies[i], self._pieces[row])
        }

    def count(self, choice: Choice, t: arb) -> None:
        """Count an impact at the instant of the others; raise where they don't end."""
        if choice.kind not in COLLISION_KINDS:
            return
        for k in choice.balls:
            kind = "slowed" if self._slowed[k] else "not slowed"
            most = AT_ONE_INSTANT[kind if self._losing.get(choice.kind) else "elastic"]
            if self._impacts[k] >= most:
                raise SustainedContactError("impacts without end at one instant", (choice,), t)
        self._impacts.update(choice.balls)

    def note(
        self, chosen: Candidate, bodies: tuple[Body, ...], overlapping: bool, *, still: bool
    ) -> None:
        """Note that what just collided touches, unless it overlaps; and whether it is still.

        That is, whether the impact has exactly ended the approach of two balls.
        """
        choice, gap = chosen.choice, chosen.gap
        if overlapping:
            return
        if choice.kind is EventKind.BALL_CUSHION:
            assert isinstance(gap, ObstacleGap)
            # What lies in one line with it, as the other rail of a side pocket, is as far away.
            self._obstacles.update((choice.a, row) for row in self._in_line[gap.piece.row])
        elif choice.kind is EventKind.BALL_BALL:
            self._balls.add((choice.a, choice.b))
            if still:
                self._still[choice.a, choice.b] = bodies

    def check_bounce(self, chosen: Candidate, rate: arb, opening: arb, diameter: arb) -> None:
        """Raise where the contact that an event makes is sustained from here on.

        `rate` [m/s]: of the gap, before the impact.
        `opening` [m/s^2]: by which the gap would open, or is pulled closed where it is negative.
        `diameter` [m]: the sum of the radii, or twice the ball's.
        """
        choice, t, square = chosen.choice, chosen.instant, rate * rate
        most = 2 * LOW_BOUNCE * diameter * arb.max(-opening, ZERO)
        if not square > most:
            if opening < 0 and square <= most:
                raise SustainedContactError("in resting contact", (choice,), t)
            raise UndecidedError("whether they bounce or stay in contact", (choice,), t)
        self._count_bounce(chosen, abs(float(rate)), LOW_BOUNCE * float(diameter))

    def _count_bounce(self, chosen: Candidate, speed: float, height: float) -> None:
        """Count low bounces in a row; in doubles, since where to stop is a choice."""
        if not any(self._slowed[k] for k in chosen.balls):
            return
        choice, now = chosen.choice, float(chosen.instant)
        before, was, bounces = self._low_bounces.get(choice, (-math.inf, 0.0, 0))
        bounces = bounces + 1 if (now - before) * max(speed, was) <= height else 0
        if bounces > MOST_LOW_BOUNCES:
            raise SustainedContactError("bounces that get ever lower", (choice,), chosen.instant)
        self._low_bounces[choice] = (now, speed, bounces)


def _keeps_to(body: Body, piece: Straight | Round) -> bool:
    """Whether the distance of a ball from what it touches stays exactly as it is."""
    if body.phase is Phase.FLYING:
        return False
    if isinstance(piece, Round):
        return body.resting
    v, a = piece.across((body.vx, body.vy)), piece.across((body.ax, body.ay))
    return bool(v.is_zero() and a.is_zero())


def _in_line(piece: Straight | Round, other: Straight | Round) -> bool:
    """Whether two pieces lie in one line, and have the table on the same side."""
    if isinstance(piece, Round) or isinstance(other, Round):
        return False
    (ax, ay), (bx, by) = piece.along, other.along
    dx, dy = (
        exactly(q) - exactly(p) for p, q in zip(piece.doubles[:2], other.doubles[:2], strict=True)
    )
    return bool(ax * by == ay * bx and ax * bx + ay * by > 0 and ax * dy == ay * dx)


def _touches(piece: Straight | Round, x: fmpq, y: fmpq, above: fmpq, radius: fmpq) -> bool:
    """Whether the gap of a ball to what stands on the table is exactly 0, by exact numbers.

    To the line of a piece, wherever along it.
    """
    wx, wy, *rest = piece.doubles
    dx, dy = x - exactly(wx), y - exactly(wy)
    if isinstance(piece, Round):
        if piece.takes_out or not (piece.is_post or above == 0):
            return False
        reach = exactly(rest[0]) + radius
        return bool(dx * dx + dy * dy == reach * reach)
    ax, ay = piece.along
    away, square = ax * dy - ay * dx, ax * ax + ay * ay
    return bool(away > 0 and away * away == (radius * radius - above * above) * square)

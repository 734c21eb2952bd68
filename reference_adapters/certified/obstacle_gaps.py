"""Gaps between a ball and an obstacle, as functions of time.

The distance from a line, or from a face, has degree 2. For a ball in the air, the nose is a line at
a height, and the gap is like that of two balls in the vertical plane across the line. A disc is
like a resting ball, and a hole is like a ball that the centre of the ball meets.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb

from ghostball.model import EventKind, Phase
from ghostball.reference_adapters.certified.arithmetic import Direction, exactly, minus
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.gaps import (
    DistanceGap,
    PairGap,
    error_in_doubles,
    motion_in_doubles,
    motion_of,
    search_distance,
)
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.obstacles import RoundPiece, StraightPiece
from ghostball.reference_adapters.certified.problem import ExactProblem
from ghostball.reference_adapters.certified.roots import (
    ROOT,
    Bracket,
    first_entry_in_doubles,
    unreached,
    unsearched,
)


class NoseGap(DistanceGap):
    """The gap of a ball in the air and a nose, a line at a height."""

    def __init__(self, body: Body, piece: StraightPiece, height: float, choice: Choice) -> None:
        self.choice = choice
        self.piece = piece
        self.t = body.t
        self.curved = False
        self.reach = body.constants.radius
        self._body, self._height = body, height

    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return the position of the ball relative to the nose: away from it and up [m]."""
        x, y, z = motion_of(self._body, s, order, in_space=True)
        if order == 0:
            return (self.piece.away((x, y)), z - self._height)
        return (self.piece.across((x, y)), z)

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; UNSURE if the intervals of the ball are too wide."""
        state = self._body.doubles
        if not state.exact_enough:
            return unsearched(high)
        x, y, nx, ny, _ = self.piece.doubles
        r, v, a = motion_in_doubles(self._body, 0.0, in_space=True)
        motion = [
            (nx * (r[0] - x) + ny * (r[1] - y), r[2] - self._height),
            (nx * v[0] + ny * v[1], v[2]),
            (nx * a[0] + ny * a[1], a[2]),
        ]
        reach = float(self.reach)
        place = state.place + abs(x) + abs(y) + self._height + reach
        return search_distance(motion, reach, high, place, state.speed, state.pull)


class RoundGap(DistanceGap):
    """The horizontal gap of a ball and a disc, or of its centre and the edge of a hole.

    `reach`: distance of the ball's centre from the edge of the disc at contact [m].
    """

    def __init__(self, body: Body, piece: RoundPiece, choice: Choice, reach: arb) -> None:
        self.choice = choice
        self.piece = piece
        self.t = body.t
        self.curved = body.curved
        self.reach = piece.radius if piece.takes_out else piece.radius + reach
        self._body = body

    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return the position of the ball relative to the centre [m], or its derivatives."""
        moved = motion_of(self._body, s, order, in_space=False)
        return moved if order else minus(moved, self.piece.centre)

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; UNSURE if the intervals of the ball are too wide."""
        state = self._body.doubles
        if not state.exact_enough:
            return unsearched(high)
        x, y, _ = self.piece.doubles
        reach = float(self.reach)
        r = (state.x - x, state.y - y)
        place, speed, pull = state.place + abs(x) + abs(y) + reach, state.speed, state.pull
        most = 1.5 * (reach + high * (speed + high * pull))
        if abs(r[0]) + abs(r[1]) > most + error_in_doubles(place, speed, pull, high):
            return unreached(high)
        motion = [r, (state.vx, state.vy), (state.ax, state.ay)]
        return search_distance(motion, reach, high, place, speed, pull)


class StraightGap:
    """The distance of a ball from the line of a straight piece, on the side of the table [m].

    The ball's radius is subtracted, or a different `reach` [m] if the nose isn't at the height of
    its centre. If the piece is a face, the ball touches it only if `is_on_face`.
    """

    def __init__(
        self, body: Body, piece: StraightPiece, choice: Choice, reach: arb | None = None
    ) -> None:
        self._reach = body.constants.radius if reach is None else reach
        self.choice = choice
        self.piece = piece
        self.t = body.t
        self._body = body
        self.curved = body.curved

    @property
    def ends(self) -> bool:
        """Whether the piece is a face, so that the gap may close beside it."""
        return self.piece.extent is not None

    @property
    def is_behind(self) -> bool:
        """Whether the centre is certainly behind the line initially; rounding can't cause this."""
        return bool(self.piece.away((self._body.x, self._body.y)) < 0)

    @property
    def slowing(self) -> arb:
        """Component, across the line, of the initial velocity or slip that friction acts against.

        The component of the deceleration across the line is proportional to it.
        """
        body = self._body
        slides = body.phase is Phase.SLIDING
        return self.piece.across((body.ux, body.uy) if slides else (body.vx, body.vy))

    def is_on_face(self, s: arb) -> bool | None:
        """Return whether the ball is in front of the face after a time s; None if undecided."""
        return self.piece.holds_foot_of(self._body.position_after(s))

    def coefficients(self) -> list[arb]:
        """Return the coefficients, the constant first [m, m/s, m/s^2]."""
        body, across = self._body, self.piece.across
        away = self.piece.away((body.x, body.y)) - self._reach
        return [away, across((body.vx, body.vy)), across((body.ax, body.ay)) / 2]

    def value(self, s: arb) -> arb:
        """Return the gap after a time s [m]."""
        if self.curved:
            return self.piece.away(self._body.position_after(s)) - self._reach
        c0, c1, c2 = self.coefficients()
        return c0 + s * (c1 + s * c2)

    def slope(self, s: arb) -> arb:
        """Return the rate of the gap after a time s [m/s]."""
        if self.curved:
            return self.piece.across(self._body.velocity_after(s))
        _, c1, c2 = self.coefficients()
        return c1 + 2 * s * c2

    def bend(self, s: arb) -> arb:
        """Return the second derivative of the gap after a time s [m/s^2]."""
        return self.piece.across(self._body.acceleration_after(s))

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; UNSURE if the intervals of the ball are too wide."""
        q = self._body.doubles
        if not q.exact_enough:
            return unsearched(high)
        x, y, nx, ny, extent = self.piece.doubles
        reach = float(self._reach)
        size = q.place + abs(x) + abs(y) + reach
        rx, ry = q.x - x, q.y - y
        gap = (nx * rx + ny * ry - reach, nx * q.vx + ny * q.vy, 0.5 * (nx * q.ax + ny * q.ay))

        def margin(s: float) -> float:
            return error_in_doubles(size, q.speed, q.pull, s)

        if not self.ends:
            return first_entry_in_doubles((*gap, 0.0, 0.0), high, margin)
        along = (ny * rx - nx * ry, ny * q.vx - nx * q.vy, 0.5 * (ny * q.ax - nx * q.ay))

        def misses(low: float, end: float) -> bool:
            least, most = _range(along, low, end)
            allowed = margin(end)
            return least > extent + allowed or most < -allowed

        if _range(gap, 0.0, high)[1] < -margin(high) or misses(0.0, high):
            return unreached(high)
        if not gap[0] > margin(0.0):
            return unsearched(high)
        found = first_entry_in_doubles((*gap, 0.0, 0.0), high, margin)
        # A parabola that starts in front of the line crosses it downwards at most once.
        if found.verdict == ROOT and misses(float(found.low), float(found.high)):
            return unreached(high)
        return found


ObstacleGap = NoseGap | RoundGap | StraightGap
"""Gaps of a ball and an obstacle."""

Gap = PairGap | ObstacleGap
"""Gaps from a given time on; positive if the bodies are apart."""


def choice_at(i: int, piece: StraightPiece | RoundPiece) -> Choice:
    """Return the event of ball i with an obstacle."""
    takes_out = isinstance(piece, RoundPiece) and piece.takes_out
    kind = EventKind.POCKETED if takes_out else EventKind.BALL_CUSHION
    return Choice(kind, i, piece.obstacle)


def reach_to_nose(problem: ExactProblem, i: int, piece: StraightPiece | RoundPiece) -> arb:
    """Return the distance from a nose, or a post, at which ball i on the cloth touches it [m]."""
    radius = problem.balls[i].radius
    if not problem.airborne or (isinstance(piece, RoundPiece) and piece.is_post):
        return arb(radius)
    return nose_reach(radius, problem.cushion_height)


def nose_reach(radius: float, height: float) -> arb:
    """Return the horizontal distance from a nose at which a ball on the cloth touches it [m]."""
    if height == radius:
        return arb(radius)
    h, r = exactly(height), exactly(radius)
    return arb(h * (2 * r - h)).sqrt()


def _range(gap: Sequence[float], low: float, high: float) -> tuple[float, float]:
    """Return the least and the largest value of a parabola between two times, up to rounding."""
    c0, c1, c2 = gap
    values = [c0 + s * (c1 + s * c2) for s in (low, high)]
    if low < (top := -0.5 * c1 / c2 if c2 else low) < high:
        values.append(c0 + 0.5 * top * c1)
    return min(values), max(values)

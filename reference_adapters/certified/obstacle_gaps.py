"""Gaps between a ball and what stands on the table, as functions of the time.

A line, or a face of it, is at a distance of degree 2. For a ball in the air its nose is a line at a
height, and the gap that of two balls, across it, in a vertical plane. A disc is a ball that rests,
and a hole one that the ball's centre meets.
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
from ghostball.reference_adapters.certified.obstacles import Round, Straight
from ghostball.reference_adapters.certified.problem import Problem
from ghostball.reference_adapters.certified.roots import (
    ROOT,
    Bracket,
    first_entry_in_doubles,
    unreached,
    unsearched,
)


class NoseGap(DistanceGap):
    """The gap of a ball in the air and a nose, a line at a height."""

    def __init__(self, body: Body, piece: Straight, height: float, choice: Choice) -> None:
        self.choice = choice
        self.piece = piece
        self.t = body.t
        self.curved = False
        self.reach = body.constants.radius
        self._body, self._height = body, height

    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return where the ball is, seen from the nose: away from it and up [m]."""
        x, y, z = motion_of(self._body, s, order, in_space=True)
        if order == 0:
            return (self.piece.away((x, y)), z - self._height)
        return (self.piece.across((x, y)), z)

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; a ball too wide for that is UNSURE."""
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
    """The gap, in plan, of a ball and a disc, or of its centre and the edge of a hole.

    `reach` [m]: how near to a disc's edge the ball's centre touches it.
    """

    def __init__(self, body: Body, piece: Round, choice: Choice, reach: arb) -> None:
        self.choice = choice
        self.piece = piece
        self.t = body.t
        self.curved = body.curved
        self.reach = piece.radius if piece.takes_out else piece.radius + reach
        self._body = body

    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return where the ball is, seen from the centre [m], or the derivatives of that."""
        moved = motion_of(self._body, s, order, in_space=False)
        return moved if order else minus(moved, self.piece.centre)

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; a ball too wide for that is UNSURE."""
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
    """The distance of a ball from the line of a straight piece, on the table's side [m].

    Less the ball's radius, or another `reach` [m]: where the nose is not at the height of its
    centre. Where the piece is a face, the ball touches it only if `is_on_face`.
    """

    def __init__(
        self, body: Body, piece: Straight, choice: Choice, reach: arb | None = None
    ) -> None:
        self._reach = body.constants.radius if reach is None else reach
        self.choice = choice
        self.piece = piece
        self.t = body.t
        self._body = body
        self.curved = body.curved

    @property
    def ends(self) -> bool:
        """Whether the piece is a face: the gap may close beside it."""
        return self.piece.extent is not None

    @property
    def is_behind(self) -> bool:
        """Whether the ball's centre is surely behind the line, at first: no rounding does that."""
        return bool(self.piece.away((self._body.x, self._body.y)) < 0)

    @property
    def slowing(self) -> arb:
        """Component, across the line, of the velocity or slip that friction acts against, at first.

        The line's own share of what slows the ball is in proportion to it.
        """
        body = self._body
        slides = body.phase is Phase.SLIDING
        return self.piece.across((body.ux, body.uy) if slides else (body.vx, body.vy))

    def is_on_face(self, s: arb) -> bool | None:
        """Whether the ball is in front of the face after a time s; None: that isn't decided."""
        return self.piece.holds_foot_of(self._body.position_after(s))

    def coefficients(self) -> list[arb]:
        """Return the coefficients from the constant up [m, m/s, m/s^2]."""
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
        """Return its rate after a time s [m/s]."""
        if self.curved:
            return self.piece.across(self._body.velocity_after(s))
        _, c1, c2 = self.coefficients()
        return c1 + 2 * s * c2

    def bend(self, s: arb) -> arb:
        """Return its second derivative after a time s [m/s^2]."""
        return self.piece.across(self._body.acceleration_after(s))

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; a ball too wide for that is UNSURE."""
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
        # A parabola that begins in front of the line crosses it downwards once at most.
        if found.verdict == ROOT and misses(float(found.low), float(found.high)):
            return unreached(high)
        return found


ObstacleGap = NoseGap | RoundGap | StraightGap
"""Gaps of a ball and what stands on the table."""

Gap = PairGap | ObstacleGap
"""Gaps from an instant on: positive where there is room."""


def choice_at(i: int, piece: Straight | Round) -> Choice:
    """Return what it is called when ball i meets something on the table."""
    takes_out = isinstance(piece, Round) and piece.takes_out
    kind = EventKind.POCKETED if takes_out else EventKind.BALL_CUSHION
    return Choice(kind, i, piece.obstacle)


def reach_to_nose(problem: Problem, i: int, piece: Straight | Round) -> arb:
    """Return how far from a nose, or a post, ball i, on the cloth, touches it [m]."""
    radius = problem.balls[i].radius
    if not problem.airborne or (isinstance(piece, Round) and piece.is_post):
        return arb(radius)
    return nose_reach(radius, problem.cushion_height)


def nose_reach(radius: float, height: float) -> arb:
    """Return how far from the line of a nose a ball on the cloth touches it [m]."""
    if height == radius:
        return arb(radius)
    h, r = exactly(height), exactly(radius)
    return arb(h * (2 * r - h)).sqrt()


def _range(gap: Sequence[float], low: float, high: float) -> tuple[float, float]:
    """Return the least and the largest value of a parabola between two times, but for rounding."""
    c0, c1, c2 = gap
    values = [c0 + s * (c1 + s * c2) for s in (low, high)]
    if low < (top := -0.5 * c1 / c2 if c2 else low) < high:
        values.append(c0 + 0.5 * top * c1)
    return min(values), max(values)

"""Gaps between two balls, and between a ball and what it bounces off, as functions of the time.

Two balls: |r + v s + a s^2 / 2|^2 - D^2, of degree 4 in the time s since the later of their
instants; in space where one of them is in the air, else in the plane. A disc is a ball that rests.
A cushion: degree 2; for a ball in the air its nose is a line, and the gap that of two balls, across
it, in a vertical plane.
Where air slows a ball there is no polynomial.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from operator import mul, sub
from typing import Protocol

from flint import arb

from ghostball.model import EventKind, Phase
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    Direction,
    UndecidedError,
    dot,
    exactly,
    minus,
    unit,
)
from ghostball.reference_adapters.certified.certificate import Choice
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

DOUBLES_ERROR = 1e-10
"""Bound of the error of a search in doubles, in units of the sum of all terms.

A state that `exact_enough` lets pass is wrong by 1e-13 of its terms, doubles round by 1e-16, and a
coefficient adds up a few of them.
"""


class Gap(Protocol):
    """A gap from an instant on: positive where there is room."""

    t: arb
    """Instant that its time counts from [s]."""
    choice: Choice
    """What closes it."""

    curved: bool
    """Whether a ball is slowed by air: then the gap is no polynomial."""

    def coefficients(self) -> list[arb]:
        """Return the coefficients, from the constant up; of one that isn't `curved`."""
        ...

    def value(self, s: arb) -> arb:
        """Return the gap after a time s [s]."""
        ...

    def slope(self, s: arb) -> arb:
        """Return its derivative after a time s [s]."""
        ...

    def bend(self, s: arb) -> arb:
        """Return its second derivative after a time s [s]."""
        ...

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles up to the time `high` [s]."""
        ...


class _DistanceGap(ABC):
    """The squared length of a vector that moves, less the square of a reach [m^2].

    `t` [s]: instant that its time counts from.
    `reach` [m].
    """

    t: arb
    choice: Choice
    reach: arb
    curved: bool

    @abstractmethod
    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return the vector a time s after `t` [m], or its first or second derivative."""

    def coefficients(self) -> list[arb]:
        """Return the coefficients from the constant up [m^2, m^2/s ...]."""
        r, v, a = (self.vector(ZERO, order) for order in range(3))
        return [
            dot(r, r) - self.reach * self.reach,
            2 * dot(r, v),
            dot(v, v) + dot(r, a),
            dot(v, a),
            dot(a, a) / 4,
        ]

    def value(self, s: arb) -> arb:
        """Return the gap after a time s, from the places: narrower than by powers of s."""
        r = self.vector(s)
        return dot(r, r) - self.reach * self.reach

    def slope(self, s: arb) -> arb:
        """Return the derivative of the gap after a time s."""
        return 2 * dot(self.vector(s), self.vector(s, 1))

    def bend(self, s: arb) -> arb:
        """Return the second derivative of the gap after a time s."""
        v = self.vector(s, 1)
        return 2 * (dot(v, v) + dot(self.vector(s), self.vector(s, 2)))

    def normal(self, s: arb, *, touching: bool) -> Direction:
        """Return the unit vector along the gap after a time s, where it is closed."""
        r = self.vector(s)
        if touching:
            return tuple(x / self.reach for x in r)
        square = dot(r, r)
        if not square > 0:
            raise UndecidedError("where they meet")
        size = square.sqrt()
        return tuple(x / size for x in r)


class PairGap(_DistanceGap):
    """The gap of two balls.

    `free`: whether one of them is in the air: then it is a gap in space.
    `reach` [m]: the sum of their radii; another one where balls of different size lie on the cloth
        of a scene in space, and touch along a line that isn't level.
    """

    def __init__(self, a: Body, b: Body, choice: Choice, reach: arb | None = None) -> None:
        self.choice = choice
        self._a, self._b = a, b
        self.curved = a.curved or b.curved
        self.free = Phase.FLYING in (a.phase, b.phase)
        self._later = a if a.order >= b.order else b
        self.t = self._later.t
        radii = a.constants.radius + b.constants.radius
        self.reach = radii if reach is None or self.free else reach
        self._start: tuple[Direction, ...] | None = None

    def _age(self, body: Body, s: arb) -> arb:
        if body.resting:
            return ZERO
        return s if body.order == self._later.order else (self.t - body.t) + s

    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return where b is relative to a at a time s [m], or the derivatives of that."""
        if self.curved:
            return self._apart(s, order)
        if self._start is None:
            self._start = tuple(self._apart(ZERO, of_start) for of_start in range(3))
        r, v, a = self._start
        if order == 0:
            return tuple(x + s * (y + s * z / 2) for x, y, z in zip(r, v, a, strict=True))
        return a if order == 2 else tuple(y + s * z for y, z in zip(v, a, strict=True))

    def _apart(self, s: arb, order: int) -> Direction:
        first, second = (
            motion_of(body, self._age(body, s), order, in_space=self.free)
            for body in (self._a, self._b)
        )
        return minus(second, first)

    def normal(self, s: arb, *, touching: bool) -> Direction:
        """Return the unit normal from a to b where they touch, after a time s."""
        if not self.free:
            x, y = self.vector(s)
            if x.is_zero() or y.is_zero() or not touching:
                return unit(x, y, "where two balls meet")
        return super().normal(s, touching=touching)

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; balls too wide for that are UNSURE."""
        a, b = self._a.doubles, self._b.doubles
        if not (a.exact_enough and b.exact_enough):
            return unsearched(high)
        # Differences of instants are taken before rounding, which would be coarser.
        sa, sb = (float(self._age(body, ZERO)) for body in (self._a, self._b))
        first = _motion_in_doubles(self._a, sa, in_space=self.free)
        second = _motion_in_doubles(self._b, sb, in_space=self.free)
        motion = [list(map(sub, of_b, of_a)) for of_a, of_b in zip(first, second, strict=True)]
        reach = float(self.reach)
        place = a.place + b.place + reach + sa * (a.speed + sa * a.pull)
        place += sb * (b.speed + sb * b.pull)
        speed = a.speed + b.speed + sa * a.pull + sb * b.pull
        return _search(motion, reach, high, place, speed, a.pull + b.pull)


class NoseGap(_DistanceGap):
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
        r, v, a = _motion_in_doubles(self._body, 0.0, in_space=True)
        motion = [
            (nx * (r[0] - x) + ny * (r[1] - y), r[2] - self._height),
            (nx * v[0] + ny * v[1], v[2]),
            (nx * a[0] + ny * a[1], a[2]),
        ]
        reach = float(self.reach)
        place = state.place + abs(x) + abs(y) + self._height + reach
        return _search(motion, reach, high, place, state.speed, state.pull)


class RoundGap(_DistanceGap):
    """The gap of a ball on the cloth and a disc, or of its centre and the edge of a hole."""

    def __init__(self, body: Body, piece: Round, choice: Choice) -> None:
        self.choice = choice
        self.piece = piece
        self.t = body.t
        self.curved = body.curved
        self.reach = piece.radius if piece.takes_out else piece.radius + body.constants.radius
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
        most = high * (state.speed + high * state.pull)
        size = state.place + abs(x) + abs(y) + reach + most
        if abs(r[0]) + abs(r[1]) > 1.5 * (reach + most) + DOUBLES_ERROR * size:
            return unreached(high)
        motion = [r, (state.vx, state.vy), (state.ax, state.ay)]
        return _search(motion, reach, high, size - most, state.speed, state.pull)


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
            return DOUBLES_ERROR * (size + s * (q.speed + s * q.pull))

        if not self.ends:
            return first_entry_in_doubles((*gap, 0.0, 0.0), 0.0, high, margin)
        along = (ny * rx - nx * ry, ny * q.vx - nx * q.vy, 0.5 * (ny * q.ax - nx * q.ay))

        def misses(low: float, end: float) -> bool:
            least, most = _range(along, low, end)
            allowed = margin(end)
            return least > extent + allowed or most < -allowed

        if _range(gap, 0.0, high)[1] < -margin(high) or misses(0.0, high):
            return unreached(high)
        if not gap[0] > margin(0.0):
            return unsearched(high)
        found = first_entry_in_doubles((*gap, 0.0, 0.0), 0.0, high, margin)
        # A parabola that begins in front of the line crosses it downwards once at most.
        if found.verdict == ROOT and misses(float(found.low), float(found.high)):
            return unreached(high)
        return found


ObstacleGap = NoseGap | RoundGap | StraightGap
"""Gaps of a ball and what stands on the table."""


def motion_of(body: Body, s: arb, order: int = 0, *, in_space: bool) -> Direction:
    """Return where a ball's centre is a time s [s] after its instant, or a derivative of that.

    In m, m/s or m/s^2; in space with its height above the cloth.
    """
    if body.resting:
        level = ((body.x, body.y), (body.vx, body.vy), (ZERO, ZERO))[order]
    elif order == 0:
        level = body.position_after(s)
    else:
        level = body.velocity_after(s) if order == 1 else body.acceleration_after(s)
    return (*level, body.vertical_after(s)[order]) if in_space else level


def level_reach(a: Body, b: Body) -> arb:
    """Return how far apart, in plan, two balls that lie on the cloth touch [m]: 2 sqrt(R_a R_b)."""
    first, second = a.constants.radius, b.constants.radius
    if first == second:
        return first + second
    return 2 * (first * second).sqrt()


def reach_to_cushion(problem: Problem, i: int) -> arb:
    """Return how far from the line of a cushion ball i, on the cloth, touches it [m]."""
    radius = problem.balls[i].radius
    return nose_reach(radius, problem.cushion_height) if problem.airborne else arb(radius)


def over_nose(body: Body, piece: Straight) -> tuple[arb, arb]:
    """Return how far a ball's centre is from the line of a nose [m], and the rate of that [m/s]."""
    return piece.away((body.x, body.y)), piece.across((body.vx, body.vy))


def nose_reach(radius: float, height: float) -> arb:
    """Return how far from the line of a nose a ball on the cloth touches it [m]."""
    if height == radius:
        return arb(radius)
    h, r = exactly(height), exactly(radius)
    return arb(h * (2 * r - h)).sqrt()


def _motion_in_doubles(body: Body, lag: float, *, in_space: bool) -> Sequence[Sequence[float]]:
    q = body.doubles
    r, v, a = (
        (
            q.x + lag * (q.vx + 0.5 * lag * q.ax),
            q.y + lag * (q.vy + 0.5 * lag * q.ay),
        ),
        (q.vx + lag * q.ax, q.vy + lag * q.ay),
        (q.ax, q.ay),
    )
    if not in_space:
        return r, v, a
    height, up, pull = (float(number) for number in body.vertical)
    rise = height + lag * (up + 0.5 * lag * pull)
    return (*r, rise), (*v, up + lag * pull), (*a, pull)


def _search(
    motion: Sequence[Sequence[float]],
    reach: float,
    high: float,
    place: float,
    speed: float,
    pull: float,
) -> Bracket:
    """Search in doubles; `place`, `speed` and `pull` bound the sums of what is added up."""
    r, v, a = motion
    gap = (
        sum(map(mul, r, r)) - reach * reach,
        2.0 * sum(map(mul, r, v)),
        sum(map(mul, v, v)) + sum(map(mul, r, a)),
        sum(map(mul, v, a)),
        0.25 * sum(map(mul, a, a)),
    )

    def margin(s: float) -> float:
        size = place + s * (speed + s * pull)
        return DOUBLES_ERROR * size * size

    return first_entry_in_doubles(gap, 0.0, high, margin)


def _range(gap: Sequence[float], low: float, high: float) -> tuple[float, float]:
    """Return the least and the largest value of a parabola between two times, but for rounding."""
    c0, c1, c2 = gap
    values = [c0 + s * (c1 + s * c2) for s in (low, high)]
    if low < (top := -0.5 * c1 / c2 if c2 else low) < high:
        values.append(c0 + 0.5 * top * c1)
    return min(values), max(values)


def choice_at(i: int, piece: Straight | Round) -> Choice:
    """Return what it is called when ball i meets something on the table."""
    takes_out = isinstance(piece, Round) and piece.takes_out
    kind = EventKind.POCKETED if takes_out else EventKind.BALL_CUSHION
    return Choice(kind, i, piece.obstacle)

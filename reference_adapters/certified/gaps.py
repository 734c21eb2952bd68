"""Gaps between two balls, and between a ball and a cushion, as functions of the time.

Two balls: |r + v s + a s^2 / 2|^2 - D^2, of degree 4 in the time s since the later of their
instants; in space where one of them is in the air, else in the plane. A cushion: degree 2; for a
ball in the air its nose is a line, and the gap that of two balls, across it, in a vertical plane.
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
from ghostball.reference_adapters.certified.problem import Problem
from ghostball.reference_adapters.certified.roots import Bracket, first_entry_in_doubles, unsearched

DOUBLES_ERROR = 1e-10
"""Bound of the error of a search in doubles, in units of the sum of all terms.

A state that `exact_enough` lets pass is wrong by 1e-13 of its terms, doubles round by 1e-16, and a
coefficient adds up a few of them.
"""

SIDES: tuple[tuple[int, int], ...] = ((1, 0), (-1, 0), (0, 1), (0, -1))
"""Normals into the table, by the index of the cushion."""


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

    def __init__(self, body: Body, line: float, height: float, choice: Choice) -> None:
        self.choice = choice
        self.t = body.t
        self.curved = False
        self.reach = body.constants.radius
        self._body, self._line, self._height = body, line, height
        nx, ny = SIDES[choice.b]
        self._axis, self._inward = (0, nx) if nx else (1, ny)

    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return where the ball is, seen from the nose: away from it and up [m]."""
        r = motion_of(self._body, s, order, in_space=True)
        if order == 0:
            return (self._inward * (r[self._axis] - self._line), r[2] - self._height)
        return (self._inward * r[self._axis], r[2])

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; a ball too wide for that is UNSURE."""
        state = self._body.doubles
        if not state.exact_enough:
            return unsearched(high)
        r, v, a = _motion_in_doubles(self._body, 0.0, in_space=True)
        k, n = self._axis, self._inward
        motion = [
            (n * (r[k] - self._line), r[2] - self._height),
            (n * v[k], v[2]),
            (n * a[k], a[2]),
        ]
        reach = float(self.reach)
        place = state.place + abs(self._line) + self._height + reach
        return _search(motion, reach, high, place, state.speed, state.pull)


class CushionGap:
    """The distance of a ball from a cushion [m].

    Less the ball's radius, or another `reach` [m]: where the nose is not at the height of its
    centre.
    """

    def __init__(self, body: Body, line: float, choice: Choice, reach: arb | None = None) -> None:
        self._reach = body.constants.radius if reach is None else reach
        self.choice = choice
        self.t = body.t
        self._body = body
        self.curved = body.curved
        self._line = line
        nx, ny = SIDES[choice.b]
        self._across = nx if nx else ny
        self._along_x = nx != 0

    def coefficients(self) -> list[arb]:
        """Return the coefficients from the constant up [m, m/s, m/s^2]."""
        body, n = self._body, self._across
        x, v, a = (body.x, body.vx, body.ax) if self._along_x else (body.y, body.vy, body.ay)
        return [n * (x - self._line) - self._reach, n * v, n * a / 2]

    def value(self, s: arb) -> arb:
        """Return the gap after a time s [m]."""
        if self.curved:
            place = self._body.position_after(s)[0 if self._along_x else 1]
            return self._across * (place - self._line) - self._reach
        c0, c1, c2 = self.coefficients()
        return c0 + s * (c1 + s * c2)

    def slope(self, s: arb) -> arb:
        """Return its rate after a time s [m/s]."""
        if self.curved:
            return self._across * self._body.velocity_after(s)[0 if self._along_x else 1]
        _, c1, c2 = self.coefficients()
        return c1 + 2 * s * c2

    def bend(self, s: arb) -> arb:
        """Return its second derivative after a time s [m/s^2]."""
        return self._across * self._body.acceleration_after(s)[0 if self._along_x else 1]

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; a ball too wide for that is UNSURE."""
        q, n = self._body.doubles, self._across
        if not q.exact_enough:
            return unsearched(high)
        x, v, a = (q.x, q.vx, q.ax) if self._along_x else (q.y, q.vy, q.ay)
        reach = float(self._reach)
        size = abs(x) + abs(self._line) + reach
        gap = (n * (x - self._line) - reach, n * v, 0.5 * n * a, 0.0, 0.0)

        def margin(s: float) -> float:
            return DOUBLES_ERROR * (size + s * (q.speed + s * q.pull))

        return first_entry_in_doubles(gap, 0.0, high, margin)


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


def over_nose(body: Body, line: float, cushion: int) -> tuple[arb, arb]:
    """Return how far a ball's centre is from the line of a nose [m], and the rate of that [m/s]."""
    nx, ny = SIDES[cushion]
    x, v = (body.x, body.vx) if nx else (body.y, body.vy)
    n = nx + ny
    return n * (x - line), n * v


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


def cushion_choice(i: int, cushion: int) -> Choice:
    """Return what it is called when ball i meets a cushion."""
    return Choice(EventKind.BALL_CUSHION, i, cushion)

"""Gaps where one of two balls, or the ball that meets a cushion, is in the air.

Two balls: |r + v s + a s^2 / 2|^2 - D^2 in space; a ball and a nose, which is a line: the same
across it, in the vertical plane. Both are polynomials of degree 4 in the time s, as in `gaps`.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb

from ghostball.reference_adapters.certified.arithmetic import ZERO, UndecidedError, exactly
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.gaps import QUICK_ERROR, SIDES
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.problem import Problem
from ghostball.reference_adapters.certified.roots import Bracket, first_entry_quick, unsearched

Direction = tuple[arb, ...]


class _DistanceGap:
    """The squared length of a vector that moves along a parabola, less the square of a reach.

    Attributes
    ----------
    t : arb [s]
        Instant that its time counts from.
    choice : Choice
    reach : arb [m]
    curved : bool
    """

    t: arb
    choice: Choice
    reach: arb
    curved: bool

    def _motion(self, s: arb) -> tuple[Direction, Direction, Direction]:
        """Return the vector a time s after `t`, its velocity and its acceleration."""
        raise NotImplementedError

    def coefficients(self) -> list[arb]:
        """Return the coefficients from the constant up [m^2, m^2/s ...]."""
        r, v, a = self._motion(ZERO)
        return [
            _dot(r, r) - self.reach * self.reach,
            2 * _dot(r, v),
            _dot(v, v) + _dot(r, a),
            _dot(v, a),
            _dot(a, a) / 4,
        ]

    def value(self, s: arb) -> arb:
        """Return the gap after a time s, from the places: narrower than by powers of s."""
        r, _, _ = self._motion(s)
        return _dot(r, r) - self.reach * self.reach

    def slope(self, s: arb) -> arb:
        """Return the derivative of the gap after a time s."""
        r, v, _ = self._motion(s)
        return 2 * _dot(r, v)

    def bend(self, s: arb) -> arb:
        """Return the second derivative of the gap after a time s."""
        r, v, a = self._motion(s)
        return 2 * (_dot(v, v) + _dot(r, a))

    def towards(self, s: arb, *, touching: bool) -> Direction:
        """Return the unit vector along the gap after a time s, where it is closed."""
        r, _, _ = self._motion(s)
        if touching:
            return tuple(x / self.reach for x in r)
        square = _dot(r, r)
        if not square > 0:
            raise UndecidedError("where they meet")
        size = square.sqrt()
        return tuple(x / size for x in r)


class PairInSpace(_DistanceGap):
    """The gap of two balls, of which one or both fly."""

    def __init__(self, a: Body, b: Body, choice: Choice) -> None:
        self.choice = choice
        self._a, self._b = a, b
        self.curved = a.curved or b.curved
        self._later = a if a.order >= b.order else b
        self.t = self._later.t
        self.reach = a.constants.radius + b.constants.radius
        self._start: tuple[Direction, Direction, Direction] | None = None

    def _age(self, body: Body, s: arb) -> arb:
        """Return how old a body is after a time s [s]."""
        if body.resting:
            return ZERO
        return s if body.order == self._later.order else (self.t - body.t) + s

    def _motion(self, s: arb) -> tuple[Direction, Direction, Direction]:
        if self.curved:
            return self._apart(s)
        if self._start is None:
            self._start = self._apart(ZERO)
        return _after(self._start, s)

    def _apart(self, s: arb) -> tuple[Direction, Direction, Direction]:
        """Return the motion of b relative to a at the time s, from the motion of each."""
        first = motion_of(self._a, self._age(self._a, s))
        second = motion_of(self._b, self._age(self._b, s))
        place, velocity, pull = (_minus(y, x) for x, y in zip(first, second, strict=True))
        return place, velocity, pull

    def quick(self, high: float) -> Bracket:
        """Search in doubles; balls too wide for that are UNSURE."""
        a, b = self._a.quick, self._b.quick
        if not (a.exact_enough and b.exact_enough):
            return unsearched(high)
        lags = [float(self._age(body, ZERO)) for body in (self._a, self._b)]
        (ra, va, aa), (rb, vb, ab) = (
            _quick_motion(body, lag) for body, lag in zip((self._a, self._b), lags, strict=True)
        )
        motion = [
            tuple(y - x for x, y in zip(first, second, strict=True))
            for first, second in ((ra, rb), (va, vb), (aa, ab))
        ]
        place, speed = float(self.reach), 0.0
        for quick, lag in ((a, lags[0]), (b, lags[1])):
            place += quick.place + lag * (quick.speed + lag * quick.pull)
            speed += quick.speed + lag * quick.pull
        return _search(motion, float(self.reach), high, place, speed, a.pull + b.pull)


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

    def _motion(self, s: arb) -> tuple[Direction, Direction, Direction]:
        r, v, a = motion_of(self._body, s)
        k, n = self._axis, self._inward
        return (
            (n * (r[k] - self._line), r[2] - self._height),
            (n * v[k], v[2]),
            (n * a[k], a[2]),
        )

    def quick(self, high: float) -> Bracket:
        """Search in doubles; a ball too wide for that is UNSURE."""
        quick = self._body.quick
        if not quick.exact_enough:
            return unsearched(high)
        r, v, a = _quick_motion(self._body, 0.0)
        k, n = self._axis, self._inward
        motion = [
            (n * (r[k] - self._line), r[2] - self._height),
            (n * v[k], v[2]),
            (n * a[k], a[2]),
        ]
        reach = float(self.reach)
        place = quick.place + abs(self._line) + self._height + reach
        return _search(motion, reach, high, place, quick.speed, quick.pull)


def motion_of(body: Body, s: arb) -> tuple[Direction, Direction, Direction]:
    """Return where a ball's centre is a time s [s] after its instant, and its derivatives.

    In m, m/s and m/s^2, with its height above the cloth.
    """
    height, up, pull = body.vertical_after(s)
    if body.resting:
        return (body.x, body.y, height), (body.vx, body.vy, up), (ZERO, ZERO, pull)
    return (
        (*body.position_after(s), height),
        (*body.velocity_after(s), up),
        (*body.acceleration_after(s), pull),
    )


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


def _quick_motion(
    body: Body, lag: float
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    quick = body.quick
    height, up, pull = (float(number) for number in body.vertical)
    r, v, a = (quick.x, quick.y, height), (quick.vx, quick.vy, up), (quick.ax, quick.ay, pull)
    return (
        tuple(x + lag * (y + 0.5 * lag * z) for x, y, z in zip(r, v, a, strict=True)),
        tuple(y + lag * z for y, z in zip(v, a, strict=True)),
        a,
    )


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

    def dot(x: Sequence[float], y: Sequence[float]) -> float:
        return sum(p * q for p, q in zip(x, y, strict=True))

    gap = (dot(r, r) - reach * reach, 2.0 * dot(r, v), dot(v, v) + dot(r, a), dot(v, a))

    def margin(s: float) -> float:
        size = place + s * (speed + s * pull)
        return QUICK_ERROR * size * size

    return first_entry_quick((*gap, 0.25 * dot(a, a)), 0.0, high, margin)


def _after(
    motion: tuple[Direction, Direction, Direction], s: arb
) -> tuple[Direction, Direction, Direction]:
    r, v, a = motion
    return (
        tuple(x + s * (y + s * z / 2) for x, y, z in zip(r, v, a, strict=True)),
        tuple(y + s * z for y, z in zip(v, a, strict=True)),
        a,
    )


def _dot(x: Direction, y: Direction) -> arb:
    total = ZERO
    for p, q in zip(x, y, strict=True):
        total += p * q
    return total


def _minus(x: Direction, y: Direction) -> Direction:
    return tuple(p - q for p, q in zip(x, y, strict=True))

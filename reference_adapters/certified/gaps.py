"""Gaps between two balls, and between a ball and a cushion, as polynomials of the time.

Two balls: |r + v s + a s^2 / 2|^2 - D^2, of degree 4 in the time s since the later of their
instants; a cushion: degree 2. Where balls touch, because they just hit each other or because the
scene's very doubles say so, the gap is exactly 0, and its root s = 0 is divided out: what remains
tells whether they part, and when they meet again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from flint import arb

from ghostball.model import EventKind
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    SustainedContactError,
    UndecidedError,
    Vector,
    unit,
)
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.drag import first_entry_of, parting
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.roots import (
    NONE,
    ROOT,
    UNSURE,
    Bracket,
    first_entry,
    first_entry_quick,
    refined,
    unsearched,
)

QUICK_ERROR = 1e-10
"""Bound of the error of a quick search, in units of the sum of all terms.

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

    def quick(self, high: float) -> Bracket:
        """Search in doubles up to the time `high` [s]."""
        ...


class PairGap:
    """The squared distance of two balls less the square of the sum of their radii [m^2].

    Or of another `reach` [m]: where balls of different size touch along a line that isn't level.
    """

    def __init__(self, a: Body, b: Body, choice: Choice, reach: arb | None = None) -> None:
        self.choice = choice
        self._a, self._b = a, b
        self.curved = a.curved or b.curved
        self._later = a if a.order >= b.order else b
        self.t = self._later.t
        self.reach = a.constants.radius + b.constants.radius if reach is None else reach
        self._relative: tuple[Vector, Vector, Vector] | None = None

    def _terms(self) -> tuple[Vector, Vector, Vector]:
        """Return position, velocity and half the acceleration of b relative to a, at `t`."""
        if self._relative is None:
            (ax, ay), (avx, avy) = self._at_reference(self._a)
            (bx, by), (bvx, bvy) = self._at_reference(self._b)
            h = ((self._b.ax - self._a.ax) / 2, (self._b.ay - self._a.ay) / 2)
            self._relative = ((bx - ax, by - ay), (bvx - avx, bvy - avy), h)
        return self._relative

    def _lag(self, body: Body) -> float:
        """Return how long ago the body's instant was at `t` [s]; 0 where it doesn't matter."""
        if body.order == self._later.order or body.resting:
            return 0.0
        return float(self.t - body.t)

    def _at_reference(self, body: Body) -> tuple[Vector, Vector]:
        if body.order == self._later.order or body.resting:
            return (body.x, body.y), (body.vx, body.vy)
        s = self.t - body.t
        return body.position_after(s), body.velocity_after(s)

    def coefficients(self) -> list[arb]:
        """Return the coefficients from the constant up [m^2, m^2/s ...]."""
        (rx, ry), (vx, vy), (hx, hy) = self._terms()
        return [
            rx * rx + ry * ry - self.reach * self.reach,
            2 * (rx * vx + ry * vy),
            vx * vx + vy * vy + 2 * (rx * hx + ry * hy),
            2 * (vx * hx + vy * hy),
            hx * hx + hy * hy,
        ]

    def _age(self, body: Body, s: arb) -> arb:
        """Return how old a body is after a time s [s]."""
        if body.resting:
            return ZERO
        return s if body.order == self._later.order else (self.t - body.t) + s

    def offset(self, s: arb) -> Vector:
        """Return the position of b relative to a after a time s [m]."""
        if self.curved:
            ax, ay = self._a.position_after(self._age(self._a, s))
            bx, by = self._b.position_after(self._age(self._b, s))
            return (bx - ax, by - ay)
        (rx, ry), (vx, vy), (hx, hy) = self._terms()
        return (rx + s * (vx + s * hx), ry + s * (vy + s * hy))

    def rate(self, s: arb) -> Vector:
        """Return the velocity of b relative to a after a time s [m/s]."""
        if self.curved:
            avx, avy = self._a.velocity_after(self._age(self._a, s))
            bvx, bvy = self._b.velocity_after(self._age(self._b, s))
            return (bvx - avx, bvy - avy)
        _, (vx, vy), (hx, hy) = self._terms()
        return (vx + 2 * s * hx, vy + 2 * s * hy)

    def pull(self, s: arb) -> Vector:
        """Return the acceleration of b relative to a after a time s [m/s^2]."""
        if self.curved:
            ax, ay = self._a.acceleration_after(self._age(self._a, s))
            bx, by = self._b.acceleration_after(self._age(self._b, s))
            return (bx - ax, by - ay)
        _, _, (hx, hy) = self._terms()
        return (2 * hx, 2 * hy)

    def value(self, s: arb) -> arb:
        """Return the gap after a time s, from the positions: narrower than by powers of s."""
        x, y = self.offset(s)
        return x * x + y * y - self.reach * self.reach

    def slope(self, s: arb) -> arb:
        """Return the derivative of the gap after a time s."""
        (x, y), (vx, vy) = self.offset(s), self.rate(s)
        return 2 * (x * vx + y * vy)

    def bend(self, s: arb) -> arb:
        """Return the second derivative of the gap after a time s."""
        (x, y), (vx, vy), (ax, ay) = self.offset(s), self.rate(s), self.pull(s)
        return 2 * (vx * vx + vy * vy + x * ax + y * ay)

    def normal(self, s: arb, touching: bool) -> Vector:
        """Return the unit normal from a to b where they touch, after a time s."""
        x, y = self.offset(s)
        if x.is_zero() or y.is_zero() or not touching:
            return unit(x, y, "where two balls meet")
        return (x / self.reach, y / self.reach)

    def quick(self, high: float) -> Bracket:
        """Search in doubles; balls too wide for that are UNSURE."""
        a, b = self._a.quick, self._b.quick
        if not (a.exact_enough and b.exact_enough):
            return unsearched(high)
        # Differences of instants are taken before rounding, which would be coarser.
        sa, sb = self._lag(self._a), self._lag(self._b)
        rx = b.x + sb * (b.vx + 0.5 * sb * b.ax) - (a.x + sa * (a.vx + 0.5 * sa * a.ax))
        ry = b.y + sb * (b.vy + 0.5 * sb * b.ay) - (a.y + sa * (a.vy + 0.5 * sa * a.ay))
        vx, vy = b.vx + sb * b.ax - (a.vx + sa * a.ax), b.vy + sb * b.ay - (a.vy + sa * a.ay)
        hx, hy = 0.5 * (b.ax - a.ax), 0.5 * (b.ay - a.ay)
        reach = float(self.reach)
        gap = (
            rx * rx + ry * ry - reach * reach,
            2.0 * (rx * vx + ry * vy),
            vx * vx + vy * vy + 2.0 * (rx * hx + ry * hy),
            2.0 * (vx * hx + vy * hy),
            hx * hx + hy * hy,
        )
        place = a.place + b.place + reach + sa * (a.speed + sa * a.pull)
        place += sb * (b.speed + sb * b.pull)
        speed = a.speed + b.speed + sa * a.pull + sb * b.pull
        pull = a.pull + b.pull

        def margin(s: float) -> float:
            size = place + s * (speed + s * pull)
            return QUICK_ERROR * size * size

        return first_entry_quick(gap, 0.0, high, margin)


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

    def quick(self, high: float) -> Bracket:
        """Search in doubles; a ball too wide for that is UNSURE."""
        q, n = self._body.quick, self._across
        if not q.exact_enough:
            return unsearched(high)
        x, v, a = (q.x, q.vx, q.ax) if self._along_x else (q.y, q.vy, q.ay)
        reach = float(self._reach)
        size = abs(x) + abs(self._line) + reach
        gap = (n * (x - self._line) - reach, n * v, 0.5 * n * a, 0.0, 0.0)

        def margin(s: float) -> float:
            return QUICK_ERROR * (size + s * (q.speed + s * q.pull))

        return first_entry_quick(gap, 0.0, high, margin)


class Meeting(NamedTuple):
    """When a gap closes: after s, at t; or not before t, where `s` is None [s]."""

    s: arb | None
    t: arb


def meeting(gap: Gap, bracket: Bracket, bits: int) -> Meeting | None:
    """Find when a gap that is open at first closes, in balls; None is never.

    `bracket` is what a quick search found.
    """
    if gap.curved:
        if not gap.value(ZERO) > 0:
            return Meeting(None, gap.t)
        found = first_entry_of(gap.value, gap.slope, ZERO, bracket.high, bits)
        return _narrowed(gap.t, gap.value, gap.slope, found)
    if bracket.verdict == UNSURE:
        coefficients = gap.coefficients()
        if bracket.low.is_zero() and not coefficients[0] > 0:
            if coefficients[0] < 0:
                return _after_overlap(gap, coefficients, bracket.high, bits)
            return Meeting(None, gap.t)
        bracket = first_entry(coefficients, bracket.low, bracket.high, bits)
    return _narrowed(gap.t, gap.value, gap.slope, bracket)


def meeting_again(gap: Gap, high: float, bits: int, *, still: bool = False) -> Meeting | None:
    """Find when a gap that is exactly 0 now closes again: at once, later, or never (None).

    `still` says that its rate is exactly 0, too, though computed from numbers that are not exact.

    Raises
    ------
    UndecidedError
        Where it can't be told whether they part.
    SustainedContactError
        Where they are pressed together.
    """
    now = Meeting(ZERO, gap.t)
    if gap.curved:
        return _meeting_again_in_air(gap, arb(high), bits, still=still)
    _, *rest = gap.coefficients()
    if still:
        rest[0] = ZERO
    if all(c.is_zero() for c in rest):
        return None
    if rest[0] < 0:
        return now
    if rest[0].is_zero():
        rest = rest[1:]
        if rest[0] < 0:
            raise SustainedContactError("pressed together", (gap.choice,), gap.t)
    if not rest[0] > 0:
        raise UndecidedError("whether they part or press", (gap.choice,), gap.t)
    return _narrowed(gap.t, *_horner(rest), first_entry(rest, ZERO, arb(high), bits))


def _meeting_again_in_air(gap: Gap, high: arb, bits: int, *, still: bool) -> Meeting | None:
    opens = gap.slope
    rate = ZERO if still else opens(ZERO)
    if rate < 0:
        return Meeting(ZERO, gap.t)
    if rate.is_zero():
        opens = gap.bend
        pull = opens(ZERO)
        if pull.is_zero() and isinstance(gap, CushionGap):
            return None  # it goes along the cushion
        if pull < 0:
            raise SustainedContactError("pressed together", (gap.choice,), gap.t)
    apart = parting(opens, high, bits) if opens(ZERO) > 0 else None
    if apart is None:
        raise UndecidedError("whether they part or press", (gap.choice,), gap.t)
    if apart >= high:
        return None
    found = first_entry_of(gap.value, gap.slope, apart, high, bits)
    return _narrowed(gap.t, gap.value, gap.slope, found)


def _after_overlap(gap: Gap, coefficients: list[arb], high: arb, bits: int) -> Meeting | None:
    """Find the next entry of balls that overlap by the rounding of the scene's numbers.

    The rule of the model (Bannerman, Strobl, Formella and Poeschel 2014): an overlap that closes is
    an impact now, one that opens is none.
    """
    if all(c.is_zero() for c in coefficients[1:]):
        return None
    rate, pull = coefficients[1:3]
    if rate < 0:
        return Meeting(ZERO, gap.t)
    if rate.is_zero() and pull < 0:
        raise SustainedContactError("pressed together", (gap.choice,), gap.t)
    left = first_entry([-c for c in coefficients], ZERO, high, bits)
    if left.verdict != ROOT:
        return Meeting(None, gap.t)
    again = first_entry(coefficients, left.high, high, bits)
    return _narrowed(gap.t, gap.value, gap.slope, again)


def _horner(coefficients: Sequence[arb]) -> tuple[Callable[[arb], arb], Callable[[arb], arb]]:
    """Return a polynomial and its derivative as functions."""

    def value(s: arb) -> arb:
        total = ZERO
        for c in reversed(coefficients):
            total = total * s + c
        return total

    def slope(s: arb) -> arb:
        total = ZERO
        for k in range(len(coefficients) - 1, 0, -1):
            total = total * s + k * coefficients[k]
        return total

    return value, slope


def _narrowed(
    t: arb, value: Callable[[arb], arb], slope: Callable[[arb], arb], bracket: Bracket
) -> Meeting | None:
    """Return the meeting in a bracket of times from t on, as narrow as the precision allows."""
    if bracket.verdict == NONE:
        return None
    if bracket.verdict == ROOT:
        s = refined(value, slope, bracket.low, bracket.high)
        if s is not None:
            return Meeting(s, t + s)
    return Meeting(None, t + bracket.low)


def cushion_choice(i: int, cushion: int) -> Choice:
    """Return what it is called when ball i meets a cushion."""
    return Choice(EventKind.BALL_CUSHION, i, cushion)

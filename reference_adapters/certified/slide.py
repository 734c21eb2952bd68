"""A ball that slides in air: its way has no closed form, and is enclosed piece by piece.

With the velocity v, the slip u and q = u - v, which is what the spin gives the lowest point,

    v' = -a e - k |v| v,   q' = -(5/2) a e,   e = u / |u|,   a = mu_s g:

friction and drag are both gradients of convex functions, a |u| and k |v|^3 / 3, in the metric of
the energy, |v|^2 + (2/5) |q|^2. So two slides never get farther from each other in this metric,
and a curve that fails the equations by d(t) is never farther from the true slide than it was at
first and the integral of |d| (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations
I, theorem I.10.6, with a logarithmic norm of 0). Each piece (`slide_piece`) is such a curve, with
a proved bound of its d. So no error is ever magnified, and what it begins with may be wide.

The direction of the slip turns like a power of what is left of it, so that pieces get shorter
towards the end, in a constant ratio, until bounds say enough about what is left (`_Tail`).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import NamedTuple

from flint import arb, ctx

from ghostball.reference_adapters.certified.arithmetic import (
    ONE,
    ZERO,
    UndecidedError,
    Vector,
    check_time,
    length,
    unit,
)
from ghostball.reference_adapters.certified.slide_piece import (
    SLIP_WEIGHT,
    Piece,
    State,
    next_piece,
)

_MOST_PIECES, _MORE_PIECES = 1_000, 8
"""Pieces of a slide, at most, and more for each bit: it takes two or three a bit.

Where the air is so thick, or the cloth so slippery, that a slide continues at a speed that hardly
changes, there would be more.
"""

_BLURRED = 64
"""Slip, in units of its error, below which shorter pieces say no more about the end."""


class Slide:
    """The way of one ball that slides in air, from an instant on, and a little beyond its end.

    After its end it goes straight on at a constant speed: a search that looks a little farther has
    something to look at.

    `duration` [s]: until it rolls.
    `end` (x, y) [m]: how far it has come then.
    `final_velocity` (vx, vy) [m/s].
    `pieces`: up to where a tiny part of the slide is left.
    """

    __slots__ = (
        "_drag",
        "_friction",
        "_hulls",
        "_leaves",
        "_starts",
        "_tail",
        "duration",
        "end",
        "final_velocity",
        "pieces",
    )

    def __init__(self, velocity: Vector, slip: Vector, friction: arb, drag: arb) -> None:
        """Enclose the slide that begins so.

        Raises `UndecidedError` where the slip may be 0, or may not end.
        """
        self._friction, self._drag = friction, drag
        # By symmetry a ball that neither goes nor slips across an axis stays on it.
        self._leaves = tuple(
            not (v.is_zero() and u.is_zero()) for v, u in zip(velocity, slip, strict=True)
        )
        state = State.of(velocity, slip)
        self.pieces: list[Piece] = []
        noise = (length(*state.v) + length(*state.q)) * arb((1, -ctx.prec))
        most = _MOST_PIECES + _MORE_PIECES * ctx.prec
        while True:
            size = length(*state.slip)
            if not size > SLIP_WEIGHT * state.error:
                raise UndecidedError("whether it slides or rolls")
            left = size / (3.5 * friction)
            if left * left * friction < noise or size < _BLURRED * SLIP_WEIGHT * state.error:
                break
            if len(self.pieces) == most:
                what = f"how a ball continues whose slide in air takes more than {most} pieces"
                raise UndecidedError(what, exact=True)
            check_time()
            piece = next_piece(state, friction, drag, noise)
            self.pieces.append(piece)
            state = piece.end
        self._starts = [*(piece.start.t for piece in self.pieces), state.t]
        self._hulls: dict[tuple[int, int, int], Vector] = {}
        displacement = self._blurred(state.displacement, state.displacement_error)
        v = self._blurred(state.v, state.error)
        u = self._blurred(state.slip, SLIP_WEIGHT * state.error)
        self._tail = _Tail.after(displacement, v, u, friction, drag)
        self.duration = state.t + self._tail.lasts
        self.end = self._on_axes(self._tail.end)
        self.final_velocity = self._on_axes(self._tail.final)

    def displacement(self, s: arb) -> Vector:
        """Return how far the ball has come after a time s; of a ball of times, the range [m]."""
        return self._over(s, 0)

    def velocity(self, s: arb) -> Vector:
        """Return its velocity after a time s [m/s]."""
        return self._over(s, 1)

    def slip(self, s: arb) -> Vector:
        """Return its slip after a time s [m/s]."""
        return self._over(s, 2)

    def acceleration(self, s: arb) -> Vector:
        """Return its acceleration after a time s, before the end [m/s^2]."""
        return self.slowed(self.velocity(s), self.slip(s))

    def slowed(self, v: Vector, u: Vector) -> Vector:
        """Return its acceleration at a velocity and a slip [m/s^2]."""
        drag = self._drag * length(*v)
        try:
            e = unit(*u, "where it slips to")
        except UndecidedError:
            e = self._on_axes((_within(ONE), _within(ONE)))
        return (-self._friction * e[0] - drag * v[0], -self._friction * e[1] - drag * v[1])

    def _over(self, s: arb, what: int) -> Vector:
        """Return the range of the displacement, the velocity or the slip over a ball of times."""
        low, high = s.lower(), s.upper()
        count = len(self.pieces)
        first = max(bisect_right(self._starts, low) - 1, 0)
        last = max(bisect_left(self._starts, high) - 1, first)
        ranges: list[Vector] = []
        for i in {first, last}:
            if i < count:
                ranges.append(self._in_piece(i, s, what))
        whole = (min(first + 1, count), min(last, count))
        if whole[0] < whole[1]:
            ranges.append(self._hull(what, *whole))
        if last == count:
            end = self.duration
            if not s > end:
                part = self._part(s, self._starts[-1], end.upper())
                ranges.append(self._in_tail(part - self._starts[-1], what))
            if not s < end:
                ranges.append(self._beyond(self._part(s, end.lower(), high) - end, what))
        return _united(*ranges)

    @staticmethod
    def _part(s: arb, low: arb, high: arb) -> arb:
        """Return what a ball of times has in common with an interval that it meets."""
        if s.lower() >= low and s.upper() <= high:
            return s
        return arb.max(s.lower(), low).union(arb.min(s.upper(), high))

    def _in_piece(self, i: int, s: arb, what: int) -> Vector:
        piece = self.pieces[i]
        s = self._part(s, piece.start.t, piece.end.t) - piece.start.t
        return self._blurred(piece.at(s, what), self._error(piece.end, what))

    def _hull(self, what: int, low: int, high: int) -> Vector:
        """Return the range over pieces from `low` to before `high`: of blocks that are kept."""
        found: list[Vector] = []
        while low < high:
            level = (high - low).bit_length() - 1
            while low & ((1 << level) - 1):
                level -= 1
            found.append(self._block(what, low, level))
            low += 1 << level
        return _united(*found)

    def _block(self, what: int, low: int, level: int) -> Vector:
        """Return the range over 2^level pieces from `low` on."""
        found = self._hulls.get((what, low, level))
        if found is None:
            if level == 0:
                piece = self.pieces[low]
                found = self._in_piece(low, piece.start.t.union(piece.end.t), what)
            else:
                halves = (low, low + (1 << (level - 1)))
                found = _united(*(self._block(what, half, level - 1) for half in halves))
            self._hulls[what, low, level] = found
        return found

    def _in_tail(self, s: arb, what: int) -> Vector:
        tail = self._tail
        x, y = tail.velocity if what < 2 else tail.slip
        if what == 0:
            x, y = tail.start[0] + s * x, tail.start[1] + s * y
        return self._on_axes((x, y))

    def _beyond(self, s: arb, what: int) -> Vector:
        """Return the same a time s after the end."""
        vx, vy = self.final_velocity
        if what == 0:
            return (self.end[0] + s * vx, self.end[1] + s * vy)
        return (vx, vy) if what == 1 else (ZERO, ZERO)

    @staticmethod
    def _error(state: State, what: int) -> arb:
        return (state.displacement_error, state.error, SLIP_WEIGHT * state.error)[what]

    def _blurred(self, value: Vector, error: arb) -> Vector:
        blur = _within(error)
        return self._on_axes((value[0] + blur, value[1] + blur))

    def _on_axes(self, value: Vector) -> Vector:
        """Return a vector with exactly 0 across an axis that the ball stays on."""
        return (value[0] if self._leaves[0] else ZERO, value[1] if self._leaves[1] else ZERO)


class _Tail(NamedTuple):
    """What bounds say of the last bit of a slide.

    `lasts` [s].
    `start`, `end` [m]: the ways when it begins and ends.
    `velocity`, `slip` [m/s]: their ranges all through it.
    `final` [m/s]: the velocity when it ends.
    """

    lasts: arb
    start: Vector
    end: Vector
    velocity: Vector
    slip: Vector
    final: Vector

    @classmethod
    def after(cls, displacement: Vector, v: Vector, u: Vector, friction: arb, drag: arb) -> _Tail:
        """Bound it. The air slows the ball by D(t), which changes by `change` at most.

        u' = -c e - D; so (c |u| - D(0).u)' = D(0)^2 - c^2 + (D(0) - c e).(D - D(0)), whatever way
        u turns, and (v - (2/7) u)' = -(5/7) D. The slip only gets less where c is above the drag.
        """
        slows, slip, speed = 3.5 * friction, length(*u), length(*v)
        most = (2 * slip / slows).upper()
        fastest = speed + friction * most
        drags = drag * fastest * fastest
        if drag * speed * speed >= slows:
            what = "how a ball continues that air slows by more than it can roll with"
            raise UndecidedError(what, exact=True)
        # Within `most` no drag is above that, and by such a one the slip ends within it.
        if not (slows > drags and slip / (slows - drags) <= most):
            raise UndecidedError("whether a slide in air ends")
        change = 2 * drag * fastest * (friction + drags) * most
        air = (drag * speed * v[0], drag * speed * v[1])
        now = drag * speed * speed
        falls = slows * slows - now * now + _within((slows + now) * change)
        if not falls > 0:
            raise UndecidedError("whether a slide in air ends")
        lasts = (slows * slip - air[0] * u[0] - air[1] * u[1]) / falls
        spread = (friction + drags) * lasts
        reach = 2 * slip * lasts / 7 + 5 * drags * lasts * lasts / 14
        rolls = [(7 * a - 2 * b) / 7 for a, b in zip(v, u, strict=True)]
        return cls(
            lasts,
            displacement,
            (
                displacement[0] + lasts * rolls[0] + _within(reach),
                displacement[1] + lasts * rolls[1] + _within(reach),
            ),
            (v[0] + _within(spread), v[1] + _within(spread)),
            (_within(slip), _within(slip)),
            (
                rolls[0] - 5 * lasts / 7 * (air[0] + _within(change)),
                rolls[1] - 5 * lasts / 7 * (air[1] + _within(change)),
            ),
        )


def _within(size: arb) -> arb:
    """Return a ball that holds all numbers up to a size."""
    return arb(0, size.upper())


def _united(*ranges: Vector) -> Vector:
    x, y = ranges[0]
    for ox, oy in ranges[1:]:
        x, y = _union(x, ox), _union(y, oy)
    return (x, y)


def _union(a: arb, b: arb) -> arb:
    return a if a.is_exact() and b.is_exact() and a == b else a.union(b)

"""Rolling in air, or on a cloth with quadratic friction: distance, speed and duration.

Along the straight path dv/dt = -(a + b v^2), with a = mu_r g. b is the quadratic friction of the
cloth plus (5/7) k for the air drag k v^2, because cloth friction takes the rest; for the paper's
point ball it is all of k. With q = v0 sqrt(b / a) and w = sqrt(a b):

    v(t) = (v0 - sqrt(a / b) tan(w t)) / (1 + q tan(w t)),  x(t) = ln(cos(w t) + q sin(w t)) / b,

until t = atan(q) / w, after the distance ln(1 + q^2) / 2b. Without cloth friction, a = 0, the ball
never stops: v = v0 / (1 + b v0 t), x = ln(1 + b v0 t) / b.

This motion isn't polynomial: contacts are searched on intervals of time, on which the gap is
enclosed by its value in the middle and its rate on the whole interval.
"""

from __future__ import annotations

from collections.abc import Callable

from flint import arb

from ghostball.reference_adapters.certified.arithmetic import ZERO
from ghostball.reference_adapters.certified.roots import NONE, ROOT, UNSURE, Bracket

Function = Callable[[arb], arb]

_CUT = 0.486
"""Fraction at which an interval is divided; not 1/2, where scenes of simple numbers have roots."""


class Roll:
    """The motion of one rolling ball from a given time.

    `distance`, `duration`: until the ball rests [m] and [s]; None if it never stops.
    """

    __slots__ = ("_a", "_b", "_q", "_v", "_w", "distance", "duration")

    def __init__(self, speed: arb, constant: arb, quadratic: arb) -> None:
        self._v, self._a, self._b = speed, constant, quadratic
        self.duration: arb | None = None
        self.distance: arb | None = None
        self._q = self._w = ZERO
        if not constant.is_zero():
            self._q = speed * (quadratic / constant).sqrt()
            self._w = (constant * quadratic).sqrt()
            self.duration = self._q.atan() / self._w
            self.distance = (self._q * self._q).log1p() / (2 * quadratic)

    def displacement(self, s: arb) -> arb:
        """Return the distance after a time s [m]; for an interval of times, the range."""
        return self._displacement(s.upper()) if s.is_exact() else self._range(self._displacement, s)

    def speed(self, s: arb) -> arb:
        """Return the speed after a time s [m/s]."""
        return self._speed(s.upper()) if s.is_exact() else self._range(self._speed, s)

    def deceleration(self, s: arb) -> arb:
        """Return the deceleration after a time s [m/s^2]."""
        v = self.speed(s)
        return self._a + self._b * v * v

    def series(self, s: arb, powers: int) -> list[arb]:
        """Return the coefficients of the displacement in powers of the time since s, from 1.

        (n + 1) v_{n+1} = -(a [n = 0] + b sum of v_i v_{n-i}).
        """
        v = [self.speed(s)]
        for n in range(powers - 1):
            square = sum((v[i] * v[n - i] for i in range(n + 1)), ZERO)
            v.append(-((self._a if n == 0 else ZERO) + self._b * square) / (n + 1))
        return [part / (n + 1) for n, part in enumerate(v)]

    def reach(self, s: arb) -> arb:
        """Return the radius of convergence of `series` at a time s [s], or a lower bound."""
        v = self.speed(s)
        if self.duration is None:
            return 1 / (self._b * v)
        # Distance to the pole of the tangent, at an earlier time.
        return arb.atan2(self._a.sqrt(), self._b.sqrt() * v) / self._w

    def _range(self, function: Function, s: arb) -> arb:
        # The ball never reverses, so both functions are monotonic.
        return function(s.lower()).union(function(s.upper()))

    def _displacement(self, s: arb) -> arb:
        if self.duration is None:
            return (self._b * self._v * s).log1p() / self._b
        assert self.distance is not None
        if s > self.duration:
            return self.distance
        turn = self._w * s
        return (turn.cos() + self._q * turn.sin()).log() / self._b

    def _speed(self, s: arb) -> arb:
        if self.duration is None:
            return self._v / (1 + self._b * self._v * s)
        if s > self.duration:
            return ZERO
        turn = (self._w * s).tan()
        return (self._v - self._v / self._q * turn) / (1 + self._q * turn)


def first_entry_of(value: Function, slope: Function, low: arb, high: arb, bits: int) -> Bracket:
    """Search for the first time in [low, high], both exact, at which a gap closes [s].

    `value`, `slope`: the gap and its rate; for an interval of times, enclosures over the interval.
    `bits`: the search ends with `UNSURE` at intervals of 2^-`bits` of the first one.
    """
    stack = [(low, high)]
    narrow = ((high - low) * arb((1, -bits))).upper()
    while stack:
        start, end = stack.pop()
        span = start.union(end)
        rate = slope(span)
        middle = (start + _CUT * (end - start)).mid()
        if value(middle) + rate * (span - middle) > 0 or (rate > 0 and value(start) > 0):
            continue
        if rate < 0 and value(start) > 0 and value(end) < 0:
            return Bracket(ROOT, start, end)
        if end - start <= narrow or not start < middle < end:
            return Bracket(UNSURE, start, high)
        stack += [(middle, end), (start, middle)]
    return Bracket(NONE, high, high)


def parting(slope: Function, high: arb, bits: int) -> arb | None:
    """Return a time until which a gap that is 0 only opens [s]; None if unknown."""
    for _ in range(bits):
        if slope(ZERO.union(high)) > 0:
            return high
        high = (high / 2).mid()
    return None

"""A ball that rolls in air, or on a cloth that slows fast balls more: how far, how fast, how long.

Along its straight way dv/dt = -(a + b v^2), a = mu_r g; b is (5/7) k of the air's k v^2, for the
cloth's friction takes the rest, but all of it for the paper's point, and what the cloth adds. With
q = v0 sqrt(b / a) and w = sqrt(a b):

    v(t) = (v0 - sqrt(a / b) tan(w t)) / (1 + q tan(w t)),  x(t) = ln(cos(w t) + q sin(w t)) / b,

until t = atan(q) / w, after ln(1 + q^2) / 2b. Without friction of the cloth, a = 0, the ball never
stops: v = v0 / (1 + b v0 t), x = ln(1 + b v0 t) / b.

Such a way is no polynomial: where it meets another is searched on intervals of time, on which the
gap lies within its value in the middle and its rate over all of them.
"""

from __future__ import annotations

from collections.abc import Callable

from flint import arb

from ghostball.reference_adapters.certified.arithmetic import ZERO
from ghostball.reference_adapters.certified.roots import NONE, ROOT, UNSURE, Bracket

Function = Callable[[arb], arb]

_CUT = 0.486
"""Where an interval is cut, in parts of it: not in halves, where roots of simple numbers lie."""


class Roll:
    """The way of one ball from an instant on.

    `distance`, `duration` [m] and [s]: until it rests; None where nothing stops it.
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
        """Return how far the ball has come after a time s; of a ball of times, the range [m]."""
        return self._displacement(s.upper()) if s.is_exact() else self._range(self._displacement, s)

    def speed(self, s: arb) -> arb:
        """Return how fast it is after a time s [m/s]."""
        return self._speed(s.upper()) if s.is_exact() else self._range(self._speed, s)

    def deceleration(self, s: arb) -> arb:
        """Return by how much it is slowed after a time s [m/s^2]."""
        v = self.speed(s)
        return self._a + self._b * v * v

    def series(self, s: arb, powers: int) -> list[arb]:
        """Return the displacement after a time s in powers of the time since, from the first on.

        (n + 1) v_{n+1} = -(a [n = 0] + b sum of v_i v_{n-i}).
        """
        v = [self.speed(s)]
        for n in range(powers - 1):
            square = sum((v[i] * v[n - i] for i in range(n + 1)), ZERO)
            v.append(-((self._a if n == 0 else ZERO) + self._b * square) / (n + 1))
        return [part / (n + 1) for n, part in enumerate(v)]

    def reach(self, s: arb) -> arb:
        """Return how far from a time s that series converges [s]; at least, where it is over."""
        v = self.speed(s)
        if self.duration is None:
            return 1 / (self._b * v)
        # Up to the pole of the tangent, where the ball would have come from.
        return arb.atan2(self._a.sqrt(), self._b.sqrt() * v) / self._w

    def _range(self, function: Function, s: arb) -> arb:
        # The ball never turns back: both only rise, or only fall.
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
    """Search for the first instant in [low, high] at which a gap closes, both exact [s].

    `value`, `slope`: the gap and its rate; of a ball of times, a ball that holds them at all of
        these.
    `bits`: the search gives up, with `UNSURE`, where intervals come down to 2^-`bits` of the first.
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
    """Return an instant until which a gap that is 0 only opens [s]; None where that isn't known."""
    for _ in range(bits):
        if slope(ZERO.union(high)) > 0:
            return high
        high = (high / 2).mid()
    return None

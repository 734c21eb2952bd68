"""A slide in air as polynomial pieces: the interface of an integrated slide.

A slide in air has no closed form, and can't be certified. If `prove` gets an integrator of slides,
its result is integrated and isn't a proof (`validation.truth.integration`).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from operator import attrgetter
from typing import NamedTuple

from flint import arb, arb_poly

from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    UndecidedError,
    Vector,
    length as length_of,
    unit,
)

_START = attrgetter("start")


class SlidePiece(NamedTuple):
    """Polynomials in the time since `start` [s]: displacement, velocity and slip, for x and y."""

    start: arb
    displacement: tuple[arb_poly, arb_poly]
    velocity: tuple[arb_poly, arb_poly]
    slip: tuple[arb_poly, arb_poly]


class IntegratedSlide(NamedTuple):
    """A slide in air from a given time to a little beyond its end.

    `friction`: deceleration by the cloth [m/s^2].
    `drag`: k in the deceleration k v^2 by the air [1/m].
    `pieces`: the last piece continues in a straight line after the end, for searches beyond it.
    `duration`: time until the ball rolls [s].
    `end`: displacement at that time, (x, y) [m].
    `final_velocity`: (vx, vy) [m/s].
    """

    friction: arb
    drag: arb
    pieces: list[SlidePiece]
    duration: arb
    end: Vector
    final_velocity: Vector

    def displacement(self, s: arb) -> Vector:
        """Return the displacement after a time s [m]; for an interval of times, the range."""
        return self._range(s, 0)

    def velocity(self, s: arb) -> Vector:
        """Return the velocity after a time s [m/s]."""
        return self._range(s, 1)

    def slip(self, s: arb) -> Vector:
        """Return the slip after a time s [m/s]."""
        return self._range(s, 2)

    def acceleration(self, s: arb) -> Vector:
        """Return the acceleration after a time s, before the end [m/s^2]."""
        return self.slowed(self.velocity(s), self.slip(s))

    def slowed(self, v: Vector, u: Vector) -> Vector:
        """Return the acceleration at a velocity and a slip [m/s^2]."""
        air = self.drag * length_of(*v)
        try:
            e = unit(*u, "where it slips to")
        except UndecidedError:
            x, y = (ZERO if part.is_zero() else arb(0, 1) for part in u)
            e = (x, y)
        return (-self.friction * e[0] - air * v[0], -self.friction * e[1] - air * v[1])

    def _range(self, s: arb, what: int) -> Vector:
        low, high = s.lower(), s.upper()
        first = max(bisect_right(self.pieces, low, key=_START) - 1, 0)
        last = max(bisect_left(self.pieces, high, key=_START) - 1, first)
        ranges: list[Vector] = []
        for k in range(first, last + 1):
            since, part = self.pieces[k].start, s
            if first < last:
                until = high if k == last else self.pieces[k + 1].start
                part = (low if k == first else since).union(until)
            piece = self.pieces[k]
            path = (piece.displacement, piece.velocity, piece.slip)[what]
            ranges.append((path[0](part - since), path[1](part - since)))
        x, y = ranges[0]
        for other in ranges[1:]:
            x, y = _union(x, other[0]), _union(y, other[1])
        return (x, y)


def _union(a: arb, b: arb) -> arb:
    return a if a.is_zero() and b.is_zero() else a.union(b)


Integrator = Callable[[Vector, Vector, arb, arb], IntegratedSlide]
"""Function of velocity [m/s], slip [m/s], cloth friction [m/s^2] and drag [1/m]: the slide."""

"""Integrate slides in air by collocation at Gauss points, with 40 digits.

    v' = -a e - k |v| v,   u' = -(7/2) a e - k |v| v,   e = u / |u|,

where v is the velocity and u the slip (Hairer, Norsett and Wanner 1993, section II.7). A step is a
fraction of the time in which the slip or the velocity could vanish, because the equations are
singular there. The last part of the slip ends with a constant drag D: then ((7/2) a |u| - D.u)' =
D^2 - (7/2)^2 a^2, for any rotation of the slip.
"""

from __future__ import annotations

from flint import arb, arb_mat, arb_poly

from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    UndecidedError,
    Vector,
    length,
    working_precision,
)
from ghostball.reference_adapters.certified.integrated_slide import IntegratedSlide, SlidePiece

BITS = 192
"""Precision of all numbers: 40 digits, plus the loss by powers of the time in a step."""

_NEGLIGIBLE_SHARE = arb((1, -50))
"""Share of slip and speed below which a slip ends with constant drag, and below which drag is
ignored.

The error is about the square of this.
"""

_CONVERGED = arb((1, -120))
"""Change of the rates in an iteration, in units of the friction rate, that ends the iteration."""

_MOST_ITERATIONS = 200
"""Largest number of iterations in a step: each gains one or two digits."""

_MOST_STEPS = 1_000
"""Largest number of steps of a slide: typically some hundred, and more in thick air."""


class Collocation:
    """An integrator of slides in air (`integrated_slide.Integrator`).

    `points`: collocation points of a step.
    `part`: length of a step, in units of the time to the singularity.
    """

    def __init__(self, points: int, part: arb) -> None:
        self._points, self._part = points, part
        every = range(points)
        with working_precision(4 * BITS):  # the inverse loses three quarters of the digits
            nodes = [(1 - arb.legendre_p_root(points, j)) / 2 for j in every]
            powers = arb_mat([[node**m for m in every] for node in nodes]).inv()
            up_to = arb_mat([[node ** (m + 1) / (m + 1) for m in every] for node in nodes])
            self._to_integrals, self._to_powers = (up_to * powers).mid(), powers.mid()

    def __call__(self, v: Vector, u: Vector, friction: arb, drag: arb) -> IntegratedSlide:
        """Return the slide."""
        a, k, c = friction.mid(), drag.mid(), 3.5 * friction.mid()
        pieces: list[SlidePiece] = []
        t, r, y = ZERO, (ZERO, ZERO), [number.mid() for number in (*v, *u)]
        least = _NEGLIGIBLE_SHARE * length(y[2], y[3])
        still = least + _NEGLIGIBLE_SHARE * length(y[0], y[1])

        def go_on(polys: list[arb_poly], h: arb) -> None:
            """Add a piece with these velocities and slips, and a duration `h`."""
            nonlocal t, r, y
            x, z = (p.integral() + start for p, start in zip(polys, r, strict=False))
            pieces.append(SlidePiece(t, (x, z), (polys[0], polys[1]), (polys[2], polys[3])))
            t, r, y = (t + h).mid(), (x(h).mid(), z(h).mid()), [p(h).mid() for p in polys]

        while (size := length(y[2], y[3])) > least:
            if len(pieces) == _MOST_STEPS:
                raise UndecidedError("whether a slide in air ends", exact=True)
            speed = length(y[0], y[1])
            pull = a + k * speed * speed
            h = self._part * arb.min(size / (c + pull), speed / pull).mid()
            if not speed > still:
                h = self._part * arb.min(size / c, still / a).mid()
            rates = self._solved(y, h, a, k if speed > still else ZERO)
            powers, over = (self._to_powers * rates).mid(), arb_poly([0, 1 / h])
            each = [[powers[m, j] for m in range(self._points)] for j in range(4)]
            go_on([arb_poly(each[j])(over).integral() + y[j] for j in range(4)], h)
        if not c > k * length(y[0], y[1]) ** 2:
            what = "how a ball moves on if air slows it by more than rolling allows"
            raise UndecidedError(what, exact=True)
        drags = [k * length(y[0], y[1]) * part for part in y[:2]]
        lasts = c * length(y[2], y[3]) - drags[0] * y[2] - drags[1] * y[3]
        lasts = (lasts / (c * c - drags[0] * drags[0] - drags[1] * drags[1])).mid()
        final = [(y[j] - y[j + 2] / 3.5 - lasts * drags[j] / 1.4).mid() for j in range(2)]
        ends = [*final, ZERO, ZERO]
        go_on([arb_poly([w, (e - w) / lasts]) for w, e in zip(y, ends, strict=True)], lasts)
        duration, end = t, r
        go_on([arb_poly([w]) for w in ends], ZERO)
        return IntegratedSlide(friction, drag, pieces, duration, end, (final[0], final[1]))

    def _solved(self, y: list[arb], h: arb, a: arb, k: arb) -> arb_mat:
        """Return the rates of velocity and slip at the points of a step, (points, 4)."""

        def rates_at(vx: arb, vy: arb, ux: arb, uy: arb) -> list[arb]:
            cloth, air = a / length(ux, uy), k * length(vx, vy)
            dx, dy = -air * vx, -air * vy
            return [dx - cloth * ux, dy - cloth * uy, dx - cloth * 3.5 * ux, dy - cloth * 3.5 * uy]

        rates = arb_mat([rates_at(*y)] * self._points)
        for _ in range(_MOST_ITERATIONS):
            moved, before = (self._to_integrals * rates * h).mid().tolist(), rates
            states = [[w + d for w, d in zip(y, row, strict=True)] for row in moved]
            rates = arb_mat([rates_at(*state) for state in states]).mid()
            if all(abs(x) < _CONVERGED * a for x in (rates - before).entries()):
                return rates
        raise UndecidedError("how a slide in air continues", exact=True)

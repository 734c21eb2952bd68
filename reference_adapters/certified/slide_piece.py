"""One piece of a slide in air: polynomials, and a proved bound of how far the true slide is off.

The polynomials are the power series of the motion, cut; how they were found proves nothing. What
proves is how well they meet the equations (`slide`), which is a matter of a few products: with
polynomials E for the direction of the slip and S for the speed,

    | U / |U| - E |  is at most  2 |U - r E| / |U| + ||E|^2 - 1|,   r a polynomial for |U|,
    | |V| - S |      is at most  |S^2 - |V|^2| / S,

each a polynomial whose coefficients, by their sizes, bound it all through the piece.
"""

from __future__ import annotations

from operator import mul
from typing import NamedTuple

from flint import arb, arb_poly, ctx

from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    UndecidedError,
    Vector,
    length,
    working_precision,
)

_PIECE_LENGTH = arb((1, -2))
"""Length of a piece, in units of a time within which neither slip nor velocity can vanish.

So its series falls like 4^-n: the shorter, the more pieces; the longer, the more powers.
"""

_LENGTH_BITS = 16
"""To which the length of a piece is rounded, so that sums of them are exact.

No piece is shorter than what half the bits resolve of the first.
"""

_MOST_POWERS = 4
"""Powers of a piece, at most, for each bit of the precision."""

SLIP_WEIGHT = arb("1.8709")
"""sqrt(7/2), and more: how far the slip may be off where the distance in that metric is 1."""

_SPIN_WEIGHT = arb("0.6325")
"""sqrt(2/5), and more: the weight of q in the metric of the energy."""

Series = list[arb]


class State(NamedTuple):
    """Where a curve near the true slide is at an instant.

    `t` [s]: since the slide began.
    `displacement` (x, y) [m], exact.
    `v`, `q` [m/s]: velocity, and what the spin adds to it in the slip.
    `error`, `displacement_error` [m/s] and [m]: how far the true slide is off at most, in the
        metric of the energy, and in its place.
    """

    t: arb
    displacement: Vector
    v: Vector
    q: Vector
    error: arb
    displacement_error: arb

    @classmethod
    def of(cls, velocity: Vector, slip: Vector) -> State:
        """Return the state in which a slide begins."""
        q = (slip[0] - velocity[0], slip[1] - velocity[1])
        middle = (velocity[0].mid(), velocity[1].mid()), (q[0].mid(), q[1].mid())
        nothing = (ZERO, ZERO)
        return cls(ZERO, nothing, *middle, _off(velocity, q), ZERO)

    @property
    def slip(self) -> Vector:
        """The slip [m/s]."""
        return (self.v[0] + self.q[0], self.v[1] + self.q[1])


class Piece(NamedTuple):
    """Polynomials of the time since `start`, up to `end`: displacement, velocity, slip; x and y."""

    start: State
    end: State
    displacement: tuple[arb_poly, arb_poly]
    velocity: tuple[arb_poly, arb_poly]
    slip: tuple[arb_poly, arb_poly]

    def at(self, s: arb, what: int) -> Vector:
        """Return the displacement (0), the velocity (1) or the slip (2) after a time s."""
        x, y = (self.displacement, self.velocity, self.slip)[what]
        return (x(s), y(s))


def next_piece(start: State, friction: arb, drag: arb, noise: arb) -> Piece:
    """Return the piece from a state on.

    `friction`, `drag` [m/s^2] and [1/m].
    `noise` [m/s]: what doesn't matter.

    Raises `UndecidedError` where the slip may end within the piece.
    """
    size, speed = length(*start.slip), length(*start.v)
    pull = friction + drag * speed * speed
    h = _PIECE_LENGTH * size / (pull + 2.5 * friction)
    # So slow that for all its time air does less than what doesn't matter.
    slow = (noise * friction / (drag + 1)).root(3)
    drags = bool(speed > slow)
    h = arb.min(h, _PIECE_LENGTH * speed / pull if drags else slow / friction)
    with working_precision(_LENGTH_BITS):
        h = (1 * h).mid()
    with working_precision(ctx.prec + 4 * _LENGTH_BITS):
        t = start.t + h
    if not t.is_exact():
        raise UndecidedError("how a ball continues that slides in air")
    vx, vy, qx, qy, found = _series(start, h, friction, drag if drags else ZERO, noise)
    v, q = (arb_poly(vx), arb_poly(vy)), (arb_poly(qx), arb_poly(qy))
    u = (v[0] + q[0], v[1] + q[1])
    failure, least = _failure(v, q, u, found, h, friction, drag)
    error = (start.error + failure * h).upper()
    if not least > SLIP_WEIGHT * error:
        raise UndecidedError("whether it slides or rolls")
    displacement_error = (start.displacement_error + error * h).upper()
    displacement = (
        v[0].integral() + start.displacement[0],
        v[1].integral() + start.displacement[1],
    )
    places, speeds, spins = ((p[0](h), p[1](h)) for p in (displacement, v, q))
    end = State(
        t,
        (places[0].mid(), places[1].mid()),
        (speeds[0].mid(), speeds[1].mid()),
        (spins[0].mid(), spins[1].mid()),
        (error + _off(speeds, spins)).upper(),
        (displacement_error + places[0].rad() + places[1].rad()).upper(),
    )
    return Piece(start, end, displacement, v, u)


def _off(v: Vector, q: Vector) -> arb:
    """Return a bound of how far the balls of a velocity and of q reach, in the metric."""
    return (v[0].rad() + v[1].rad() + _SPIN_WEIGHT * (q[0].rad() + q[1].rad())).upper()


class _Found(NamedTuple):
    """Series for the slip's size and direction, and the speed; the latter empty without air."""

    size: Series
    ex: Series
    ey: Series
    speed: Series


def _series(
    start: State, h: arb, friction: arb, drag: arb, noise: arb
) -> tuple[Series, Series, Series, Series, _Found]:
    """Return the power series of velocity and q, and of what they are made of; middles only.

    r' = e.u' for r = |u|; e from u = r e; the speed from s^2 = v^2.
    """
    friction, drag = friction.mid(), drag.mid()
    drags = not drag.is_zero()
    ux, uy = ([part.mid()] for part in start.slip)
    vx, vy, qx, qy = ([part] for part in (*start.v, *start.q))
    r, s = [length(ux[0], uy[0]).mid()], [length(vx[0], vy[0]).mid()]
    ex, ey = [(ux[0] / r[0]).mid()], [(uy[0] / r[0]).mid()]
    rate_x, rate_y = [ZERO], [ZERO]  # n u_n
    scale, small, n = arb(1), 0, 0
    spins = 2.5 * friction
    while small < 2 and n < _MOST_POWERS * ctx.prec:
        if n > 0:
            r.append(((_dot(ex, rate_x[:0:-1]) + _dot(ey, rate_y[:0:-1])) / n).mid())
            ex.append(((ux[n] - _dot(r[1:], ex[::-1])) / r[0]).mid())
            ey.append(((uy[n] - _dot(r[1:], ey[::-1])) / r[0]).mid())
            if drags:
                square = _dot(vx, vx[::-1]) + _dot(vy, vy[::-1]) - _dot(s[1:], s[:0:-1])
                s.append((square / (2 * s[0])).mid())
        ax, ay = friction * ex[n], friction * ey[n]
        if drags:
            ax, ay = ax + drag * _dot(s, vx[::-1]), ay + drag * _dot(s, vy[::-1])
        vx.append((-ax / (n + 1)).mid())
        vy.append((-ay / (n + 1)).mid())
        qx.append((-spins * ex[n] / (n + 1)).mid())
        qy.append((-spins * ey[n] / (n + 1)).mid())
        n += 1
        ux.append((vx[n] + qx[n]).mid())
        uy.append((vy[n] + qy[n]).mid())
        rate_x.append(n * ux[n])
        rate_y.append(n * uy[n])
        scale = (scale * h).mid()
        term = scale * (abs(ux[n]) + abs(uy[n]) + abs(vx[n]) + abs(vy[n]))
        small = small + 1 if term < noise else 0
    return vx, vy, qx, qy, _Found(r, ex, ey, s if drags else [])


def _dot(a: Series, b: Series) -> arb:
    return sum(map(mul, a, b), ZERO)


def _failure(
    v: tuple[arb_poly, arb_poly],
    q: tuple[arb_poly, arb_poly],
    u: tuple[arb_poly, arb_poly],
    found: _Found,
    h: arb,
    friction: arb,
    drag: arb,
) -> tuple[arb, arb]:
    """Return how far a piece fails the equations, in the metric of the energy, and its least slip.

    Bounds of both [m/s^2], [m/s].

    Raises `UndecidedError` where slip or velocity may vanish within the piece.
    """
    r, ex, ey = arb_poly(found.size), arb_poly(found.ex), arb_poly(found.ey)
    least = length(u[0][0], u[1][0]) - _size(u[0] - u[0][0], h) - _size(u[1] - u[1][0], h)
    difference = _size(u[0] - r * ex, h) + _size(u[1] - r * ey, h)
    if not least > difference:
        raise UndecidedError("whether it slides or rolls")
    turned = 2 * difference / least + _size(ex * ex + ey * ey - 1, h)
    miss_v = [v[0].derivative() + friction * ex, v[1].derivative() + friction * ey]
    fastest = _size(v[0], h) + _size(v[1], h)
    if found.speed:
        s = arb_poly(found.speed)
        slowest = s[0] - _size(s - s[0], h)
        if not slowest > 0:
            raise UndecidedError("how a ball continues that slides in air")
        miss_v = [miss_v[0] + drag * (s * v[0]), miss_v[1] + drag * (s * v[1])]
        wrong = _size(s * s - v[0] * v[0] - v[1] * v[1], h) / slowest
    else:
        wrong = fastest
    of_v = _size(miss_v[0], h) + _size(miss_v[1], h) + friction * turned + drag * wrong * fastest
    spins = 2.5 * friction
    miss_q = [q[0].derivative() + spins * ex, q[1].derivative() + spins * ey]
    of_q = _size(miss_q[0], h) + _size(miss_q[1], h) + spins * turned
    return (of_v + _SPIN_WEIGHT * of_q).upper(), least


def _size(p: arb_poly, h: arb) -> arb:
    """Return a bound of a polynomial's size on [0, h]."""
    total = ZERO
    for c in reversed(p.coeffs()):
        total = total * h + abs(c)
    return arb(total.upper())

"""Real numbers as balls that surely hold them (python-flint's `arb`), and how a decision fails."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from operator import mul, sub

from flint import arb, ctx, fmpq

from ghostball.reference_adapters.certified.certificate import Choice, Enclosure

ZERO = arb(0)
ONE = arb(1)

Vector = tuple[arb, arb]

Direction = tuple[arb, ...]
"""A vector in the plane or in space."""


@contextmanager
def working_precision(bits: int) -> Iterator[None]:
    """Compute with `bits` bits inside; the precision is one for the whole process."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


class OutOfTimeError(Exception):
    """The computing time is over."""


@contextmanager
def computing_until(deadline: float) -> Iterator[None]:
    """Let `check_time` raise, inside, from this instant of `time.perf_counter` on."""
    before = _clock[0]
    _clock[0] = deadline
    try:
        yield
    finally:
        _clock[0] = before


_clock = [math.inf]


def check_time() -> None:
    """Raise `OutOfTimeError` where the computing time is over; for what may take long."""
    if time.perf_counter() > _clock[0]:
        raise OutOfTimeError


class UndecidedError(Exception):
    """What happens next can't be decided in the precision at hand.

    `what`: what can't be decided, in one clause.
    `choices`: the events that may come next, or whose outcome is open.
    `t` [s]: when.
    `exact`: whether no precision could decide it: the numbers are equal.
    """

    def __init__(
        self, what: str, choices: tuple[Choice, ...] = (), t: arb = ZERO, *, exact: bool = False
    ) -> None:
        super().__init__(what)
        self.what = what
        self.choices = choices
        self.t = t
        self.exact = exact


class SustainedContactError(Exception):
    """From here on balls are in resting contact with others or a cushion, which has no closed form.

    Attributes are those of `UndecidedError`.
    """

    def __init__(self, what: str, choices: tuple[Choice, ...], t: arb) -> None:
        super().__init__(what)
        self.what = what
        self.choices = choices
        self.t = t


def exactly(value: float) -> fmpq:
    """Return the rational number that a double is."""
    return fmpq(*value.as_integer_ratio())


def enclosure_of(value: arb) -> Enclosure:
    """Return an arb as plain integers, without any rounding."""
    mid, rad = value.mid().man_exp(), value.rad().man_exp()
    return Enclosure(int(mid[0]), int(mid[1]), int(rad[0]), int(rad[1]))


def length(x: arb, y: arb) -> arb:
    """Return sqrt(x^2 + y^2), exact along an axis."""
    if y.is_zero():
        return abs(x)
    if x.is_zero():
        return abs(y)
    square = x * x + y * y
    if square > 0:
        return square.sqrt()
    return ZERO.union(square.upper().sqrt())


def unit(x: arb, y: arb, what: str) -> Vector:
    """Return (x, y) over its length; exact along an axis.

    Raises `UndecidedError` where (x, y) may be 0; `what` says what that would mean.
    """
    if y.is_zero():
        return (_sign(x, what), ZERO)
    if x.is_zero():
        return (ZERO, _sign(y, what))
    square = x * x + y * y
    if not square > 0:
        raise UndecidedError(what)
    size = square.sqrt()
    return (x / size, y / size)


def _sign(x: arb, what: str) -> arb:
    if x > 0:
        return ONE
    if x < 0:
        return -ONE
    raise UndecidedError(what)


def dot(x: Direction, y: Direction) -> arb:
    """Return the scalar product."""
    return sum(map(mul, x, y), ZERO)


def minus(x: Direction, y: Direction) -> Direction:
    """Return the difference of two vectors."""
    return tuple(map(sub, x, y))


def radius_of(value: arb) -> float:
    """Return the radius of a ball, rounded up."""
    return float(value.rad()) * (1.0 + 1e-15)

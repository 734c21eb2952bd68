"""Real numbers as intervals (python-flint's `arb`), and errors for open decisions."""

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
    """Compute with `bits` bits inside the block; the precision is global to the process."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


class OutOfTimeError(Exception):
    """The time limit of the computation is reached."""


@contextmanager
def computing_until(deadline: float) -> Iterator[None]:
    """Make `check_time` raise inside the block once `time.perf_counter` exceeds the deadline."""
    before = _clock[0]
    _clock[0] = deadline
    try:
        yield
    finally:
        _clock[0] = before


_clock = [math.inf]


def check_time() -> None:
    """Raise `OutOfTimeError` if the time limit is reached; called in long computations."""
    if time.perf_counter() > _clock[0]:
        raise OutOfTimeError


class ProofEndsError(Exception):
    """A run can't prove the next event.

    `what`: clause that names the open question, or the contact that begins.
    `choices`: the possible next events, or the events with an open outcome.
    `t`: time [s].
    `exact`: whether no precision could decide the question, because the numbers are equal.
    """

    def __init__(
        self, what: str, choices: tuple[Choice, ...] = (), t: arb = ZERO, *, exact: bool = False
    ) -> None:
        super().__init__(what)
        self.what, self.choices, self.t, self.exact = what, choices, t, exact


class UndecidedError(ProofEndsError):
    """The next event can't be decided with the present precision."""


class SustainedContactError(ProofEndsError):
    """Balls are in resting contact from now on, which has no closed form."""


def exactly(value: float) -> fmpq:
    """Return the exact value of a double as a rational number."""
    return fmpq(*value.as_integer_ratio())


def enclosure_of(value: arb) -> Enclosure:
    """Return an arb as integers, without rounding."""
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
    """Return (x, y) divided by its length; exact along an axis.

    Raises `UndecidedError` with the clause `what` if (x, y) may be 0.
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
    """Return the scalar product of two vectors."""
    return sum(map(mul, x, y), ZERO)


def minus(x: Direction, y: Direction) -> Direction:
    """Return the difference of two vectors."""
    return tuple(map(sub, x, y))


def radius_of(value: arb) -> float:
    """Return the radius of an interval, rounded up."""
    return float(value.rad()) * (1.0 + 1e-15)

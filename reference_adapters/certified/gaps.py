"""The gap of two balls as a function of time; `obstacle_gaps` has the gaps to obstacles.

It is |r + v s + a s^2 / 2|^2 - D^2, of degree 4 in the time s since the later of their start times;
in space if one ball is in the air, otherwise in the plane. If air slows a ball, the gap isn't
polynomial.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from operator import mul, sub

from flint import arb

from ghostball.model import Phase
from ghostball.reference_adapters.certified.arithmetic import (
    ZERO,
    Direction,
    UndecidedError,
    dot,
    minus,
    unit,
)
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.motion import Body
from ghostball.reference_adapters.certified.roots import (
    Bracket,
    first_entry_in_doubles,
    unsearched,
)

DOUBLES_ERROR = 1e-10
"""Error bound of a search in doubles, relative to the sum of all terms.

A state that is `exact_enough` has an error of 1e-13 of its terms, doubles round by 1e-16, and a
coefficient is the sum of a few terms.
"""


class DistanceGap(ABC):
    """The squared length of a moving vector minus the square of a reach [m^2].

    `t`: time at which s is 0 [s].
    `choice`: the event when it closes.
    `reach`: distance at contact [m].
    `curved`: whether air slows a ball; then the gap isn't polynomial.
    """

    t: arb
    choice: Choice
    reach: arb
    curved: bool

    @abstractmethod
    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return the vector at a time s after `t` [m], or its first or second derivative."""

    def coefficients(self) -> list[arb]:
        """Return the coefficients, the constant first [m^2, m^2/s ...]."""
        r, v, a = (self.vector(ZERO, order) for order in range(3))
        return [
            dot(r, r) - self.reach * self.reach,
            2 * dot(r, v),
            dot(v, v) + dot(r, a),
            dot(v, a),
            dot(a, a) / 4,
        ]

    def value(self, s: arb) -> arb:
        """Return the gap after a time s, from positions: narrower than from powers of s."""
        r = self.vector(s)
        return dot(r, r) - self.reach * self.reach

    def slope(self, s: arb) -> arb:
        """Return the derivative of the gap after a time s."""
        return 2 * dot(self.vector(s), self.vector(s, 1))

    def bend(self, s: arb) -> arb:
        """Return the second derivative of the gap after a time s."""
        v = self.vector(s, 1)
        return 2 * (dot(v, v) + dot(self.vector(s), self.vector(s, 2)))

    def normal(self, s: arb, *, touching: bool) -> Direction:
        """Return the unit vector along the gap after a time s, when it is closed."""
        r = self.vector(s)
        if touching:
            return tuple(x / self.reach for x in r)
        square = dot(r, r)
        if not square > 0:
            raise UndecidedError("where they meet")
        size = square.sqrt()
        return tuple(x / size for x in r)


class PairGap(DistanceGap):
    """The gap of two balls.

    `free`: whether one of them is in the air; then it is a gap in space.
    `reach`: the sum of their radii [m]; smaller for balls of different sizes on the cloth of an
        airborne scene, whose contact normal isn't horizontal.
    """

    def __init__(self, a: Body, b: Body, choice: Choice, reach: arb | None = None) -> None:
        self.choice = choice
        self._a, self._b = a, b
        self.curved = a.curved or b.curved
        self.free = Phase.FLYING in (a.phase, b.phase)
        self._later = a if a.order >= b.order else b
        self.t = self._later.t
        radii = a.constants.radius + b.constants.radius
        self.reach = radii if reach is None or self.free else reach
        self._start: tuple[Direction, ...] | None = None

    def _age(self, body: Body, s: arb) -> arb:
        if body.resting:
            return ZERO
        return s if body.order == self._later.order else (self.t - body.t) + s

    def vector(self, s: arb, order: int = 0) -> Direction:
        """Return the position of b relative to a at a time s [m], or its derivatives."""
        if self.curved:
            return self._apart(s, order)
        if self._start is None:
            self._start = tuple(self._apart(ZERO, of_start) for of_start in range(3))
        r, v, a = self._start
        if order == 0:
            return tuple(x + s * (y + s * z / 2) for x, y, z in zip(r, v, a, strict=True))
        return a if order == 2 else tuple(y + s * z for y, z in zip(v, a, strict=True))

    def _apart(self, s: arb, order: int) -> Direction:
        first, second = (
            motion_of(body, self._age(body, s), order, in_space=self.free)
            for body in (self._a, self._b)
        )
        return minus(second, first)

    def normal(self, s: arb, *, touching: bool) -> Direction:
        """Return the unit normal from a to b at their contact, after a time s."""
        if not self.free:
            x, y = self.vector(s)
            if x.is_zero() or y.is_zero() or not touching:
                return unit(x, y, "where two balls meet")
        return super().normal(s, touching=touching)

    def search_in_doubles(self, high: float) -> Bracket:
        """Search in doubles; UNSURE if the intervals of a ball are too wide."""
        a, b = self._a.doubles, self._b.doubles
        if not (a.exact_enough and b.exact_enough):
            return unsearched(high)
        # Times are subtracted before rounding, because the difference of rounded times is coarser.
        sa, sb = (float(self._age(body, ZERO)) for body in (self._a, self._b))
        first = motion_in_doubles(self._a, sa, in_space=self.free)
        second = motion_in_doubles(self._b, sb, in_space=self.free)
        motion = [list(map(sub, of_b, of_a)) for of_a, of_b in zip(first, second, strict=True)]
        reach = float(self.reach)
        place = a.place + b.place + reach + sa * (a.speed + sa * a.pull)
        place += sb * (b.speed + sb * b.pull)
        speed = a.speed + b.speed + sa * a.pull + sb * b.pull
        return search_distance(motion, reach, high, place, speed, a.pull + b.pull)


def motion_of(body: Body, s: arb, order: int = 0, *, in_space: bool) -> Direction:
    """Return the centre of a ball a time s [s] after its start time, or a derivative.

    The unit is m, m/s or m/s^2; `in_space` adds the height above the cloth.
    """
    if body.resting:
        level = ((body.x, body.y), (body.vx, body.vy), (ZERO, ZERO))[order]
    elif order == 0:
        level = body.position_after(s)
    else:
        level = body.velocity_after(s) if order == 1 else body.acceleration_after(s)
    return (*level, body.vertical_after(s)[order]) if in_space else level


def level_reach(a: Body, b: Body) -> arb:
    """Return the horizontal distance of two touching balls on the cloth [m]: 2 sqrt(R_a R_b)."""
    first, second = a.constants.radius, b.constants.radius
    if first == second:
        return first + second
    return 2 * (first * second).sqrt()


def error_in_doubles(place: float, speed: float, pull: float, s: float) -> float:
    """Return an error bound of a length computed in doubles after a time s [m].

    `place`, `speed` and `pull`: bounds of the sums of terms of position, velocity, acceleration.
    """
    return DOUBLES_ERROR * (place + s * (speed + s * pull))


def motion_in_doubles(body: Body, lag: float, *, in_space: bool) -> Sequence[Sequence[float]]:
    """Return position, velocity and acceleration of a ball, `lag` [s] after its start time."""
    q = body.doubles
    r, v, a = (
        (
            q.x + lag * (q.vx + 0.5 * lag * q.ax),
            q.y + lag * (q.vy + 0.5 * lag * q.ay),
        ),
        (q.vx + lag * q.ax, q.vy + lag * q.ay),
        (q.ax, q.ay),
    )
    if not in_space:
        return r, v, a
    height, up, pull = (float(number) for number in body.vertical)
    rise = height + lag * (up + 0.5 * lag * pull)
    return (*r, rise), (*v, up + lag * pull), (*a, pull)


def search_distance(
    motion: Sequence[Sequence[float]],
    reach: float,
    high: float,
    place: float,
    speed: float,
    pull: float,
) -> Bracket:
    """Search in doubles for the time at which a moving vector is as short as `reach` [m].

    `motion`: the vector and its first two derivatives.
    `place`, `speed` and `pull`: bounds, as in `error_in_doubles`.
    """
    r, v, a = motion
    gap = (
        sum(map(mul, r, r)) - reach * reach,
        2.0 * sum(map(mul, r, v)),
        sum(map(mul, v, v)) + sum(map(mul, r, a)),
        sum(map(mul, v, a)),
        0.25 * sum(map(mul, a, a)),
    )

    def margin(s: float) -> float:
        size = place + s * (speed + s * pull)
        return DOUBLES_ERROR * size * size

    return first_entry_in_doubles(gap, high, margin)

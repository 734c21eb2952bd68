"""A shot replayed through a stated order of collisions, each step by its formula, in `mpf`."""

from __future__ import annotations

from itertools import combinations, pairwise

from mpmath import mp, mpf

from validation.closed_forms._setup import Collision, OrderError, Outcome, Setup, Vector

Polynomial = tuple[mpf, ...]
"""Coefficients, constant first."""


def dot(a: Vector, b: Vector) -> mpf:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def along(a: Vector, factor: mpf, b: Vector) -> Vector:
    """Return a + factor b."""
    return (a[0] + factor * b[0], a[1] + factor * b[1])


def length_of(a: Vector) -> mpf:
    """Return the Euclidean length."""
    return mp.sqrt(dot(a, a))


def rolled(position: Vector, velocity: Vector, deceleration: mpf, dt: mpf) -> tuple[Vector, Vector]:
    """Return position and velocity after rolling for `dt` seconds, or to rest if that is sooner.

    s = v t - mu g t^2 / 2 along the line of motion, until t = v / (mu g).
    """
    speed = length_of(velocity)
    if speed == 0:
        return position, velocity
    if deceleration * dt >= speed:
        zero = mp.mpf(0)
        return along(position, speed / (2 * deceleration), velocity), (zero, zero)
    position = along(position, dt - deceleration * dt**2 / (2 * speed), velocity)
    return position, along((mp.mpf(0), mp.mpf(0)), 1 - deceleration * dt / speed, velocity)


def time_to_roll(distance: mpf, speed: mpf, deceleration: mpf) -> mpf | None:
    """Return the time to roll `distance` [s], or None where the ball rests before.

    The smaller root of s = v t - a t^2 / 2, in the form that holds for a = 0 too.
    """
    discriminant = speed**2 - 2 * deceleration * distance
    return None if discriminant < 0 else 2 * distance / (speed + mp.sqrt(discriminant))


class Shot:
    """Rolling balls, advanced from one stated collision to the next.

    Where `setup.verify`, each step makes sure that nothing else happens first, and raises
    `OrderError` where something does: then the stated order isn't that of these values.
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup
        self.time = mp.mpf(0)
        self.positions = list(setup.positions)
        self.velocities = list(setup.velocities)
        self.collisions: list[Collision] = []

    def hit(self, a: int, b: int) -> Shot:
        """Roll until balls `a` and `b` touch; exchange J = (1 + e) m_r (v_a - v_b).n along n."""
        dt = self._time_of_contact(a, b)
        self._advance(dt, ("ball-ball", a, b))
        between = along(self.positions[b], mp.mpf(-1), self.positions[a])
        normal = along((mp.mpf(0), mp.mpf(0)), 1 / length_of(between), between)
        closing = dot(self.velocities[a], normal) - dot(self.velocities[b], normal)
        mass_a, mass_b = self.setup.masses[a], self.setup.masses[b]
        reduced = mass_a * mass_b / (mass_a + mass_b)
        impulse = (1 + self.setup.ball_restitution) * reduced * closing
        self.velocities[a] = along(self.velocities[a], -impulse / mass_a, normal)
        self.velocities[b] = along(self.velocities[b], impulse / mass_b, normal)
        return self

    def bounce(self, ball: int, cushion: str) -> Shot:
        """Roll until the ball touches the cushion; v_n -> -e_n v_n, v_t -> e_t v_t."""
        self._advance(self._time_of_bounce(ball, cushion), ("ball-cushion", ball, cushion))
        normal = -self.setup.cushion_restitution
        tangential = self.setup.cushion_tangential_restitution
        vx, vy = self.velocities[ball]
        self.velocities[ball] = (
            (normal * vx, tangential * vy)
            if cushion in ("left", "right")
            else (tangential * vx, normal * vy)
        )
        return self

    def end(self) -> Outcome:
        """Roll until every ball rests, or to `t_max`."""
        stops = [self._time_to_rest(ball) for ball in range(len(self.positions))]
        dt = max(stops)
        if self.setup.t_max is not None:
            dt = min(dt, self.setup.t_max - self.time)
        self._advance(dt, None)
        return Outcome(
            tuple(self.positions), tuple(self.velocities), self.time, tuple(self.collisions)
        )

    def _advance(self, dt: mpf | None, collision: Collision | None) -> None:
        if dt is None:
            raise OrderError(f"{collision} never happens")
        if self.setup.verify:
            self._make_sure_nothing_precedes(dt, collision)
        for i, (position, velocity) in enumerate(zip(self.positions, self.velocities, strict=True)):
            self.positions[i], self.velocities[i] = rolled(
                position, velocity, self.setup.deceleration, dt
            )
        self.time += dt
        if collision is not None:
            self.collisions.append(collision)

    def _make_sure_nothing_precedes(self, dt: mpf, collision: Collision | None) -> None:
        balls = range(len(self.positions))
        others: list[tuple[Collision, mpf | None]] = [
            (("ball-ball", a, b), self._time_of_contact(a, b)) for a, b in combinations(balls, 2)
        ]
        others += [
            (("ball-cushion", ball, cushion), self._time_of_bounce(ball, cushion))
            for ball in balls
            for cushion in self.setup.cushions
        ]
        for other, when in others:
            if other != collision and when is not None and when <= dt:
                raise OrderError(f"{other} comes before {collision}")

    def _time_to_rest(self, ball: int) -> mpf:
        speed = length_of(self.velocities[ball])
        if speed == 0:
            return mp.mpf(0)
        return speed / self.setup.deceleration if self.setup.deceleration else mp.inf

    def _time_of_bounce(self, ball: int, cushion: str) -> mpf | None:
        axis = 0 if cushion in ("left", "right") else 1
        extent = self.setup.length if axis == 0 else self.setup.width
        radius, velocity = self.setup.radii[ball], self.velocities[ball]
        target = radius if cushion in ("left", "bottom") else extent - radius
        ahead = target - self.positions[ball][axis]
        outwards = velocity[axis] < 0 if cushion in ("left", "bottom") else velocity[axis] > 0
        if not outwards:
            return None
        speed = length_of(velocity)
        return time_to_roll(ahead * speed / velocity[axis], speed, self.setup.deceleration)

    def _time_of_contact(self, a: int, b: int) -> mpf | None:
        """Time until two balls touch, phase by phase: both roll, then one, as the other rests."""
        reach = self.setup.radii[a] + self.setup.radii[b]
        stops = sorted({self._time_to_rest(a), self._time_to_rest(b)} - {mp.mpf(0)})
        begin = mp.mpf(0)
        for stop in stops:
            states = [
                rolled(self.positions[i], self.velocities[i], self.setup.deceleration, begin)
                for i in (a, b)
            ]
            dt = _entry(states[0], states[1], reach, self.setup.deceleration, stop - begin)
            if dt is not None:
                return begin + dt
            begin = stop
        return None


def _entry(
    a: tuple[Vector, Vector], b: tuple[Vector, Vector], reach: mpf, deceleration: mpf, dt: mpf
) -> mpf | None:
    """Return when the distance shrinks to `reach` within `dt`, or None; no ball stops meanwhile.

    With one ball at rest, or no relative acceleration, the relative path is a straight line: a
    quadratic in the path length, exactly. Else |r + v t + A t^2 / 2|^2 = reach^2 is a quartic.
    """
    r = along(b[0], mp.mpf(-1), a[0])
    v = along(b[1], mp.mpf(-1), a[1])
    if length_of(v) == 0:
        return None
    at_rest = [length_of(ball[1]) == 0 for ball in (a, b)]
    acceleration = _relative_acceleration(a[1], b[1], deceleration)
    if any(at_rest) or length_of(acceleration) == 0:
        braking = deceleration if any(at_rest) else mp.mpf(0)
        speed = length_of(v)
        along_path = dot(r, v) / speed
        discriminant = along_path**2 - (dot(r, r) - reach**2)
        if along_path >= 0 or discriminant < 0:
            return None
        when = time_to_roll(-along_path - mp.sqrt(discriminant), speed, braking)
        return when if when is not None and when <= dt else None
    quartic = (
        dot(r, r) - reach**2,
        2 * dot(r, v),
        dot(v, v) + dot(r, acceleration),
        dot(v, acceleration),
        dot(acceleration, acceleration) / 4,
    )
    return _first_fall_below_zero(quartic, dt)


def _first_fall_below_zero(polynomial: Polynomial, end: mpf) -> mpf | None:
    """Return where the polynomial first falls through 0 on [0, end], or None.

    Between neighbouring roots of its derivative a polynomial is monotone, so each such interval
    holds one root or none, and bisection finds it to the last digit. Balls that already touch, and
    close in, are at the root: the interval starts within rounding of 0.
    """
    noise = mp.mpf(10) ** (-mp.dps // 2)
    edges = [mp.mpf(0), *_roots(_derivative(polynomial), mp.mpf(0), end), end]
    for low, high in pairwise(edges):
        at_low, at_high = _value(polynomial, low), _value(polynomial, high)
        if at_high < 0 and at_high < at_low and at_low > -noise:
            return _bisect(polynomial, low, high) if at_low > 0 else low
    return None


def _roots(polynomial: Polynomial, low: mpf, high: mpf) -> list[mpf]:
    """Return the roots at which the polynomial changes sign between `low` and `high`, in order."""
    if len(polynomial) < 2:
        return []
    edges = [low, *_roots(_derivative(polynomial), low, high), high]
    return [
        _bisect(polynomial, a, b)
        for a, b in pairwise(edges)
        if (_value(polynomial, a) < 0) != (_value(polynomial, b) < 0)
    ]


def _bisect(polynomial: Polynomial, low: mpf, high: mpf) -> mpf:
    starts_below = _value(polynomial, low) < 0
    for _ in range(mp.prec + 10):
        middle = (low + high) / 2
        if (_value(polynomial, middle) < 0) == starts_below:
            low = middle
        else:
            high = middle
    return low


def _value(polynomial: Polynomial, t: mpf) -> mpf:
    total = mp.mpf(0)
    for coefficient in reversed(polynomial):
        total = total * t + coefficient
    return total


def _derivative(polynomial: Polynomial) -> Polynomial:
    return tuple(k * coefficient for k, coefficient in enumerate(polynomial) if k > 0)


def _relative_acceleration(va: Vector, vb: Vector, deceleration: mpf) -> Vector:
    total = (mp.mpf(0), mp.mpf(0))
    for velocity, sign in ((vb, -1), (va, 1)):
        speed = length_of(velocity)
        if speed != 0:
            total = along(total, sign * deceleration / speed, velocity)
    return total

"""The motion of a ball on the cloth until its next collision: slide, roll and rest by formulas."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations
from typing import NamedTuple

from mpmath import mp, mpf

from ghostball.validation.truth.closed_forms._setup import OrderError, Setup, Spin, Vector

ROUNDING_DIGITS = 40
"""A speed below 1e-40 m/s counts as 0: it is the rounding of 50 digits.

The conditioning nudges numbers by 1e-25 of themselves, which changes a speed by more.
"""


class BallState(NamedTuple):
    """A ball: position [m], velocity [m/s], angular velocity [rad/s], whether it rolls."""

    position: Vector
    velocity: Vector
    spin: Spin  # for a rolling or resting ball, only the third component is meaningful
    rolls: bool


class Cloth(NamedTuple):
    """The effect of the cloth on one ball: decelerations [m/s^2], of spin [rad/s^2]; radius [m]."""

    radius: mpf
    rolling: mpf
    sliding: mpf
    spinning: mpf


class PathSegment(NamedTuple):
    """A constant acceleration [m/s^2] from the time `start` [s], at which the ball has `state`."""

    start: mpf
    state: BallState
    acceleration: Vector


def dot(a: Vector, b: Vector) -> mpf:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def along(a: Vector, factor: mpf, b: Vector) -> Vector:
    """Return a + factor b."""
    return (a[0] + factor * b[0], a[1] + factor * b[1])


def scaled(factor: mpf, a: Vector) -> Vector:
    """Return factor a."""
    return (factor * a[0], factor * a[1])


def length_of(a: Vector) -> mpf:
    """Return the Euclidean length."""
    return mp.sqrt(dot(a, a))


def negligible(speed: mpf) -> bool:
    """Return True if a speed [m/s] is a rounding of 0."""
    return bool(speed < mp.mpf(10) ** -ROUNDING_DIGITS)


def cloth_of(setup: Setup, ball: int) -> Cloth:
    """Return the effect of the cloth on a ball of the setup."""
    return Cloth(
        setup.radii[ball],
        setup.rolling_frictions[ball] * setup.gravity,
        setup.sliding_frictions[ball] * setup.gravity,
        setup.spin_decelerations[ball],
    )


def starting_state(setup: Setup, ball: int) -> BallState:
    """Return the initial state of a ball of the setup."""
    return BallState(
        setup.positions[ball],
        setup.velocities[ball],
        setup.spins[ball],
        setup.rolls[ball] or not setup.slides,
    )


def rolling_spin(state: BallState, radius: mpf) -> Spin:
    """Return the angular velocity of a ball: k x v / R if it rolls, otherwise its own."""
    if not state.rolls:
        return state.spin
    return (-state.velocity[1] / radius, state.velocity[0] / radius, state.spin[2])


def slip_of(state: BallState, radius: mpf) -> Vector:
    """Return the velocity of the ball's contact point with the cloth, v + w x (-R z)."""
    (vx, vy), (wx, wy, _) = state.velocity, state.spin
    return (vx - radius * wy, vy + radius * wx)


def path_of(state: BallState, cloth: Cloth) -> list[PathSegment]:
    """Return the undisturbed motion of a ball: a slide, a roll and a rest, or some of them.

    Sliding friction acts against the slip u and never turns it, so the path is a parabola for T = 2
    |u0| / (7 mu_s g), which ends with v = v0 - (2/7) u0. A straight line of v^2 / (2 mu g) follows
    (Coriolis 1835; Alciatore TP A.4).
    """
    path = []
    start = mp.mpf(0)
    if not state.rolls:
        slip = slip_of(state, cloth.radius)
        speed = length_of(slip)
        if not negligible(speed):
            friction = scaled(-cloth.sliding / speed, slip)
            path.append(PathSegment(start, state, friction))
            start = 2 * speed / (7 * cloth.sliding) if cloth.sliding else mp.inf
            if start == mp.inf:
                return path
            state = moved(path[-1], cloth, start)
        state = state._replace(rolls=True)
    speed = length_of(state.velocity)
    if not negligible(speed):
        path.append(PathSegment(start, state, scaled(-cloth.rolling / speed, state.velocity)))
        if not cloth.rolling:
            return path
        stop = speed / cloth.rolling
        state = moved(path[-1], cloth, stop)
        start += stop
    zero = mp.mpf(0)
    path.append(PathSegment(start, state._replace(velocity=(zero, zero)), (zero, zero)))
    return path


def moved(segment: PathSegment, cloth: Cloth, dt: mpf) -> BallState:
    """Return the state `dt` after the segment's start; in a slide dw/dt = (5 / 2R) (ay, -ax)."""
    state, acceleration = segment.state, segment.acceleration
    turn = 5 * dt / (2 * cloth.radius)
    position = along(along(state.position, dt, state.velocity), dt**2 / 2, acceleration)
    velocity = along(state.velocity, dt, acceleration)
    wx, wy, wz = state.spin
    left = max(abs(wz) - cloth.spinning * dt, mp.mpf(0))
    spin = (wx + turn * acceleration[1], wy - turn * acceleration[0], mp.sign(wz) * left)
    return BallState(position, velocity, spin, state.rolls)


def state_at(path: list[PathSegment], cloth: Cloth, dt: mpf) -> BallState:
    """Return the state at the time `dt` on a path."""
    segment = next(segment for segment in reversed(path) if segment.start <= dt)
    return moved(segment, cloth, dt - segment.start)


def make_sure_apart(ways: Iterable[Sequence[Vector]], radii: Iterable[mpf]) -> None:
    """Check that balls on some paths never meet: the boxes around the paths must be disjoint.

    `ways` [m]: for each path, points with a convex hull that contains it.
    `radii` [m]: of the largest ball on each path.
    """
    boxes = [[(min(xs), max(xs)) for xs in zip(*way, strict=True)] for way in ways]
    for (one, radius), (other, reach) in combinations(zip(boxes, radii, strict=True), 2):
        gaps = [max(a - d, c - b) for (a, b), (c, d) in zip(one, other, strict=True)]
        if max(gaps) <= radius + reach:
            raise OrderError("two balls come too close to each other")


def time_to_rest(path: list[PathSegment], cloth: Cloth) -> mpf:
    """Return the time at which the ball has stopped moving and spinning [s].

    A spin without friction doesn't count.
    """
    last = path[-1]
    if length_of(last.state.velocity) != 0:
        return mp.inf
    spinning = abs(path[0].state.spin[2])
    return max(last.start, spinning / cloth.spinning if cloth.spinning else mp.mpf(0))

"""Balls without collisions, in air or in flight: where and when they come to rest.

In air: a rolling ball decelerates by a + b v^2, a = mu_r g, b = (5/7) k + b': the friction of the
cloth reduces the effect of the air's k v^2 by 2/7, except for the paper's point masses. With q = v
sqrt(b / a) it stops after atan(q) / sqrt(a b), at the distance ln(1 + q^2) / 2b. A ball that slides
along its slip is accelerated or decelerated by mu_s g and decelerated by k v^2; its spin changes as
without air, until v = R w.

In flight: a ball falls along a parabola and bounces with the table's restitution e. Coulomb
friction changes the velocity against the slip by mu (1 + e) V, where V is the speed of the fall,
but by at most 2/7 of the slip, which ends the slip. The spin about the vertical is constant
(Alciatore, technical proof B.5). Each bounce is followed by a flight of 2 e V / g; all bounces end
after a finite time.

Vertically in air: v' = -g - k |v| v. A throw at v rises ln(1 + k v^2 / g) / 2k within atan(v sqrt(k
/ g)) / sqrt(g k); a fall from h takes acosh(exp(k h)) / sqrt(g k) and ends at sqrt((g / k)(1 -
exp(-2 k h))). The table returns e times this speed. When air is negligible, the remaining bounces
are those without air and take 2 v / (g (1 - e)).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, pairwise
from typing import NamedTuple

from mpmath import mp, mpf

from ghostball.validation.truth.closed_forms._motion import (
    BallState,
    Cloth,
    along,
    cloth_of,
    dot,
    length_of,
    make_sure_apart,
    negligible,
    path_of,
    rolling_spin,
    scaled,
    slip_of,
    starting_state,
    time_to_rest,
)
from ghostball.validation.truth.closed_forms._setup import FormResult, OrderError, Setup, Vector


class _End(NamedTuple):
    """Where and when a ball comes to rest, and points with a convex hull that contains its path."""

    position: Vector
    time: mpf
    hull: list[Vector]


def _alone(setup: Setup, end_of: Callable[[Setup, int], _End]) -> FormResult:
    """Return the result for balls that never meet, each computed separately."""
    if setup.cushions or setup.t_max is not None:
        raise OrderError("needs an unbounded cloth, and no `t_max`")
    ends = [end_of(setup, ball) for ball in range(len(setup.positions))]
    if setup.verify:
        make_sure_apart([end.hull for end in ends], setup.radii)
    return FormResult.at_rest([end.position for end in ends], max(end.time for end in ends))


def alone_in_air(setup: Setup) -> FormResult:
    """Solve balls that slide and roll on straight lines until they rest; they never meet."""
    return _alone(setup, _end_in_air)


def alone_in_flight(setup: Setup) -> FormResult:
    """Solve balls that bounce, slide and roll until they rest; they never meet."""
    if setup.table_restitution == 1:
        raise OrderError("needs bounces that end at rest")
    return _alone(setup, _end_of_flight)


def _end_in_air(setup: Setup, ball: int) -> _End:
    """Return the end of a ball that slides and rolls on a line."""
    state, cloth = starting_state(setup, ball), cloth_of(setup, ball)
    time = mp.mpf(0)
    if not state.rolls and not negligible(length_of(slip_of(state, cloth.radius))):
        state, time = _slid(setup, state, cloth)
    speed = length_of(state.velocity)
    if negligible(speed):
        return _End(state.position, time, [setup.positions[ball], state.position])
    displacement, lasts = _rolled(setup, speed, cloth)
    spin = abs(state.spin[2]) / cloth.spinning if cloth.spinning else mp.mpf(0)
    x, y = scaled(displacement / speed, state.velocity)
    place = (state.position[0] + x, state.position[1] + y)
    return _End(place, max(time + lasts, spin), [setup.positions[ball], place])


def _rolled(setup: Setup, speed: mpf, cloth: Cloth) -> tuple[mpf, mpf]:
    """Return the distance [m] and duration [s] of a roll."""
    felt = mp.mpf(5) / 7 if setup.slides else mp.mpf(1)
    a, b = cloth.rolling, felt * setup.air_drag + setup.rolling_friction_quadratic
    q = speed * mp.sqrt(b / a)
    return mp.log1p(q * q) / (2 * b), mp.atan(q) / mp.sqrt(a * b)


def _slid(setup: Setup, state: BallState, cloth: Cloth) -> tuple[BallState, mpf]:
    """Return the state at the end of a straight slide, and its time [s]."""
    slip = slip_of(state, cloth.radius)
    size = length_of(slip)
    direction = scaled(1 / size, slip)
    start = dot(state.velocity, direction)
    across = direction[0] * state.velocity[1] - direction[1] * state.velocity[0]
    if not negligible(abs(across)):
        raise OrderError("needs a slip along the path of the ball")
    f, k = cloth.sliding, setup.air_drag
    # In the direction of the slip p' = -f - k |p| p: a tangent while p > 0, then a hyperbolic
    # tangent.
    rate, fast = mp.sqrt(f * k), mp.sqrt(f / k)
    turn = mp.atan(start / fast) / rate if start > 0 else mp.mpf(0)
    way_there = mp.log1p((start / fast) ** 2) / (2 * k) if start > 0 else mp.mpf(0)
    back = mp.atanh(-start / fast) if start < 0 else mp.mpf(0)

    def velocity(t: mpf) -> mpf:
        if t <= turn:
            return fast * mp.tan(rate * (turn - t))
        return -fast * mp.tanh(rate * (t - turn) + back)

    def displacement(t: mpf) -> mpf:
        if t <= turn:
            return way_there + mp.log(mp.cos(rate * (turn - t))) / k
        return way_there - mp.log(mp.cosh(rate * (t - turn) + back) / mp.cosh(back)) / k

    lasts = size / (mp.mpf(7) / 2 * f)
    end = mp.findroot(lambda t: velocity(t) - start + size - mp.mpf(5) / 2 * f * t, lasts)
    x, y = scaled(displacement(end), direction)
    return state._replace(
        position=(state.position[0] + x, state.position[1] + y),
        velocity=scaled(velocity(end), direction),
        rolls=True,
    ), end


def _end_of_flight(setup: Setup, ball: int) -> _End:
    """Return the end of a ball that bounces, slides and rolls."""
    state, time, hull = _bounced(setup, ball)
    cloth = cloth_of(setup, ball)
    path = path_of(state, cloth)
    for segment, after in pairwise(path):
        # A parabola is within the triangle of its ends and the intersection of their tangents.
        half = (after.start - segment.start) / 2
        hull += [along(segment.state.position, half, segment.state.velocity), after.state.position]
    return _End(path[-1].state.position, time + time_to_rest(path, cloth), hull)


def _bounced(setup: Setup, ball: int) -> tuple[BallState, mpf, list[Vector]]:
    """Return the state of a ball when its bounces end, the time, and the places of its bounces."""
    state, radius = starting_state(setup, ball), setup.radii[ball]
    state = state._replace(spin=rolling_spin(state, radius), rolls=False)
    rises, height = setup.rises[ball], setup.heights[ball]
    if height == 0 and rises == 0:
        return state, mp.mpf(0), [state.position]
    hull, g = [state.position], setup.gravity
    fall = mp.sqrt(rises**2 + 2 * g * height)
    time = lasts = (rises + fall) / g
    while True:
        state = state._replace(position=along(state.position, lasts, state.velocity))
        hull.append(state.position)
        if negligible(fall):
            return state, time, hull
        state = _rubbed(state, radius, (1 + setup.table_restitution) * fall, setup, ball)
        fall *= setup.table_restitution
        lasts = 2 * fall / g
        time += lasts


def _rubbed(state: BallState, radius: mpf, push: mpf, setup: Setup, ball: int) -> BallState:
    """Return the state after a bounce; `push` is its impulse over the mass [m/s]."""
    slip = slip_of(state, radius)
    size = length_of(slip)
    if negligible(size):
        return state
    loss = min(setup.sliding_frictions[ball] * push, 2 * size / 7)
    x, y = scaled(-loss / size, slip)
    wx, wy, wz = state.spin
    turn = 5 / (2 * radius)
    return state._replace(
        velocity=(state.velocity[0] + x, state.velocity[1] + y),
        spin=(wx + turn * y, wy - turn * x, wz),
    )


def fall_in_air(setup: Setup) -> FormResult:
    """Solve balls that bounce on the spot until they rest; they never meet."""
    if setup.cushions or setup.t_max is not None or setup.table_restitution == 1:
        raise OrderError("needs an unbounded cloth, and bounces that end at rest")
    balls = range(len(setup.positions))
    for ball in balls:
        state = starting_state(setup, ball)
        if length_of(state.velocity) != 0 or any(spin != 0 for spin in state.spin):
            raise OrderError("needs balls that move up and down alone, without spin")
    for i, j in combinations(balls, 2):
        (x, y), (u, v) = setup.positions[i], setup.positions[j]
        if length_of((u - x, v - y)) <= setup.radii[i] + setup.radii[j]:
            raise OrderError("two balls are above each other")
    return FormResult.at_rest(setup.positions, max(_time_of(setup, ball) for ball in balls))


def _time_of(setup: Setup, ball: int) -> mpf:
    """Return the time of a ball's last bounce."""
    g, k, e = setup.gravity, setup.air_drag, setup.table_restitution
    height, up = setup.heights[ball], setup.rises[ball]
    if height == 0 and up == 0:
        return mp.mpf(0)
    rate, time = mp.sqrt(g * k), mp.mpf(0)
    if up < 0:
        raise OrderError("needs balls that are let go, or thrown up")
    # Air changes a bounce at v by k v^2 / g; the last bounces are those without air.
    while not negligible(k * up * up / g) or height > 0:
        time += mp.atan(up * mp.sqrt(k / g)) / rate
        height += mp.log1p(k * up * up / g) / (2 * k)
        time += mp.acosh(mp.exp(k * height)) / rate
        up = e * mp.sqrt(-g / k * mp.expm1(-2 * k * height))
        height = mp.mpf(0)
    return time + 2 * up / (g * (1 - e))

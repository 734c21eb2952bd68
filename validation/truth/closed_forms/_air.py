"""Balls that roll or slide along a line in air, each alone: where and when they come to rest.

A ball that rolls is slowed by a + b v^2, a = mu_r g, b = (5/7) k + b': of the air's k v^2 the
cloth's friction takes 2/7, but for the paper's point. With q = v sqrt(b / a) it stops after
atan(q) / sqrt(a b), having gone ln(1 + q^2) / 2b. One that slides along its slip is slowed, or sped
up, by mu_s g and slowed by k v^2, and its spin changes as without air, until v = R w.
"""

from __future__ import annotations

from mpmath import mp, mpf

from ghostball.validation.truth.closed_forms._motion import (
    Cloth,
    State,
    cloth_of,
    dot,
    length_of,
    make_sure_apart,
    negligible,
    scaled,
    slip_of,
    starting_state,
)
from ghostball.validation.truth.closed_forms._setup import OrderError, Outcome, Setup, Vector


def alone_in_air(setup: Setup) -> Outcome:
    """Let each ball slide and roll along its own line until it rests; they never meet."""
    if setup.cushions or setup.t_max is not None:
        raise OrderError("needs an unbounded cloth, and no end but rest")
    ends = [_end_of(setup, ball) for ball in range(len(setup.positions))]
    places = [place for place, _ in ends]
    if setup.verify:
        make_sure_apart(list(zip(setup.positions, places, strict=True)), setup.radii)
    return Outcome.at_rest(places, max(time for _, time in ends))


def _end_of(setup: Setup, ball: int) -> tuple[Vector, mpf]:
    """Return where and when a ball comes to rest."""
    state, cloth = starting_state(setup, ball), cloth_of(setup, ball)
    time = mp.mpf(0)
    if not state.rolls and not negligible(length_of(slip_of(state, cloth.radius))):
        state, time = _slid(setup, state, cloth)
    speed = length_of(state.velocity)
    if negligible(speed):
        return state.position, time
    displacement, lasts = _rolled(setup, speed, cloth)
    spin = abs(state.spin[2]) / cloth.spinning if cloth.spinning else mp.mpf(0)
    x, y = scaled(displacement / speed, state.velocity)
    return (state.position[0] + x, state.position[1] + y), max(time + lasts, spin)


def _rolled(setup: Setup, speed: mpf, cloth: Cloth) -> tuple[mpf, mpf]:
    """Return how far and how long a ball rolls [m], [s]."""
    felt = mp.mpf(5) / 7 if setup.slides else mp.mpf(1)
    a, b = cloth.rolling, felt * setup.air_drag + setup.rolling_friction_quadratic
    q = speed * mp.sqrt(b / a)
    return mp.log1p(q * q) / (2 * b), mp.atan(q) / mp.sqrt(a * b)


def _slid(setup: Setup, state: State, cloth: Cloth) -> tuple[State, mpf]:
    """Return the state in which a straight slide ends, and when [s]."""
    slip = slip_of(state, cloth.radius)
    size = length_of(slip)
    along = scaled(1 / size, slip)
    start = dot(state.velocity, along)
    across = along[0] * state.velocity[1] - along[1] * state.velocity[0]
    if not negligible(abs(across)):
        raise OrderError("needs a slip along the way that the ball goes")
    f, k = cloth.sliding, setup.air_drag
    # In the direction of the slip p' = -f - k |p| p: a tangent while p > 0, then a hyperbolic one.
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
    x, y = scaled(displacement(end), along)
    return state._replace(
        position=(state.position[0] + x, state.position[1] + y),
        velocity=scaled(velocity(end), along),
        rolls=True,
    ), end

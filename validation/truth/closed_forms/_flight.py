"""Balls that are dropped or thrown, each alone: how they bounce, slide, roll and come to rest.

A ball falls along a parabola and bounces with the table's restitution e. Coulomb friction takes
mu (1 + e) V of its slip's direction from its velocity, V the speed of the fall, but no more than
ends the slip: 2/7 of it. Its spin about the vertical stays (Alciatore, technical proof B.5). Each
bounce is followed by a flight of 2 e V / g; all of them end after a finite time.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

from mpmath import mp, mpf

from ghostball.validation.truth.closed_forms._motion import (
    State,
    along,
    cloth_of,
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
from ghostball.validation.truth.closed_forms._setup import OrderError, Outcome, Setup, Vector


class _Flown(NamedTuple):
    """Where and when a ball comes to rest, and points whose hull holds its path in the plane."""

    position: Vector
    time: mpf
    hull: list[Vector]


def alone_in_flight(setup: Setup) -> Outcome:
    """Let each ball bounce, slide and roll until it rests; they never meet."""
    if setup.cushions or setup.t_max is not None or setup.table_restitution == 1:
        raise OrderError("needs an unbounded cloth, and bounces that end at rest")
    ends = [_end_of(setup, ball) for ball in range(len(setup.positions))]
    if setup.verify:
        make_sure_apart([end.hull for end in ends], setup.radii)
    return Outcome.at_rest([end.position for end in ends], max(end.time for end in ends))


def _end_of(setup: Setup, ball: int) -> _Flown:
    state, time, hull = _bounced(setup, ball)
    cloth = cloth_of(setup, ball)
    path = path_of(state, cloth)
    for segment, after in pairwise(path):
        # A parabola lies within its ends and where the tangents there meet.
        half = (after.start - segment.start) / 2
        hull += [
            along(segment.state.position, half, segment.state.velocity),
            after.state.position,
        ]
    return _Flown(path[-1].state.position, time + time_to_rest(path, cloth), hull)


def _bounced(setup: Setup, ball: int) -> tuple[State, mpf, list[Vector]]:
    """Return a ball's state once it stays on the cloth, when that is, and where it bounced."""
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


def _rubbed(state: State, radius: mpf, push: mpf, setup: Setup, ball: int) -> State:
    """Return the state after a bounce whose impulse over the mass is `push` [m/s]."""
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

"""Tests with an invented motion of degree 4: every scheduler must find all of its contacts.

The motion is curved, and its pieces have a fixed duration. A separate simulation gives the expected
result: it checks all pairs at every event, with roots of polynomials of degree 8 by numpy. The
kernels run interpreted, because compiled kernels would keep the original motion.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from more_obstacles import add_obstacles
from shots import R, ball, scene_of

from ghostball.engine import simulate, simulate_sweep
from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.event_loop import predict
from ghostball.engine.motion import position
from ghostball.engine.motion.next_piece import predict_motion, predict_obstacles
from ghostball.engine.motion.series import put_power
from ghostball.engine.running import skips
from ghostball.engine.scheduling import broad_phase
from ghostball.engine.scheduling.grid import _LATE
from ghostball.model import EventKind, Scene, Table

LASTS = 0.07
"""Duration of a piece [s]."""

NOSE = (0.55, 0.33, 0.06)
"""Centre and radius of a nose [m]."""

made_up = pytest.mark.skipif(COMPILED, reason="an invented motion needs interpreted kernels")


def powers(vx: float, vy: float) -> np.ndarray:
    """Return the coefficients of a piece, (5, 2), from the origin with an initial velocity."""
    v, across = np.array([vx, vy]), np.array([-vy, vx])
    return np.array([0.0 * v, v, -0.4 * v + 1.5 * across, 6.0 * across, -30.0 * v - 20.0 * across])


def predict_made_up(balls, i, laws) -> None:
    """Replace `predict_motion`."""
    ball = balls.state[i]
    if ball.vx == 0.0 and ball.vy == 0.0:
        predict_motion(balls, i, laws)
        return
    _, _, second, third, fourth = powers(ball.vx, ball.vy)
    ball.phase = st.ROLLING
    ball.ax, ball.ay = 2.0 * second
    jerk = 6.0 * np.abs(third) + 24.0 * np.abs(fourth) * LASTS
    balls.powers[i, st.JERK_X], balls.powers[i, st.JERK_Y] = jerk
    balls.powers[i, st.COUNT] = 3
    for power, (x, y) in enumerate((third, fourth), 3):
        put_power(balls.powers, i, power, x, y, 0.0)
    balls.own_kind[i] = st.OWN_PIECE
    predict_obstacles(balls, i, laws, LASTS, 0)


@pytest.fixture
def moves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give balls this motion, on a table with a nose."""
    x, y, radius = NOSE
    add_obstacles(monkeypatch, (st.DISC, x, y, 0.0, 0.0, radius, 0.0, 4))
    monkeypatch.setattr(predict, "predict_motion", predict_made_up)


def ten_balls(seed: int) -> Scene:
    chance = np.random.default_rng(seed)
    balls: list[dict[str, object]] = []
    while len(balls) < 10:
        place = chance.uniform([R, R], [1.1 - R, 0.7 - R]).tolist()
        clear = all(math.dist(place, other["position"]) > 2.02 * R for other in balls)
        if clear and math.dist(place, NOSE[:2]) > 1.01 * (R + NOSE[2]):
            velocity = 2.0 * chance.normal(size=2) if len(balls) % 3 else np.zeros(2)
            balls.append(ball(place, velocity.tolist()))
    # With this negligible drag, the kernels expect pieces of higher degrees.
    return scene_of(*balls, table=Table(length=1.1, width=0.7), t_max=0.8, air_drag=1e-9)


class Piece:
    """A ball's motion from a time on, as numpy polynomials."""

    def __init__(self, t: float, place: np.ndarray, velocity: np.ndarray) -> None:
        self.start, self.end = t, t + LASTS if velocity.any() else math.inf
        self.powers = powers(*velocity)
        self.powers[0] = place

    def at(self, t: float) -> np.ndarray:
        """Return the coefficients when the time counts from t."""
        d = t - self.start
        return np.array(
            [
                sum(math.comb(m, k) * self.powers[m] * d ** (m - k) for m in range(k, 5))
                for k in range(5)
            ]
        )


def first_entry(gap: np.ndarray, reach: float) -> float:
    """Return the first time at which |gap(s)| falls to `reach` [s]: the smallest such root."""
    square = np.polymul(gap[::-1, 0], gap[::-1, 0])
    square = np.polyadd(square, np.polymul(gap[::-1, 1], gap[::-1, 1]))
    square = np.polyadd(square, [-reach * reach])
    roots = np.roots(square)
    real = np.sort(roots[np.abs(roots.imag) < 1e-7].real)
    falls = real[(real > -1e-9) & (np.polyval(np.polyder(square), real) < 0.0)]
    return float(falls[0]) if len(falls) else math.inf


def simulated(scene: Scene):
    """Return the events (t, a, b), with b a ball or -1 minus an obstacle, and all pieces."""
    n, t_max = len(scene.balls), scene.t_max
    pieces = [
        Piece(0.0, r[:2], v[:2]) for r, v in zip(scene.positions, scene.velocities, strict=True)
    ]
    cushions = [((1, 0), 0.0), ((-1, 0), -1.1), ((0, 1), 0.0), ((0, -1), -0.7)]
    events, history, now = [], list(enumerate(pieces)), 0.0
    while True:
        moved = [piece.at(now) for piece in pieces]
        due = [(piece.end - now, i, None) for i, piece in enumerate(pieces)]
        for i in range(n):
            for j in range(i + 1, n):
                due.append((first_entry(moved[j] - moved[i], 2.0 * R), i, j))
            from_nose = moved[i].copy()
            from_nose[0] -= NOSE[:2]
            due.append((first_entry(from_nose, R + NOSE[2]), i, -5))
            for k, (normal, offset) in enumerate(cushions):
                gap = moved[i] @ normal
                gap[0] -= offset + R
                roots = np.roots(gap[::-1]) if gap[1:].any() else np.array([])
                real = np.sort(roots[np.abs(roots.imag) < 1e-7].real)
                rates = np.polyval(np.polyder(gap[::-1]), real)
                falls = real[(real > -1e-9) & (rates < 0.0)]
                due.append((float(falls[0]) if len(falls) else math.inf, i, -1 - k))
        s, i, j = min(due, key=lambda one: one[0])
        now += max(s, 0.0)
        if now > t_max:
            return events, history
        place_i, vi = pieces[i].at(now)[:2]
        if j is None:
            changed = [(i, place_i, vi)]
        elif j >= 0:
            q = pieces[j].at(now)
            normal = (q[0] - place_i) / np.linalg.norm(q[0] - place_i)
            passed = normal * (normal @ (q[1] - vi))
            changed = [(i, place_i, vi + passed), (j, q[0], q[1] - passed)]
            events.append((now, i, j))
        else:
            normal = np.array(cushions[-1 - j][0] if j > -5 else place_i - NOSE[:2], dtype=float)
            normal /= np.linalg.norm(normal)
            changed = [(i, place_i, vi - 2.0 * (normal @ vi) * normal)]
            events.append((now, i, j))
        for k, place, velocity in changed:
            pieces[k] = Piece(now, place, velocity)
            history.append((k, pieces[k]))


@cache
def _simulated(seed: int):
    return simulated(ten_balls(seed))


@made_up
@pytest.mark.parametrize("many", [False, True], ids=["all pairs", "cells"])
@pytest.mark.parametrize("seed", range(3))
def test_a_motion_of_the_fourth_degree_misses_no_contact(moves, monkeypatch, seed, many):
    if many:
        monkeypatch.setattr(skips, "MOST_PAIRED", 0)
    scene = ten_balls(seed)
    expected, history = _simulated(seed)
    result = simulate(scene, record="trajectory")
    kinds = result.events["kind"]
    collision = result.events[(kinds == EventKind.BALL_BALL) | (kinds == EventKind.BALL_CUSHION)]
    cushion = collision["kind"] == EventKind.BALL_CUSHION
    found = list(
        zip(collision["a"], np.where(cushion, -1 - collision["b"], collision["b"]), strict=True)
    )
    assert found == [(i, j) for _, i, j in expected]
    assert len(found) > 10
    assert np.any(cushion)
    np.testing.assert_allclose(collision["t"], [t for t, _, _ in expected], atol=1e-9)
    assert result.work["cell_moves"] > 0 or not many
    for t in np.linspace(0.0, scene.t_max, 40):
        states = result.sample([t])
        for k in range(len(scene.balls)):
            piece = [one for who, one in history if who == k and one.start <= t][-1].at(t)
            np.testing.assert_allclose(states.positions[0, k, :2], piece[0], atol=1e-8)
            np.testing.assert_allclose(states.velocities[0, k, :2], piece[1], atol=1e-6)
    before, after = result.orientation([0.3999, 0.4001])
    turned = np.linalg.norm(after - before, axis=1) / 1e-4
    spins = np.linalg.norm(result.sample([0.4]).angular_velocities[0], axis=1)
    np.testing.assert_allclose(turned, spins, rtol=1e-2, atol=1e-6)


@made_up
@pytest.mark.parametrize("seed", range(3))
def test_a_ball_stays_in_its_cell_until_it_is_said_to_leave(moves, monkeypatch, seed):
    """Valid for any motion, up to `_LATE`, and except for the outermost cells, which are open."""
    found = broad_phase.time_in_cell
    beyond = []

    def watched(world, i, t):
        leaves, balls, cells = found(world, i, t), world.balls, world.cells
        side, most = cells.frame[2], cells.size
        cell = cells.link[i, st.CELL_COLUMN], cells.link[i, st.CELL_ROW]
        until = min(leaves, balls.state[i].own_time, t + LASTS)  # a ball at rest stays in its cell
        for instant in np.linspace(t, until, 20):
            for k, x in enumerate(position.position_at(balls, i, instant)):
                inside = x - cells.frame[k] - (cell[k] - 1) * side
                if cell[k] > 1:
                    beyond.append(-inside / side)
                if cell[k] < most[k]:
                    beyond.append(inside / side - 1.0)
        return leaves

    monkeypatch.setattr(skips, "MOST_PAIRED", 0)
    monkeypatch.setattr(broad_phase, "time_in_cell", watched)
    simulate(ten_balls(seed), record="rest")
    assert len(beyond) > 1000
    assert max(beyond) <= 1.01 * _LATE


@made_up
def test_both_schedulers_find_the_same_contacts_and_a_sweep_agrees(moves, monkeypatch):
    scene = ten_balls(5)
    few = simulate(scene, record="events")
    vx, vy = scene.balls[1].velocity[:2]
    angle = math.atan2(vy, vx)
    batch = simulate_sweep(scene, math.hypot(vx, vy), [angle], ball=1)
    np.testing.assert_allclose(batch.rest_positions[0], few.rest_positions, atol=1e-7)

"""Tests of flight in air, against closed forms and a reference with 24 digits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import product

import numpy as np
import pytest
from mpmath import mp, mpf
from shots import FLIES, R, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core.tolerances import EPS
from ghostball.model import EventKind, Phase, Status, Table
from ghostball.model.trajectory.polynomial import OF_Z, PER_POWER, rises

DIGITS = 24
_ORDER, _PART = 24, mpf("0.1")
K = 0.0041
G = 9.81
AIR = FLIES | {"air_drag": K}

Vector = list[mpf]
Piece = tuple[mpf, mpf, list[Vector]]  # start, duration, coefficients of the position by power


class Arc:
    """Reference path of a ball's centre, from `place` with `velocity`, at times from 0 on.

    It is computed with Taylor steps, each a fixed fraction of v / a.
    """

    def __init__(self, place: Sequence[float], velocity: Sequence[float], k: float, g: float):
        self._k, self._g = mpf(k), mpf(g)
        self._pieces: list[Piece] = []
        self._end = (mpf(0), [mpf(x) for x in place], [mpf(v) for v in velocity])

    def at(self, t: mpf) -> tuple[Vector, Vector]:
        """Return position and velocity at a time [s]."""
        t = mpf(t)
        while self._end[0] <= t:
            self._step()
        begins, _, powers = next(p for p in self._pieces if p[0] <= t <= p[0] + p[1])
        return _value(powers, t - begins)

    def when(self, gap: Callable[[Vector], mpf], before: float, after: float) -> mpf:
        """Return the only time between two times at which a gap is 0 [s]."""
        low, high = mpf(before), mpf(after)
        sign = gap(self.at(low)[0]) > 0
        assert (gap(self.at(high)[0]) > 0) != sign
        for _ in range(4 * DIGITS):
            middle = (low + high) / 2
            if (gap(self.at(middle)[0]) > 0) == sign:
                low = middle
            else:
                high = middle
        return (low + high) / 2

    def _step(self) -> None:
        t, place, velocity = self._end
        v = [velocity]
        s = [mp.sqrt(sum(x * x for x in velocity))]
        for n in range(_ORDER):
            if n > 0:
                square = sum(x[a] * y[a] for x, y in zip(v, v[::-1], strict=True) for a in range(3))
                square -= sum(s[j] * s[n - j] for j in range(1, n))
                s.append(square / (2 * s[0]))
            drag = [sum(s[j] * v[n - j][a] for j in range(n + 1)) * self._k for a in range(3)]
            drag[2] += self._g if n == 0 else 0
            v.append([-one / (n + 1) for one in drag])
        lasts = _PART * s[0] / (self._g + self._k * s[0] ** 2)
        powers = [place, *([x / (n + 1) for x in one] for n, one in enumerate(v))]
        self._pieces.append((t, lasts, powers))
        self._end = (t + lasts, *_value(powers, lasts))


def _value(powers: list[Vector], s: mpf) -> tuple[Vector, Vector]:
    place = [sum(one[a] * s**n for n, one in enumerate(powers)) for a in range(3)]
    speed = [sum(n * one[a] * s ** (n - 1) for n, one in enumerate(powers) if n) for a in range(3)]
    return place, speed


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(DIGITS):
        yield


def landings(result):
    return result.events["t"][result.events["kind"] == EventKind.BALL_CLOTH]


def test_the_polynomial_of_a_height_is_that_of_its_powers():
    coefficients = np.zeros((4, PER_POWER))
    coefficients[:, OF_Z] = 3.0, -2.0, 5.0, 7.0
    z, vz, az = rises(coefficients.ravel(), 4, 0.5)
    powers = list(enumerate(coefficients[:, OF_Z], start=2))
    assert z == pytest.approx(sum(c * 0.5**n for n, c in powers), rel=EPS)
    assert vz == pytest.approx(sum(n * c * 0.5 ** (n - 1) for n, c in powers), rel=EPS)
    assert az == pytest.approx(sum(n * (n - 1) * c * 0.5 ** (n - 2) for n, c in powers), rel=EPS)


def first(result, kind):
    return result.events["t"][result.events["kind"] == kind][0]


# --- up and down, in closed form


@pytest.mark.parametrize("k", [K, 0.3, 20.0])
def test_a_fall_lasts_as_the_closed_form_says(k):
    """v = sqrt(g/k) tanh(sqrt(g k) t), t = acosh(exp(k h)) / sqrt(g k)."""
    h = mpf(R + 0.2) - mpf(R)
    result = simulate(scene_of(ball((0, 0, R + 0.2)), **(AIR | {"air_drag": k})), record="events")
    t = mp.acosh(mp.exp(k * h)) / mp.sqrt(mpf(G) * k)
    assert landings(result)[0] == pytest.approx(float(t), rel=2 * EPS)
    if k == K:
        assert landings(result)[0] == pytest.approx(0.20195510882942493, rel=2 * EPS)
    before = float(t) - 1e-6
    down = mp.sqrt(mpf(G) / k) * mp.tanh(mp.sqrt(mpf(G) * k) * before)
    assert result.sample([before]).velocities[0, 0, 2] == pytest.approx(-float(down), rel=4 * EPS)


@pytest.mark.parametrize("k", [K, 0.3, 20.0])
def test_a_throw_rises_as_the_closed_form_says(k):
    """h = ln(1 + k v^2/g) / 2k, t = atan(v sqrt(k/g)) / sqrt(g k); then the ball falls."""
    v = 3.0
    result = simulate(scene_of(ball((0, 0), (0, 0, v)), **(AIR | {"air_drag": k})), record="events")
    h = mp.log(1 + k * mpf(v) ** 2 / mpf(G)) / (2 * mpf(k))
    t = mp.atan(v * mp.sqrt(k / mpf(G))) / mp.sqrt(mpf(G) * k)
    top = result.sample([float(t)])
    assert top.positions[0, 0, 2] - R == pytest.approx(float(h), rel=4 * EPS)
    assert top.velocities[0, 0, 2] == pytest.approx(0.0, abs=4 * EPS)
    t += mp.acosh(mp.exp(k * h)) / mp.sqrt(mpf(G) * k)
    assert landings(result)[0] == pytest.approx(float(t), rel=4 * EPS)


# --- along an arc


@pytest.mark.parametrize(
    ("velocity", "k"),
    [
        *product([(2.0, 0.5, 1.5), (-8.0, 3.0, 3.0), (1.0, 1.0, 0.05)], [K, 0.1, 2.0]),
        *product([(0.01, 0.0, 2.0), (1e-5, 2e-5, 1.0)], [0.1]),  # slow to compute for the reference
    ],
)
def test_an_arc_is_that_of_the_oracle(velocity, k):
    """Steep arcs have pieces that become short near the top, where the speed nearly vanishes."""
    scene = scene_of(
        ball((0, 0), velocity, angular_velocity=(3, -40, 70)), **(AIR | {"air_drag": k})
    )
    result = simulate(scene, record="trajectory")
    arc = Arc((0, 0, 0), velocity, k, G)
    lands = landings(result)[0]
    t = arc.when(lambda place: place[2], 0.9 * lands, 1.1 * lands)
    assert lands == pytest.approx(float(t), rel=4 * EPS)
    size = math.hypot(*velocity)
    for part in (0.2, 0.5, 0.9, 1.0 - 1e-12):
        place, speed = arc.at(part * lands)
        state = result.sample([part * lands])
        assert state.positions[0, 0] - [0, 0, R] == pytest.approx(
            np.array(place, dtype=float), abs=4 * EPS * size * lands + EPS * R
        )
        assert state.velocities[0, 0] == pytest.approx(
            np.array(speed, dtype=float), abs=8 * EPS * size
        )
        assert state.angular_velocities[0, 0].tolist() == [3, -40, 70]
    assert result.work["events"] < 40


def test_energy_falls_all_the_way():
    scene = scene_of(ball((0, 0), (4.0, 1.0, 3.0), angular_velocity=(9, 9, 9)), **AIR)
    result = simulate(scene, record="trajectory")
    t = np.linspace(0, landings(result)[0] * (1 - 1e-12), 200)
    total = result.energy(t).total
    assert np.all(np.diff(total) < 0.0)
    # The energy decreases by the power of the drag: m k |v|^3.
    speed = np.linalg.norm(result.sample(t).velocities[:, 0], axis=1)
    taken = np.trapezoid(scene.masses[0] * K * speed**3, t)
    assert total[0] - total[-1] == pytest.approx(taken, rel=1e-4)


def test_a_mirror_shows_the_same_flight():
    shots = [(2.0, 0.7, 1.1), (-2.0, 0.7, 1.1), (0.7, 2.0, 1.1)]
    ends = [simulate(scene_of(ball((0, 0), v), **AIR)).rest_positions[0] for v in shots]
    assert ends[1].tolist() == [-ends[0][0], ends[0][1], R]
    assert ends[2].tolist() == [ends[0][1], ends[0][0], R]


def test_air_slows_low_bounces_too():
    """Compare with all bounces computed one by one, with their friction, to 1e-9 m/s."""
    velocity, spin, e, mu = (3.0, 0.4, 0.5), (20.0, 50.0, 7.0), 0.6, 0.2
    scene = scene_of(
        ball((0, 0), velocity, angular_velocity=spin),
        **(AIR | {"table_restitution": e, "air_drag": 0.5}),
    )
    result = simulate(scene, record="trajectory")
    ends = landings(result)[-1]
    place, speed, w = [mpf(0)] * 3, [mpf(v) for v in velocity], [mpf(x) for x in spin]
    t, tiny = mpf(0), mpf(10) ** -12
    while speed[2] > tiny:
        arc = Arc(place, speed, 0.5, G)
        free = 2 * speed[2] / mpf(G)
        lasts = arc.when(lambda at: at[2], 0.5 * free, 1.01 * free)
        place, speed = arc.at(lasts)
        place[2], t = mpf(0), t + lasts
        ux, uy = speed[0] - R * w[1], speed[1] + R * w[0]
        slip = mp.sqrt(ux * ux + uy * uy)
        part = min(mu * (1 + mpf(e)) * -speed[2] / slip, mpf(2) / 7)
        speed = [speed[0] - part * ux, speed[1] - part * uy, -e * speed[2]]
        turn = mpf(5) / 2 / R
        w = [w[0] - turn * part * uy, w[1] + turn * part * ux, w[2]]
    assert ends == pytest.approx(float(t), abs=1e-12)
    state = result.sample([ends])
    assert state.positions[0, 0, :2] == pytest.approx(np.array(place[:2], dtype=float), abs=1e-11)
    assert state.velocities[0, 0, :2] == pytest.approx(np.array(speed[:2], dtype=float), abs=1e-9)
    turns = state.angular_velocities[0, 0, :2]
    assert turns == pytest.approx(np.array(w[:2], dtype=float), abs=1e-7)


# --- contacts


def test_a_ball_in_flight_hits_a_resting_one_when_the_oracle_says():
    """Without air, the time would be 0.12445751678484287 s."""
    scene = scene_of(ball((0, 0), (2.0, 0.0, 0.8)), ball((0.3, 0.01)), **(AIR | {"air_drag": 0.1}))
    result = simulate(scene, record="events")
    arc = Arc((0, 0, 0), (2.0, 0.0, 0.8), 0.1, G)

    def gap(at):
        return mp.sqrt((at[0] - mpf(0.3)) ** 2 + (at[1] - mpf(0.01)) ** 2 + at[2] ** 2) - 2 * mpf(R)

    t = arc.when(gap, 0.11, 0.135)
    assert result.events["kind"][0] == EventKind.BALL_BALL
    assert result.events["t"][0] == pytest.approx(float(t), rel=8 * EPS)


def test_two_in_flight_meet_when_the_oracle_says():
    starts = ((0.0, 0.0, R), (1.5, 0.0, 1.5)), ((0.5, 0.02, R + 0.1), (-1.0, 0.0, 0.9))
    scene = scene_of(*(ball(*one) for one in starts), **(AIR | {"air_drag": 0.3}))
    result = simulate(scene, record="events")
    one, other = (Arc(place, velocity, 0.3, G) for place, velocity in starts)
    low, high = mpf("0.05"), mpf("0.19")
    for _ in range(100):
        middle = (low + high) / 2
        a, b = one.at(middle)[0], other.at(middle)[0]
        near = sum((x - y) ** 2 for x, y in zip(a, b, strict=True)) < (2 * mpf(R)) ** 2
        low, high = (low, middle) if near else (middle, high)
    assert result.events["kind"][0] == EventKind.BALL_BALL
    assert result.events["t"][0] == pytest.approx(float(low), rel=8 * EPS)


def test_a_nose_is_met_when_the_oracle_says():
    table, nose = Table(length=0.8, width=1.0, cushions=("right",)), 0.0357
    scene = scene_of(
        ball((0.3, 0.5), (2.5, 0.3, 1.1)),
        table=table,
        **(AIR | {"cushion": "restitution", "cushion_height": nose, "air_drag": 0.1}),
    )
    result = simulate(scene, record="events")
    arc = Arc((0.3, 0.5, R), (2.5, 0.3, 1.1), 0.1, G)
    met = result.events["t"][0]
    t = arc.when(
        lambda at: mp.hypot(mpf(0.8) - at[0], at[2] - mpf(nose)) - mpf(R), met - 1e-3, met + 1e-3
    )
    assert result.events["kind"][0] == EventKind.BALL_CUSHION
    assert met == pytest.approx(float(t), rel=8 * EPS)


@pytest.mark.parametrize("k", [0.1, 0.8])
def test_a_ball_leaves_the_table_when_the_oracle_says(k):
    table = Table(length=0.8, width=1.0, cushions=("right",))
    scene = scene_of(
        ball((0.3, 0.5), (2.5, 0.3, 1.8)),
        table=table,
        **(AIR | {"cushion": "restitution", "air_drag": k}),
    )
    result = simulate(scene, record="trajectory")
    arc = Arc((0.3, 0.5, R), (2.5, 0.3, 1.8), k, G)
    t = arc.when(lambda at: mpf(0.8) - at[0], 0.2, 0.3)
    assert first(result, EventKind.LEAVES_TABLE) == pytest.approx(float(t), rel=8 * EPS)
    assert result.phases([result.rest_time])[0, 0] == Phase.GONE


def test_a_flight_is_the_same_at_any_size():
    """Bit-identical for lengths and times scaled by powers of two."""
    v = np.array([2.0, 0.7, 1.1])
    one = simulate(scene_of(ball((0, 0), v), t_max=0.5, **AIR), record="events")
    for length, time in ((2.0**-9, 2.0**3), (2.0**5, 2.0**-4)):
        other = scene_of(
            ball((0, 0), v * length / time, radius=R * length),
            t_max=0.5 * time,
            **AIR
            | {
                "air_drag": K / length,
                "gravity": G * length / time**2,
                "spinning_friction_rate": 10.0 / time**2,
            },
        )
        found = simulate(other, record="events")
        assert found.events["kind"].tolist() == one.events["kind"].tolist()
        assert (found.events["t"] == time * one.events["t"]).all()
        assert (found.rest_positions == length * one.rest_positions).all()


# --- limits


@pytest.mark.parametrize(
    "velocity", [(1e-200, 0, 2), (1e-14, 1e-14, 2), (0, 0, 1e-3), (3, 0, 1e-3)]
)
@pytest.mark.parametrize("k", [1e-300, 1e-12, K, 1e3])
def test_any_flight_ends(velocity, k):
    scene = scene_of(ball((0, 0, R + 0.01), velocity), **(AIR | {"air_drag": k}))
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    assert result.work["events"] < 60


def test_a_flight_in_the_thinnest_air_agrees_with_a_flight_without_air():
    shots = [scene_of(ball((0, 0), (2, 0.5, 1.5)), **(FLIES | {"air_drag": k})) for k in (0, 1e-30)]
    without, thin = (simulate(shot, record="events") for shot in shots)
    assert thin.events["t"] == pytest.approx(without.events["t"], rel=1e-13)
    assert thin.rest_positions == pytest.approx(without.rest_positions, abs=1e-13)

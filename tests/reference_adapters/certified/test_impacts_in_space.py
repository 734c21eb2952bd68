"""Impacts of airborne balls: worked examples, momentum, the friction cone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpmath import mp, mpf
from proofs import after, flying, keys, middle
from shots import R, ball

from ghostball.model import EventKind

G = 9.81


NO_SPIN = {"angular_velocity": (0.0, 0.0, 0.0)}


def test_a_ball_in_flight_meets_one_that_rests_at_the_root_of_a_quartic() -> None:
    """A worked example with e = 0.95, without friction."""
    balls = ball((0.0, 0.0), (2.0, 0.0, 0.8), **NO_SPIN), ball((0.3, 0.01), **NO_SPIN)
    scene = flying(*balls, ball_restitution=0.95, ball_friction=0.0, table_restitution=0.0)
    certificate = after(scene, 1)
    assert keys(certificate) == [(int(EventKind.BALL_BALL), 0, 1)]
    assert float(certificate.t_end) == pytest.approx(0.12445751678484287, rel=1e-15)
    assert [float(v) for v in certificate.velocities[0]] == pytest.approx(
        (0.29050405037044281, -0.33463777488461412, 0.36845432862537209), rel=1e-14
    )
    # The table ends the downward velocity at once, with a friction of mu times this.
    push = scene.physics.sliding_friction * 0.78938256828468065
    vx, vy = 1.7094959496295572, 0.33463777488461412
    part = 1.0 - min(push / math.hypot(vx, vy), 2.0 / 7.0)
    assert [float(v) for v in certificate.velocities[1]] == pytest.approx(
        (part * vx, part * vy, 0.0), rel=1e-14
    )


def test_unequal_balls_on_the_cloth_touch_where_their_surfaces_do() -> None:
    small, large = 0.02, 0.03
    scene = flying(
        ball((0.0, 0.0), (1.0, 0.0), radius=small, **NO_SPIN),
        ball((0.2, 0.0), radius=large),
        sliding_friction=0.0,
        rolling_friction=0.0,
        t_max=1.0,
    )
    certificate = after(scene, 1)
    with mp.workdps(40):
        t = mpf(0.2) - 2 * mp.sqrt(mpf(small) * mpf(large))
        assert abs(middle(certificate.t_end) - t) < mpf(10) ** -30
    # The small ball hits the large ball below its centre, and lifts it.
    assert float(certificate.velocities[1][2]) > 0.0


@pytest.mark.parametrize("seed", range(4))
def test_an_impact_in_space_keeps_momentum_and_takes_no_more_than_it_may(seed) -> None:
    """For two balls in the air, without a reaction of the table, momentum is conserved."""
    chance = np.random.default_rng(seed)
    velocity = chance.uniform(-1.0, 1.0, 3)
    spins = chance.uniform(-60.0, 60.0, (2, 3))
    scene = flying(
        ball((0.0, 0.0, 0.5), velocity, angular_velocity=spins[0], mass=0.2),
        ball(0.3 * velocity + (0.0, 0.01, 0.5), -velocity, angular_velocity=spins[1]),
        ball_restitution=0.8,
        ball_friction=0.1,
    )
    certificate = after(scene, 1)
    t = float(certificate.t_end)
    v = np.array([[float(x) for x in row] for row in certificate.velocities])
    w = np.array([[float(x) for x in row] for row in certificate.spins])
    x = np.array([[float(x) for x in row] for row in certificate.positions])
    before = scene.velocities - [0.0, 0.0, G * t]
    m, radii = scene.masses, scene.radii
    assert m @ v == pytest.approx(m @ before, abs=1e-15)
    n = (x[1] - x[0]) / (2 * R)
    assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-15)
    assert (v[1] - v[0]) @ n == pytest.approx(0.8 * (before[0] - before[1]) @ n, abs=1e-14)
    impulse = m[0] * (v[0] - before[0])
    along = impulse @ n
    assert np.linalg.norm(impulse - along * n) <= 0.1 * abs(along) * (1.0 + 1e-12)
    # The spin of each ball changes by R n x J / I, with the same sign.
    for k in range(2):
        turn = radii[k] * np.cross(n, impulse) / (0.4 * m[k] * radii[k] ** 2)
        assert w[k] - spins[k] == pytest.approx(turn, abs=1e-11)
